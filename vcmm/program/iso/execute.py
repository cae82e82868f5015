"""Execution of one block: codes in the order of the control, whatever their order in the line.

Feed mode, F, S, T, tool change, spindle, dwell, plane, unit, radius compensation, tool length, work offset, path control,
distance mode, retract level, data and reference moves, motion, stop (order of RS274/NGC, 3.8).

Scaling, mirror images and polar words of the G-code family: what they do to programmed points.

Sources: FANUC Series 30i operator's manual B-64304EN: "scaling", "programmable mirror image", "polar coordinate command"; Haas mill operator's manual: G51, G100, G101.
"""

from __future__ import annotations

from typing import Any

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl, PolarWords
from vcmm.program.iso.cycles import DRILLING, drill, lathe_cycle, rigid_tap
from vcmm.program.iso.grooving import SINGLE, THREADED, single_cut
from vcmm.program.iso.groups import PROBING
from vcmm.program.iso.lengths import length, pass_over_axes, waiting
from vcmm.program.iso.modes import column_of, feed_and_speed, modes, tools_and_spindle
from vcmm.program.iso.motion import CENTRE_WORDS, arc, line, probe, thread
from vcmm.program.iso.offsets import (
    coordinate_turn,
    go_home,
    local_shift,
    machine_move,
    preset,
    reference_axes,
    return_from_home,
    select_offset,
    set_data,
    store_home,
)
from vcmm.program.iso.patterns import nonmodal
from vcmm.program.iso.planes import tilt_plane
from vcmm.program.iso.tools import radius_compensation, tool_length
from vcmm.program.iso.winding import wind
from vcmm.program.leading import name_axes
from vcmm.program.levels import NOT_MOVED, pass_over
from vcmm.program.moves import Point, Source, point_of


def scaling(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Scale by G51 X Y Z P, or I J K along the axes: all programmed points about a centre; G50 ends it. Mach3: factors by axis, no centre.

    P and I J K without a point count thousandths (FANUC, parameter 5400); a negative factor mirrors.
    """
    c.free("the scale changes")
    if code == "G50":
        c.scale = None
        c.rebuild()
        return
    if c.language.codes == "mach3":
        factors = [w.take(axis) for axis in AXES]
        c.scale = ((0.0, 0.0, 0.0), point_of([1.0 if f is None else f for f in factors]))
    else:
        centre = list(c.p)
        for i, axis in enumerate(AXES):
            number = w.take(axis)
            if number is not None:
                centre[i] = length(c, w, axis, number)
        c.scale = (point_of(centre), _factors(c, w, code, column))
    if 0.0 in c.scale[1]:
        raise BlockFault(column, f"{code}: a scale of zero; correct its factor")
    c.rebuild()


def _factors(c: IsoControl, w: IsoWords, code: str, column: int) -> Point:
    common, by_axis = _factor(w, "P"), [_factor(w, k) for k in CENTRE_WORDS]
    if common is None and by_axis == [None, None, None]:
        setting = "Haas setting 71" if c.language.haas else "FANUC parameter 5411, by axis 5421"
        c.assume(
            f"the factor of {code} without P or I J K ({setting})", "1: nothing is scaled",
            f"{code} without P or I J K scales by a setting of the control ({setting}), which is not known; write the factor", column=column,
        )  # fmt: skip
        return 1.0, 1.0, 1.0
    return point_of([(1.0 if f is None else f) if common is None else common for f in by_axis])


def _factor(w: IsoWords, letter: str) -> float | None:
    number = w.take(letter)
    return number if number is None or w.words[letter].has_point else number / 1000.0


def mirror(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Mirror by G51.1 X10: the programmed points mirrored at X 10; G50.1 X0 ends it, without axes of all. Haas: G101, ended by G100."""
    c.free("a mirror image changes")
    named = {i: w.take(axis) for i, axis in enumerate(AXES) if w.has(axis)}
    if code in ("G51.1", "G101"):
        if not named:
            raise BlockFault(column, f"{code} needs the axis to be mirrored, as in {code} X0")
        haas = code == "G101"
        c.mirrors |= {i: 0.0 if haas else length(c, w, AXES[i], n or 0.0) for i, n in named.items()}
    else:
        for i in named or dict(c.mirrors):
            c.mirrors.pop(i, None)
    c.rebuild()


def polar_words(c: IsoControl, code: str) -> None:
    """Switch polar words: G16, G15."""
    c.polar = PolarWords() if code == "G16" else None


def execute(c: IsoControl, w: IsoWords) -> None:
    """Execute all codes and words of a block. Raises BlockFault."""
    words = w.block.words
    c.exact_once, c.column = False, 0
    c.source = (
        Source(c.line, words[0].first, words[-1].last) if words else Source(c.line, 1, len(w.block.text) + 1)
    )
    if w.block.blank_column:
        c.remark(
            "blanks inside a number are passed over, as controls do; check that it is one number",
            w.block.blank_column,
            kind="blanks",
        )
    feed_and_speed(c, w)
    tools_and_spindle(c, w)
    modes(c, w)
    _shifts(c, w)
    _motion(c, w)
    unused_words(c, w)
    if c.feed_mode == "G93":
        c.feed = None  # inverse time is that of each block
    _stop(c, w)


def _shifts(c: IsoControl, w: IsoWords) -> None:
    """Execute dwell, compensation, tool length, offsets, reference moves."""
    g = w.g
    if "dwell" in g:
        _dwell(c, w)
    if "compensation" in g:
        radius_compensation(c, w, g["compensation"], column_of(w, "compensation"))
    elif w.has("D") and c.compensation is not None and c.language.words == "macro":
        radius_compensation(c, w, "G41" if c.compensation.side == "left" else "G42", w.column("D"))
    elif w.has("D") and c.language.words == "macro" and not c.language.lathe and "pocket" not in g:
        c.radius_word = w.whole("D", 1)  # the next G41 without D takes it
    if "length" in g:
        tool_length(c, w, g["length"], column_of(w, "length"))
    elif w.has("H") and c.language.words == "macro" and any(c.tool_offset):
        tool_length(c, w, "G43", w.column("H"))
    elif w.has("H") and c.language.words == "macro" and c.language.codes != "lathe" and "macro" not in g:
        c.length_word = w.whole("H", 1) or 0  # the next G43 without H takes it
    if "offset" in g:
        select_offset(c, w, g["offset"], column_of(w, "offset"))
    if "rotation" in g:
        coordinate_turn(c, w, g["rotation"], column_of(w, "rotation"))
    for group, action in (("scaling", scaling), ("mirror", mirror), ("tilt", tilt_plane)):
        if group in g:
            action(c, w, g[group], column_of(w, group))
    if "dynamic" in g:
        _dynamic_offset(c, w, column_of(w, "dynamic"))
    if "winding" in g:
        wind(c, w, g["winding"], column_of(w, "winding"))
    if "polar" in g:
        polar_words(c, g["polar"])
    if "other" in g:
        _execute_other(c, w, g["other"], column_of(w, "other"))


def _dwell(c: IsoControl, w: IsoWords) -> None:
    column = column_of(w, "dwell")
    other = next((k for k in "SX" if w.has(k)), "") if c.language.cycles_apart else ""
    if c.language.words == "o" and (w.has("P") or not other):
        seconds: float = w.need("P", "the time of G4 in seconds, as in G4 P0.5", column)
    elif c.language.words == "o":
        seconds = w.take(other) or 0.0
        c.assume(
            f"the time of G4 {other}{seconds:g}", f"{seconds:g} s, as the firmware of printers reads it",
            f"G4 needs P, its time in seconds: {c.language.name} stops here with an error; write G4 P{seconds:g}", column=column, matters=False,
        )  # fmt: skip
    else:
        seconds = waiting(c, w, w.take("P") or 0.0) if w.has("P") else 0.0
        for letter in "XU":
            if w.has(letter):
                seconds = w.take(letter) or 0.0
                if c.language.decimal_point == "increment" and not w.words[letter].has_point:
                    seconds *= 0.001
        pass_over_axes(c, w)
    c.column = column
    c.dwell(seconds)


def _dynamic_offset(c: IsoControl, w: IsoWords, column: int) -> None:
    """Note a dynamic offset: G54.2 Pn moves the work zero with the rotary axes, G54.4 Pn shifts and turns it by what was measured: not
    modelled; P0 ends both."""
    code = w.g["dynamic"]
    if w.whole("P", column) != 0:
        text, cure = {
            "G54.2": (
                "(dynamic work offsets) leads the work zero with the rotary axes, from a fixture offset and its angles that stand in the memory of the control",
                "have the program posted without it, with G43.4 or a work offset for each position",
            ),
            "G54.4": (
                "(workpiece setting error compensation) shifts and turns the work by errors that stand in the memory of the control",
                "take it out where the part lies as drawn, or state the shift in [offsets] and the turn about Z in [rotations] of the set-up",
            ),
        }[code]
        raise BlockFault(column, f"{code} {text}, which vcmm does not model; {cure}")
    c.remark(f"{code} P0: no such offset is in force", column, code)


def _execute_other(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    motion = w.g.get("motion")
    if motion is not None and w.any_axis and motion != "G80" and not c.language.sharing:
        raise BlockFault(
            column, f"{motion} and {code} both want the axis words of this block; write them in two blocks"
        )
    actions: dict[str, Any] = {
        "G10": lambda: set_data(c, w, column), "G28": lambda: go_home(c, w, False, column),
        "G29": lambda: return_from_home(c, w, column), "G30": lambda: go_home(c, w, True, column), "G28.1": lambda: reference_axes(c, w, column) if c.language.codes == "mach3" else store_home(c, False),
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
    if c.unmoved_axes and w.any_axis:
        name_axes(c, "".join("XYZ"["UVW".index(a)] if a in "UVW" else a for a in "XYZABCUVW" if w.has(a)))
    if w.g.get("motion") in PROBING:
        probe(c, w, w.g["motion"], column_of(w, "motion"))
        return
    code, column = _motion_code(c, w)
    if code is not None and code != c.motion:
        if code not in DRILLING or c.motion not in DRILLING or _turns_aside(c, code):
            c.cycle.clear()
            c.cycle_level = None
        c.motion = code
    if "other" in w.g or "tilt" in w.g or ("dwell" in w.g and not _axis_left(c, w)):
        return
    if "machine" in w.g:
        machine_move(c, w, column_of(w, "machine"))
        return
    if nonmodal(c, w):
        return
    if "single" in w.g and _single_direction(c, w):
        return
    if code is None and w.passed:
        return
    if code == "G80" or not (_axis_left(c, w) or _bare(c, w, code)):
        return
    if not column:
        column = min((word.first for word in w.words.values()), default=1)
    _move(c, w, c.motion, column)


def _turns_aside(c: IsoControl, code: str) -> bool:
    """Return whether a drilling cycle of a lathe drills along another axis than the one in force: its levels are not those of the other."""
    return c.language.lathe and lathe_cycle(c, code)[1] != lathe_cycle(c, str(c.motion))[1]


def _single_direction(c: IsoControl, w: IsoWords) -> bool:
    """Return whether a block has G60: it positions at rapid, from one side; the overrun past the end point is a parameter of the control,
    with a remark."""
    column = column_of(w, "single")
    c.assume(
        "G60, positioning from one side", "at rapid to its end point; how far it runs past it (FANUC 5440) is not known and left out", column=column,
        matters=False,
    )  # fmt: skip
    if c.motion in DRILLING or not _axis_left(c, w):
        return False
    _move(c, w, "G0", column)
    return True


def _motion_code(c: IsoControl, w: IsoWords) -> tuple[str | None, int]:
    """Return the motion of the block and its column. Where cycles are a group of their own, G80 leaves G0 or G1 in force, and of a
    motion and a cycle in one block the later one counts (FANUC B-64304EN, "canned cycle", notes)."""
    code, column = w.g.get("motion"), w.g_columns.get("motion", 0)
    cycle, at = w.g.get("cycle"), w.g_columns.get("cycle", 0)
    if not c.language.cycles_apart:
        return code, column
    if code in ("G80", *DRILLING):  # tables with one group
        code, cycle, column, at = None, code, 0, column
    if c.motion not in DRILLING and c.motion not in (None, "G80"):
        c.base_motion = c.motion
    c.base_motion = code or c.base_motion
    if cycle is None or (code is not None and at < column and cycle != "G80"):
        if cycle is not None:
            w.used |= {"R", "P", "Q", "K", "L"}
        return code, column
    return (code or c.base_motion, column or at) if cycle == "G80" else (cycle, at)


def _axis_left(c: IsoControl, w: IsoWords) -> bool:
    letters = "XYZABCUVW" if c.language.lathe else "XYZABC@^"
    letters += "H" if c.language.codes == "lathe" else ""
    return any(a in w.values and a not in w.used for a in letters)


def _bare(c: IsoControl, w: IsoWords, code: str | None) -> bool:
    """Return whether a block moves without an axis word: an arc with a centre (full circle)."""
    mode = code or c.motion
    centre = any(k in w.values for k in "IJK")
    if mode in ("G2", "G3"):
        return centre or (code is not None and "R" in w.values)
    if mode == "G76" and c.language.words == "o":
        return code is not None
    return mode in DRILLING and code is not None and c.language.words == "o"


def _move(c: IsoControl, w: IsoWords, mode: str | None, column: int) -> None:
    if (
        mode in (None, "G80")
        and c.language.survey
        and any("remapped" in what or "tilted" in what for what in c.assumptions)
    ):
        c.assume("the motion in force behind a remapped code", "G0", column=column)
        mode = c.motion = "G0"
    if mode is None or mode == "G80":
        raise BlockFault(
            column, "axis words without a motion code in force; write G0, G1, G2 or G3 before them"
        )
    c.column = column
    if mode in ("G0", "G1"):
        line(c, w, mode == "G0")
    elif mode in ("G2", "G3"):
        arc(c, w, mode == "G2")
    elif mode == "G77" and c.language.haas and not c.language.lathe:
        c.assume(
            "G77 of Haas (back boring)", NOT_MOVED, "G77 (back boring) is not understood; write its moves with G0 and G1",
            column=column,
        )  # fmt: skip
        w.used |= set(w.values)
    elif mode in SINGLE:
        c.marker = mode
        single_cut(c, w, mode, _lead(c, w, column) if mode in THREADED else 0.0)
        c.marker = ""
    elif mode in ("G32", "G33", "G34"):
        thread(c, w, _lead(c, w, column))
    elif mode in ("G5", "G5.1"):
        from vcmm.program.iso.splines import spline

        spline(c, w, mode, column)
    elif mode == "G33.1":
        rigid_tap(c, w, _lead(c, w, column))
    else:
        c.marker = mode
        if mode == "G76" and c.language.words == "o":
            from vcmm.program.iso.threading_cycle import thread_cycle

            thread_cycle(c, w)
        else:
            before = c.plane
            if c.language.lathe:
                mode, c.plane = lathe_cycle(c, mode)
            drill(c, w, mode)
            c.plane = before
        c.marker = ""


def _lead(c: IsoControl, w: IsoWords, column: int) -> float:
    """Return the mm per turn; the last one stays in force, for Fanuc even an F of another motion."""
    letter = "K" if c.language.words == "o" else "F"
    number = w.take(letter)
    if number is not None:
        c.lead = length(c, w, letter, number) if c.language.words == "o" else number * c.unit
    elif c.lead is None and c.language.words == "macro" and c.turning_feed is not None:
        c.lead = c.turning_feed * c.unit
    if c.lead is None:
        raise BlockFault(column, f"the thread has no lead; add {letter}, as in {letter}1.5")
    return c.lead


_HARMLESS_WORDS = frozenset("NOS")


def unused_words(c: IsoControl, w: IsoWords) -> None:
    """Note words without use in the block."""
    if w.passed:
        return
    left = [letter for letter in w.values if letter not in w.used and letter not in _HARMLESS_WORDS]
    for letter in sorted(left, key=w.column):
        if letter in "UVW" and not c.language.lathe:
            refusal = f"the axis {letter} is not modelled; vcmm knows X Y Z A B C"
            c.assume(f"the axis {letter}", "not modelled: it stays", refusal, column=w.column(letter))
            continue
        refused = c.language.unused_words == "refuse" or letter in "XYZABC@^"
        pass_over(c, f"{letter}{w.words[letter].text}", w.column(letter), refused)


def _stop(c: IsoControl, w: IsoWords) -> None:
    if w.m.get("stop") in (2, 30):
        c.has_ended = True
