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
from typing import NamedTuple

from vcmm.program.cycle_tables import Cycle, cycle, in_units
from vcmm.program.faults import BlockFault
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.offsets import OFFSETS, further
from vcmm.program.measuring import Findings, MeasuringCycle, circle, width
from vcmm.program.moves import Point
from vcmm.program.probing import at, correct_zero, measuring_cycle, meeting
from vcmm.program.recorder import NO_TOOL
from vcmm.program.setup import Tool

CLEAR = 8.0  # mm: R where it is not given
FEED = 3000.0  # mm/min: of the ways, where F is not given; the slow second touch is not in the time
NUMBER = dict(zip("ABCDFIJQRSXYZ", (1, 2, 3, 7, 9, 4, 5, 17, 18, 19, 24, 25, 26)))
RESULTS = {  # meaning -> variables of the actual value and its error
    "x": (135, 140), "y": (136, 141), "z": (137, 142), "size": (138, 143), "angle": (139, 144), "second angle": (142, 143),
}  # fmt: skip


class MacroCall(MeasuringCycle):
    """One call, from outside where it has a depth."""

    rapid = False
    r: IsoControl

    @property
    def tool(self) -> Tool:
        return self.r.tools.get(self.r.tool, NO_TOOL)

    @property
    def inside(self) -> bool:
        return not self.v.has("depth")

    def off(self, inside: bool) -> float | None:
        return None if inside else self.v.without("clear", CLEAR) + self.feeler.radius

    def depth(self, height: float) -> float:
        return self.v["depth"]

    def put(self, number: int, value: float) -> None:
        self.r.parameters.set(number, value, self.column)

    def axis(self, letters: str, what: str) -> int:
        """Return the one given axis."""
        named = [i for i, letter in enumerate(letters) if self.v.has(letter)]
        if len(named) != 1:
            raise BlockFault(self.column, what)
        return named[0]

    def sense(self, axis: int, expected: float) -> float:
        """Return +1 or -1: the way to the expected surface along an axis."""
        way = expected - self.r.p[axis]
        if abs(way) < 1e-9:
            raise BlockFault(
                self.column, f"{'XYZ'[axis]} is the present position of the probe; start beside the surface"
            )
        return math.copysign(1.0, way)

    def report(self, findings: Findings) -> None:
        """Report results and their errors, and correct the work offset by those of the axes."""
        c = self.r
        for meaning, (should, reads) in findings.items():
            unit = 1.0 if "angle" in meaning else c.unit
            self.put(RESULTS[meaning][0], reads / unit)
            self.put(RESULTS[meaning][1], (reads - should) / unit)
        name = self.corrected_offset() if any(k in findings for k in "xyz") else ""
        if name:
            ends = [findings.get(k, (None, None)) for k in "xyz"]
            correct_zero(c, name, [reads for _, reads in ends], [should for should, _ in ends])
            c.rebuild()

    def corrected_offset(self) -> str:
        """Return the work offset of S, none where it is not given."""
        if not self.v.has("offset"):
            return ""
        number = self.v["offset"]
        if number > 100:
            return further(int(number) - 100)
        if 1 <= number <= 6:
            return OFFSETS[int(number) - 1]
        raise BlockFault(
            self.column,
            f"S{number:g} is no work offset; 1 to 6 are G54 to G59, 101 and on G54.1 P1 and on",
        )


MacroPrimitive = Callable[[MacroCall], Findings | None]


class Macro(NamedTuple):
    """A row, and the sentences for missing needed words (the last sentence is for all later words too)."""

    row: Cycle[MacroPrimitive]
    needs: tuple[str, ...] = ()


def measuring_macro(c: IsoControl, number: int, arguments: Mapping[int, float], column: int) -> bool:
    """Run the macro of that number; False where it is none of the measuring macros."""
    if number in LATER:
        numbers = ", ".join(f"P{k}" for k in sorted(MACROS))
        c.assume(
            f"G65 P{number} ({LATER[number]})", "passed over: nothing is probed",
            f"G65 P{number} ({LATER[number]}) is not understood; known are {numbers}: measure with these, or put the macro itself beside the program, as O{number}.nc",
            column=column,
        )  # fmt: skip
    if number not in MACROS:
        return number in LATER
    c.column, (row, needs) = column, MACROS[number]
    words = {letter: arguments[n] for letter, n in NUMBER.items() if n in arguments}
    m = MacroCall(c, row.read(words, in_units(c.unit, c.unit)), column)
    with measuring_cycle(c, f"G65 P{number}", m.v["feed"] or FEED):
        for k, name in enumerate(row.required_names):
            if name not in words:
                raise BlockFault(column, needs[min(k, len(needs) - 1)])
        m.report(row.primitive(m) or {})
    return True


def _move(m: MacroCall) -> None:
    """Move straight; no obstacle is modelled."""
    x, y, z = (m.v.without(letter, p) for letter, p in zip("XYZ", m.r.p))
    m.r.straight((x, y, z), False)


def _switch(m: MacroCall) -> None:
    """Switch the probe; no axis moves."""


def _calibrate(m: MacroCall) -> None:
    """Set length, offset and radius of the ball as the set-up states them."""
    m.r.remark(
        "calibrates the probe, which is passed over: its length and ball are those of the set-up; what the calibration errs by is u_length and u_radius of that "
        "tool in vcmm cut",
        m.column,
    )


def _surface(m: MacroCall) -> Findings:
    """Return the findings of one surface along one axis."""
    axis = m.axis("XYZ", "this macro takes one of X, Y and Z: the expected position of the surface")
    expected = m.v["XYZ"[axis]]
    return {"xyz"[axis]: (expected, m.feeler.surface(axis, expected, m.sense(axis, expected)))}


def _three(m: MacroCall) -> Findings:
    """Return a bore or boss by three points at the angles A, B and C (deg, from X+)."""
    return circle(m, m.inside, [math.radians(m.v[letter]) for letter in "ABC"])


def _at_angle(m: MacroCall) -> Findings:
    """Return a pocket from inside, a web from outside, across the angle A (deg, from X+)."""
    start, size, turn = m.r.p, m.v["size"], math.radians(m.v["angle"])
    first, second = (m.rim(start[:2], size, a, m.inside) for a in (turn, turn + math.pi))
    m.finish(start)
    across = (first[0] - second[0]) * math.cos(turn) + (first[1] - second[1]) * math.sin(turn)
    reads = across + (2.0 if m.inside else -2.0) * m.feeler.radius
    ends = {"xy"[i]: (start[i], (first[i] + second[i]) / 2.0) for i in (0, 1)}
    return {"size": (size, reads), **ends}


def _angle(m: MacroCall) -> Findings:
    """Return the angle of a surface along Y (X given) or along X (Y given), by two points D apart about where the probe stands."""
    axis = m.axis(
        "XY", "P9843 takes X or Y, where the surface is expected, and D: how far apart it is touched"
    )
    if not m.v.has("apart"):
        raise BlockFault(m.column, "P9843 takes D: how far apart the two points lie")
    apart, expected, place = m.v["apart"], m.v["XY"[axis]], m.r.p[1 - axis]
    sense, along = m.sense(axis, expected), m.v.without("angle", 0.0 if axis == 1 else 90.0)
    lean = math.tan(math.radians(along if axis == 1 else 90.0 - along))
    places = m.along(axis, [(place + k * apart, expected + k * apart * lean, sense) for k in (-0.5, 0.5)])
    step = places[1] - places[0]
    m.put(RESULTS["xy"[axis]][0], sum(places) / 2.0 / m.r.unit)
    return {"angle": (along, math.degrees(math.atan2(step, apart) if axis == 1 else math.atan2(apart, step)))}


def _corner(m: MacroCall, inner: bool) -> Findings:
    """Return X and Y of a corner, from the probe diagonally before it: from inside along X and Y; round an outer
    corner as far beyond it as the probe is before it. I, J: a second touch further along X, along Y; then the surfaces may be turned."""
    c, start, corner = m.r, m.r.p, (m.v["X"], m.v["Y"])
    sense = [m.sense(i, corner[i]) for i in (0, 1)]
    lines: list[list[Point]] = []
    for axis, step in ((1, m.v["I"]), (0, m.v["J"])):
        other, tips = 1 - axis, []
        first = start[other] if inner else 2.0 * corner[other] - start[other]
        on = sense[other] * (-1.0 if inner else 1.0)
        for along in [first] + ([first + on * abs(step)] if step else []):
            m.go(at(start, other, along))
            m.feeler.surface(axis, corner[axis], sense[axis])
            tips.append(c.skip or c.p)
        m.finish(start)
        lines.append(tips)
    x, y, angles = meeting(lines, sense, m.feeler.radius)
    turned = {"second angle": (0.0, angles[0]), "angle": (90.0, angles[1])}
    turned = {k: v for (k, v), tips in zip(turned.items(), lines) if len(tips) == 2}
    for _ in turned:
        c.remark(
            "after a corner with I or J #139 is taken as the angle of the surface touched along X, #142 of that touched along Y, both in degrees from X+",
            m.column,
        )
    return {**turned, "x": (corner[0], x), "y": (corner[1], y)}


def _web(m: MacroCall) -> Findings:
    """Return a pocket from inside, a web from outside, along X or Y."""
    axis = m.axis("XY", "P9812 takes X or Y: the expected width")
    return width(m, m.inside, axis, m.v["XY"[axis]])


_ALL, _DEPTH = "Q=overtravel mm?, S=offset plain?, F=feed mm", "Z=depth mm?, R=clear mm?"
_CALIBRATE, _SWITCH = Macro(cycle(_ALL, _calibrate)), Macro(cycle(_ALL, _switch))
_CORNER = f"X mm!, Y mm!, I mm, J mm, {_ALL}"
_CORNER_NEEDS = ("a corner takes X and Y, where it is expected",)
MACROS: Mapping[int, Macro] = {
    9801: _CALIBRATE, 9802: _CALIBRATE, 9803: _CALIBRATE, 9804: _CALIBRATE, 9810: Macro(cycle(f"X mm?, Y mm?, Z mm?, {_ALL}", _move)),
    9811: Macro(cycle(f"X mm?, Y mm?, Z mm?, {_ALL}", _surface)),
    9812: Macro(cycle(f"X mm?, Y mm?, {_DEPTH}, {_ALL}", _web)),
    9814: Macro(cycle(f"D=size mm!, {_DEPTH}, {_ALL}", lambda m: circle(m, m.inside)), ("P9814 takes D: the expected diameter",)),
    9815: Macro(cycle(_CORNER, lambda m: _corner(m, True)), _CORNER_NEEDS),
    9816: Macro(cycle(_CORNER, lambda m: _corner(m, False)), _CORNER_NEEDS),
    9821: Macro(cycle(f"D=size mm!, A=angle plain!, {_DEPTH}, {_ALL}", _at_angle), (
        "P9821 takes D, the expected width, and A: the angle across it", "P9821 takes A: the angle from X+ across the pocket or web, in degrees")),
    9823: Macro(cycle(f"D=size mm!, A plain!, B plain!, C plain!, {_DEPTH}, {_ALL}", _three), (
        "P9823 takes D, the expected diameter, and A, B, C: the angles of its three points", "P9823 takes A, B and C: the angles of its three points, in degrees")),
    9832: _SWITCH, 9833: _SWITCH,
    9843: Macro(cycle(f"X mm?, Y mm?, D=apart mm?, A=angle plain?, {_ALL}", _angle)),
}  # fmt: skip
LATER: Mapping[int, str] = {
    9817: "rotary axis aligned by two surfaces", 9818: "rotary axis aligned by two bores", 9819: "bores or bosses on a pitch circle", 9820: "diagonal check of stock",
    9822: "corner at an angle", 9834: "from feature to feature", 9835: "statistics of an offset", 9836: "statistics of an offset", 9837: "statistics of an offset",
}  # fmt: skip
