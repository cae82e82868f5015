"""Measuring cycles of Sinumerik: CYCLE976 (calibrate), CYCLE977, CYCLE978, CYCLE979, CYCLE998, in both ways of calling them.

Source: Siemens, SINUMERIK 840D sl / 828D, Programming Manual Measuring Cycles: 09/2011 (arguments in brackets) and 03/2009 (parameters
_MVAR, _SETVAL, _KNUM ... set before a call without brackets). _MVAR: last digit what is measured (1 hole, 2 spigot, 3 groove, 4 web,
5 and 6 rectangle inside and outside; of CYCLE998 5 the angle of one edge), third digit from the end what is corrected (0 nothing, 1 a
work offset), fourth whether a protection zone is gone round. _KNUM: 0 none, 1 to 99 G54 to G57 and G505 to G599 (10000 more: fine or
coarse value), 9000 the one in force. Results in _OVR: [0] set, [4] actual, [16] difference, of each what follows it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

from vcmm.program.faults import BlockFault
from vcmm.program.moves import Point
from vcmm.program.probing import OVERTRAVEL, Feeler, at, correct_turn, correct_zero, measuring_cycle
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.memory import MEASURING, Variable
from vcmm.program.sinumerik.state import SinumerikControl

FEED = 300.0  # mm/min, as usual of measuring feeds; it is a setting of the machine
ACTIVE, FINE = 9000, 10000  # of _KNUM
_ENDS = ("TNAME", "DLNUM", "TZL", "TDIF", "TUL", "TLL", "TMV", "K", "EVNUM", "MCBIT", "DMODE", "AMODE")
ARGUMENTS: Mapping[str, tuple[str, ...]] = {
    "CYCLE977": (
        "MVAR", "KNUM", "KNUM1", "PRNUM", "SETVAL", "SETV[0]", "SETV[1]", "FA", "TSA", "STA1", "ID", "SZA", "SZO", "MA", "NMSP", *_ENDS,
    ),
    "CYCLE978": ("MVAR", "KNUM", "KNUM1", "PRNUM", "SETVAL", "FA", "TSA", "MA", "MD", "NMSP", *_ENDS),
    "CYCLE998": (
        "MVAR", "KNUM", "RA", "PRNUM", "SETVAL", "STA1", "INCA", "FA", "TSA", "MA", "MD", "ID", "SETV[0]", "SETV[1]", "SETV[2]", "SETV[3]", "NMSP",
        "EVNUM", "DMODE", "AMODE",
    ),
}  # fmt: skip
SHAPES = {1: "hole", 2: "spigot", 3: "groove", 4: "web", 5: "rectangle inside", 6: "rectangle outside"}


@dataclass(eq=False)
class SinumerikMeasuring:
    """One call. given: by name without underscore, in the unit of the program; old: called without brackets."""

    i: SinumerikControl
    runner: SinumerikRunner
    item: Item
    given: dict[str, float]
    old: bool

    def fault(self, text: str) -> NoReturn:
        raise BlockFault(self.item.first, f"{self.item.name}: {text}")

    def value(self, name: str, otherwise: float = 0.0) -> float:
        return self.given.get(name, otherwise)

    def mm(self, name: str, otherwise: float = 0.0) -> float:
        return self.given[name] * self.i.r.unit if name in self.given else otherwise

    def need(self, name: str, what: str) -> float:
        """mm."""
        if name not in self.given:
            self.fault(
                f"it needs {'_' if self.old else 'S_'}{name.replace('SETVAL', 'SETVAL' if self.old else 'SETV')}, {what}"
            )
        return self.mm(name)

    @property
    def kind(self) -> int:
        """Last digit of _MVAR."""
        return round(self.value("MVAR")) % 10

    @property
    def zone(self) -> bool:
        """Whether a protection zone is gone round: probing from the middle over an island."""
        return round(self.value("MVAR")) // 1000 % 10 == 1

    @property
    def feeler(self) -> Feeler:
        """_FA is how far it goes beyond, always mm."""
        return Feeler(self.i.r, self.i.r.tool_data, self.value("FA", OVERTRAVEL))

    def axis(self, allowed: int) -> int:
        """_MA: 1, 2, 3."""
        axis = round(self.value("MA"))
        if not 1 <= axis <= allowed:
            self.fault(
                f"_MA = {axis} must be {'1, 2 or 3' if allowed == 3 else '1 or 2'}, the axis along which it measures"
            )
        return axis - 1

    def corrected_offset(self) -> str:
        """The work offset that is to be corrected, none where it only measures."""
        target, number = round(self.value("MVAR")) // 100 % 10, round(self.value("KNUM"))
        tool = target in (2, 3) or (self.old and target == 0 and number > 0)
        number = number % FINE if number != ACTIVE else number
        if tool:
            self.i.r.assume(
                f"the tool that {self.item.name} corrects", "left as the set-up states it",
                f"{self.item.name} with _MVAR = {self.value('MVAR'):g} corrects a tool, which is not understood; let it correct a work offset (_MVAR = 1xx) or "
                "only measure", column=self.item.first,
            )  # fmt: skip
        if tool or target == 0 or number == 0:
            return ""
        if number == ACTIVE:
            return self.i.r.offset
        if 1 <= number <= 99:
            return f"G{53 + number}" if number <= 4 else f"G{500 + number}"
        self.i.r.assume(
            f"the frame that {self.item.name} corrects (_KNUM = {number})", "left as it is",
            f"{self.item.name}: _KNUM = {number} is a basic or system frame, which is not understood; correct a work offset: 1 to 99, or 9000, the one in force",
            column=self.item.first,
        )  # fmt: skip
        return ""

    def results(self, first: int, values: tuple[float, ...], lengths: bool = True) -> None:
        """_OVR[first ...], mm or degrees."""
        found = self.runner.memory.scopes[0].setdefault("_OVR", Variable("REAL", many=True))
        for k, value in enumerate(values):
            found.store((float(first + k),), value / (self.i.r.unit if lengths else 1.0))

    def set_results(self, should: tuple[float, ...], found: tuple[float, ...]) -> None:
        """Set, actual and difference, mm."""
        self.results(0, should)
        self.results(4, found)
        self.results(16, tuple(a - b for a, b in zip(found, should)))

    def safe(self, off: float, lengths: bool = True) -> None:
        """_TSA: the cycle stops the machine where it finds more than that."""
        limit = self.mm("TSA") if lengths else self.value("TSA")
        if limit and abs(off) > limit:
            self.fault(
                f"what it finds lies {off:.4g} {'mm' if lengths else 'deg'} off, more than the safe area _TSA = {limit:g}: the control stops; check set-up and set values"
            )

    def correct(self, reads: list[float | None], should: list[float | None]) -> None:
        for one, other in zip(reads, should):
            if one is not None and other is not None:
                self.safe(one - other)
        name = self.corrected_offset()
        if name:
            correct_zero(self.i.r, name, reads, should)
            self.i.r.refresh()


def measure(
    i: SinumerikControl, runner: SinumerikRunner, item: Item, arguments: Sequence[float | None]
) -> None:
    """CYCLE976 to CYCLE979, CYCLE998, with their arguments as they are now. Raises BlockFault for what they cannot do without."""
    old = item.arguments is None
    if item.name == "CYCLE976":
        i.r.remark(
            "CYCLE976 calibrates the probe, which is passed over: its length and ball are those of the set-up; what the calibration errs by is u_length and u_radius "
            "of that tool in vcmm cut"
        )
        return
    if item.name not in ARGUMENTS and not old:
        i.r.assume(
            f"{item.name} with arguments in brackets", "passed over: nothing is probed",
            f"{item.name} is understood with the parameters set before it (_MVAR = 101 _SETVAL = 30 _CPA = 0 _CPO = 0 _STA1 = 0 _INCA = 90 _NUM = 4), not with arguments in brackets; "
            "a hole or spigot is measured by CYCLE977 as well", column=item.first,
        )  # fmt: skip
        return
    named = {n: v for n, v in zip(ARGUMENTS.get(item.name, ()), arguments) if v is not None}
    found = SinumerikMeasuring(i, runner, item, _parameters(runner) if old else named, old)
    with measuring_cycle(i.r, item.name, FEED):
        KINDS[item.name](found)


def _parameters(runner: SinumerikRunner) -> dict[str, float]:
    """What the program has set, without its underscore."""
    out = {}
    for scope in (runner.memory.scopes[0], runner.memory.scopes[-1]):
        for name, variable in scope.items():
            for index, value in variable.elements.items() if name in MEASURING else ():
                if not isinstance(value, str):
                    out[name[1:] + (f"[{index[0]:g}]" if index else "")] = float(value)
    return out


def _surface(m: SinumerikMeasuring) -> None:
    """CYCLE978: one surface along _MA, from where the probe stands. _MD: 1 and 2 (with brackets), 0 and 1 (without) are + and -."""
    axis, expected = m.axis(3), m.need("SETVAL", "where the surface is expected")
    way = expected - m.i.r.p[axis]
    said = m.given.get("MD")
    sense = math.copysign(1.0, way) if said is None else (1.0 if said == (0.0 if m.old else 1.0) else -1.0)
    reads = m.feeler.surface(axis, expected, sense)
    here = m.i.r.p
    m.set_results((expected, *at(here, axis, expected)), (reads, *at(here, axis, reads)))
    m.correct(
        [reads if k == axis else None for k in range(3)], [expected if k == axis else None for k in range(3)]
    )


def _parallel(m: SinumerikMeasuring) -> None:
    """CYCLE977: parallel to the axes, about where the probe stands: the set middle."""
    if m.kind not in SHAPES:
        m.fault(
            f"_MVAR = {m.value('MVAR'):g} is not understood; its last digit is 1 to 6: {', '.join(SHAPES.values())}"
        )
    {1: _hole, 2: _hole, 3: _width, 4: _width, 5: _rectangle, 6: _rectangle}[m.kind](m)


def _hole(m: SinumerikMeasuring) -> None:
    size, start, inside = m.need("SETVAL", "the diameter"), m.i.r.p, m.kind == 1
    tips = [_rim(m, start[:2], size, angle) for angle in (0.0, math.pi)]
    middle = (tips[0][0] + tips[1][0]) / 2.0, start[1]
    tips += [_rim(m, middle, size, angle) for angle in (math.pi / 2.0, -math.pi / 2.0)]
    m.i.r.straight(start, True)
    found = m.feeler.circle(tips, inside)
    m.set_results((size, *start[:2]), (found.diameter, found.x, found.y))
    m.correct([found.x, found.y, None], [*start[:2], None])


def _width(m: SinumerikMeasuring) -> None:
    axis, size, start = m.axis(2), m.need("SETVAL", "the width"), m.i.r.p
    found = _across(m, axis, size)
    middle, width = (found[0] + found[1]) / 2.0, found[0] - found[1]
    m.set_results((size, *start[:2]), (width, *at(start, axis, middle)[:2]))
    m.correct(
        [middle if k == axis else None for k in range(3)], [start[k] if k == axis else None for k in range(3)]
    )


def _rectangle(m: SinumerikMeasuring) -> None:
    start = m.i.r.p
    sizes = [m.need(f"SETV[{k}]", f"the length along axis {k + 1}") for k in (0, 1)]
    found = [_across(m, 0, sizes[0])]
    m.i.r.straight(at(start, 0, (found[0][0] + found[0][1]) / 2.0), True)
    found.append(_across(m, 1, sizes[1]))
    m.i.r.straight(start, True)
    x, y = ((a + b) / 2.0 for a, b in found)
    m.set_results((*sizes, *start[:2]), (*(a - b for a, b in found), x, y))
    m.correct([x, y, None], [*start[:2], None])


def _across(m: SinumerikMeasuring, axis: int, size: float) -> tuple[float, float]:
    """The two sides along an axis about where the probe stands, the positive one first."""
    start, found = m.i.r.p, []
    for side in (1.0, -1.0):
        lifted = _beside(m, at(start, axis, start[axis] + side * size / 2.0), side, axis)
        sense = side if m.kind in (3, 5) else -side
        found.append(m.feeler.surface(axis, start[axis] + side * size / 2.0, sense))
        _back(m, start, lifted)
    return found[0], found[1]


def _rim(m: SinumerikMeasuring, middle: tuple[float, ...], size: float, angle: float) -> Point:
    r, (x, y) = m.i.r, middle
    over = (x, y, r.p[2])
    r.straight(over, True)
    lifted = False
    if m.kind == 2:
        away = size / 2.0 + m.feeler.radius + m.feeler.overtravel
        r.straight((x + away * math.cos(angle), y + away * math.sin(angle), over[2]), True)
        _down(m)
        lifted = True
    found = m.feeler.rim((x, y), size, angle, m.kind in (1,))
    _back(m, over, lifted)
    return found


def _beside(m: SinumerikMeasuring, expected: Point, side: float, axis: int) -> bool:
    """Outside a web or rectangle, and down by _ID; inside with a protection zone over it, and down before the side."""
    if m.kind in (3, 5) and not m.zone:
        return False
    sense = 1.0 if m.kind in (4, 6) else -1.0
    away = m.feeler.radius + m.feeler.overtravel
    m.i.r.straight(at(expected, axis, expected[axis] + side * sense * away), True)
    _down(m)
    return True


def _down(m: SinumerikMeasuring) -> None:
    p = m.i.r.p
    m.i.r.straight(at(p, 2, p[2] + m.mm("ID")), True)


def _back(m: SinumerikMeasuring, over: Point, lifted: bool) -> None:
    if lifted:
        m.i.r.straight(at(m.i.r.p, 2, over[2]), True)
    m.i.r.straight(over, True)


def _points(m: SinumerikMeasuring) -> None:
    """CYCLE979: hole or spigot by _NUM points from the angle _STA1 (deg) on, _INCA apart, about the set middle _CPA, _CPO."""
    if m.kind not in (1, 2):
        m.fault(
            f"_MVAR = {m.value('MVAR'):g} is not understood; its last digit is 1 (hole) or 2 (spigot), grooves and webs at an angle are not read"
        )
    size, r = m.need("SETVAL", "the diameter"), m.i.r
    middle = (m.need("CPA", "the set middle in X"), m.need("CPO", "the set middle in Y"))
    count, step = round(m.value("NUM", 3.0)), m.value("INCA")
    if count not in (3, 4) or not step:
        m.fault("it takes _NUM = 3 or 4 points and an angle _INCA between them")
    start = r.p
    tips = [_rim(m, middle, size, math.radians(m.value("STA1") + k * step)) for k in range(count)]
    r.straight(start, True)
    found = m.feeler.circle(tips, m.kind == 1)
    m.set_results((size, *middle), (found.diameter, found.x, found.y))
    m.correct([found.x, found.y, None], [*middle, None])


def _angle(m: SinumerikMeasuring) -> None:
    """CYCLE998: the angle of an edge by two points _ID apart; _MA = 102: measured along Y, moved on along X. The work offset is turned.

    _STA1: the set angle from the axis along which it moves on, counter-clockwise.
    """
    which = round(m.value("MA"))
    axis, along = which % 10 - 1, which // 100 - 1
    if m.kind != 5 or {axis, along} != {0, 1}:
        m.fault(
            f"_MVAR = {m.value('MVAR'):g}, _MA = {which} is not understood; known is the angle of one edge in the plane: _MVAR = 105 (or 5) with _MA = 102 or 201"
        )
    if m.value("RA"):
        m.fault("_RA turns a rotary axis, which is not understood; with _RA = 0 the work offset is turned")
    apart, expected = (
        m.need("ID", "how far apart the two points lie"),
        m.need("SETVAL", "where the edge is expected"),
    )
    start, sign = m.i.r.p, 1.0 if axis == 1 else -1.0
    lean, found = math.tan(math.radians(m.value("STA1"))), []
    for k in (0, 1):
        m.i.r.straight(at(start, along, start[along] + k * apart), True)
        should = expected + sign * k * apart * lean
        found.append(m.feeler.surface(axis, should, math.copysign(1.0, should - start[axis])))
    m.i.r.straight(start, True)
    angle = math.degrees(math.atan2(sign * (found[1] - found[0]), apart))
    for first, value in ((0, m.value("STA1")), (4, angle), (16, angle - m.value("STA1"))):
        m.results(first, (value,), lengths=False)
    m.safe(angle - m.value("STA1"), lengths=False)
    name = m.corrected_offset()
    if name:
        correct_turn(m.i.r, name, math.radians(angle - m.value("STA1")))
        m.i.r.refresh()


KINDS: Mapping[str, Callable[[SinumerikMeasuring], None]] = {
    "CYCLE977": _parallel, "CYCLE978": _surface, "CYCLE979": _points, "CYCLE998": _angle,
}  # fmt: skip
