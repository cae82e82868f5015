"""Pockets of Fagor mills: G87 (rectangular), G88 (circular), as rows of parameters over the shared moves.

Source: FAGOR, CNC 8055 Programming manual (M and EN models), 9.13 "G87. Rectangular pocket canned cycle"; CNC 8060 and 8070 for the sign of J: Z reference
plane, I depth, D from the plane to the part, J K half of length and width (G88: J radius), J+ clockwise, B infeed (positive: equal ones, no larger;
negative: as it is, the last the rest), C from ring to ring (3/4 of the diameter where it is left out), L left for a last way round at H, V feed of the infeed
(half of F). From the centre outwards, at each depth; then to the centre and on. How the rings follow one another and the tangential way onto the
last one are the control's own (with a remark).
"""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.program.clearing import PathPiece, circle, rectangle, shift_pieces
from vcmm.program.cutter import CycleCutter, equal_depths
from vcmm.program.cycle_tables import Cycle, Values, cycle, in_units
from vcmm.program.drilling import Hole, depths_of
from vcmm.program.recorder import Recorder
from vcmm.program.setup import Tool

Ring = list[PathPiece]
GAP = 1.0  # mm above the milled surface, on the way to the centre
WORDS = "BCDHJKLV"
ROWS: dict[str, Cycle[str]] = {
    "87": cycle("J mm, K size, B mm, C size?, D size, H feed, L size, V feed", "rectangle"),
    "88": cycle("J mm, B mm, C size?, D size, H feed, L size, V feed", "circle"),
}


def mill(r: Recorder, hole: Hole, code: str, given: dict[str, float]) -> None:
    """Mill one pocket at the position of the tool at the reference plane. given: the words of its block."""
    row = ROWS[code]
    v = row.read(given, in_units(r.unit, 1.0))
    cutter, who = CycleCutter(r), f"G{code} of Fagor"
    r.tool_data = r.setup.tools.get(r.tool, Tool(r.tool))
    radius = cutter.radius(who)
    if not v["J"] or not v["B"] or (code == "87" and not v["K"]):
        r.fault(f"{who} needs J{', K' if code == '87' else ''} and B above or below zero; add them")
    step = v.without("C", 1.5 * radius)
    if radius and not 0.0 < step <= 2.0 * radius:
        r.fault(
            f"C of {who} is a way above zero and up to the diameter of the tool; the control stops here, correct it"
        )
    half = [abs(v["J"]), v["K"]] if code == "87" else [abs(v["J"])]
    if min(half) < radius + v["L"]:
        r.fault(
            f"the tool does not fit into the pocket of {who}: {min(half):g} mm to its side; take a smaller one"
        )
    r.assume(
        f"how {who} clears", "in rings from the centre outwards, straight onto the last one",
        f"how {who} clears is the control's own affair and not known; write its motion with G1 to G3",
    )  # fmt: skip
    top = hole.clearance - v["D"]
    rough, last = (
        _rings(half, radius + v["L"], step, v["J"] > 0),
        _rings(half, radius, 0.0, v["J"] > 0) if v["L"] else [],
    )
    _levels(cutter, v, (rough, last), (hole.clearance, _depths(v["B"], top, hole.bottom)))
    hole.leave()


def _depths(infeed: float, top: float, bottom: float) -> list[float]:
    return equal_depths(top, bottom, infeed) if infeed > 0 else depths_of(top, bottom, -infeed)


def _rings(half: Sequence[float], off: float, step: float, clockwise: bool) -> Ring:
    """Return the rings about the middle up to `off` from the wall; the last one alone where step is zero."""
    if len(half) == 1:
        return circle(half[0] - off, step, clockwise)
    return rectangle((half[0] - off, half[1] - off), step, clockwise=clockwise)


def _levels(
    cutter: CycleCutter, v: Values, rings: tuple[Ring, Ring], heights: tuple[float, Sequence[float]]
) -> None:
    """Mill all infeeds, from the middle."""
    r, middle = cutter.recorder, cutter.here()
    plane, depths = heights
    feed = r.feed or 0.0
    for k, depth in enumerate(depths):
        if k:
            cutter.to(None, min(depths[k - 1] + GAP, plane), True)
            cutter.to(middle, None, True)
        with cutter.feed_at(v["V"] or feed / 2.0):
            cutter.to(None, depth, False)
        cutter.follow(shift_pieces(rings[0], middle), depth)
        with cutter.feed_at(v["H"]):
            cutter.follow(shift_pieces(rings[1], middle), depth)
    cutter.to(None, min(depths[-1] + GAP, plane), True)
    cutter.to(middle, None, True)
