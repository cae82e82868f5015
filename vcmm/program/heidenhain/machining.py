"""Inputs of a machining cycle of Klartext: its Q parameters in mm, the tool, its feeds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple

from vcmm.program.cutter import CycleCutter
from vcmm.program.cycle_tables import Cycle, Values, cycle, in_units
from vcmm.program.drilling import Hole
from vcmm.program.moves import Point
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
        """Name of the cycle in messages and traces."""
        return f"CYCL DEF {self.number}"

    def mm(self, name: str, otherwise: float = 0.0) -> float:
        """Return a length."""
        return self.values.get(name, otherwise) * self.recorder.unit

    def plain(self, name: str, otherwise: float = 0.0) -> float:
        """Return a number that is no length."""
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
        """Return the hole under the tool."""
        bottom = self.surface + self.mm("Q201")
        return Hole(
            self.recorder, self.clearance, bottom, self.second if retract is None else retract, idle=True
        )

    def feed(self, name: str, otherwise: str = "") -> float:
        """Return the feed of a parameter in mm/min; that of another one where it is zero or missing. Infinite: rapid."""
        value = self.values.get(name, 0.0)
        if not value and otherwise:
            return self.feed(otherwise)
        if math.isnan(value):  # FAUTO
            return self.auto_feed or 0.0
        return value * (2.54 if self.recorder.unit > 1.0 else 1.0)

    @contextmanager
    def feed_at(self, *feeds: float) -> Iterator[bool]:
        """Move at the first of the feeds that is not zero, mm/min, that of TOOL CALL for FAUTO; yields whether that is rapid."""
        r, feed = self.recorder, next(filter(None, feeds), 0.0)
        feed = (self.auto_feed or 0.0) if math.isnan(feed) else feed
        before, mode = r.feed, r.feed_mode
        r.feed, r.feed_mode = feed, "G94"
        yield math.isinf(feed)
        r.feed, r.feed_mode = before, mode

    @property
    def cutter(self) -> CycleCutter:
        """The tool."""
        return CycleCutter(self.recorder)

    def radius(self) -> float:
        """Return the radius of the tool, mm; 0 where it is unknown: the path then runs on the contour."""
        return self.cutter.radius(f"cycle {self.number}")

    def to(self, a: float | None, b: float | None, height: float | None, rapid: bool) -> None:
        """Move straight to coordinates of the plane, and a height along the tool axis, mm; None: as it is."""
        here = self.here()
        self.cutter.to((here[0] if a is None else a, here[1] if b is None else b), height, rapid)

    def here(self) -> tuple[float, float]:
        """Return the position of the tool in the plane."""
        return self.cutter.here()

    def at(self, a: float, b: float, height: float) -> Point:
        """Return a point from its coordinates in the plane and along the tool axis."""
        return self.cutter.point((a, b), height)


KlartextPrimitive = Callable[[MachiningCycle, Values], None]


class BlockwiseCycle(NamedTuple):
    """An old cycle: each of its blocks n.1, n.2 ... holds one or two numbers, whose words change with the language of the control."""

    blocks: tuple[tuple[str, ...], ...]
    row: Cycle[KlartextPrimitive]


def blockwise(parameters: str, primitive: KlartextPrimitive) -> BlockwiseCycle:
    """Return a row whose blocks are divided by ";"; behind "|" the parameters with words of their own."""
    blocks = tuple(
        tuple(word.split()[0] for word in block.split(","))
        for block in parameters.partition("|")[0].split(";")
    )
    return BlockwiseCycle(blocks, cycle(parameters.replace(";", ",").replace("|", ","), primitive))


def read_row(r: Recorder, row: Cycle[Any], values: Mapping[str, float]) -> Values:
    """Return the inputs of a cycle of a table; feeds of programs in inches count 0.1 inch/min."""
    return row.read(values, in_units(r.unit, 2.54 if r.unit > 1.0 else 1.0))


def of_row(row: Cycle[KlartextPrimitive]) -> Action:
    """Return the action of a cycle of a table. Its parameters are read once for all the calls that follow."""
    latest: dict[int, tuple[MachiningCycle, Values]] = {}

    def act(c: MachiningCycle) -> None:
        if id(c) not in latest:
            latest.clear()
            latest[id(c)] = c, read_row(c.recorder, row, c.values)
        row.primitive(c, latest[id(c)][1])

    return act
