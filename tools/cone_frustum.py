"""The program of the cone frustum test piece: flank milled under tool centre point control, of our own making.

    python tools/cone_frustum.py > scenarios/cone_frustum/part.nc

A cone of apex half angle HALF stands inclined by LEAN about Y. The flank of an end mill lies along its generators: the tool axis
is the generator, the tip follows the circle of the base, one radius out and OVER below it. Inclined cones are the classic
five-axis test (NAS 979; ISO 10791-7); the sizes here are ours.
"""

from __future__ import annotations

import math
import sys

BASE, HEIGHT = 45.0, 25.0  # mm: radius of the base, height along the axis
HALF, LEAN = math.radians(15.0), math.radians(10.0)
RADIUS, OVER = 10.0, 3.0  # of the mill; how far its tip reaches below the base
FEED, BLOCKS = 1500, 720


def turned(v: tuple[float, float, float]) -> tuple[float, float, float]:
    """About Y by LEAN."""
    c, s = math.cos(LEAN), math.sin(LEAN)
    return c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]


def tool(angle: float, off: float = 0.0) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Tip (mm from the middle of the base) and tool axis at an azimuth of the cone; off: mm beside the surface."""
    c, s = math.cos(angle), math.sin(angle)
    axis = (-math.sin(HALF) * c, -math.sin(HALF) * s, math.cos(HALF))
    out = (math.cos(HALF) * c, math.cos(HALF) * s, math.sin(HALF))
    foot = (BASE * c, BASE * s, 0.0)
    tip = tuple(f + (RADIUS + off) * n - OVER * a for f, n, a in zip(foot, out, axis))
    return turned((tip[0], tip[1], tip[2])), turned(axis)


def block(head: str, at: float, off: float = 0.0, tail: str = "") -> str:
    tip, axis = tool(at, off)
    point = " ".join(f"{letter}{v:.5f}" for letter, v in zip("XYZ", tip))
    return f"{head}{point} " + " ".join(f"{letter}{v:.8f}" for letter, v in zip("IJK", axis)) + tail


def program() -> str:
    lines = [
        "%",
        "O0979 (INCLINED CONE, FLANK MILLED, G43.5)",
        "G21 G17 G40 G49 G80 G90 G94",
        "T1 M6",
        "S6000 M3",
    ]
    lines += ["G54 G0 X0 Y0 Z150.", "G43.5 H1 Z120.", block("G0 ", 0.0, 60.0)]
    lines.append(block("G1 ", 0.0, 0.0, f" F{FEED}"))
    lines += [block("", 2.0 * math.pi * k / BLOCKS) for k in range(1, BLOCKS + 8)]
    lines.append(block("G1 ", 2.0 * math.pi * 7 / BLOCKS, 60.0))
    lines += ["G0 Z150.", "G49", "M30", "%"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(program())
