"""Contour cycles of Klartext: 14 (labels), 20 (data), 21 to 23 (an area is cleared), 24 (side finishing), 25 (contour train).

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "SL cycles": a contour is a subprogram with RL or RR; Q10 is an infeed, Q11 its feed,
Q12 that along the contour, Q3 (24: Q14) is left on its side, Q5 the surface, Q1 the depth below it, Q7 the clearance height; Q9 (25: Q15) is +1 climb, -1
up-cut, 25 with 0 to and fro. With M3 the tool climbs where it is left of its way. Where each infeed is made is the control's own; an assumption says so.

21 (pilot drilling), 22 (rough-out) and 23 (floor finishing) clear the area of the contours of cycle 14 (iTNC 530 User's Manual too). Data of cycle 20: Q1 depth below the surface Q5, Q2 times the
tool radius from row to row, Q3 and Q4 left on side and floor, Q6 set-up clearance, Q7 clearance height, Q9 +1 climb, -1 up-cut. A contour that the
tool follows on its inside is a pocket, one on its outside an island. 21: pecks Q10 at Q11 where the rough-out tool Q13 goes in, short of both
allowances; 22: infeeds Q10 at Q11, in the plane Q12; 23: the floor. In which order they clear, and where they go in, is the control's own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from vcmm.program.area import Area, Stroke, area
from vcmm.program.contouring import flat, is_closed, offset_contour, pieces, reverse
from vcmm.program.cycle_tables import Cycle, cycle
from vcmm.program.drilling import Hole, depths_of
from vcmm.program.faults import BlockFault
from vcmm.program.heidenhain.holes import ENTRY, ENTRY_MOST, ENTRY_SHARE
from vcmm.program.heidenhain.machining import MachiningCycle
from vcmm.program.levels import unknown_tool
from vcmm.program.moves import Move
from vcmm.program.radius import HEIDENHAIN

Contours = Sequence[tuple[Sequence[Move], str]]  # each with the side on which the tool goes


def rough_out(c: MachiningCycle, contours: Contours) -> None:
    """Run cycle 22: rough out."""
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
    """Return the height down to which the tool comes at rapid before it is fed in: Q6 above the surface, at most Q7; Q7 where there is no Q6."""
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


CONTOUR_DATA = cycle("Q1 mm!, Q3 mm!, Q5 mm!, Q7 mm!", None)  # of cycle 20 for 21 to 24


SidedContours = list[tuple[list[Move], str | None]]  # moves of each, and the side of its compensation
ContourPrimitive = Callable[[MachiningCycle, SidedContours], None]


@dataclass(eq=False)
class ContourCycles:
    """Data of cycles 14 and 20. read: the moves of a label, the first of them the way to it, and the side of its compensation."""

    labels: list[str] = field(default_factory=list)
    data: dict[str, float] = field(default_factory=dict)
    read: Callable[[str], tuple[list[Move], str | None]] = lambda name: ([], None)

    def mill(self, c: MachiningCycle) -> None:
        """Mill: 24 along each label, 25 along the one of cycle 14."""
        r = c.recorder
        if not self.labels:
            r.fault(f"cycle {c.number} has no contour; add CYCL DEF 14.1 with its label before it")
        if c.number == "25" and len(self.labels) > 1:
            r.fault(f"cycle 25 mills one contour, and cycle 14 names {len(self.labels)}; name one")
        CONTOUR_CYCLES[c.number].primitive(c, [self._contour(c, name) for name in self.labels])

    def _contour(self, c: MachiningCycle, name: str) -> tuple[list[Move], str | None]:
        """Return the moves of a label, and its side."""
        moves, side = self.read(name)
        path = [m for m in moves[1:] if m.kind in ("line", "arc")]
        if not path:
            c.recorder.fault(
                f"LBL {name} makes no contour for cycle {c.number}; write its first point and two moves at least"
            )
        if side is None and c.number != "25":
            c.recorder.fault(f"LBL {name} has no RL or RR: on which side cycle {c.number} mills is not known")
        return path, side


def along(c: MachiningCycle, contours: SidedContours) -> None:
    """Mill each contour in its infeeds (cycles 24, 25)."""
    for path, side in contours:
        _follow(c, path, side)


def over(clear: Callable[[MachiningCycle, Contours], None]) -> ContourPrimitive:
    """Run cycles 21 to 23: clear what lies between the contours, which all have a side."""
    return lambda c, contours: clear(c, [(path, side or "left") for path, side in contours])


def _follow(c: MachiningCycle, path: list[Move], side: str | None) -> None:
    """Mill one contour in its infeeds."""
    closed = is_closed(path)
    left = c.mm("Q14") if c.number == "24" else c.mm("Q3")
    made = offset_contour(path, side, c.radius() + left, HEIDENHAIN, c.recorder.file, closed)
    sense = round(c.plain("Q9" if c.number == "24" else "Q15", 1.0))
    if side is not None and sense == (-1 if side == "left" else 1):
        made = reverse(made)
    way = "rapid to Q6 above the surface, then" if "Q6" in c.values else "from Q7"
    c.recorder.assume(
        f"where cycle {c.number} goes in and out", f"straight down at its first point, {way} at Q11; up at its last",
        f"where cycle {c.number} goes in is the control's own affair and not known; write its contour with APPR and DEP",
    )  # fmt: skip
    surface, floor, high = c.mm("Q5"), c.mm("Q5") + c.mm("Q1"), c.mm("Q7")
    if floor >= surface:
        c.recorder.fault(f"cycle {c.number} needs a negative depth Q1: it counts from the surface Q5")
    c.to(None, None, high, True)
    for level in depths_of(surface, floor, abs(c.mm("Q10"))):
        begin = flat(made[0], False)
        if c.here() != begin:
            c.to(None, None, high, True)
            c.to(*begin, None, True)
            c.to(None, None, entry_height(c), True)
        with c.feed_at(c.feed("Q11")) as rapid:
            c.to(None, None, level, rapid)
        with c.feed_at(c.feed("Q12")):
            c.cutter.follow(pieces(made), level)
        made = reverse(made) if sense == 0 else made
    c.to(None, None, high, True)


CONTOUR_CYCLES: Mapping[str, Cycle[ContourPrimitive]] = {
    "21": cycle("Q10 mm!, Q11 feed!, Q13 count!", over(drill_pilots)),
    "22": cycle("Q10 mm!, Q11 feed!, Q12 feed!", over(rough_out)),
    "23": cycle("Q11 feed!, Q12 feed!", over(finish_floor)),
    "24": cycle("Q10 mm!, Q11 feed!, Q12 feed!", along),
    "25": cycle("Q1 mm!, Q5 mm!, Q7 mm!, Q10 mm!, Q11 feed!, Q12 feed!", along),
}
