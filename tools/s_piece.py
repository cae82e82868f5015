"""The S-shaped test piece: one flank of an S, flank milled under tool centre point control, of our own making.

    python tools/s_piece.py scenarios/s_piece     writes part.nc, flank.obj and points.csv

The idea is that of the S-shaped test piece of ISO 10791-7; curve and sizes are ours. A sine of amplitude WAVE over LENGTH is the foot of
the flank; the rulings stand on it square to the sine and lean out of Z by LEAN + SWING sin, so that all five axes change their sense
along the way. The surface is twisted, which no cylinder can mill: the tool touches in the middle of each ruling, and elsewhere
it cuts R (1 - cos of the angle between the normals there and in the middle) too deep, at most 1.5 um here.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

LENGTH, WAVE, HEIGHT = 120.0, 30.0, 20.0  # mm
LEAN, SWING = math.radians(10.0), math.radians(3.0)
RADIUS, OVER = 5.0, 2.0  # of the mill; how far its tip reaches below the foot
FEED, BLOCKS, COLUMNS = 1200, 960, 600
Vector = tuple[float, float, float]


def foot(t: float) -> Vector:
    """t from 0 to 1 along the S."""
    return LENGTH * (t - 0.5), WAVE * math.sin(2.0 * math.pi * (t - 0.5)), 0.0


def ruling(t: float) -> Vector:
    """Unit vector along the flank, upwards."""
    slope = 2.0 * math.pi * WAVE / LENGTH * math.cos(2.0 * math.pi * (t - 0.5))
    size = math.hypot(1.0, slope)
    out = (-slope / size, 1.0 / size)  # square to the sine
    lean = LEAN + SWING * math.sin(2.0 * math.pi * t + 1.0)
    return -math.sin(lean) * out[0], -math.sin(lean) * out[1], math.cos(lean)


def on_flank(t: float, v: float) -> Vector:
    """v from 0 (foot) to 1 (HEIGHT along the ruling)."""
    return plus(foot(t), ruling(t), v * HEIGHT)


def normal(t: float, v: float) -> Vector:
    """Outward: the side of the tool."""
    step = 1e-6
    a, b = on_flank(t - step, v), on_flank(t + step, v)
    u, w = tuple(y - x for x, y in zip(a, b)), ruling(t)
    n = (w[1] * u[2] - w[2] * u[1], w[2] * u[0] - w[0] * u[2], w[0] * u[1] - w[1] * u[0])
    size = math.hypot(*n)
    return n[0] / size, n[1] / size, n[2] / size


def plus(p: Vector, d: Vector, by: float) -> Vector:
    return p[0] + by * d[0], p[1] + by * d[1], p[2] + by * d[2]


def tip(t: float, off: float = 0.0) -> Vector:
    """Tip of the tool beside the middle of a ruling; off: mm away from the flank."""
    beside = plus(on_flank(t, 0.5), normal(t, 0.5), RADIUS + off)
    return plus(beside, ruling(t), -HEIGHT / 2.0 - OVER)


def block(head: str, t: float, off: float = 0.0, tail: str = "") -> str:
    point = " ".join(f"{letter}{v:.5f}" for letter, v in zip("XYZ", tip(t, off)))
    return f"{head}{point} " + " ".join(f"{letter}{v:.8f}" for letter, v in zip("IJK", ruling(t))) + tail


def program() -> str:
    lines = ["%", "O0980 (S-SHAPED FLANK, G43.5)", "G21 G17 G40 G49 G80 G90 G94", "T1 M6", "S8000 M3"]
    lines += [
        "G54 G0 X0 Y0 Z150.",
        "G43.5 H1 Z120.",
        block("G0 ", -0.02, 60.0),
        block("G1 ", -0.02, 0.0, f" F{FEED}"),
    ]
    lines += [block("", -0.02 + 1.04 * k / BLOCKS) for k in range(1, BLOCKS + 1)]
    lines += [block("G1 ", 1.02, 60.0), "G0 Z150.", "G49", "M30", "%"]
    return "\n".join(lines) + "\n"


def mesh() -> str:
    """The flank as OBJ: two triangles for each of COLUMNS strips along the rulings, against the clock seen from the tool."""
    at = [-0.01 + 1.02 * k / COLUMNS for k in range(COLUMNS + 1)]
    lines = ["# S-shaped flank, mm"]
    lines += ["v " + " ".join(f"{c:.6f}" for c in on_flank(t, v)) for t in at for v in (0.0, 1.0)]
    for k in range(COLUMNS):
        p, s, q, r = (2 * k + i for i in (1, 2, 3, 4))
        lines += [f"f {p} {r} {q}", f"f {p} {s} {r}"]
    return "\n".join(lines) + "\n"


def points() -> str:
    """Where the flank is inspected: 24 rulings at three heights, as in ISO 10791-7."""
    rows = ["x_mm,y_mm,z_mm,nx,ny,nz"]
    for v in (0.2, 0.5, 0.8):
        for k in range(24):
            t = 0.02 + 0.96 * k / 23
            rows.append(",".join(f"{c:.9f}" for c in (*on_flank(t, v), *normal(t, v))))
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    (folder / "part.nc").write_text(program(), encoding="utf-8")
    (folder / "flank.obj").write_text(mesh(), encoding="utf-8")
    (folder / "points.csv").write_text(points(), encoding="utf-8")
