"""The modal state of a control: values in force from block to block until changed, for all languages.

Lengths are mm, angles rad. The feed is kept as the language counts it, `feed_scale` mm in each of its units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from vcmm.program.moves import ORIGIN, Point, Posture
from vcmm.program.radius import RadiusCompensation


class Modal(NamedTuple):
    """The modal state that a rewriter must keep: a snapshot, made only where traces are."""

    motion: str | None
    plane: str
    unit: float  # mm per unit of the program
    absolute: bool
    arc_absolute: bool
    feed_mode: str
    feed: float  # as kept; 0 with inverse time, which is that of each block
    spindle_mode: str
    speed: float
    offset: str
    side: str | None
    retract: str
    tool: int
    tool_offset: Point
    exact_stop: bool
    tolerance: float | None
    diameter: bool


@dataclass(slots=True, eq=False)
class ModalState:
    """State that codes change and moves obey. A language adds the state of its control."""

    motion: str | None = None
    plane: str = "XY"
    unit: float = 1.0
    absolute: bool = True
    arc_absolute: bool = False
    diameter: str = ""  # X counts diameters: "always", "absolute" (in absolute words only), or "" never
    feed: float | None = None  # per minute, per turn, or 1/min
    feed_scale: float = 1.0
    feed_mode: str = "G94"
    speed: float = 0.0
    speed_limit: float = math.inf
    surface: bool = False  # G96: the speed is m/min, or ft/min in programs in inches
    sense: int = 0  # of the spindle: +1 M3, -1 M4
    retract: str = ""
    offset: str = "G54"
    tool: int = 0
    tool_offset: Point = ORIGIN
    is_tcp_on: bool = False  # tool centre point control is on
    over_face: bool = False  # polar interpolation is on: X and C lead the tip
    work_spindle: int = 1  # which spindle holds the part
    is_plane_tilted: bool = False  # a tilted plane is in force, and the tool is square to it
    aim: Point | None = None  # tool axis that the program asks for, workpiece axes
    sweeps: bool = False  # the tool axis sweeps the plane of its directions at both ends of a block
    posture: Posture | None = None  # which of the positions that point the tool alike
    unmoved_axes: str = (
        ""  # axes that no word has moved since the tip was led: only the machine knows where they stand
    )
    compensation: RadiusCompensation | None = None
    exact_stop: bool = False
    exact_once: bool = False
    tolerance: float | None = None

    def diametral(self) -> bool:
        """Return whether X counts diameters now."""
        return self.diameter == "always" or (self.diameter == "absolute" and self.absolute)

    def release(self, letter: str) -> None:
        """Release a rotary axis that a word moves."""
        self.unmoved_axes = self.unmoved_axes.replace(letter, "")

    def surface_speed(self) -> float:
        """Return the cutting speed with G96, mm/min."""
        return 1000.0 * self.speed

    def turns(self, x: float) -> float:
        """Turns per minute, not signed; with G96 v / (2 pi |x|) at radius x, mm, infinite at x = 0 without a limit."""
        if not self.surface:
            return self.speed
        return min(self.surface_speed() / (2.0 * math.pi * abs(x)) if x else math.inf, self.speed_limit)

    def modal(self) -> Modal:
        """Return the snapshot of the modal state."""
        return Modal(
            motion=self.motion, plane=self.plane, unit=self.unit, absolute=self.absolute, arc_absolute=self.arc_absolute,
            feed_mode=self.feed_mode, feed=0.0 if self.feed_mode == "G93" else self.feed or 0.0,
            spindle_mode="G96" if self.surface else "G97", speed=self.speed, offset=self.offset,
            side=self.compensation.side if self.compensation else None, retract=self.retract, tool=self.tool,
            tool_offset=self.tool_offset, exact_stop=self.exact_stop, tolerance=self.tolerance, diameter=self.diametral(),
        )  # fmt: skip
