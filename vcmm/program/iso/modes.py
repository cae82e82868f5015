"""Modal codes of a block: feed, speed, tool, spindle, unit, plane, distance, path, in the order in which a control takes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.tools import tool_of

PLANES = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
MOST_TOOL = 99_999_999


def column_of(w: IsoWords, group: str) -> int:
    """Return the column of the code of a group."""
    return w.g_columns.get(group, 1)


def feed_and_speed(c: IsoControl, w: IsoWords) -> None:
    mode = w.g.get("feed")
    if mode:
        new = {"G98": "G94", "G99": "G95"}.get(mode, mode) if c.language.lathe else mode
        if new != c.feed_mode:
            c.feed = None  # a feed per minute is none per turn
        c.feed_mode = new
    if c.language.words == "macro":  # RS274: F counts in the unit before G20 or G21 of its block
        _unit(c, w)
    if "spindle" in w.g:
        _spindle_mode(c, w)
    if c.feed_mode != "G93" and w.has("F") and not _threading(c, w):
        number = w.take("F")
        assert number is not None
        if number < 0:
            raise BlockFault(w.column("F"), f"F{number:g}: a feed cannot be negative; correct it")
        c.feed = c.turning_feed = number
    elif c.feed_mode == "G93":
        c.feed = w.take("F")
    w.used.add("F")
    speed = w.take("S")
    if speed is not None and w.g.get("other") not in ("G50", "G92"):
        if speed < 0:
            raise BlockFault(
                w.column("S"),
                f"S{speed:g}: a spindle speed cannot be negative; choose the sense with M3 or M4",
            )
        c.speed = speed
    if c.language.words == "o":
        _unit(c, w)


def _threading(c: IsoControl, w: IsoWords) -> bool:
    """Return whether F of a thread is its lead, not a feed (Fanuc)."""
    thread = ("G32", "G33", "G34", "G92", "G78")
    return c.language.words == "macro" and (
        w.g.get("motion", c.motion) in thread or w.g.get("turning") == "G76"
    )


def _unit(c: IsoControl, w: IsoWords) -> None:
    code = w.g.get("unit")
    if code is None:
        return
    new, c.unit_said = c.language.unit_codes[code], True
    if new != c.unit:
        if c.moves:
            c.remark(f"the unit changes within the program ({code})", column_of(w, "unit"), every=True)
        if c.feed is not None and c.feed_mode != "G93" and (c.language.words == "o" or not w.has("F")):
            c.feed *= c.unit / new  # the feed in force stays what it is
        c.set_unit(new)


def _spindle_mode(c: IsoControl, w: IsoWords) -> None:
    c.surface = w.g["spindle"] == "G96"
    if c.surface:
        if c.language.words == "o":
            limit = w.take("D")
            c.speed_limit = math.inf if limit is None else limit
        if w.has("R"):
            w.take("R")


def tools_and_spindle(c: IsoControl, w: IsoWords) -> None:
    if w.has("T"):
        _select_tool(c, w)
    change = w.m.get("tool")
    if change == 6:
        c.tool = c.next_tool
        if w.next_tool is not None:
            c.next_tool = int(w.next_tool)
        if c.language.words == "o" and c.tool:
            tool_of(c, c.tool, w.m_columns["tool"], "T")
        if c.tool:
            c.tool_names.setdefault(c.tool, f"T{c.tool}")
        if c.compensation is not None:
            refusal = "a tool change while cutter radius compensation is on; cancel it with G40 before"
            if c.language.words == "o":
                raise BlockFault(w.m_columns["tool"], refusal)
            what = "radius compensation behind a tool change"
            c.assume(what, "cancelled, as macros of tool changers do", refusal, column=w.m_columns["tool"])
            c.compensation = None
    elif change == 61:
        number = w.whole("Q", w.m_columns["tool"])
        if number is None:
            raise BlockFault(w.m_columns["tool"], "M61 needs Q, the number of the tool in the spindle")
        c.tool = number
    spindle = w.m.get("spindle")
    if spindle is not None:
        c.sense = {3: 1, 4: -1, 13: 1, 14: -1}.get(spindle, 0)
        w.used |= {"P", "R", "Q"} if spindle == 19 else set()
    if c.language.words == "o" and spindle in (3, 4, 5):
        w.used.add("$")


def _select_tool(c: IsoControl, w: IsoWords) -> None:
    number = w.whole("T", 1)
    assert number is not None
    if number > MOST_TOOL:
        raise BlockFault(w.column("T"), f"T{number} is no tool number")
    if c.language.lathe:  # T0101: tool and offset register; the turret turns at once
        c.tool, register = divmod(number, 100) if number > 99 else (number, 0)
        c.next_tool = c.tool
        if c.tool:
            c.tool_names.setdefault(c.tool, f"T{number:04d}")
        tool = tool_of(c, register, w.column("T"), "T") if register else None
        c.tool_offset = tool.offset if tool else (0.0, 0.0, 0.0)
        c.locate()
        return
    c.next_tool = number


def modes(c: IsoControl, w: IsoWords) -> None:
    g = w.g
    if "diameter" in g:
        c.diameter = "always" if g["diameter"] == "G7" else ""
    if "plane" in g:
        if c.compensation is not None and PLANES[g["plane"]] != c.plane:
            raise BlockFault(
                column_of(w, "plane"),
                "the plane changes while cutter radius compensation is on; cancel it with G40 before",
            )
        if (
            PLANES[g["plane"]] != c.plane and c.language.words == "macro"
        ):  # LinuxCNC keeps the level of the series
            c.cycle_level = None
        c.plane = PLANES[g["plane"]]
    if "distance" in g:
        c.absolute = g["distance"] == "G90"
    if "arc" in g:
        c.arc_absolute, c.arcs_seen = g["arc"] == "G90.1", True
    if "path" in g:
        _path(c, w)
    c.exact_once = g.get("exact") == "G9"
    if "retract" in g:
        c.retract = g["retract"]
    if "state" in w.m:
        _saved_state(c, w.m["state"])


def _path(c: IsoControl, w: IsoWords) -> None:
    code = w.g["path"]
    c.exact_stop = code in ("G61", "G61.1")
    c.tolerance = None
    if code == "G64" and c.language.words == "o":
        blend, merged = w.take("P"), w.take("Q")
        if merged:
            c.assume(
                "Q of G64 (lines that lie within it are merged into one)", f"every line is run, and corners are rounded within P; Q {merged:g} would leave the "
                "path by as much", column=w.column("Q"), matters=False,
            )  # fmt: skip
        if blend is not None:
            if blend < 0:
                raise BlockFault(w.column("P"), "the tolerance of G64 cannot be negative; correct P")
            c.tolerance = blend * c.unit


_STATE = (
    "plane", "unit", "feed_scale", "absolute", "arc_absolute", "feed_mode", "feed", "surface", "speed", "sense", "retract", "exact_stop",
    "tolerance", "diameter", "compensation",
)  # fmt: skip


def _saved_state(c: IsoControl, code: int) -> None:
    """Execute M70 to M73 of LinuxCNC: save, forget, restore the modal state; M73: save, and restore when the subprogram ends. The motion code is not
    restored (LinuxCNC, G code reference, "M70 save modal state")."""
    if code in (70, 73):
        c.state_of_m70 = snapshot(c)
        if code == 73 and c.states_of_m73:
            c.states_of_m73[-1] = c.state_of_m70
    elif code == 71:
        c.state_of_m70 = None
        if c.states_of_m73:
            c.states_of_m73[-1] = None
    elif c.state_of_m70 is not None:
        restore(c, c.state_of_m70)


def snapshot(c: IsoControl) -> tuple[object, ...]:
    """Return the modal state that M70 saves, with work offset and tool length."""
    return (*(getattr(c, name) for name in _STATE), c.offset, c.tool_offset)


def restore(c: IsoControl, saved: Sequence[Any]) -> None:
    """Restore a saved state."""
    for name, value in zip(_STATE, saved):
        setattr(c, name, value)
    offset, length = saved[-2:]
    if c.tool_offset != length:
        c.set_length(length)
    if c.offset != offset:
        c.set_offset(offset)
