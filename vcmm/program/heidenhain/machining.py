"""What a machining cycle of Klartext is given: its Q parameters in mm, the tool, its feeds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from vcmm.program.drilling import Hole
from vcmm.program.levels import SetupEntry
from vcmm.program.moves import PLANES, Point
from vcmm.program.recorder import Recorder

Action = Callable[["MachiningCycle"], None]


@dataclass(frozen=True, eq=False)
class MachiningCycle:
    """A cycle that is defined. values: as programmed, lengths in the unit of the program; infinite: FMAX, MAX."""

    recorder: Recorder
    number: str
    values: Mapping[str, float]
    action: Action
    auto_feed: float | None = None

    @property
    def name(self) -> str:
        """As it stands in messages and traces."""
        return f"CYCL DEF {self.number}"

    def mm(self, name: str, otherwise: float = 0.0) -> float:
        """A length."""
        return self.values.get(name, otherwise) * self.recorder.unit

    def plain(self, name: str, otherwise: float = 0.0) -> float:
        """A number that is no length."""
        return self.values.get(name, otherwise)

    @property
    def surface(self) -> float:
        return self.mm("Q203")

    @property
    def clearance(self) -> float:
        """Height of the set-up clearance."""
        return self.surface + self.mm("Q200")

    @property
    def second(self) -> float:
        """Height of the second set-up clearance, where it is the higher one."""
        return self.surface + max(self.mm("Q200"), self.mm("Q204"))

    def hole(self, retract: float | None = None) -> Hole:
        """The hole under the tool."""
        bottom = self.surface + self.mm("Q201")
        return Hole(
            self.recorder, self.clearance, bottom, self.second if retract is None else retract, idle=True
        )

    def feed(self, name: str, otherwise: str = "") -> float:
        """Feed of a parameter in mm/min; that of another one where it is zero or missing. Infinite: rapid."""
        value = self.values.get(name, 0.0)
        if not value and otherwise:
            return self.feed(otherwise)
        if math.isnan(value):  # FAUTO
            return self.auto_feed or 0.0
        return value * (2.54 if self.recorder.unit > 1.0 else 1.0)

    @contextmanager
    def feed_at(self, feed: float) -> Iterator[bool]:
        """Moves at this feed, mm/min; yields whether that is rapid."""
        r = self.recorder
        kept, mode = r.feed, r.feed_mode
        r.feed, r.feed_mode = feed, "G94"
        yield math.isinf(feed)
        r.feed, r.feed_mode = kept, mode

    def radius(self) -> float:
        """Of the tool, mm; 0 where nobody knows it: the path then runs on the contour."""
        tool = self.recorder.tool_data
        if tool.radius is None:
            self.recorder.assume(
                f"the diameter of tool {tool.number}", "0 mm: the path on the programmed contour",
                f"cycle {self.number} needs the radius of tool {tool.number}; state its diameter in the set-up under [tools.{tool.number}]",
                blank=SetupEntry(f"tools.{tool.number}", "diameter", '"10 mm"'),
            )  # fmt: skip
        return tool.radius or 0.0

    def to(self, a: float | None, b: float | None, height: float | None, rapid: bool) -> None:
        """Straight to coordinates of the plane, and a height along the tool axis, mm; None: as it is."""
        one, two, normal = PLANES[self.recorder.plane]
        point = list(self.recorder.p)
        for k, value in ((one, a), (two, b), (normal, height)):
            if value is not None:
                point[k] = value
        if tuple(point) != self.recorder.p:
            self.recorder.straight((point[0], point[1], point[2]), rapid)

    def here(self) -> tuple[float, float]:
        """Where the tool stands in the plane."""
        one, two, _ = PLANES[self.recorder.plane]
        return self.recorder.p[one], self.recorder.p[two]

    def at(self, a: float, b: float, height: float) -> Point:
        """A point from its coordinates in the plane and along the tool axis."""
        point = [0.0, 0.0, 0.0]
        for k, value in zip(PLANES[self.recorder.plane], (a, b, height)):
            point[k] = value
        return point[0], point[1], point[2]
