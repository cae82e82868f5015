"""Contour cycles of Klartext: 14 (labels), 20 (data), 24 (side finishing), 25 (contour train); 21 to 23 are in `areas`.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "SL cycles": a contour is a subprogram with RL or RR; Q10 is an infeed, Q11 its feed,
Q12 that along the contour, Q3 (24: Q14) is left on its side, Q5 the surface, Q1 the depth below it, Q7 the clearance height; Q9 (25: Q15) is +1 climb, -1
up-cut, 25 with 0 to and fro. With M3 the tool climbs where it is left of its way. Where each infeed is made is the control's own, and told.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from vcmm.program.contouring import flat, is_closed, offset_contour, pieces, reverse
from vcmm.program.cycle_tables import Cycle, cycle
from vcmm.program.drilling import depths_of
from vcmm.program.heidenhain.areas import Contours, drill_pilots, entry_height, finish_floor, rough_out
from vcmm.program.heidenhain.machining import MachiningCycle
from vcmm.program.moves import Move
from vcmm.program.radius import HEIDENHAIN

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
    """Return the cycle that clears what lies between the contours, which all have a side (cycles 21 to 23)."""
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
