"""MeasuringCall macros that machines with a spindle probe have: P9810 (move), P9811 (surface), P9812 (web, pocket), P9814 (bore, boss).

Source: Renishaw, Inspection Plus software for Fanuc and Haas controls, programming manual H-2000-6222: X, Y, Z expected
position or size, D diameter, Z depth beside a web or boss, R clearance, Q overtravel, S work offset that is corrected (1 to 6:
G54 to G59, 101 on: G54.1 P1 on) by measured minus expected; #135 to #137 position, #138 size, #140 to #143 their errors.
Where the program has a subprogram of that number itself, that one runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from vcmm.nc.faults import BlockFault
from vcmm.nc.iso.control import IsoControl
from vcmm.nc.iso.offsets import OFFSETS, further
from vcmm.nc.moves import ORIGIN
from vcmm.nc.probing import OVERTRAVEL, at, ball_radius, corrected_zero, read_surface
from vcmm.nc.recorder import NO_TOOL
from vcmm.nc.setup import Tool

CLEAR = 8.0  # mm: R where it is not given
FEED = 3000.0  # mm/min: of the ways, where F is not given; the slow second touch is not in the time
NUMBER = dict(zip("XYZDFQRS", (24, 25, 26, 7, 9, 17, 18, 19)))
POSITION, SIZE, ERROR, SIZE_ERROR = 135, 138, 140, 143


class MeasuringCall:
    """One call. Lengths in mm."""

    def __init__(self, c: IsoControl, given: Mapping[int, float], column: int) -> None:
        self.c, self.column = c, column
        self.plain = {letter: given[n] for letter, n in NUMBER.items() if n in given}

    @property
    def tool(self) -> Tool:
        return self.c.tools.get(self.c.tool, NO_TOOL)

    def mm(self, letter: str) -> float | None:
        value = self.plain.get(letter)
        return None if value is None else value * self.c.unit

    def axis(self) -> int:
        """The one axis that is given."""
        named = [i for i, letter in enumerate("XYZ") if letter in self.plain]
        if len(named) != 1:
            raise BlockFault(
                self.column, "this macro takes one of X, Y and Z: the expected position of the surface"
            )
        return named[0]

    def surface(self, axis: int, expected: float, sense: float) -> float:
        return read_surface(self.c, axis, expected, sense, self.tool, overtravel=self.mm("Q") or OVERTRAVEL)

    def result(self, axis: int, position: float, expected: float) -> None:
        """Position and its error, and the work offset that is corrected by it."""
        c = self.c
        c.parameters.set(POSITION + axis, position / c.unit, self.column)
        c.parameters.set(ERROR + axis, (position - expected) / c.unit, self.column)
        number = self.plain.get("S")
        if number is None:
            return
        name = (
            further(int(number) - 100)
            if number > 100
            else OFFSETS[int(number) - 1]
            if 1 <= number <= 6
            else ""
        )
        if not name:
            raise BlockFault(
                self.column,
                f"S{number:g} is no work offset; 1 to 6 are G54 to G59, 101 and on G54.1 P1 and on",
            )
        shifted, kept = corrected_zero(c, axis, position, expected), c.offsets.get(name, ORIGIN)
        c.offsets[name] = shifted if name == c.offset else at(kept, axis, shifted[axis])
        c.rebuild()

    def size(self, size: float, expected: float) -> None:
        self.c.parameters.set(SIZE, size / self.c.unit, self.column)
        self.c.parameters.set(SIZE_ERROR, (size - expected) / self.c.unit, self.column)


def measuring_macro(c: IsoControl, number: int, given: Mapping[int, float], column: int) -> bool:
    """Runs the macro of that number; False where it is none of these."""
    action = MACROS.get(number)
    if action is None:
        return False
    c.column = column
    m = MeasuringCall(c, given, column)
    mode, feed = c.feed_mode, c.feed
    c.feed_mode, c.feed = "G94", m.mm("F") or FEED
    action(m)
    c.feed_mode, c.feed = mode, feed
    return True


def _move(m: MeasuringCall) -> None:
    """P9810: straight there, stopping where something is in the way: nothing is."""
    end = [m.mm(letter) for letter in "XYZ"]
    m.c.straight(tuple(p if e is None else e for p, e in zip(m.c.p, end)), False)  # type: ignore[arg-type]


def _surface(m: MeasuringCall) -> None:
    """P9811: one surface along one axis."""
    axis = m.axis()
    expected = m.mm("XYZ"[axis]) or 0.0
    if abs(expected - m.c.p[axis]) < 1e-9:
        raise BlockFault(
            m.column, f"{'XYZ'[axis]} is where the probe stands already; start beside the surface"
        )
    sense = 1.0 if expected > m.c.p[axis] else -1.0
    m.result(axis, m.surface(axis, expected, sense), expected)


def _across(m: MeasuringCall, axis: int, size: float) -> tuple[float, float]:
    """(middle, width) along an axis, about where the probe stands: from inside, or, with Z, from outside at that depth."""
    c, start, depth = m.c, m.c.p, m.mm("Z")
    found = []
    for side in (1.0, -1.0):
        if depth is not None:
            away = size / 2.0 + (m.mm("R") or CLEAR) + ball_radius(m.tool)
            beside = at(start, axis, start[axis] + side * away)
            c.straight(beside, False)
            c.straight((beside[0], beside[1], depth), False)
        sense = side if depth is None else -side
        found.append(m.surface(axis, start[axis] + side * size / 2.0, sense))
        if depth is not None:
            c.straight(beside, False)
            c.straight(start, False)
    return sum(found) / 2.0, found[0] - found[1]


def _web(m: MeasuringCall) -> None:
    """P9812: a pocket from inside, a web from outside (with Z), along X or Y."""
    named = [i for i, letter in enumerate("XY") if letter in m.plain]
    if len(named) != 1:
        raise BlockFault(m.column, "P9812 takes X or Y: the expected width")
    size, expected = m.mm("XY"[named[0]]) or 0.0, m.c.p[named[0]]
    middle, width = _across(m, named[0], size)
    m.size(width, size)
    m.result(named[0], middle, expected)


def _bore(m: MeasuringCall) -> None:
    """P9814: a bore from inside, a boss from outside (with Z): across X, then across Y through the middle found."""
    size = m.mm("D")
    if size is None:
        raise BlockFault(m.column, "P9814 takes D: the expected diameter")
    expected = m.c.p
    x, _ = _across(m, 0, size)
    m.c.straight(at(expected, 0, x), False)
    y, width = _across(m, 1, size)
    m.size(width, size)
    m.c.straight(expected, False)
    m.result(0, x, expected[0])
    m.result(1, y, expected[1])


MACROS: Mapping[int, Callable[[MeasuringCall], None]] = {9810: _move, 9811: _surface, 9812: _web, 9814: _bore}
