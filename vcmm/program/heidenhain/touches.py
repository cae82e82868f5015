"""Parts of the touch probe cycles of Klartext: ways, touches, results, and their effect on the machine."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vcmm.program.cutter import Flat
from vcmm.program.heidenhain.probing import CLEARANCE
from vcmm.program.measuring import MeasuringCycle
from vcmm.program.moves import Point
from vcmm.program.probing import at, correct_turn, correct_zero

PRESETS = 6
FARTHEST = 130.0  # mm that a touch goes without an answer: DIST of the touch probe table, whose value is the machine's


@dataclass(eq=False)
class TouchCycle(MeasuringCycle):
    """One cycle. parameters: its parameters as programmed; values: Q parameters of the program, where results go."""

    values: dict[str, float]
    number: int
    parameters: Mapping[str, float]

    # -- ways --
    def leave(self) -> None:
        """Move to the clearance height, where there is one."""
        if self.v.has("over"):
            self.go(at(self.r.p, 2, self.v["over"]))

    def stand(self, x: float, y: float, height: float | None = None) -> None:
        """Move the lowest point of the ball to `height` at a place; without a height its middle to the measuring height Q261."""
        self.leave()
        self.go((x, y, self.r.p[2]))
        self.go(at(self.r.p, 2, self.v["height"] - self.feeler.radius if height is None else height))

    def approach(self, over: Point, ray: Flat, half: float, inside: bool) -> None:
        """Approach: in a feature that is too narrow for the set-up clearance it begins at the middle (manual, 408 and 412)."""
        reach = max(half - self.before(), 0.0) if inside else half + self.before()
        self.stand(over[0] + reach * ray[0], over[1] + reach * ray[1])

    def back(self, over: Point) -> None:
        """Move back: the tool stays beside the surface."""

    def finish(self, start: Point) -> None:
        self.leave()

    def before(self) -> float:
        """Return the mm between the middle of the ball and the surface from where probing begins."""
        return CLEARANCE + self.v["clear"] + self.feeler.radius

    # -- touches --
    def side(self, expected: Flat, axis: int, sense: float) -> Point:
        """Return the tip position at the touch of a surface expected at (x, y), along X or Y; the ball then is beside it."""
        start = list(expected)
        start[axis] -= sense * self.before()
        self.stand(start[0], start[1])
        self.feeler.surface(axis, expected[axis], sense)
        return self.r.skip or self.r.p

    def coordinate(self, expected: Flat, axis: int, sense: float) -> float:
        """Measure the coordinate of a surface that is expected at (x, y), along X or Y."""
        return self.side(expected, axis, sense)[axis] + sense * self.feeler.radius

    def top(self, x: float, y: float, expected: float, sense: float = -1.0) -> float:
        """Measure the height of a surface square to Z, from above."""
        self.stand(x, y, expected - sense * (CLEARANCE + self.v["clear"]))
        reads = self.feeler.surface(2, expected, sense)
        self.leave()
        return reads

    def angles(self) -> list[float]:
        """Return the angles of the touches of a circle, rad: four, or Q423 = 3, from Q325 on, Q247 apart."""
        count = round(self.v.without("points", 4.0))
        if count not in (3, 4):
            self.r.fault(f"TCH PROBE {self.number}: Q423 = {count} must be 3 or 4 points", self.column)
        step = self.v.without("step", 90.0) or 360.0 / count
        return [math.radians(self.v["first"] + k * step) for k in range(count)]

    def hole(self, x: float, y: float) -> tuple[float, float]:
        """Measure the middle of a hole of unknown size: by four points from its expected place."""
        r, tips = self.r, []
        self.stand(x, y)
        for k in range(4):
            angle = k * math.pi / 2.0
            tips.append(self.feeler.until((math.cos(angle), math.sin(angle), 0.0), FARTHEST))
            if tips[-1] is None:
                r.fault(
                    f"TCH PROBE {self.number} finds no hole at X {x:g}, Y {y:g} (mm), and the cycle does not say how large it is; state it in the set-up file, as "
                    f'[[surfaces]] with point = "{x:g} {y:g} 0 mm", diameter and inside = true',
                    self.column,
                )
        self.leave()
        fit = self.feeler.circle([t for t in tips if t is not None], True)
        return fit.x, fit.y

    # -- what the machine sets --
    def preset(self) -> str:
        """Return the work offset of Q305; '' for one that the set-up has not."""
        r, number = self.r, self.v.number("preset")
        if number > PRESETS:
            r.assume(
                f"preset {number}", "not written: the set-up has 1 to 6, which are G54 to G59",
                f"TCH PROBE {self.number} writes preset {number} (Q305), which the set-up has not; 1 to 6 are G54 to G59 there, 0 is the one in force",
            )  # fmt: skip
            return ""
        return r.offset if number == 0 else f"G{53 + number}"

    def datum(self, reads: Sequence[float | None], should: Sequence[float | None]) -> None:
        """Set the datum: the found values read so from here on, and the touch probe axis too where Q381 = 1 asks for it."""
        actual, wanted = [*reads], [*should]
        if self.v["also_z"]:
            self.check("Q382", "Q383", "Q384")
            actual[2], wanted[2] = self.top(self.v["z_x"], self.v["z_y"], self.v["z_z"]), self.v["new_z"]
        name = self.preset()
        if name:
            correct_zero(self.r, name, actual, wanted)
            self.r.refresh()

    def turn(self, degrees: float) -> None:
        """Turn by a basic rotation: the found angle reads Q307 from here on."""
        name = self.preset()
        if name:
            correct_turn(self.r, name, math.radians(degrees - self.v["new_angle"]))
            self.r.refresh()

    # -- remarks --
    def check(self, *needed: str) -> None:
        missing = next((name for name in needed if name not in self.parameters), None)
        if missing:
            self.r.fault(f"TCH PROBE {self.number} needs {missing}; add it", self.column)

    def axis(self, most: int) -> int:
        """Return the axis of Q272."""
        if self.v["axis"] not in range(1, most + 1):
            self.r.fault(
                f"TCH PROBE {self.number}: Q272 = {self.v['axis']:g} must be {'1, 2 or 3' if most == 3 else '1 or 2'}, the axis along which it measures",
                self.column,
            )
        return self.v.number("axis") - 1

    def sense(self) -> float:
        """Return the sense of Q267."""
        if self.v["sense"] not in (-1.0, 1.0):
            self.r.fault(
                f"TCH PROBE {self.number}: Q267 = {self.v['sense']:g} must be -1 or +1, the way to the surface",
                self.column,
            )
        return self.v["sense"]
