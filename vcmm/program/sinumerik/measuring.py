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

from vcmm.program.cycle_tables import Cycle, cycle
from vcmm.program.faults import BlockFault
from vcmm.program.measuring import Findings, MeasuringCycle, circle, rectangle, width
from vcmm.program.probing import correct_turn, correct_zero, measuring_cycle
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.memory import MEASURING, Variable
from vcmm.program.sinumerik.state import SinumerikControl

FEED = 300.0  # mm/min, as usual of measuring feeds; it is a setting of the machine
ACTIVE, FINE = 9000, 10000  # of _KNUM
SHAPES = {1: "hole", 2: "spigot", 3: "groove", 4: "web", 5: "rectangle inside", 6: "rectangle outside"}


@dataclass(eq=False)
class SinumerikMeasuring(MeasuringCycle):
    """One call. parameters: by name without underscore, in the unit of the program; old: called without brackets."""

    runner: SinumerikRunner
    item: Item
    parameters: Mapping[str, float]
    old: bool

    def fault(self, text: str) -> NoReturn:
        raise BlockFault(self.column, f"{self.item.name}: {text}")

    def need(self, name: str, what: str) -> None:
        """Raise BlockFault where the program does not give a parameter."""
        if name not in self.parameters:
            self.fault(
                f"it needs {'_' if self.old else 'S_'}{name.replace('SETVAL', 'SETVAL' if self.old else 'SETV')}, {what}"
            )

    @property
    def kind(self) -> int:
        """Last digit of _MVAR."""
        return self.v.number("MVAR") % 10

    def off(self, inside: bool) -> float | None:
        """Return the distance off: from outside, and from inside where a protection zone is gone round: over an island."""
        zone = self.v.number("MVAR") // 1000 % 10 == 1
        return None if inside and not zone else self.feeler.radius + self.feeler.overtravel

    def depth(self, height: float) -> float:
        return height + self.v["ID"]

    def axis(self, allowed: int) -> int:
        """Return the axis _MA: 1, 2, 3."""
        axis = self.v.number("MA")
        if not 1 <= axis <= allowed:
            self.fault(
                f"_MA = {axis} must be {'1, 2 or 3' if allowed == 3 else '1 or 2'}, the axis along which it measures"
            )
        return axis - 1

    def corrected_offset(self) -> str:
        """Return the work offset that is to be corrected, none where it only measures."""
        target, number = self.v.number("MVAR") // 100 % 10, self.v.number("KNUM")
        tool = target in (2, 3) or (self.old and target == 0 and number > 0)
        number = number % FINE if number != ACTIVE else number
        if tool:
            self.r.assume(
                f"the tool that {self.item.name} corrects", "left as the set-up states it",
                f"{self.item.name} with _MVAR = {self.v['MVAR']:g} corrects a tool, which is not understood; let it correct a work offset (_MVAR = 1xx) or "
                "only measure", column=self.column,
            )  # fmt: skip
        if tool or target == 0 or number == 0:
            return ""
        if number == ACTIVE:
            return self.r.offset
        if 1 <= number <= 99:
            return f"G{53 + number}" if number <= 4 else f"G{500 + number}"
        self.r.assume(
            f"the frame that {self.item.name} corrects (_KNUM = {number})", "left as it is",
            f"{self.item.name}: _KNUM = {number} is a basic or system frame, which is not understood; correct a work offset: 1 to 99, or 9000, the one in force",
            column=self.column,
        )  # fmt: skip
        return ""

    def results(self, findings: Sequence[tuple[float, float]], unit: float) -> None:
        """Set, actual and difference in _OVR."""
        memory = self.runner.memory.scopes[0].setdefault("_OVR", Variable("REAL", many=True))
        for k, (should, reads) in enumerate(findings):
            for first, value in ((0, should), (4, reads), (16, reads - should)):
                memory.store((float(first + k),), value / unit)

    def safe(self, off: float, unit: str = "mm") -> None:
        """Check _TSA: the cycle stops the machine for larger errors."""
        limit = self.v["TSA"]
        if limit and abs(off) > limit:
            self.fault(
                f"what it finds lies {off:.4g} {unit} off, more than the safe area _TSA = {limit:g}: the control stops; check set-up and set values"
            )

    def report(self, findings: Findings, axes: str = "xy") -> None:
        """Report results, first those that are no place, then the axes; correct the work offset by the errors of the axes."""
        places = [findings.get(k, (p, p)) for k, p in zip(axes, self.r.p)]
        self.results([*(value for k, value in findings.items() if k not in axes), *places], self.r.unit)
        ends = [findings.get(k, (None, None)) for k in "xyz"]
        for should, reads in ends:
            if should is not None and reads is not None:
                self.safe(reads - should)
        name = self.corrected_offset()
        if name:
            correct_zero(self.r, name, [reads for _, reads in ends], [should for should, _ in ends])
            self.r.refresh()


def measure(
    i: SinumerikControl, runner: SinumerikRunner, item: Item, arguments: Sequence[float | None]
) -> None:
    """Run CYCLE976 to CYCLE979, CYCLE998, with their arguments as they are now. Raises BlockFault for missing arguments that they need."""
    old = item.arguments is None
    if item.name == "CYCLE979" and not old:
        i.r.assume(
            f"{item.name} with arguments in brackets", "passed over: nothing is probed",
            f"{item.name} is understood with the parameters set before it (_MVAR = 101 _SETVAL = 30 _CPA = 0 _CPO = 0 _STA1 = 0 _INCA = 90 _NUM = 4), not with arguments in brackets; "
            "a hole or spigot is measured by CYCLE977 as well", column=item.first,
        )  # fmt: skip
        return
    row = MEASURED[item.name]
    parameters = _parameters(runner) if old else row.by_name(arguments)
    with measuring_cycle(i.r, item.name, FEED):
        row.primitive(
            SinumerikMeasuring(
                i.r,
                i.values(row, parameters),
                item.first,
                runner=runner,
                item=item,
                parameters=parameters,
                old=old,
            )
        )


def _parameters(runner: SinumerikRunner) -> dict[str, float]:
    """Return the parameters set by the program, without their underscore."""
    out = {}
    for scope in (runner.memory.scopes[0], runner.memory.scopes[-1]):
        for name, variable in scope.items():
            for index, value in variable.elements.items() if name in MEASURING else ():
                if not isinstance(value, str):
                    out[name[1:] + (f"[{index[0]:g}]" if index else "")] = float(value)
    return out


def _calibrate(m: SinumerikMeasuring) -> None:
    """Run CYCLE976."""
    m.r.remark(
        "CYCLE976 calibrates the probe, which is passed over: its length and ball are those of the set-up; what the calibration errs by is u_length and u_radius "
        "of that tool in vcmm cut"
    )


def _surface(m: SinumerikMeasuring) -> None:
    """Run CYCLE978: one surface along _MA, from the position of the probe. _MD: 1 and 2 (with brackets), 0 and 1 (without) are + and -."""
    axis, expected = m.axis(3), m.v["size"]
    m.need("SETVAL", "where the surface is expected")
    sense = math.copysign(1.0, expected - m.r.p[axis])
    if m.v.has("MD"):
        sense = 1.0 if m.v["MD"] == (0.0 if m.old else 1.0) else -1.0
    finding = (expected, m.feeler.surface(axis, expected, sense))
    m.report({"surface": finding, "xyz"[axis]: finding}, "xyz")


def _parallel(m: SinumerikMeasuring) -> None:
    """Run CYCLE977: parallel to the axes, about the position of the probe: the set middle."""
    inside = m.kind in (1, 3, 5)
    if m.kind not in SHAPES:
        m.fault(
            f"_MVAR = {m.v['MVAR']:g} is not understood; its last digit is 1 to 6: {', '.join(SHAPES.values())}"
        )
    if m.kind in (5, 6):
        for k in (0, 1):
            m.need(f"SETV[{k}]", f"the length along axis {k + 1}")
        m.report(rectangle(m, inside))
    elif m.kind in (3, 4):
        axis = m.axis(2)
        m.need("SETVAL", "the width")
        m.report(width(m, inside, axis, m.v["size"]))
    else:
        m.need("SETVAL", "the diameter")
        m.report(circle(m, inside))


def _points(m: SinumerikMeasuring) -> None:
    """Run CYCLE979: hole or spigot by _NUM points from the angle _STA1 (deg) on, _INCA apart, about the set middle _CPA, _CPO."""
    if m.kind not in (1, 2):
        m.fault(
            f"_MVAR = {m.v['MVAR']:g} is not understood; its last digit is 1 (hole) or 2 (spigot), grooves and webs at an angle are not read"
        )
    m.need("SETVAL", "the diameter")
    m.need("CPA", "the set middle in X")
    m.need("CPO", "the set middle in Y")
    count, step = round(m.v.without("NUM", 3.0)), m.v["INCA"]
    if count not in (3, 4) or not step:
        m.fault("it takes _NUM = 3 or 4 points and an angle _INCA between them")
    m.report(circle(m, m.kind == 1, [math.radians(m.v["STA1"] + k * step) for k in range(count)]))


def _angle(m: SinumerikMeasuring) -> None:
    """Run CYCLE998: the angle of an edge by two points _ID apart; _MA = 102: measured along Y, moved on along X. The work offset is turned.

    _STA1: the set angle from the axis along which it moves on, counter-clockwise.
    """
    which, should = m.v.number("MA"), m.v["STA1"]
    axis, along = which % 10 - 1, which // 100 - 1
    if m.kind != 5 or {axis, along} != {0, 1}:
        m.fault(
            f"_MVAR = {m.v['MVAR']:g}, _MA = {which} is not understood; known is the angle of one edge in the plane: _MVAR = 105 (or 5) with _MA = 102 or 201"
        )
    if m.v["RA"]:
        m.fault("_RA turns a rotary axis, which is not understood; with _RA = 0 the work offset is turned")
    m.need("ID", "how far apart the two points lie")
    m.need("SETVAL", "where the edge is expected")
    apart, start, sign = m.v["ID"], m.r.p, 1.0 if axis == 1 else -1.0
    expected = [m.v["size"] + sign * k * apart * math.tan(math.radians(should)) for k in (0, 1)]
    ways = [math.copysign(1.0, e - start[axis]) for e in expected]
    first, second = m.along(axis, [(start[along] + k * apart, expected[k], ways[k]) for k in (0, 1)])
    angle = math.degrees(math.atan2(sign * (second - first), apart))
    m.results([(should, angle)], 1.0)
    m.safe(angle - should, "deg")
    name = m.corrected_offset()
    if name:
        correct_turn(m.r, name, math.radians(angle - should))
        m.r.refresh()


_ENDS = "NMSP plain, TNAME text, DLNUM plain, TZL plain, TDIF plain, TUL plain, TLL plain, TMV plain, K plain, EVNUM plain, MCBIT plain, DMODE plain, AMODE plain"
_SIZE = "SETVAL=size mm"
MEASURED: Mapping[str, Cycle[Callable[[SinumerikMeasuring], None]]] = {
    "CYCLE976": cycle("", _calibrate),
    "CYCLE977": cycle(f"MVAR plain, KNUM plain, KNUM1 plain, PRNUM plain, {_SIZE}, SETV[0]=length mm, SETV[1]=width mm, FA=overtravel plain?, TSA mm, STA1 plain, ID mm, SZA mm, SZO mm, MA plain, {_ENDS}", _parallel),
    "CYCLE978": cycle(f"MVAR plain, KNUM plain, KNUM1 plain, PRNUM plain, {_SIZE}, FA=overtravel plain?, TSA mm, MA plain, MD plain?, {_ENDS}", _surface),
    "CYCLE979": cycle(f"MVAR plain, KNUM plain, {_SIZE}, CPA=x mm, CPO=y mm, NUM plain?, STA1 plain, INCA plain, FA=overtravel plain?, TSA mm, ID mm", _points),
    "CYCLE998": cycle(f"MVAR plain, KNUM plain, RA plain, PRNUM plain, {_SIZE}, STA1 plain, INCA plain, FA=overtravel plain?, TSA plain, MA plain, MD plain, ID mm, SETV[0] mm, SETV[1] mm, SETV[2] mm, SETV[3] mm, NMSP plain, EVNUM plain, DMODE plain, AMODE plain", _angle),
}  # fmt: skip
