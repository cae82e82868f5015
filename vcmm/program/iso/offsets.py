"""Codes that change how programmed points become machine positions: work offsets, G92, G52, G68, tool length, G10, G28, G53."""

from __future__ import annotations

import math
from dataclasses import replace

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl
from vcmm.program.iso.lengths import length, need_axis
from vcmm.program.iso.motion import target
from vcmm.program.moves import ORIGIN, PLANES, Point
from vcmm.program.recorder import UNMOVED
from vcmm.program.setup import Tool

OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
MOST_FURTHER = 300  # G54.1 P1 .. P300


def select_offset(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Select G54 ... G59.3, G54.1 Pn: no axis moves, the programmed point is computed again."""
    if code == "G54.1":
        number = w.whole("P", column, 1)
        if number is None or number > MOST_FURTHER:
            raise BlockFault(column, f"G54.1 needs P1 to P{MOST_FURTHER}, as in G54.1 P3")
        code = further(number)
    elif code == "G154":  # Haas: G154 P1 is what others call G54.1 P1, G110 the first of it
        number = w.whole("P", column, 1)
        if number is None or number > 99:
            raise BlockFault(column, "G154 needs P1 to P99, as in G154 P3")
        code = further(number)
    elif code.startswith("G1"):
        code = further(int(code[1:]) - 109)
    elif code == "G54" and _further_by_p(c, w):  # G54 P3 of Fanuc is G54.1 P3
        number = w.whole("P", column, 1)
        if number is None or number > MOST_FURTHER:
            raise BlockFault(column, f"G54 P is G54.1 P here, and takes P1 to P{MOST_FURTHER}")
        code = further(number)
    c.select(code)
    c.rebuild()


_TAKES_P = {"dwell", "cycle", "other", "macro", "turning", "pattern", "pocket", "dynamic"}


def _further_by_p(c: IsoControl, w: IsoWords) -> bool:
    """Return whether P of a block with G54 belongs to it: "G54.1 Pn or G54 Pn" (FANUC B-64304EN, additional workpiece coordinate systems)."""
    fanuc = c.language.words == "macro" and not c.language.haas
    return fanuc and w.has("P") and "P" not in w.used and not (_TAKES_P & w.g.keys())


def further(number: int) -> str:
    """Name of the offset of G54.1 Pn."""
    return f"G54.1 P{number}"


def set_data(c: IsoControl, w: IsoWords, column: int) -> None:
    """Set data by G10: L2 and L20 work offsets; L1, L10 to L13 tool data."""
    kind = w.whole("L", column)
    if kind == 2 or (kind == 20 and c.language.words == "o"):
        _set_offset(c, w, kind, column)
    elif kind == 20 and c.language.words == "macro" and w.has("P") and not w.has("R"):
        _set_offset(c, w, 2, column)
    elif kind in (1, 10, 11, 12, 13) and (w.has("R") or c.language.words == "o"):
        _set_tool(c, w, kind, column)
    else:
        text = "without L" if kind is None else f"L{kind}"
        refusal = f"G10 {text} is not understood; known are L1, L2, L10 to L13 and L20"
        c.assume(f"the data of G10 {text}", "passed over", refusal, column=column)
        w.used |= set(w.values)


def _offset_name(c: IsoControl, w: IsoWords, column: int) -> str:
    further_ones = w.values.get("L") == 20 and c.language.words == "macro"
    number = w.whole("P", column)
    if further_ones and number:  # Fanuc, Haas: G10 L20 Pn is G54.1 Pn
        return further(number)
    most = 9 if c.language.words == "o" else 6
    if number is None and c.language.survey:
        number = 0
    if number is None or number > most:
        raise BlockFault(column, f"G10 L2 needs P0 to P{most}; P1 is G54")
    if number == 0:
        return c.offset if c.language.words == "o" else ""
    return OFFSETS[number - 1]


def _set_offset(c: IsoControl, w: IsoWords, kind: int, column: int) -> None:
    name = _offset_name(c, w, column)
    old = list(c.offsets.get(name, ORIGIN) if name else c.common)
    named: dict[int, float] = {}
    angle = w.take("R")
    if angle is not None and kind == 2 and c.language.words == "o":
        c.rotations[name] = math.radians(angle)
    for i, axis in enumerate(AXES):
        number = w.take(axis)
        if number is None:
            continue
        value = length(c, w, axis, number) / (2.0 if axis == "X" and c.diametral() else 1.0)
        named[i] = value
        old[i] = value if c.absolute or c.language.words == "o" else old[i] + value
    if kind == 20:
        old = _reading(c, name, named)
    _no_rotary(w, column)
    new = (old[0], old[1], old[2])
    if name:
        c.offsets[name] = new
    else:
        c.common = new
    c.rebuild()


def _reading(c: IsoControl, name: str, named: dict[int, float]) -> list[float]:
    """Return the offset with which the present position reads the named values; other axes are unchanged."""
    before, c.offset = c.offset, name or c.offset
    c.rebuild()
    here, wanted = c.world.apply(c.p), [named.get(i, c.p[i]) for i in range(3)]
    there, base = c.world.apply((wanted[0], wanted[1], wanted[2])), c.offsets.get(c.offset, ORIGIN)
    c.offset = before
    return [base[i] + here[i] - there[i] for i in range(3)]


def _no_rotary(w: IsoWords, column: int) -> None:
    for axis in "ABC":
        if w.take(axis):
            raise BlockFault(
                w.column(axis), f"offsets of the rotary axis {axis} are not understood; keep it at zero"
            )


def _set_tool(c: IsoControl, w: IsoWords, kind: int, column: int) -> None:
    number = w.whole("P", column, 1)
    if number is None:
        raise BlockFault(column, f"G10 L{kind} needs P, the number of the tool or register")
    old = c.tools.get(number, Tool(number))
    radius = w.take("R")
    if c.language.words == "o":
        c.tools[number] = _entered_tool(c, w, old, kind, column)
        return
    if radius is None:
        raise BlockFault(column, f"G10 L{kind} needs R, the value of the register")
    value = length(c, w, "R", radius)
    if kind in (10, 11):
        base = 0.0 if c.absolute and kind == 10 else c.lengths.get(number, old.length)
        c.lengths[number] = base + value
    else:
        base = 0.0 if c.absolute and kind == 12 else c.radii.get(number, old.radius or 0.0)
        c.radii[number] = base + value


def _entered_tool(c: IsoControl, w: IsoWords, old: Tool, kind: int, column: int) -> Tool:
    """Return the tool with entered offsets. G10 L1: offsets as given. L10: so that the present position reads X Y Z; L11: the same in the
    ninth offset, G59.3."""
    if kind not in (1, 10, 11):
        raise BlockFault(
            column, f"G10 L{kind} is not known in {c.language.name}; known are L1, L2, L10, L11 and L20"
        )
    origin = c.offsets.get("G59.3", ORIGIN) if kind == 11 else c.world.shift
    new = list(old.offset)
    for i, axis in enumerate(AXES):
        number = w.take(axis)
        if number is not None:
            new[i] = number * c.unit if kind == 1 else c.q[i] - origin[i] - number * c.unit
    radius, orientation = w.take("R"), w.whole("Q", column)
    w.used |= {"I", "J"}  # angles of a turning tool: no effect on the path
    return replace(
        old, offset_x=new[0], offset_y=new[1], length=new[2],
        diameter=old.diameter if radius is None else 2.0 * radius * c.unit,
        orientation=old.orientation if orientation is None else orientation,
    )  # fmt: skip


def preset(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Set a preset by G92: the present position gets the programmed values; G92.1 to G92.3 cancel, suspend and restore."""
    if code == "G92":
        if not w.any_axis and not (c.language.words == "macro" and w.has("S")):
            raise BlockFault(column, "G92 needs at least one axis word, as in G92 X0 Y0")
        if not w.any_axis:
            c.speed_limit = w.need("S", "the highest speed of the spindle", column)
            return
        _no_rotary(w, column)
        shift = list(c.g92)
        for i, axis in enumerate(AXES):
            number = w.take(axis)
            if number is not None:
                value = length(c, w, axis, number) / (2.0 if axis == "X" and c.diametral() else 1.0)
                shift[i] += c.p[i] - value
        c.g92 = c.g92_kept = (shift[0], shift[1], shift[2])
    elif code == "G92.3":
        c.g92 = c.g92_kept
    else:
        if c.language.survey:
            w.used |= set("XYZABC")  # some posts name the axes
        c.g92 = ORIGIN
        c.g92_kept = ORIGIN if code == "G92.1" else c.g92_kept
    c.rebuild()


def local_shift(c: IsoControl, w: IsoWords, column: int) -> None:
    """Shift by G52: a shift of all work offsets (Fanuc); in LinuxCNC it is kept with the shift of G92."""
    shift = list(c.g52 if c.language.words == "macro" else c.g92)
    if not w.any_axis and c.language.survey:
        c.remark("G52 without axes shifts nothing", column)
        return
    if not w.any_axis:
        raise BlockFault(column, "G52 needs at least one axis word; G52 X0 Y0 Z0 cancels it")
    for i, axis in enumerate(AXES):
        number = w.take(axis)
        if number is not None:
            shift[i] = length(c, w, axis, number) / (2.0 if axis == "X" and c.diametral() else 1.0)
    _no_rotary(w, column)
    new = (shift[0], shift[1], shift[2])
    if c.language.words == "macro":
        c.g52 = new
    else:
        c.g92 = c.g92_kept = new
    c.rebuild()


def coordinate_turn(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Turn by G68: turn the programmed points about a centre, in the plane; G69 ends it."""
    if code == "G69":
        c.turn, c.tilt, c.is_plane_tilted, c.posture, c.is_tilt_given = None, UNMOVED, False, None, False
        c.plane_words.clear()
    elif c.language.words == "macro" and c.language.codes != "mach3" and any(w.has(k) for k in "IJK"):
        c.assume(
            "G68 about an axis in space (I J K)", "passed over: nothing is turned",
            "G68 with I J K turns about an axis in space, which is not understood; write G68.2", column=column,
        )  # fmt: skip
        w.used |= set("XYZIJKR")
    else:
        if c.compensation:
            raise BlockFault(column, "G68 while cutter radius compensation is on; cancel it with G40 before")
        first, second, _ = PLANES[c.plane]
        mach3 = c.language.codes == "mach3"
        letter = "R" if c.language.words == "macro" or w.has("R") or mach3 else "B"
        if c.language.survey and not w.has(letter):
            c.assume("the angle of G68", "0 degrees (FANUC parameter 5410)", column=column)
            w.values[letter] = 0.0
        angle = w.need(letter, f"the angle of G68, in degrees, as in G68 X0 Y0 {letter}30", column)
        centre = list(c.p)
        for i, name in ((first, "A" if mach3 else AXES[first]), (second, "B" if mach3 else AXES[second])):
            number = w.take(name)  # Mach3: G68 A10 B0 R90, A and B are coordinates of the centre
            if number is not None:
                centre[i] = number * c.unit if mach3 else length(c, w, name, number)
        more = w.take("I") is not None if mach3 else not c.absolute
        old = 0.0 if not more or c.turn is None else c.turn[2]
        c.turn = (c.plane, (centre[0], centre[1], centre[2]), old + math.radians(angle))
    c.rebuild()


# -- moves in machine coordinates -------------------------------------------------------------------------------------
def machine_move(c: IsoControl, w: IsoWords, column: int) -> None:
    """Execute G53: one block whose words are positions of the axes in machine coordinates."""
    rapid = c.motion != "G1" or c.language.words == "macro"
    if c.language.words == "o" and c.motion not in ("G0", "G1"):
        raise BlockFault(column, "G53 needs G0 or G1 in force; write G53 G0 Z0")
    if not c.absolute and not c.language.cycles_apart:
        raise BlockFault(column, "G53 needs absolute coordinates; write G90 before")
    if not c.absolute and c.language.words == "macro" and not c.language.haas and not c.language.lathe:
        c.assume(
            "G53 under G91", "passed over, as the control does: no move",
            "G53 is passed over under G91 (FANUC B-64304EN, machine coordinate system); write G90 before it", column=column,
        )  # fmt: skip
        w.used |= set(w.values)
        return
    if c.compensation is not None:
        _suspend(c, "G53 while cutter radius compensation is on; cancel it with G40 before", column)
    q, rotary = list(c.q), list(c.rotary)
    for i, axis in enumerate(AXES):
        number = w.take(axis)
        if number is not None:
            q[i] = length(c, w, axis, number) / (2.0 if axis == "X" and c.diametral() else 1.0)
    for i, axis in enumerate("ABC"):
        number = w.take(axis)
        if number is not None:
            need_axis(c, w, axis)
            rotary[i] = math.radians(number)
    c.column = column
    go_to_axes(c, (q[0], q[1], q[2]), rapid, (rotary[0], rotary[1], rotary[2]))


def _suspend(c: IsoControl, refusal: str, column: int) -> None:
    """Suspend compensation while the axes go to a machine position: Fanuc (B-64304EN, "automatic return to reference position")."""
    if c.language.words == "o":
        raise BlockFault(column, refusal)
    c.assume(
        "radius compensation in a move of the machine", "at rest during that move", refusal, column=column
    )


def go_to_axes(c: IsoControl, q: Point, rapid: bool, rotary: Point) -> None:
    """Move the axes straight to a machine position; never rewritten, and without radius compensation."""
    o, before = c.tool_offset, c.compensation
    c.compensation = None
    c.to_machine((q[0] - o[0], q[1] - o[1], q[2] - o[2]), rapid, rotary)
    c.compensation = before
    c.q = q
    c.locate()


def reference_axes(c: IsoControl, w: IsoWords, column: int) -> None:
    """Reference axes by G28.1 of Mach3: the axes named are sent home (Mach3Mill, "reference axes"); LinuxCNC keeps the position there."""
    c.assume(
        "G28.1 of Mach3, which sends the axes home", "by way of the programmed point to the reference point, as G28",
        "G28.1 of Mach3 sends the axes to their switches, where these are the machine alone knows; use G28", column=column,
    )  # fmt: skip
    go_home(c, w, False, column)


def go_home(c: IsoControl, w: IsoWords, second: bool, column: int) -> None:
    """Move home by G28, G30: by way of the programmed point to the reference point, only the axes that are named (LinuxCNC: or all)."""
    if c.compensation is not None:
        _suspend(
            c, "a reference move while cutter radius compensation is on; cancel it with G40 before", column
        )
    named = [axis for axis in AXES if w.has(axis) or (c.language.lathe and w.has("UVW"[AXES.index(axis)]))]
    turned = [axis for axis in "ABC" if w.has(axis)]
    if second and c.language.words == "macro":
        number = w.whole("P", column)
        if number not in (None, 2):
            refusal = f"G30 P{number} is not known: the set-up file holds the first and the second reference point only"
            c.assume(f"the reference point of G30 P{number}", "the second one", refusal, column=column)
    everything = not named and not turned and c.language.everything_home
    if not (named or turned or everything):
        code = "G30" if second else "G28"
        c.assume(
            f"where {code} without axes goes", f"nowhere: {c.language.name} moves the axes that are named; on a Haas all axes go", column=column
        )  # fmt: skip
    if named or turned:
        p, rotary = target(c, w)
        c.between |= {i: (*p, *rotary)[i] for i, a in enumerate("XYZABC") if a in (*named, *turned)}
        _rapid_by(c, p, rotary)
    home = c.home2 if second else c.home
    q = [home[i] if everything or AXES[i] in named else c.q[i] for i in range(3)]
    turning = [0.0 if everything or "ABC"[i] in turned else c.rotary[i] for i in range(3)]
    go_to_axes(c, (q[0], q[1], q[2]), True, (turning[0], turning[1], turning[2]))


def return_from_home(c: IsoControl, w: IsoWords, column: int) -> None:
    """Return from home by G29: the axes that are named go to the point by way of which G28 or G30 came, and on to the programmed point, which counts
    increments from the former (FANUC B-64304EN, "return from reference position (G29)"; Haas mill operator's manual, G29)."""
    if c.compensation is not None:
        _suspend(c, "G29 while cutter radius compensation is on; cancel it with G40 before", column)
    letters = [(a, "UVW"[i] if c.language.lathe else "") for i, a in enumerate(AXES)] + [
        (a, "") for a in "ABC"
    ]
    named = [i for i, words in enumerate(letters) if any(k and w.has(k) for k in words)]
    lost = [letters[i][0] for i in named if i not in c.between]
    if lost or not named:
        what = f"no G28 has led {lost[0]} over a point" if lost else "no axis is named"
        raise BlockFault(column, f"G29: {what}; G29 takes the axes that a G28 before it has named")
    via = [*c.p, *c.rotary]
    for i in named:
        via[i] = c.between[i]
    _rapid_by(c, (via[0], via[1], via[2]), (via[3], via[4], via[5]))
    _rapid_by(c, *target(c, w))


def _rapid_by(c: IsoControl, p: Point, rotary: Point) -> None:
    """Make a rapid of a reference move to a programmed point."""
    end = c.world.apply(p)
    if c.tip() != end or rotary != c.rotary:
        c.emit("rapid", end, rotary=rotary, rewritable=False)
    c.p = p


def store_home(c: IsoControl, second: bool) -> None:
    """Store the home of G28.1, G30.1: the present position of the axes becomes the reference point."""
    if second:
        c.home2 = c.q
    else:
        c.home = c.q
