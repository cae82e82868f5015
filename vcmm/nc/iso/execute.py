"""One block, executed: codes in the order in which a control takes them, whatever their order in the line.

Feed mode, F, S, T, tool change, spindle, dwell, plane, unit, radius compensation, tool length, work offset, path control,
distance mode, retract level, data and reference moves, motion, stop (order of RS274/NGC, 3.8).
"""

from __future__ import annotations

import math
from typing import Any

from vcmm.nc.faults import BlockFault
from vcmm.nc.iso.codes import IsoWords
from vcmm.nc.iso.control import IsoControl
from vcmm.nc.iso.cycles import CYCLES, drill, rigid_tap
from vcmm.nc.iso.motion import arc, length, line, thread
from vcmm.nc.iso.offsets import (
    coordinate_turn,
    go_home,
    local_shift,
    machine_move,
    preset,
    radius_compensation,
    select_offset,
    set_data,
    store_home,
    tool_length,
    tool_of,
)
from vcmm.nc.moves import Source

PLANES = {"G17": "XY", "G18": "ZX", "G19": "YZ"}
MOST_TOOL = 99_999_999


def execute(c: IsoControl, w: IsoWords) -> None:
    """All codes and words of a block. Raises BlockFault."""
    words = w.block.words
    c.exact_once, c.column = False, 0
    c.source = (
        Source(c.line, words[0].first, words[-1].last) if words else Source(c.line, 1, len(w.block.text) + 1)
    )
    if w.block.spaced:
        c.remark(
            "blanks inside a number are passed over, as controls do; check that one number is meant",
            w.block.spaced,
            kind="blanks",
        )
    _feed_and_speed(c, w)
    _tools_and_spindle(c, w)
    _modes(c, w)
    _shifts(c, w)
    _motion(c, w)
    _unused(c, w)
    if c.feed_mode == "G93":
        c.feed = None  # inverse time is that of each block
    _stop(c, w)


def _column(w: IsoWords, group: str) -> int:
    return w.g_columns.get(group, 1)


def _feed_and_speed(c: IsoControl, w: IsoWords) -> None:
    mode = w.g.get("feed")
    if mode:
        new = {"G98": "G94", "G99": "G95"}.get(mode, mode) if c.language.lathe else mode
        if new != c.feed_mode:
            c.feed = None  # a feed per minute is none per turn
        c.feed_mode = new
    _unit(c, w)
    if "spindle" in w.g:
        _spindle_mode(c, w)
    if c.feed_mode != "G93" and w.has("F") and w.g.get("motion") not in ("G32",) and not _threading(c, w):
        number = w.take("F")
        assert number is not None
        if number < 0:
            raise BlockFault(w.column("F"), f"F{number:g}: a feed cannot be negative; correct it")
        c.feed = number
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


def _threading(c: IsoControl, w: IsoWords) -> bool:
    """Fanuc: F of a thread is its lead, not a feed."""
    return c.language.words == "macro" and w.g.get("motion", c.motion) in ("G32", "G33")


def _unit(c: IsoControl, w: IsoWords) -> None:
    code = w.g.get("unit")
    if code is None:
        return
    new = c.language.unit_codes[code]
    if new != c.unit:
        if c.moves:
            c.remark(f"the unit changes within the program ({code})", _column(w, "unit"), every=True)
        if c.feed is not None and not w.has("F") and c.feed_mode != "G93":
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


def _tools_and_spindle(c: IsoControl, w: IsoWords) -> None:
    if w.has("T"):
        _select_tool(c, w)
    change = w.m.get("tool")
    if change == 6:
        c.tool = c.next_tool
        if c.language.words == "o" and c.tool:
            tool_of(c, c.tool, w.m_columns["tool"], "T")
        if c.tool:
            c.called.setdefault(c.tool, f"T{c.tool}")
        if c.compensation is not None:
            raise BlockFault(
                w.m_columns["tool"],
                "a tool change while cutter radius compensation is on; cancel it with G40 before",
            )
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
            c.called.setdefault(c.tool, f"T{number:04d}")
        tool = tool_of(c, register, w.column("T"), "T") if register else None
        c.tool_offset = tool.offset if tool else (0.0, 0.0, 0.0)
        c.locate()
        return
    c.next_tool = number


def _modes(c: IsoControl, w: IsoWords) -> None:
    g = w.g
    if "diameter" in g:
        c.diameter = "always" if g["diameter"] == "G7" else ""
    if "plane" in g:
        if c.compensation is not None and PLANES[g["plane"]] != c.plane:
            raise BlockFault(
                _column(w, "plane"),
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
        c.arc_absolute = g["arc"] == "G90.1"
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
        blend = w.take("P")
        w.take("Q")
        if blend is not None:
            if blend < 0:
                raise BlockFault(w.column("P"), "the tolerance of G64 cannot be negative; correct P")
            c.tolerance = blend * c.unit


_STATE = (
    "plane", "unit", "feed_scale", "absolute", "arc_absolute", "feed_mode", "feed", "surface", "speed", "retract", "exact_stop",
    "tolerance", "diameter", "motion",
)  # fmt: skip


def _saved_state(c: IsoControl, code: int) -> None:
    """M70 to M72 of LinuxCNC: save, forget, restore the modal state."""
    if code in (70, 73):
        c.saved = tuple(getattr(c, name) for name in _STATE)
    elif code == 71:
        c.saved = None
    elif c.saved is not None:
        for name, value in zip(_STATE, c.saved):
            setattr(c, name, value)


def _shifts(c: IsoControl, w: IsoWords) -> None:
    """Dwell, compensation, tool length, offsets, reference moves."""
    g = w.g
    if "dwell" in g:
        _dwell(c, w)
    if "compensation" in g:
        radius_compensation(c, w, g["compensation"], _column(w, "compensation"))
    elif w.has("D") and c.compensation is not None and c.language.words == "macro":
        radius_compensation(c, w, "G41" if c.compensation.side == "left" else "G42", w.column("D"))
    if "length" in g:
        tool_length(c, w, g["length"], _column(w, "length"))
    elif w.has("H") and c.language.words == "macro" and any(c.tool_offset):
        tool_length(c, w, "G43", w.column("H"))
    elif w.has("H") and c.language.words == "macro":
        w.take("H")
    if "offset" in g:
        select_offset(c, w, g["offset"], _column(w, "offset"))
    if "rotation" in g:
        coordinate_turn(c, w, g["rotation"], _column(w, "rotation"))
    if "other" in g:
        _other(c, w, g["other"], _column(w, "other"))


def _dwell(c: IsoControl, w: IsoWords) -> None:
    column = _column(w, "dwell")
    if c.language.words == "o":
        seconds: float = w.need("P", "the time of G4 in seconds, as in G4 P0.5", column)
    else:
        seconds = 0.0
        if w.has("P"):
            seconds = (w.take("P") or 0.0) * c.language.dwell
        for letter in "XU":
            if w.has(letter):
                seconds = w.take(letter) or 0.0
                if c.language.decimal_point == "increment" and not w.words[letter].pointed:
                    seconds *= 0.001
    c.column = column
    c.dwell(seconds)


def _other(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    motion = w.g.get("motion")
    if motion is not None and w.any_axis and motion != "G80" and not c.language.sharing:
        raise BlockFault(
            column, f"{motion} and {code} both want the axis words of this block; write them in two blocks"
        )
    actions: dict[str, Any] = {
        "G10": lambda: set_data(c, w, column), "G28": lambda: go_home(c, w, False, column),
        "G30": lambda: go_home(c, w, True, column), "G28.1": lambda: store_home(c, False),
        "G30.1": lambda: store_home(c, True), "G52": lambda: local_shift(c, w, column),
    }  # fmt: skip
    if code in actions:
        actions[code]()
    elif code == "G50":  # lathe, system A: what G92 is elsewhere
        if w.has("S") and not w.any_axis:
            c.speed_limit = w.need("S", "the highest speed of the spindle", column)
        else:
            preset(c, w, "G92", column)
    else:
        preset(c, w, code, column)


def _motion(c: IsoControl, w: IsoWords) -> None:
    code, column = w.g.get("motion"), w.g_columns.get("motion", 0)
    if code is not None and code != c.motion:
        if code not in CYCLES or c.motion not in CYCLES:
            c.cycle.clear()
            c.cycle_level = None
        c.motion = code
    if "other" in w.g or ("dwell" in w.g and not _axis_left(c, w)):
        return
    if "machine" in w.g:
        machine_move(c, w, _column(w, "machine"))
        return
    if code == "G80" or not (_axis_left(c, w) or _bare(c, w, code)):
        return
    if not column:
        column = min((word.first for word in w.words.values()), default=1)
    _move(c, w, c.motion, column)


def _axis_left(c: IsoControl, w: IsoWords) -> bool:
    letters = "XYZABCUVW" if c.language.lathe else "XYZABC"
    return any(a in w.values and a not in w.used for a in letters)


def _bare(c: IsoControl, w: IsoWords, code: str | None) -> bool:
    """A block that moves without an axis word: an arc with a centre (full circle)."""
    mode = code or c.motion
    centre = any(k in w.values for k in "IJK")
    if mode in ("G2", "G3"):
        return centre or (code is not None and "R" in w.values)
    if mode == "G76" and c.language.words == "o":
        return code is not None
    return mode in CYCLES and code is not None and c.language.words == "o"


def _move(c: IsoControl, w: IsoWords, mode: str | None, column: int) -> None:
    if mode is None or mode == "G80":
        raise BlockFault(
            column, "axis words without a motion code in force; write G0, G1, G2 or G3 before them"
        )
    c.column = column
    if mode in ("G0", "G1"):
        line(c, w, mode == "G0")
    elif mode in ("G2", "G3"):
        arc(c, w, mode == "G2")
    elif mode in ("G32", "G33"):
        thread(c, w, _lead(c, w, column))
    elif mode == "G33.1":
        rigid_tap(c, w, _lead(c, w, column))
    else:
        c.marker = mode
        if mode == "G76" and c.language.words == "o":
            from vcmm.nc.iso.threading_cycle import thread_cycle

            thread_cycle(c, w)
        else:
            drill(c, w, mode)
        c.marker = ""


def _lead(c: IsoControl, w: IsoWords, column: int) -> float:
    letter = "K" if c.language.words == "o" else "F"
    number = w.take(letter)
    if number is None:
        number = c.cycle.get("lead")
        if number is None:
            raise BlockFault(column, f"the thread has no lead; add {letter}, as in {letter}1.5")
        return number
    c.cycle["lead"] = length(c, w, letter, number) if c.language.words == "o" else number * c.unit
    return c.cycle["lead"]


_HARMLESS_WORDS = frozenset("NOS")


def _unused(c: IsoControl, w: IsoWords) -> None:
    """IsoWords that nothing in the block uses."""
    left = [letter for letter in w.values if letter not in w.used and letter not in _HARMLESS_WORDS]
    if not left:
        return
    letter = min(left, key=w.column)
    if letter in "UVW" and not c.language.lathe:
        raise BlockFault(w.column(letter), f"the axis {letter} is not modelled; vcmm knows X Y Z A B C")
    text = f'nothing in this block uses the word "{letter}"'
    if c.language.unused == "refuse" or letter in "XYZABC":
        raise BlockFault(w.column(letter), f"{text}; remove it, or add the code that it belongs to")
    c.remark(f"{text}; it is passed over", w.column(letter), f"unused {letter}")


def _stop(c: IsoControl, w: IsoWords) -> None:
    if w.m.get("stop") in (2, 30):
        c.ended = True
