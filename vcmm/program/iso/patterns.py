"""Codes of one block that make a pattern or a pocket: G12 G13 (circular pockets), G70 to G72 of Haas (bolt holes).

Source: Haas mill operator's manual, G12/G13 circular pocket milling, G70 bolt hole circle, G71 arc, G72 along an angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from vcmm.program.cutter import Flat
from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.faults import BlockFault
from vcmm.program.hole_patterns import hole_circle, hole_line
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.cycles import DRILLING, drill_at
from vcmm.program.iso.lengths import read_words
from vcmm.program.iso.motion import ArcEnds, emit_arc
from vcmm.program.moves import Point

MOST_HOLES = 10_000


def nonmodal(c: IsoControl, w: IsoWords) -> bool:
    """Execute a block with one of the codes here. Return whether it had one."""
    if "pocket" in w.g:
        circular_pocket(c, w, w.g["pocket"], w.g_columns["pocket"])
        return True
    if "pattern" in w.g:
        bolt_holes(c, w, w.g["pattern"], w.g_columns["pattern"])
        return True
    if "irregular" in w.g:  # made behind its block: pocketing.mill_pocket
        w.used |= set(w.values)
        return True
    return False


def circular_pocket(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Run G12 (clockwise), G13: I radius, or of the first circle; K radius of the finished one with steps Q; Z depth, L passes of it.
    D: the radius of the tool is subtracted. From the centre out by half circles, round, and back to the centre."""
    c.column = column
    w.need("I", "the radius of the circle", column)
    v, tool, passes = read_words(c, w, POCKET), _tool_radius(c, w, column), w.whole("L", column, 1) or 1
    radii, step, last = [v["first"]], v["step"], v.without("last", v["first"])
    drop = v["depth"] - c.p[2] if v.has("depth") and c.absolute else v["depth"]
    while step > 0 and radii[-1] + step < last - 1e-9 and len(radii) < MOST_HOLES:
        radii.append(radii[-1] + step)
    if last > radii[-1] + 1e-9:
        radii.append(last)
    for _ in range(passes):
        centre = c.p
        if drop:
            c.straight((centre[0], centre[1], centre[2] + drop / (passes if c.absolute else 1)), False)
        _rings(c, c.p, [r - tool for r in radii if r > tool], code == "G12")


def _rings(c: IsoControl, centre: Point, radii: list[float], clockwise: bool) -> None:
    """Mill half a circle out, a whole one at each radius, half a circle back."""
    x, y, z = centre
    at = 0.0
    for r in radii:
        _half(c, (x + r, y, z), (x + (r + at) / 2.0, y), clockwise)
        _half(c, (x + r, y, z), (x, y), clockwise)
        at = r
    if radii:
        _half(c, centre, (x + at / 2.0, y), clockwise)


def _half(c: IsoControl, end: Point, centre: tuple[float, float], clockwise: bool) -> None:
    if c.p != end or centre != (end[0], end[1]):
        emit_arc(c, ArcEnds(c.p, end, clockwise, True), (centre[0], centre[1], c.p[2]), 1, c.rotary)


def _tool_radius(c: IsoControl, w: IsoWords, column: int) -> float:
    from vcmm.program.iso.tools import radius_of

    number = w.whole("D", column)
    return 0.0 if number is None else radius_of(c, number, column)[0]


def bolt_holes(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Drill L holes about (G72: from) the position of the tool; the drilling cycle in force makes each (L0 on its line: none there)."""
    if c.motion not in DRILLING:
        raise BlockFault(
            column, f"{code} needs a drilling cycle in force; write for example G81 ... L0 before it"
        )
    w.need("I", "the radius or the distance", column)
    v, count = read_words(c, w, PATTERNS[code]), w.whole("L", column, 1)
    if count is None or count > MOST_HOLES:
        raise BlockFault(column, f"{code} needs L, the number of holes, up to {MOST_HOLES}")
    for x, y in PATTERNS[code].primitive(v, count, c.p[:2]):
        drill_at(c, x, y)


def ring(v: Values, count: int, middle: Flat) -> list[Flat]:
    """Return the holes of G70, evenly; of G71 in steps of K."""
    step = v.without("step", 2.0 * math.pi / count)
    return hole_circle(middle, v["radius"], [v["start"] + k * step for k in range(count)])


def row(v: Values, count: int, begin: Flat) -> list[Flat]:
    """Return the holes of G72."""
    return hole_line(begin, v["start"], [v["radius"] * k for k in range(count)])


POCKET = cycle("I=first mm!, K=last mm?, Q=step mm, Z=depth mm?", None)
PATTERNS: Mapping[str, Cycle[Callable[[Values, int, Flat], list[Flat]]]] = {
    "G70": cycle("I=radius mm!, J=start deg", ring),
    "G71": cycle("I=radius mm!, J=start deg, K=step deg", ring),
    "G72": cycle("I=radius mm!, J=start deg", row),
}
