"""Features that the measuring cycles of all controls touch: the ways to them, the touches, found values beside set ones.

A cycle is a row of a table (vcmm.program.cycle_tables) whose parameters mean "size", "length" and "width", "x" and "y" (where a row has
none, the middle is where the probe stands); its primitive is one of the functions here or one of the control's own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from vcmm.program.cutter import Flat
from vcmm.program.cycle_tables import Values
from vcmm.program.moves import Point
from vcmm.program.probing import OVERTRAVEL, Feeler, at
from vcmm.program.recorder import Recorder
from vcmm.program.setup import Tool

Findings = dict[str, tuple[float, float]]  # meaning -> (set value, actual value), mm or deg


@dataclass(eq=False)
class MeasuringCycle:
    """One call. Its ways are those of a control that probes from where it stands, over the middle; others go in their own way."""

    r: Recorder
    v: Values
    column: int
    rapid: ClassVar[bool] = True

    @property
    def tool(self) -> Tool:
        """Tool that probes."""
        return self.r.tool_data

    @property
    def feeler(self) -> Feeler:
        return Feeler(self.r, self.tool, self.v.without("overtravel", OVERTRAVEL))

    def go(self, point: Point) -> None:
        """Move straight there, where that is a way."""
        if point != self.r.p:
            self.r.straight(point, self.rapid)

    def off(self, inside: bool) -> float | None:
        """Return mm between the middle of the ball and a surface from which it probes; None: from the middle of the feature."""
        raise NotImplementedError

    def depth(self, height: float) -> float:
        """Return the depth beside a feature, from a height."""
        raise NotImplementedError

    def approach(self, over: Point, ray: Flat, half: float, inside: bool) -> None:
        """Move to the start of a touch of a surface that is expected `half` mm from the middle along a unit vector of the plane."""
        self.go(over)
        off = self.off(inside)
        if off is not None:
            away = half + (-off if inside else off)
            self.go((over[0] + away * ray[0], over[1] + away * ray[1], over[2]))
            self.go(at(self.r.p, 2, self.depth(over[2])))

    def back(self, over: Point) -> None:
        """Move up after a touch, and over the middle."""
        self.go(at(self.r.p, 2, over[2]))
        self.go(over)

    def finish(self, start: Point) -> None:
        """Move after the last touch to the start of the cycle."""
        self.go(start)

    def middle(self) -> Flat:
        """Return the expected place of the feature."""
        return self.v.without("x", self.r.p[0]), self.v.without("y", self.r.p[1])

    def rim(self, middle: Flat, size: float, angle: float, inside: bool) -> Point:
        """Return the tip position at the touch of a bore, or of a boss from outside, at an angle (rad)."""
        over = (*middle, self.r.p[2])
        self.approach(over, (math.cos(angle), math.sin(angle)), size / 2.0, inside)
        tip = self.feeler.rim(middle, size, angle, inside)
        self.back(over)
        return tip

    def across(self, middle: Flat, axis: int, size: float, inside: bool) -> Flat:
        """Return the coordinates of two sides along an axis, the positive one first."""
        over, sides = (*middle, self.r.p[2]), []
        for side in (1.0, -1.0):
            self.approach(over, (side, 0.0) if axis == 0 else (0.0, side), size / 2.0, inside)
            expected = middle[axis] + side * size / 2.0
            sides.append(self.feeler.surface(axis, expected, side if inside else -side))
            self.back(over)
        return sides[0], sides[1]

    def along(self, axis: int, stops: Sequence[tuple[float, float, float]]) -> list[float]:
        """Return the coordinates of a surface along X or Y, at places along the other axis, each with the expected one and the way to it."""
        start, places = self.r.p, []
        for place, expected, sense in stops:
            self.go(at(start, 1 - axis, place))
            places.append(self.feeler.surface(axis, expected, sense))
        self.finish(start)
        return places


def circle(m: MeasuringCycle, inside: bool, angles: Sequence[float] | None = None) -> Findings:
    """Return a bore or boss by touches at angles (rad); without them across X, and across Y through the middle found."""
    start, size, (x, y) = m.r.p, m.v["size"], m.middle()
    if angles is None:
        tips = [m.rim((x, y), size, angle, inside) for angle in (0.0, math.pi)]
        middle = (tips[0][0] + tips[1][0]) / 2.0, y
        tips += [m.rim(middle, size, angle, inside) for angle in (math.pi / 2.0, -math.pi / 2.0)]
    else:
        tips = [m.rim((x, y), size, angle, inside) for angle in angles]
    m.finish(start)
    fit = m.feeler.circle(tips, inside)
    return {"size": (size, fit.diameter), "x": (x, fit.x), "y": (y, fit.y)}


def width(m: MeasuringCycle, inside: bool, axis: int, size: float) -> Findings:
    """Return a groove or web across X or Y."""
    start, middle = m.r.p, m.middle()
    plus, minus = m.across(middle, axis, size, inside)
    m.finish(start)
    return {"size": (size, plus - minus), "xy"[axis]: (middle[axis], (plus + minus) / 2.0)}


def rectangle(m: MeasuringCycle, inside: bool) -> Findings:
    """Return a pocket or stud parallel to the axes: across X, and across Y through the middle found."""
    start, sizes, (x, y) = m.r.p, (m.v["length"], m.v["width"]), m.middle()
    right, left = m.across((x, y), 0, sizes[0], inside)
    middle = (right + left) / 2.0
    rear, front = m.across((middle, y), 1, sizes[1], inside)
    m.finish(start)
    return {
        "length": (sizes[0], right - left), "width": (sizes[1], rear - front), "x": (x, middle), "y": (y, (rear + front) / 2.0)
    }  # fmt: skip
