"""Tools of the G-code family: the table, lengths (G43, G44, G49), radius compensation (G40 to G42.1)."""

from __future__ import annotations

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl
from vcmm.program.iso.lengths import length
from vcmm.program.levels import SetupEntry, unknown_tool
from vcmm.program.moves import ORIGIN, Point, Remark
from vcmm.program.radius import FANUC_B, LINUXCNC, RadiusCompensation
from vcmm.program.setup import FANUC_TIPS, LINUXCNC_TIPS, Tool, imaginary_nose


def tool_of(c: IsoControl, number: int, column: int, letter: str) -> Tool | None:
    """Return the tool of a register; None where no table has it, with a remark where its length is used."""
    tool = c.tools.get(number)
    if tool is None and number and (c.tools or letter == "H" or c.language.lathe):
        unknown_tool(c, number, f"{letter}{number}", column)
    return tool


def tool_length(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Execute G43, G44, G43.1, G43.2, G49."""
    offset = _offset_of(c, w, code, column)
    c.is_tcp_on = code in ("G43.4", "G43.5", "G143", "G234")
    if not c.is_tcp_on:
        c.aim, c.vectors = None, False
    follows = c.language.length_follows and w.has("Z")
    c.tool_offset = offset
    if not follows:
        c.locate()


def _offset_of(c: IsoControl, w: IsoWords, code: str, column: int) -> Point:
    if code == "G49":
        return ORIGIN
    if code in ("G43.4", "G43.5", "G143", "G234"):
        c.assume(
            f"{code}, tool centre point control",
            "the path of the tip over the workpiece; which way the tool points follows from the machine of the set-up",
            column=column,
            matters=False,
        )
        c.vectors = code == "G43.5"
        if not c.vectors:
            w.used |= {"P", "Q", "I", "J", "K"}
    if code == "G43.1":
        old = list(c.tool_offset)
        for i, axis in enumerate(AXES):
            number = w.take(axis)
            if number is not None:
                old[i] = number * c.unit
        return (old[0], old[1], old[2])
    number = w.whole("H", column)
    if number is None:
        number = c.tool if c.language.words == "o" else c.length_word
    c.length_word = number
    if number == 0 and c.language.words == "macro":
        return ORIGIN
    offset = _register(c, number, column)
    sign = -1.0 if code == "G44" else 1.0
    if code == "G43.2":
        old_offset = c.tool_offset
        return (old_offset[0] + offset[0], old_offset[1] + offset[1], old_offset[2] + offset[2])
    return (sign * offset[0], sign * offset[1], sign * offset[2])


def _register(c: IsoControl, number: int, column: int) -> Point:
    if number in c.lengths:
        return (0.0, 0.0, c.lengths[number])
    tool = tool_of(c, number, column, "H")
    return ORIGIN if tool is None else tool.offset


def radius_compensation(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Execute G40, G41, G42, G41.1, G42.1: side and radius in force."""
    if code == "G40":
        c.compensation = None
        return
    if c.compensation is not None and c.language.words == "o":
        raise BlockFault(column, "cutter radius compensation is on already; end it with G40 before")
    side = "left" if code.startswith("G41") else "right"
    if c.language.name == "grbl":
        c.assume(
            f"{code} of grbl, which knows G40 alone", "read as LinuxCNC does",
            f"grbl has no radius compensation and stops at {code} (error:20); name the control that runs it with --dialect", column=column,
        )  # fmt: skip
    if code.endswith(".1"):
        diameter = w.need("D", f"the diameter of the cutter, as in {code} D10", column)
        orientation = w.whole("L", column) or 0
        c.compensation = _compensation(c, side, (diameter * c.unit / 2.0, orientation), column)
        return
    number = w.whole("D", column)
    if number is None and c.language.codes == "mach3" and w.has("P"):
        radius = length(c, w, "P", w.take("P") or 0.0)
        c.assume(
            f"P of {code}, the radius of the tool on Mach3", f"0 mm instead of {radius:g} mm: the path on the programmed contour",
            f"P of {code} (the radius of the tool on Mach3, whose way onto the contour is not known here) is not understood; write D, and the diameter into "
            "the set-up", column=column,
        )  # fmt: skip
        c.compensation = _compensation(c, side, (0.0, 0), column)
        return
    if number is None and c.language.words == "macro":
        number = c.radius_word
        if number is None and not c.language.lathe and c.compensation is None:
            c.assume(
                f"which radius {code} takes without D", f"that of tool {c.tool}; a control takes D0, none, where no D is in force",
                f"{code} has no D, and none is in force before it: the control takes D0, no radius, or what its memory holds; add D{c.tool}",
                column=column,
            )  # fmt: skip
    c.radius_word = number
    tool = radius_of(c, c.tool if number is None else number, column)
    c.compensation = _compensation(c, side, tool, column)


def _compensation(c: IsoControl, side: str, tool: tuple[float, int], column: int) -> RadiusCompensation:
    """Return the compensation, with the way from the centre of the nose to the imaginary tip that the offsets of a turning tool are measured at."""
    style, tips = (LINUXCNC, LINUXCNC_TIPS) if c.language.words == "o" else (FANUC_B, FANUC_TIPS)
    radius, orientation = tool
    if orientation and orientation not in tips:
        raise BlockFault(column, f"{orientation} is no orientation of a turning tool; they are 0 to 9")
    return RadiusCompensation(side, radius, style, imaginary_nose(orientation, radius, c.plane, tips))


def radius_of(c: IsoControl, number: int, column: int) -> tuple[float, int]:
    """Return the radius and orientation of a register, else of its tool."""
    if number in c.radii:
        return c.radii[number], 0
    if number == 0 and c.language.words == "macro":
        return 0.0, 0
    tool = tool_of(c, number, column, "D")
    if number == 0 and tool is None:
        return 0.0, 0
    if tool is None or tool.radius is None:
        _unknown_radius(c, number, tool, column)
        return 0.0, 0
    return tool.radius, tool.orientation


def _unknown_radius(c: IsoControl, number: int, tool: Tool | None, column: int) -> None:
    """Assume 0 mm, the path on the programmed contour."""
    turning = c.language.lathe if tool is None else tool.shape == "turning"
    key, size = ("nose_radius", '"0.8 mm"') if turning else ("diameter", '"10 mm"')
    name = key.replace("_", " ")
    otherwise = (
        f"cutter radius compensation needs the {name} of tool {number}: name a set-up file with --setup that has "
        f"[tools.{number}] {key} = {size}"
        if tool is None
        else f"radius compensation needs the {name} of tool {number}: add {key} = {size} to [tools.{number}] of the set-up"
    )
    c.assume(
        f"the {name} of tool {number}", "0 mm: the path on the programmed contour", otherwise,
        blank=SetupEntry(f"tools.{number}", key, size), column=column,
    )  # fmt: skip


def tell_left_in_the_changer(c: IsoControl) -> None:
    """Note a T without M6: it selects a tool and puts none in the spindle."""
    if c.next_tool and not c.tool and not c.tool_names:
        first = next((m.source.line for m in c.moves if m.kind in ("line", "arc")), 0)
        if first:
            text = f"this cuts without a tool: T{c.next_tool} is selected, but M6, which puts it in the spindle, is missing"
            c.remarks.append(Remark(first, 1, text))
