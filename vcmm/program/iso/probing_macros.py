"""Measuring macros that machines with a spindle probe have (Fanuc, Haas and their kin), called by G65.

P9810 move, P9811 surface, P9812 web or pocket, P9814 bore or boss, P9815 inner and P9816 outer corner, P9821 web or pocket at an
angle, P9823 bore or boss by three points, P9843 angle of a surface; P9832 and P9833 switch the probe, P9801 to P9804 calibrate it.

Source: Renishaw, Inspection Plus software for Fanuc and Haas controls, programming manual H-2000-6222: X, Y, Z expected
position or size, D diameter, Z depth beside a web or boss, R clearance, Q overtravel, S work offset that is corrected (1 to 6:
G54 to G59, 101 on: G54.1 P1 on) by measured minus expected; #135 to #137 position, #138 size, #139 angle (deg, from X+), #140 to #143
their errors, #144 error of the angle. Where the program has a subprogram of that number itself, that one runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from vcmm.program.faults import BlockFault
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.offsets import OFFSETS, further
from vcmm.program.moves import Point
from vcmm.program.probing import OVERTRAVEL, Feeler, at, correct_zero, measuring_cycle, meeting
from vcmm.program.recorder import NO_TOOL

CLEAR = 8.0  # mm: R where it is not given
FEED = 3000.0  # mm/min: of the ways, where F is not given; the slow second touch is not in the time
NUMBER = dict(zip("ABCDFIJQRSXYZ", (1, 2, 3, 7, 9, 4, 5, 17, 18, 19, 24, 25, 26)))
INNER = 9815
POSITION, SIZE, ANGLE, ERROR, SECOND_ANGLE, SIZE_ERROR, ANGLE_ERROR = 135, 138, 139, 140, 142, 143, 144


class MeasuringCall:
    """One call. Lengths in mm."""

    def __init__(self, c: IsoControl, number: int, given: Mapping[int, float], column: int) -> None:
        self.c, self.inner, self.column = c, number == INNER, column
        self.plain = {letter: given[n] for letter, n in NUMBER.items() if n in given}
        self.feeler = Feeler(c, c.tools.get(c.tool, NO_TOOL), self.length("Q", OVERTRAVEL))

    def mm(self, letter: str) -> float | None:
        value = self.plain.get(letter)
        return None if value is None else value * self.c.unit

    def length(self, letter: str, otherwise: float) -> float:
        """mm, or what holds where the letter is not given."""
        value = self.mm(letter)
        return otherwise if value is None else value

    def need(self, letter: str, what: str) -> float:
        value = self.mm(letter)
        if value is None:
            raise BlockFault(self.column, what)
        return value

    def axis(self, letters: str, what: str) -> int:
        """The one axis that is given."""
        named = [i for i, letter in enumerate(letters) if letter in self.plain]
        if len(named) != 1:
            raise BlockFault(self.column, what)
        return named[0]

    def put(self, number: int, value: float) -> None:
        self.c.parameters.set(number, value, self.column)

    def set_results(self, *ones: tuple[int, float, float]) -> None:
        """(axis, position, expected) of each: results and their errors, and the work offset that is corrected by them."""
        c = self.c
        reads: list[float | None] = [None] * 3
        should: list[float | None] = [None] * 3
        for axis, position, expected in ones:
            reads[axis], should[axis] = position, expected
            self.put(POSITION + axis, position / c.unit)
            self.put(ERROR + axis, (position - expected) / c.unit)
        name = self.corrected_offset()
        if name:
            correct_zero(c, name, reads, should)
            c.rebuild()

    def corrected_offset(self) -> str:
        """The work offset of S, none where it is not given."""
        number = self.plain.get("S")
        if number is None:
            return ""
        if number > 100:
            return further(int(number) - 100)
        if 1 <= number <= 6:
            return OFFSETS[int(number) - 1]
        raise BlockFault(
            self.column,
            f"S{number:g} is no work offset; 1 to 6 are G54 to G59, 101 and on G54.1 P1 and on",
        )

    def size(self, size: float, expected: float) -> None:
        self.put(SIZE, size / self.c.unit)
        self.put(SIZE_ERROR, (size - expected) / self.c.unit)

    def outside(self, away: Point) -> None:
        """Beside a web or boss, and down to its depth Z."""
        depth = self.mm("Z")
        self.c.straight(away, False)
        if depth is not None:
            self.c.straight((away[0], away[1], depth), False)

    def sense(self, axis: int, expected: float) -> float:
        """+1 or -1: the way to what is expected along an axis."""
        way = expected - self.c.p[axis]
        if abs(way) < 1e-9:
            raise BlockFault(
                self.column, f"{'XYZ'[axis]} is where the probe stands already; start beside the surface"
            )
        return math.copysign(1.0, way)

    def clear(self) -> float:
        """mm between ball and surface from which it probes from outside."""
        return self.length("R", CLEAR) + self.feeler.radius


def measuring_macro(c: IsoControl, number: int, given: Mapping[int, float], column: int) -> bool:
    """Runs the macro of that number; False where it is none of these."""
    action = MACROS.get(number)
    if action is None and number in LATER:
        known = ", ".join(f"P{k}" for k in sorted(MACROS))
        c.assume(
            f"G65 P{number} ({LATER[number]})", "passed over: nothing is probed",
            f"G65 P{number} ({LATER[number]}) is not understood; known are {known}: measure with these, or put the macro itself beside the program, as O{number}.nc",
            column=column,
        )  # fmt: skip
        return True
    if action is None:
        return False
    c.column = column
    m = MeasuringCall(c, number, given, column)
    with measuring_cycle(c, f"G65 P{number}", m.length("F", 0.0) or FEED):
        action(m)
    return True


def _move(m: MeasuringCall) -> None:
    """P9810: straight there, stopping where something is in the way: nothing is."""
    end = [m.mm(letter) for letter in "XYZ"]
    m.c.straight(tuple(p if e is None else e for p, e in zip(m.c.p, end)), False)  # type: ignore[arg-type]


def _switch(m: MeasuringCall) -> None:
    """P9832, P9833: nothing moves."""


def _calibrate(m: MeasuringCall) -> None:
    """P9801 to P9804: length, offset and radius of the ball as the set-up states them."""
    m.c.remark(
        "calibrates the probe, which is passed over: its length and ball are those of the set-up; what the calibration errs by is u_length and u_radius of that "
        "tool in vcmm cut",
        m.column,
    )


def _surface(m: MeasuringCall) -> None:
    """P9811: one surface along one axis."""
    axis = m.axis("XYZ", "this macro takes one of X, Y and Z: the expected position of the surface")
    expected = m.length("XYZ"[axis], 0.0)
    m.set_results((axis, m.feeler.surface(axis, expected, m.sense(axis, expected)), expected))


def _web(m: MeasuringCall) -> None:
    """P9812: a pocket from inside, a web from outside (with Z), along X or Y."""
    axis = m.axis("XY", "P9812 takes X or Y: the expected width")
    size, start, outside = m.length("XY"[axis], 0.0), m.c.p, "Z" in m.plain
    found = []
    for side in (1.0, -1.0):
        if outside:
            m.outside(at(start, axis, start[axis] + side * (size / 2.0 + m.clear())))
        sense = -side if outside else side
        found.append(m.feeler.surface(axis, start[axis] + side * size / 2.0, sense))
        if outside:
            m.c.straight(at(m.c.p, 2, start[2]), False)
            m.c.straight(start, False)
    m.size(found[0] - found[1], size)
    m.set_results((axis, sum(found) / 2.0, start[axis]))


def _bore(m: MeasuringCall) -> None:
    """P9814: a bore from inside, a boss from outside (with Z): across X, then across Y through the middle found."""
    size = m.need("D", "P9814 takes D: the expected diameter")
    start = m.c.p
    tips = [_rim(m, start[:2], size, angle) for angle in (0.0, math.pi)]
    middle = (tips[0][0] + tips[1][0]) / 2.0, start[1]
    tips += [_rim(m, middle, size, angle) for angle in (math.pi / 2.0, -math.pi / 2.0)]
    _round(m, tips, size, start)


def _three(m: MeasuringCall) -> None:
    """P9823: a bore or boss by three points at the angles A, B and C (deg, from X+)."""
    size = m.need("D", "P9823 takes D, the expected diameter, and A, B, C: the angles of its three points")
    if any(letter not in m.plain for letter in "ABC"):
        raise BlockFault(m.column, "P9823 takes A, B and C: the angles of its three points, in degrees")
    start = m.c.p
    tips = [_rim(m, start[:2], size, math.radians(m.plain[letter])) for letter in "ABC"]
    _round(m, tips, size, start)


def _rim(m: MeasuringCall, middle: tuple[float, ...], size: float, angle: float) -> Point:
    """Where the probe answers at an angle; from outside with Z. It ends over the middle."""
    c, inside, (x, y) = m.c, "Z" not in m.plain, middle
    over = (x, y, c.p[2])
    c.straight(over, False)
    if not inside:
        away = size / 2.0 + m.clear()
        m.outside((x + away * math.cos(angle), y + away * math.sin(angle), over[2]))
    found = m.feeler.rim((x, y), size, angle, inside)
    if not inside:
        c.straight(at(c.p, 2, over[2]), False)
    c.straight(over, False)
    return found


def _round(m: MeasuringCall, tips: list[Point], size: float, start: Point) -> None:
    found = m.feeler.circle(tips, "Z" not in m.plain)
    m.c.straight(start, False)
    m.size(found.diameter, size)
    m.set_results((0, found.x, start[0]), (1, found.y, start[1]))


def _measure_at_angle(m: MeasuringCall) -> None:
    """P9821: a pocket from inside, a web from outside (with Z), of width D across the angle A (deg, from X+)."""
    size, angle = (
        m.need("D", "P9821 takes D, the expected width, and A: the angle across it"),
        m.plain.get("A"),
    )
    if angle is None:
        raise BlockFault(m.column, "P9821 takes A: the angle from X+ across the pocket or web, in degrees")
    start, turn = m.c.p, math.radians(angle)
    tips = [_rim(m, start[:2], size, a) for a in (turn, turn + math.pi)]
    m.c.straight(start, False)
    across = (tips[0][0] - tips[1][0]) * math.cos(turn) + (tips[0][1] - tips[1][1]) * math.sin(turn)
    m.size(across + (2.0 if "Z" not in m.plain else -2.0) * m.feeler.radius, size)
    m.set_results(*((i, (tips[0][i] + tips[1][i]) / 2.0, start[i]) for i in (0, 1)))


def _angle(m: MeasuringCall) -> None:
    """P9843: the angle of a surface along Y (X given) or along X (Y given), by two points D apart about where the probe stands."""
    axis = m.axis(
        "XY", "P9843 takes X or Y, where the surface is expected, and D: how far apart it is touched"
    )
    apart = m.need("D", "P9843 takes D: how far apart the two points lie")
    expected, start, other = m.length("XY"[axis], 0.0), m.c.p, 1 - axis
    sense, along = m.sense(axis, expected), m.plain.get("A", 0.0 if axis == 1 else 90.0)
    lean = math.tan(math.radians(along if axis == 1 else 90.0 - along))
    found = []
    for side in (-0.5, 0.5):
        m.c.straight(at(start, other, start[other] + side * apart), False)
        found.append(m.feeler.surface(axis, expected + side * apart * lean, sense))
    m.c.straight(start, False)
    step = found[1] - found[0]
    angle = math.degrees(math.atan2(step, apart) if axis == 1 else math.atan2(apart, step))
    m.put(ANGLE, angle)
    m.put(ANGLE_ERROR, angle - along)
    m.put(POSITION + axis, sum(found) / 2.0 / m.c.unit)


def _corner(m: MeasuringCall) -> None:
    """P9815, P9816: X and Y of a corner, from where the probe stands diagonally before it: from inside along X and Y; round an outer
    corner as far beyond it as it stands before it. I, J: a second touch further along X, along Y; then the surfaces may be turned."""
    c, start = m.c, m.c.p
    corner = [m.need(letter, "a corner takes X and Y, where it is expected") for letter in "XY"]
    sense = [m.sense(i, corner[i]) for i in (0, 1)]
    lines = []
    for axis, step in ((1, m.length("I", 0.0)), (0, m.length("J", 0.0))):
        other, tips = 1 - axis, []
        first = start[other] if m.inner else 2.0 * corner[other] - start[other]
        on = sense[other] * (-1.0 if m.inner else 1.0)
        for along in [first] + ([first + on * abs(step)] if step else []):
            c.straight(at(start, other, along), False)
            m.feeler.surface(axis, corner[axis], sense[axis])
            tips.append(c.skip or c.p)
        c.straight(at(start, other, along), False)
        c.straight(start, False)
        lines.append(tips)
    x, y, angles = meeting(lines, sense, m.feeler.radius)
    for k, (number, error, expected) in enumerate(
        ((SECOND_ANGLE, SIZE_ERROR, 0.0), (ANGLE, ANGLE_ERROR, 90.0))
    ):
        if len(lines[k]) == 2:
            m.put(number, angles[k])
            m.put(error, angles[k] - expected)
            m.c.remark(
                "after a corner with I or J #139 is taken as the angle of the surface touched along X, #142 of that touched along Y, both in degrees from X+",
                m.column,
            )
    m.set_results((0, x, corner[0]), (1, y, corner[1]))


MACROS: Mapping[int, Callable[[MeasuringCall], None]] = {
    9801: _calibrate, 9802: _calibrate, 9803: _calibrate, 9804: _calibrate, 9810: _move, 9811: _surface, 9812: _web, 9814: _bore, 9815: _corner,
    9816: _corner, 9821: _measure_at_angle, 9823: _three, 9832: _switch, 9833: _switch, 9843: _angle,
}  # fmt: skip
LATER: Mapping[int, str] = {
    9817: "rotary axis aligned by two surfaces", 9818: "rotary axis aligned by two bores", 9819: "bores or bosses on a pitch circle", 9820: "diagonal check of stock",
    9822: "corner at an angle", 9834: "from feature to feature", 9835: "statistics of an offset", 9836: "statistics of an offset", 9837: "statistics of an offset",
}  # fmt: skip
