"""Parameters of a program: numbered and named, local and global, and those that the control itself fills in.

LinuxCNC: #1 to #30 belong to the subprogram, #<name> too, #<_name> is global; an unset number is 0, an unset name an error.
Fanuc: #0 is vacant, #1 to #33 belong to the macro, the rest is common; an unset one is vacant. Lengths that the control
fills in are in the unit of the program (work offsets of LinuxCNC: mm).
"""

from __future__ import annotations

import math
from collections.abc import Callable

from vcmm.core.errors import did_you_mean
from vcmm.program.expressions import whole_number
from vcmm.program.faults import BlockFault
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.offsets import OFFSETS, further
from vcmm.program.moves import ORIGIN

PLANE_CODES = {"XY": 17, "ZX": 18, "YZ": 19}
CLOCKS = (3001, 3002)  # of Fanuc: ms, hours; they go on by themselves


class ParameterTable:
    """All parameters of one run. `locals` is the stack of the subprograms under way."""

    def __init__(self, c: IsoControl) -> None:
        self.c = c
        self.macro = c.language.words == "macro"
        self.common: dict[int, float] = {}
        self.named_common: dict[str, float] = {}
        self.locals: list[dict[int, float]] = [{}]
        self.named_locals: list[dict[str, float]] = [{}]
        self.most_local = 33 if self.macro else 30

    def number(self, index: int) -> float | None:
        """Return the value of #index; None: vacant (Fanuc)."""
        if 1 <= index <= self.most_local:
            return self.locals[-1].get(index, None if self.macro else 0.0)
        if index in self.common:
            if self.macro and index in CLOCKS:
                self.c.states.machine_value = f"the clock #{index}"
            return self.common[index]
        filled = _fanuc(self.c, index) if self.macro else _linuxcnc(self.c, index)
        if filled is not None:
            return filled
        if index:
            self.c.states.machine_value = f"#{index}"
        if self.macro and (index == 0 or index < 1000):
            return None
        if self.macro:
            refusal = f"the system variable #{index} is not known to vcmm; replace it by its value"
            if self.c.setup.strict:
                raise BlockFault(0, refusal)
            inputs = 1000 <= index <= 1199
            self.c.assume(
                "system variables of the machine",
                f"#{index} and its like 0" if inputs else f"#{index} and its like vacant",
            )
            return 0.0 if inputs else None
        return 0.0

    def variable(self, name: str) -> float:
        table = self.named_common if name.startswith("_") else self.named_locals[-1]
        if name in table:
            return table[name]
        if name in PREDEFINED:
            return float(PREDEFINED[name](self.c))
        names = [*self.named_locals[-1], *self.named_common, *PREDEFINED]
        refusal = (
            f"the parameter #<{name}> has no value yet.{did_you_mean(name, names)} Set it before it is used"
        )
        if self.c.setup.strict:
            raise BlockFault(0, refusal)
        self.c.assume(f"the value of #<{name}>", "0")
        self.c.states.machine_value = f"#<{name}>"
        return 0.0

    def exists(self, name: str) -> bool:
        return name in self.named_common or name in self.named_locals[-1] or name in PREDEFINED

    def set(self, target: str | float | None, value: float | None, column: int) -> None:
        """Assign #target = value. Raises BlockFault for those that only the control sets."""
        if isinstance(target, str):
            if target in PREDEFINED and target not in self.named_common:
                raise BlockFault(
                    column, f"#<{target}> is filled in by the control and cannot be set; choose another name"
                )
            (self.named_common if target.startswith("_") else self.named_locals[-1])[target] = value or 0.0
            return
        index = whole_number(target, "the number of a parameter")
        if index == 0 and self.macro:
            raise BlockFault(column, "#0 is always vacant and cannot be set")
        if index < 1 or index > (999999 if self.macro else 99999):
            raise BlockFault(column, f"parameter #{index} does not exist")
        if index == 3000 and self.macro:
            refusal = (
                f"the program raises its own alarm #3000 = {value or 0:g} here; see the comment of this line"
            )
            self.c.assume(
                f"the alarm #3000 = {value or 0:g}", "the program ends here", refusal, column=column
            )
            self.c.has_ended = True
            return
        if index == 3006 and self.macro:
            return
        if self._set_offset(index, value or 0.0):
            return
        table = self.locals[-1] if 1 <= index <= self.most_local else self.common
        if value is None:
            table.pop(index, None)
        else:
            table[index] = value

    def _set_offset(self, index: int, value: float) -> bool:
        """Set a work offset by its parameter: setting one changes the offset."""
        place = _offset_place(index, self.macro)
        if place is None:
            if not self.macro and (5161 <= index <= 5428):
                raise BlockFault(
                    0, f"parameter #{index} is filled in by the control; use G10, G28.1 or G92 to change it"
                )
            return False
        name, axis = place
        scale = self.c.unit if self.macro else 1.0
        if not name:
            common = list(self.c.common)
            common[axis] = value * scale
            self.c.common = (common[0], common[1], common[2])
        else:
            old = list(self.c.offsets.get(name, ORIGIN))
            old[axis] = value * scale
            self.c.offsets[name] = (old[0], old[1], old[2])
        self.c.rebuild()
        return True


def attach(c: IsoControl) -> ParameterTable:
    """Give a control its parameters."""
    table = ParameterTable(c)
    c.parameters = table
    return table


def _offset_place(index: int, macro: bool) -> tuple[str, int] | None:
    """Return the offset and axis of a parameter: #5221 = G54 X, #5241 = G55 X; Fanuc also #5201 (common) and #7001 (G54.1 P1)."""
    if macro and 5201 <= index <= 5203:
        return "", index - 5201
    if macro and 7001 <= index <= 7960 and (index - 7001) % 20 < 3:
        return further((index - 7001) // 20 + 1), (index - 7001) % 20
    count = 6 if macro else 9
    if 5221 <= index < 5221 + 20 * count and (index - 5221) % 20 < 3:
        return OFFSETS[(index - 5221) // 20], (index - 5221) % 20
    return None


def _linuxcnc(c: IsoControl, index: int) -> float | None:
    place = _offset_place(index, False)
    if place is not None:
        return c.offsets.get(place[0], ORIGIN)[place[1]]
    if 5221 <= index <= 5400 and (index - 5221) % 20 == 9:
        return math.degrees(c.rotations.get(OFFSETS[(index - 5221) // 20], 0.0))
    for begin, point in ((5161, c.home), (5181, c.home2), (5211, c.g92), (5401, c.tool_offset)):
        if begin <= index <= begin + 2:
            return point[index - begin]
    if 5061 <= index <= 5063 and c.skip is not None:
        return c.skip[index - 5061] / c.unit
    if index == 5070:
        return 1.0 if c.has_contact else 0.0
    if 5420 <= index <= 5422:
        return c.p[index - 5420] / c.unit
    if 5423 <= index <= 5425:
        return math.degrees(c.rotary[index - 5423])
    if index == 5210:
        return 1.0 if any(c.g92) else 0.0
    if index == 5220:
        return OFFSETS.index(c.offset) + 1.0
    if index == 5400:
        return float(c.tool)
    if index == 5410:
        tool = c.tools.get(c.tool)
        return (tool.diameter or 0.0) if tool else 0.0
    return None


def _fanuc(c: IsoControl, index: int) -> float | None:
    place = _offset_place(index, True)
    if place is not None:
        point = c.offsets.get(place[0], ORIGIN) if place[0] else c.common
        return point[place[1]] / c.unit
    if 5061 <= index <= 5063 and c.skip is not None:
        return c.skip[index - 5061] / c.unit
    for begin, values in ((5001, c.p), (5021, c.q), (5041, c.p), (5081, c.tool_offset)):
        if begin <= index <= begin + 2:
            return values[index - begin] / c.unit
    if 2001 <= index <= 2200:  # offset memory A: lengths
        return _length_register(c, index - 2000) / c.unit
    modal = _MODAL.get(index)
    return None if modal is None else float(modal(c))


def _length_register(c: IsoControl, number: int) -> float:
    tool = c.tools.get(number)
    return c.lengths.get(number, tool.length if tool else 0.0)


def _motion_number(c: IsoControl) -> float:
    return float((c.motion or "G80")[1:])


_MODAL: dict[int, Callable[[IsoControl], float]] = {  # modal information of Fanuc macro B
    4001: _motion_number, 4002: lambda c: PLANE_CODES[c.plane], 4003: lambda c: 90 if c.absolute else 91,
    4005: lambda c: float(c.feed_mode[1:]), 4006: lambda c: 20 if c.unit > 1 else 21,
    4007: lambda c: 40 if c.compensation is None else 41 if c.compensation.side == "left" else 42,
    4008: lambda c: 43 if any(c.tool_offset) else 49, 4010: lambda c: float(c.retract[1:]),
    4012: lambda c: float(c.offset[1:].split()[0]), 4014: lambda c: float(c.offset[1:].split()[0]), 4109: lambda c: c.feed or 0.0, 4111: lambda c: c.length_word,
    4119: lambda c: c.speed, 4120: lambda c: c.next_tool or c.tool, 4107: lambda c: 0,
}  # fmt: skip

PREDEFINED: dict[str, Callable[[IsoControl], float]] = {  # LinuxCNC's predefined names
    "_x": lambda c: c.p[0] / c.unit, "_y": lambda c: c.p[1] / c.unit, "_z": lambda c: c.p[2] / c.unit,
    "_a": lambda c: math.degrees(c.rotary[0]), "_b": lambda c: math.degrees(c.rotary[1]), "_c": lambda c: math.degrees(c.rotary[2]),
    "_abs_x": lambda c: c.q[0], "_abs_y": lambda c: c.q[1], "_abs_z": lambda c: c.q[2],
    "_u": lambda c: 0, "_v": lambda c: 0, "_w": lambda c: 0,
    "_current_tool": lambda c: c.tool, "_current_pocket": lambda c: c.tool, "_selected_tool": lambda c: c.next_tool,
    "_feed": lambda c: c.feed or 0.0, "_rpm": lambda c: c.speed, "_line": lambda c: c.line,
    "_metric": lambda c: c.unit == 1.0, "_imperial": lambda c: c.unit != 1.0, "_absolute": lambda c: c.absolute,
    "_incremental": lambda c: not c.absolute, "_inverse_time": lambda c: c.feed_mode == "G93",
    "_units_per_minute": lambda c: c.feed_mode == "G94", "_units_per_rev": lambda c: c.feed_mode == "G95",
    "_plane": lambda c: 10 * PLANE_CODES[c.plane], "_motion_mode": lambda c: 10 * _motion_number(c),
    "_ccomp": lambda c: 400 if c.compensation is None else 410 if c.compensation.side == "left" else 420,
    "_coord_system": lambda c: 10 * float(c.offset[1:].split()[0]), "_tool_offset": lambda c: any(c.tool_offset),
    "_retract_r_plane": lambda c: c.retract == "G99", "_retract_old_z": lambda c: c.retract == "G98",
    "_spindle_rpm_mode": lambda c: not c.surface, "_spindle_css_mode": lambda c: c.surface,
    "_ijk_absolute_mode": lambda c: c.arc_absolute, "_lathe_diameter_mode": lambda c: c.diametral(),
    "_lathe_radius_mode": lambda c: not c.diametral(), "_spindle_on": lambda c: c.sense != 0, "_spindle_cw": lambda c: c.sense > 0,
    "_vmajor": lambda c: 2.9, "_vminor": lambda c: 0, "_call_level": lambda c: len(c.parameters.locals) - 1,
    "_remap_level": lambda c: 0, "_task": lambda c: 1, "_value_returned": lambda c: 0, "_mist": lambda c: 0, "_flood": lambda c: 0,
    "_speed_override": lambda c: 1, "_feed_override": lambda c: 1, "_adaptive_feed": lambda c: 0, "_feed_hold": lambda c: 0,
}  # fmt: skip
