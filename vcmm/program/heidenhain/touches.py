"""What the touch probe cycles of Klartext are made of: ways, touches, results, and what the machine sets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vcmm.program.heidenhain.probing import CLEARANCE
from vcmm.program.moves import Point
from vcmm.program.probing import Feeler, ProbedCircle, at, correct_turn, correct_zero
from vcmm.program.recorder import Recorder

PRESETS = 6
FARTHEST = 130.0  # mm that a touch goes without an answer: DIST of the touch probe table, whose value is the machine's


@dataclass(eq=False)
class TouchCycle:
    """One cycle. q: its parameters, lengths in mm; values: Q parameters of the program, where results go."""

    recorder: Recorder
    values: dict[str, float]
    number: int
    q: Mapping[str, float]
    column: int

    @property
    def feeler(self) -> Feeler:
        return Feeler(self.recorder, self.recorder.tool_data)

    def value(self, name: str, otherwise: float = 0.0) -> float:
        return self.q.get(name, otherwise)

    def point(self, *names: str) -> tuple[float, ...]:
        return tuple(self.q[n] for n in names)

    def result(self, **found: float) -> None:
        """Q151=...: lengths, mm."""
        for name, value in found.items():
            self.values[name] = value / self.recorder.unit

    def angle(self, degrees: float) -> None:
        self.values["Q150"] = degrees

    # -- ways --
    def over(self, x: float, y: float) -> None:
        """Over a place, at the clearance height."""
        r = self.recorder
        if "Q260" in self.q:
            r.straight(at(r.p, 2, self.q["Q260"]), True)
        r.straight((x, y, r.p[2]), True)

    def stand(self, x: float, y: float, height: float | None = None) -> None:
        """At a place, the lowest point of the ball at `height`; without one its middle at the measuring height Q261."""
        self.over(x, y)
        if height is None:
            height = self.value("Q261") - self.feeler.radius
        self.recorder.straight(at(self.recorder.p, 2, height), True)

    def leave(self) -> None:
        r = self.recorder
        if "Q260" in self.q:
            r.straight(at(r.p, 2, self.q["Q260"]), True)

    def before(self) -> float:
        """mm between the middle of the ball and the surface from where probing begins."""
        return CLEARANCE + self.value("Q320") + self.feeler.radius

    # -- touches --
    def side(self, expected: Sequence[float], axis: int, sense: float) -> Point:
        """Where the tip is when a surface answers that is expected at (x, y), along X or Y; the ball then is beside it."""
        start = list(expected)
        start[axis] -= sense * self.before()
        self.stand(start[0], start[1])
        self.feeler.surface(axis, expected[axis], sense)
        return self.recorder.skip or self.recorder.p

    def coordinate(self, expected: Sequence[float], axis: int, sense: float) -> float:
        """Of a surface that is expected at (x, y), along X or Y."""
        return self.side(expected, axis, sense)[axis] + sense * self.feeler.radius

    def top(self, x: float, y: float, expected: float, sense: float = -1.0) -> float:
        """Of a surface square to Z, from above."""
        self.stand(x, y, expected - sense * (CLEARANCE + self.value("Q320")))
        found = self.feeler.surface(2, expected, sense)
        self.leave()
        return found

    def width(self, middle: Sequence[float], axis: int, size: float, inside: bool) -> tuple[float, float]:
        """(middle, width) along an axis."""
        ends = []
        for side in (1.0, -1.0):
            expected = list(middle)
            expected[axis] += side * size / 2.0
            ends.append(self.coordinate(expected, axis, side if inside else -side))
        self.leave()
        return sum(ends) / 2.0, ends[0] - ends[1]

    def circle(self, nominal: Sequence[float], inside: bool) -> ProbedCircle:
        """A circle of nominal x, y and diameter by four points, or Q423 = 3, from the angle Q325 on, Q247 apart."""
        x, y, size = nominal
        count, tips = round(self.value("Q423", 4.0)), []
        if count not in (3, 4):
            self.recorder.fault(f"TCH PROBE {self.number}: Q423 = {count} must be 3 or 4 points", self.column)
        step = self.value("Q247", 90.0) or 360.0 / count
        for k in range(count):
            angle = math.radians(self.value("Q325") + k * step)
            reach = size / 2.0 + (-self.before() if inside else self.before())
            reach = max(reach, 0.0) if inside else reach
            self.stand(x + reach * math.cos(angle), y + reach * math.sin(angle))
            tips.append(self.feeler.rim((x, y), size, angle, inside))
        self.leave()
        return self.feeler.circle(tips, inside)

    def hole(self, x: float, y: float) -> tuple[float, float]:
        """The middle of a hole whose size nothing says: by four points from where it is expected."""
        r, tips = self.recorder, []
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
        found = self.feeler.circle([t for t in tips if t is not None], True)
        return found.x, found.y

    # -- what the machine sets --
    def preset(self) -> str:
        """The work offset of Q305; '' for one that the set-up has not."""
        r, number = self.recorder, round(self.value("Q305"))
        if number > PRESETS:
            r.assume(
                f"preset {number}", "not written: the set-up has 1 to 6, which are G54 to G59",
                f"TCH PROBE {self.number} writes preset {number} (Q305), which the set-up has not; 1 to 6 are G54 to G59 there, 0 is the one in force",
            )  # fmt: skip
            return ""
        return r.offset if number == 0 else f"G{53 + number}"

    def datum(self, reads: Sequence[float | None]) -> None:
        """What is found reads Q331, Q332 (and Q333 where Q381 = 1 asks for the touch probe axis too) from here on."""
        should: list[float | None] = [self.value("Q331"), self.value("Q332"), None]
        found = [*reads]
        if self.value("Q381"):
            self.check("Q382", "Q383", "Q384")
            found[2], should[2] = self.top(*self.point("Q382", "Q383", "Q384")), self.value("Q333")
        self.shift(found, [None if f is None else s for f, s in zip(found, should)])

    def shift(self, reads: Sequence[float | None], should: Sequence[float | None]) -> None:
        name = self.preset()
        if name:
            correct_zero(self.recorder, name, reads, should)
            self.recorder.refresh()

    def turn(self, degrees: float) -> None:
        """A basic rotation: what lies at that angle lies at Q307 from here on."""
        name = self.preset()
        if name:
            correct_turn(self.recorder, name, math.radians(degrees - self.value("Q307")))
            self.recorder.refresh()

    # -- what is said --
    def check(self, *needed: str) -> None:
        missing = next((name for name in needed if name not in self.q), None)
        if missing:
            self.recorder.fault(f"TCH PROBE {self.number} needs {missing}; add it", self.column)

    def axis(self, most: int) -> int:
        """Q272."""
        self.check("Q272")
        said = "1, 2 or 3" if most == 3 else "1 or 2"
        if self.q["Q272"] not in range(1, most + 1):
            self.recorder.fault(
                f"TCH PROBE {self.number}: Q272 = {self.q['Q272']:g} must be {said}, the axis along which it measures",
                self.column,
            )
        return round(self.q["Q272"]) - 1

    def sense(self) -> float:
        """Q267."""
        self.check("Q267")
        if self.q["Q267"] not in (-1.0, 1.0):
            self.recorder.fault(
                f"TCH PROBE {self.number}: Q267 = {self.q['Q267']:g} must be -1 or +1, the way to the surface",
                self.column,
            )
        return self.q["Q267"]
