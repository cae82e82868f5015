"""A circle-diamond-square test piece: NC program and drawing from one set of numbers.

In the manner of ISO 10791-7 (test pieces finished under load) and NAS 979; the dimensions are ours, no copy of either.
From the top down: a bore, a circle, a diamond (a square turned by 45 degrees) and a square, each finished by one pass of
an end mill with cutter radius compensation; no stock is stated. Which error of the machine shows in which feature, as
`vcmm demo --twin test_piece` computes it (twin.py):

    squareness of X and Y        angle of the square, widths of the diamond unequal, circle an oval at 45 degrees
    squareness of Z              bore and circle out of line, for they are cut at different heights
    scale of one axis            length of the square in that axis, angle of the diamond, circle an oval at 0 degrees
    straightness                 form of the sides along that axis; of X also the angle between two sides of the diamond
    backlash                     steps on the circle and an oval at 45 degrees, widths of the diamond unequal; a length of
                                 the square where its two sides are cut after moves of that axis in opposite senses
    reversal spike               the circle alone, over a millimetre or so: 24 points round it see an eighth of it
    lag of one axis              oval at 45 degrees that turns over with the direction of travel, widths of the diamond
    spindle growth               nothing here: no floor has a tolerance
    size of the cutter           all diameters, lengths and widths, no form
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class PieceSizes:
    """All lengths in mm, drawing frame: origin in the middle of the top face, Z up."""

    side: float = 160.0
    diamond: float = 108.0  # side
    circle: float = 104.0  # diameter
    bore: float = 30.0  # diameter
    step: float = 10.0  # height of each of the three steps
    cutter: float = 20.0  # diameter
    feed: float = 600.0  # mm/min
    speed: float = 2400.0  # 1/min


def program(piece: PieceSizes | None = None) -> str:
    """The NC program (Fanuc dialect), finishing passes only; climb milling."""
    p = piece or PieceSizes()
    blocks = ["%", "O1079 (CIRCLE DIAMOND SQUARE, FINISHING)", *_head(p)]
    blocks += ["(BORE)", *_bore(p)]
    blocks += ["(CIRCLE)", *_boss(p)]
    tip = p.diamond / math.sqrt(2)
    blocks += ["(DIAMOND)", *_polygon([(0, -tip), (-tip, 0), (0, tip), (tip, 0)], -2 * p.step, p)]
    half = p.side / 2
    square = [(half, -half), (-half, -half), (-half, half), (half, half)]
    blocks += ["(SQUARE)", *_polygon(square, -3 * p.step, p)]
    blocks += ["G0 Z50.", "M5", "G91 G28 Z0", "M30", "%"]
    return "\n".join(blocks) + "\n"


def _head(p: PieceSizes) -> list[str]:
    return [
        "G21 G17 G40 G49 G80 G90 G94",
        "T1 M6",
        f"G54 G0 X0 Y0 S{p.speed:.0f} M3",
        "G43 H1 Z50.",
    ]


def _bore(p: PieceSizes) -> list[str]:
    """Inside, counter-clockwise, entered and left on a half circle."""
    r, lead = p.bore / 2, 0.4 * p.bore
    return [
        "G0 X0 Y0",
        f"Z{-3 * p.step + 1:.1f}",
        f"G1 Z{-3 * p.step:.1f} F{p.feed:.0f}",
        f"G41 D1 G1 X{_n(r - lead)} Y{_n(-lead)}",
        f"G3 X{_n(r)} Y0 R{_n(lead)}",
        f"G3 X{_n(r)} Y0 I{_n(-r)} J0",
        f"G3 X{_n(r - lead)} Y{_n(lead)} R{_n(lead)}",
        "G40 G1 X0 Y0",
        "G0 Z5.",
    ]


def _boss(p: PieceSizes) -> list[str]:
    """Outside, clockwise, from +Y... entered and left on a tangent line."""
    r, off = p.circle / 2, p.cutter + 5
    return [
        f"G0 X{_n(-off)} Y{_n(r + off)}",
        f"Z{-p.step:.1f}",
        f"G41 D1 G1 X{_n(-off)} Y{_n(r)} F{p.feed:.0f}",
        f"G1 X0 Y{_n(r)}",
        f"G2 X0 Y{_n(r)} I0 J{_n(-r)}",
        f"G1 X{_n(off)} Y{_n(r)}",
        f"G40 G1 X{_n(off)} Y{_n(r + off)}",
        "G0 Z5.",
    ]


def _polygon(corners: list[tuple[float, float]], depth: float, p: PieceSizes) -> list[str]:
    """Outside, clockwise through the corners; entered before the first side and left after the last, both prolonged."""
    off = p.cutter + 5
    first, second, last = corners[0], corners[1], corners[-1]
    before = _beyond(second, first, off)  # on the first side, ahead of its first corner
    after = _beyond(last, first, off)  # on the last side, past its last corner
    start, stop = _outside(before, first, second, off), _outside(after, last, first, off)
    out = [f"G0 X{_n(start[0])} Y{_n(start[1])}", f"Z{depth:.1f}", f"G41 D1 G1 {_xy(before)} F{p.feed:.0f}"]
    out += [f"G1 {_xy(corner)}" for corner in corners[1:]]
    out += [f"G1 {_xy(after)}", f"G40 G1 {_xy(stop)}", "G0 Z5."]
    return out


def _beyond(start: tuple[float, float], end: tuple[float, float], by: float) -> tuple[float, float]:
    """The point `by` mm past `end` on the line from `start`."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    size = math.hypot(dx, dy)
    return end[0] + by * dx / size, end[1] + by * dy / size


def _outside(
    point: tuple[float, float], start: tuple[float, float], end: tuple[float, float], by: float
) -> tuple[float, float]:
    """`point` moved `by` mm to the left of the way from `start` to `end`: away from a part that is passed clockwise."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    size = math.hypot(dx, dy)
    return point[0] - by * dy / size, point[1] + by * dx / size


def _xy(point: tuple[float, float]) -> str:
    return f"X{_n(point[0])} Y{_n(point[1])}"


def _n(value: float) -> str:
    """A number as programs write it: with a point, three decimals at most."""
    text = f"{value:.3f}".rstrip("0")
    return "0" if text in ("0.", "-0.") else text


def features(piece: PieceSizes | None = None) -> str:
    """The drawing of the same piece: the lines of [part.features]."""
    p = piece or PieceSizes()
    half, tip, s = p.side / 2, p.diamond / math.sqrt(2), math.sqrt(0.5)
    middle = tip / 2
    lines = [
        f'bore     = {{ type = "cylinder", point = "0 0 {-3 * p.step:g} mm", axis = [0, 0, 1], diameter = "{p.bore:g} mm", length = "{3 * p.step:g} mm", inside = true }}',
        f'circle   = {{ type = "cylinder", point = "0 0 {-p.step:g} mm", axis = [0, 0, 1], diameter = "{p.circle:g} mm", length = "{p.step:g} mm" }}',
    ]
    for name, x, y in (("ne", 1, 1), ("nw", -1, 1), ("sw", -1, -1), ("se", 1, -1)):
        lines.append(
            f'{"diamond_" + name} = {{ type = "plane", point = "{x * middle:.6f} {y * middle:.6f} {-1.5 * p.step:g} mm", '
            f'normal = [{x * s:.9f}, {y * s:.9f}, 0], size = "{0.9 * p.diamond:g} {p.step:g} mm" }}'
        )
    for name, x, y in (("east", 1, 0), ("north", 0, 1), ("west", -1, 0), ("south", 0, -1)):
        lines.append(
            f'{name:8s} = {{ type = "plane", point = "{x * half:g} {y * half:g} {-2.5 * p.step:g} mm", '
            f'normal = [{x}, {y}, 0], size = "{0.95 * p.side:g} {p.step:g} mm" }}'
        )
    return "\n".join(lines) + "\n"
