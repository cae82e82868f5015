"""SL cycles of Klartext that clear an area: 21 (pilot drilling), 22 (rough-out), 23 (floor finishing), over the contours of cycle 14.

Source: HEIDENHAIN, TNC 640 and iTNC 530 User's Manual Cycle Programming, "SL cycles". Data of cycle 20: Q1 depth below the surface Q5, Q2 times the
tool radius from row to row, Q3 and Q4 left on side and floor, Q6 set-up clearance, Q7 clearance height, Q9 +1 climb, -1 up-cut. A contour that the
tool follows on its inside is a pocket, one on its outside an island. 21: pecks Q10 at Q11 where the rough-out tool Q13 goes in, short of both
allowances; 22: infeeds Q10 at Q11, in the plane Q12; 23: the floor. In which order they clear, and where they go in, is the control's own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from vcmm.program.area import Area, Stroke, area
from vcmm.program.drilling import Hole, depths_of
from vcmm.program.faults import BlockFault
from vcmm.program.heidenhain.holes import ENTRY, ENTRY_MOST, ENTRY_SHARE
from vcmm.program.heidenhain.machining import MachiningCycle
from vcmm.program.levels import unknown_tool
from vcmm.program.moves import Move

Contours = Sequence[tuple[Sequence[Move], str]]  # each with the side on which the tool goes


def rough_out(c: MachiningCycle, contours: Contours) -> None:
    """Rough out (cycle 22)."""
    if c.plain("Q18"):
        c.recorder.assume(
            "cycle 22 after a coarse tool (Q18)", "the whole area is cleared, not only what that tool left",
            "what cycle 22 clears after the coarse roughing tool Q18 is the control's own affair and not known; write Q18=0",
        )  # fmt: skip
    _tell(c)
    surface, floor = c.mm("Q5"), c.mm("Q5") + c.mm("Q1") + c.mm("Q4")
    _check(c, surface, floor)
    strokes = _strokes(c, contours, c.radius())
    for level in depths_of(surface, floor, abs(c.mm("Q10"))):
        _mill(c, strokes, level)
    c.to(None, None, c.mm("Q7"), True)


def finish_floor(c: MachiningCycle, contours: Contours) -> None:
    """Finish the floor (cycle 23)."""
    _tell(c)
    floor = c.mm("Q5") + c.mm("Q1")
    _check(c, c.mm("Q5"), floor)
    _mill(c, _strokes(c, contours, c.radius()), floor)
    c.to(None, None, c.mm("Q7"), True)


def drill_pilots(c: MachiningCycle, contours: Contours) -> None:
    """Drill pilots, cycle 21: as cycle 1, with its advanced stop."""
    r, number = c.recorder, round(c.plain("Q13"))
    tool = r.setup.tools.get(number)
    if tool is None:
        unknown_tool(r, number, f"Q13={number}")
    _tell(c)
    surface, floor = c.mm("Q5"), c.mm("Q5") + c.mm("Q1") + c.mm("Q4")
    _check(c, surface, floor)
    over = surface + c.mm("Q6")
    total = surface - floor
    ahead = ENTRY if total <= 30.0 else min(total / ENTRY_SHARE, ENTRY_MOST)
    depths = depths_of(surface, floor, abs(c.mm("Q10")))
    made, strokes = _strokes(c, contours, (tool.radius if tool else None) or 0.0)
    for stroke in _going_in(made, strokes):
        hole = Hole(r, over, floor, c.mm("Q7"))
        hole.to(c.mm("Q7"), True)
        hole.across(*stroke.start)
        hole.to(over, True)
        with c.feed_at(c.feed("Q11")):
            hole.pecks(depths, lambda depth: min(depth + ahead, over))
        hole.leave()


def _tell(c: MachiningCycle) -> None:
    c.recorder.assume(
        f"how cycle {c.number} clears", "in rows along X, then round each contour; straight down where it goes in",
        f"how cycle {c.number} clears and where it goes in is the control's own affair and not known; write its motion with L and C",
    )  # fmt: skip


def _check(c: MachiningCycle, surface: float, floor: float) -> None:
    if floor >= surface:
        c.recorder.fault(
            f"cycle {c.number} needs a negative depth Q1 of cycle 20, deeper than the allowance Q4"
        )


def _strokes(c: MachiningCycle, contours: Contours, radius: float) -> tuple[Area, list[Stroke]]:
    """Return the rows and ways round, for a tool of this radius. Without one (its diameter is not known) along the contours alone."""
    r = c.recorder
    sense = round(c.plain("Q9", 1.0))
    try:
        made = area(contours, radius + c.mm("Q3"))
        step = c.plain("Q2", 1.0) * radius
        if step < 0:
            r.fault(f"cycle {c.number} needs a path overlap Q2 above zero")
        if step > 2.0 * radius:
            r.fault(
                f"with Q2 = {c.plain('Q2'):g} rows of cycle {c.number} lie further apart than the tool is wide; the control takes up to 1.9999"
            )
        return made, made.strokes(step or math.inf, climb=sense != -1)
    except BlockFault as fault:
        r.fault(f"cycle {c.number}: {fault.text}")


def entry_height(c: MachiningCycle) -> float:
    """Down to where the tool comes at rapid before it is fed in: Q6 above the surface, at most Q7; Q7 where there is no Q6."""
    high = c.mm("Q7")
    return min(high, c.mm("Q5") + c.mm("Q6")) if "Q6" in c.values else high


def _going_in(made: Area, strokes: Sequence[Stroke]) -> Iterator[Stroke]:
    """Yield the strokes that the tool does not reach at depth."""
    before: Stroke | None = None
    for stroke in strokes:
        if before is None or not made.is_clear(before.end, stroke.start):
            yield stroke
        before = stroke


def _mill(c: MachiningCycle, clearing: tuple[Area, list[Stroke]], level: float) -> None:
    """Mill all strokes at one depth."""
    made, strokes = clearing
    inside = set(map(id, _going_in(made, strokes)))
    high = c.mm("Q7")
    for stroke in strokes:
        if id(stroke) in inside:
            c.to(None, None, high, True)
            c.to(*stroke.start, None, True)
            c.to(None, None, entry_height(c), True)
            with c.feed_at(c.feed("Q11")) as rapid:
                c.to(None, None, level, rapid)
        with c.feed_at(c.feed("Q12")):
            c.to(*stroke.start, None, False)
            c.cutter.follow(stroke.path, level)
