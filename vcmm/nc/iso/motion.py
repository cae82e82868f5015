"""Lines, arcs, threads and dwells: from words to moves.

The end point of an arc wins: where the programmed centre is not at equal distances from start and end, the radius goes
evenly with the angle from the one at the start to the one at the end, as in LinuxCNC and Fanuc controls; the centre stays
as programmed. Limits of the difference are those of LinuxCNC (`arc_limits`).
"""

from __future__ import annotations

import math

from vcmm.nc.control import AXES, Control
from vcmm.nc.faults import BlockFault
from vcmm.nc.iso.codes import Words
from vcmm.nc.moves import PLANES, Move, Point

CENTRE_WORDS = "IJK"
TINY = 1e-12
FULL_CIRCLE = 1e-6  # rad: an arc that ends where it begins is a whole turn
SAME_RADIUS = 0.001  # mm: below this the difference of the radii is rounding and not worth a remark


def target(c: Control, w: Words) -> tuple[list[float], Point]:
    """Programmed end point and rotary position from the axis words of a block."""
    p = list(c.p)
    for i, axis in enumerate(AXES):
        number = w.take(axis)
        if number is not None:
            value = length(c, w, axis, number)
            if axis == "X" and c.diameter:
                value /= 2.0
            p[i] = value if c.absolute else p[i] + value
    if c.dialect.lathe:
        _increments(c, w, p)
    return p, _rotary(c, w)


def _increments(c: Control, w: Words, p: list[float]) -> None:
    """U, V and W of G-code system A: increments of X (a diameter), Y and Z."""
    for i, letter in enumerate("UVW"):
        number = w.take(letter)
        if number is None:
            continue
        if w.has(AXES[i]):
            raise BlockFault(w.column(letter), f"{AXES[i]} and {letter} stand in one block; keep one of them")
        value = length(c, w, letter, number)
        p[i] = c.p[i] + (value / 2.0 if letter == "U" and c.diameter else value)


def _rotary(c: Control, w: Words) -> Point:
    if not any(w.has(a) for a in "ABC"):
        return c.rotary
    out = list(c.rotary)
    for i, axis in enumerate("ABC"):
        number = w.take(axis)
        if number is not None:
            angle = math.radians(number)
            out[i] = angle if c.absolute else out[i] + angle
    return (out[0], out[1], out[2])


def length(c: Control, w: Words, letter: str, number: float) -> float:
    """A number of the program in mm, with the decimal point rule of the dialect."""
    word = w.words.get(letter)
    if word is not None and number and not word.pointed and c.dialect.words == "macro":
        if c.dialect.decimal_point == "increment":
            return number * c.dialect.increment[1 if c.unit > 1.0 else 0] * c.unit
        _warn_pointless(c, w, letter, number)
    return number * c.unit


def _warn_pointless(c: Control, w: Words, letter: str, number: float) -> None:
    unit = "inch" if c.unit > 1.0 else "mm"
    small = number * c.dialect.increment[1 if c.unit > 1.0 else 0]
    c.remark(
        f"{letter}{w.words[letter].text} without a decimal point is read as {number:g} {unit} (calculator type); a control "
        f'set to increments reads {small:g} {unit}. Write the point, or decimal_point = "increment" in the set-up file',
        w.column(letter),
        once="decimal point",
    )


def feed_rate(c: Control, w: Words, distance: float, column: int, middle_x: float = 0.0) -> float:
    """mm/min along a path of `distance` mm. Raises BlockFault: no feed, or one per turn of a spindle that stands still."""
    if c.feed_mode == "G93":
        number = w.take("F")
        if number is None or number <= 0:
            raise BlockFault(column, "G93 (inverse time) needs a positive F in every block that cuts; add F")
        return distance * number
    if not c.feed or c.feed <= 0:
        raise BlockFault(column, "no feed has been programmed for this cutting move; add F, for example F200")
    if c.feed_mode == "G95":
        turns = spindle_speed(c, middle_x)
        if not turns:
            raise BlockFault(
                column, "the feed is per turn (G95), but the spindle has no speed; add S before this block"
            )
        return c.feed * c.unit * turns
    return c.feed * c.unit


def spindle_speed(c: Control, x: float) -> float:
    """Turns per minute, not signed; with G96 from the cutting speed at radius |x|, mm, limited by the programmed maximum."""
    if c.spindle_mode == "G97":
        return c.speed
    surface = c.speed * (304.8 if c.unit > 1.0 else 1000.0)  # ft/min or m/min -> mm/min
    limit = c.speed_limit if c.speed_limit is not None else math.inf
    turns = min(surface / (2.0 * math.pi * abs(x)) if x else math.inf, limit)
    return turns if math.isfinite(turns) else 0.0


def signed_speed(c: Control, x: float) -> float:
    return c.sense * spindle_speed(c, x) if c.sense else 0.0


def make(
    c: Control,
    kind: str,
    start: Point,
    end: Point,
    rotary: Point,
    feed: float | None,
    rewritable: bool = True,
) -> Move:
    """A straight move with everything that is in force."""
    x = c.p[0] if c.spindle_mode == "G97" else (start[0] + end[0]) / 2.0 - c.shift[0]
    return Move(
        kind, c.source, start, end, c.rotary, rotary, c.plane, None, 1, None, feed, signed_speed(c, x), c.tool,
        c.tool_offset, c.compensation.side if c.compensation and rewritable else None, 0.0, c.exact or c.exact_once,
        None if c.exact or c.exact_once else c.tolerance, c.offset, rewritable,
    )  # fmt: skip


def straight(c: Control, w: Words, rapid: bool, column: int, kind: str = "") -> None:
    """G0 or G1."""
    p, rotary = target(c, w)
    line(c, w, p, rotary, rapid, column, kind)


def line(
    c: Control, w: Words, p: list[float], rotary: Point, rapid: bool, column: int, kind: str = ""
) -> None:
    """A straight move to a programmed point."""
    start, end = c.tip(), c.to_tip(p)
    feed = None
    if not rapid:
        middle_x = (start[0] + end[0]) / 2.0 - c.shift[0]
        feed = feed_rate(c, w, path_length(c, start, end, rotary), column, middle_x)
        if start == end and rotary != c.rotary and c.feed_mode == "G94":
            feed /= c.unit  # degrees per minute, whatever the unit of length
    c.emit(make(c, kind or ("rapid" if rapid else "line"), start, end, rotary, feed))
    c.rotary = rotary
    c.arrive(p, end)


def path_length(c: Control, start: Point, end: Point, rotary: Point) -> float:
    """mm; degrees of the rotary axes where nothing else moves (that is what F means then)."""
    distance = math.dist(start, end)
    return distance or math.degrees(math.dist(c.rotary, rotary))


def arc_limits(c: Control) -> tuple[float, float, float]:
    """Largest difference of the radii, mm: never; and the pair (mm, share of the radius) of which one must be kept.

    LinuxCNC: 2 sqrt(2) least steps, a hundred times that in no case; the step is 0.01 mm or 0.001 inch.
    """
    step = 2.0 * math.sqrt(2.0) * (0.001 * 25.4 if c.unit > 1.0 else 0.01)
    return 100.0 * step, step, 0.001


def arc(c: Control, w: Words, clockwise: bool, column: int) -> None:
    """G2 or G3."""
    first, second, normal = PLANES[c.plane]
    before = list(c.p)
    named = any(w.has(AXES[i]) for i in (first, second)) or (c.dialect.lathe and any(w.has(k) for k in "UW"))
    p, rotary = target(c, w)
    turns = _turns(c, w)
    radius = w.take("R")
    centre_given = [w.has(k) for k in CENTRE_WORDS]
    if radius is not None and any(centre_given) and c.dialect.words == "o":
        raise BlockFault(w.column("R"), "an arc takes R or a centre (I J K), not both; remove one of them")
    if radius is not None:
        for k in CENTRE_WORDS:
            w.take(k)
        centre = _centre_of_radius(c, w, before, p, length(c, w, "R", radius), clockwise, named)
    else:
        centre = _centre_of_words(c, w, before, p, column)
    centre[normal] = before[normal]
    sweep = _swept(before, p, centre, first, second, clockwise, turns)
    _emit_arc(c, w, before, p, rotary, centre, clockwise, turns, sweep, column)


def _turns(c: Control, w: Words) -> int:
    if c.dialect.words != "o":
        return 1
    turns = w.whole("P", 1, 1)
    return 1 if turns is None else turns


def _centre_of_words(c: Control, w: Words, before: list[float], p: list[float], column: int) -> list[float]:
    """The centre from I J K; checks the radii."""
    first, second, normal = PLANES[c.plane]
    if w.has(CENTRE_WORDS[normal]) and w.values[CENTRE_WORDS[normal]] and c.dialect.words == "o":
        raise BlockFault(
            w.column(CENTRE_WORDS[normal]),
            f"{CENTRE_WORDS[normal]} is no centre word of the plane {c.plane}; choose the plane with G17, G18 or G19, or remove it",
        )
    given = [w.take(k) for k in CENTRE_WORDS]
    if given[first] is None and given[second] is None:
        raise BlockFault(
            column,
            f"the arc has neither R nor a centre ({CENTRE_WORDS[first]} {CENTRE_WORDS[second]} in the plane {c.plane}); add one",
        )
    if c.arc_absolute and (given[first] is None or given[second] is None) and c.dialect.words == "o":
        raise BlockFault(
            column, "with absolute centres (G90.1) both centre words of the plane are due; add the other"
        )
    centre = list(before)
    for i in (first, second):
        number = given[i]
        if number is not None:
            value = length(c, w, CENTRE_WORDS[i], number)
            if c.arc_absolute:
                centre[i] = value / 2.0 if i == 0 and c.diameter and c.dialect.words == "o" else value
            else:
                centre[i] = before[i] + value
    _check_radii(c, before, p, centre, column)
    return centre


def _check_radii(c: Control, before: list[float], p: list[float], centre: list[float], column: int) -> None:
    first, second, _ = PLANES[c.plane]
    r1 = math.hypot(before[first] - centre[first], before[second] - centre[second])
    r2 = math.hypot(p[first] - centre[first], p[second] - centre[second])
    if r1 < TINY or r2 < TINY:
        where = "start" if r1 < TINY else "end"
        raise BlockFault(
            column, f"the centre of the arc lies on its {where} point: an arc of radius zero; check I J K"
        )
    never, step, share = arc_limits(c)
    off = abs(r1 - r2)
    if off > never or (off > step and off > share * max(r1, r2)):
        hint = ""
        if not c.arc_absolute and _fits_absolute(c, before, p, centre):
            hint = '; the words fit an absolute centre: write arc_centre = "absolute" in the set-up file'
        raise BlockFault(
            column,
            f"the arc does not fit: radius {r1:.4f} mm at its start, {r2:.4f} mm at its end ({off * 1000:.1f} um apart; "
            f"allowed are {step * 1000:.1f} um, or 0.1 % up to {never:.2f} mm); correct the end point or the centre{hint}",
        )
    if off > SAME_RADIUS:
        c.remark(
            f"the radii of the arc at its start and end differ by {off * 1000:.1f} um ({r1:.4f} and {r2:.4f} mm); "
            "the end point is kept, the radius changes evenly on the way",
            column,
        )


def _fits_absolute(c: Control, before: list[float], p: list[float], centre: list[float]) -> bool:
    first, second, _ = PLANES[c.plane]
    a, b = centre[first] - before[first], centre[second] - before[second]
    r1 = math.hypot(before[first] - a, before[second] - b)
    r2 = math.hypot(p[first] - a, p[second] - b)
    return abs(r1 - r2) < arc_limits(c)[1]


def _centre_of_radius(
    c: Control, w: Words, before: list[float], p: list[float], radius: float, clockwise: bool, named: bool
) -> list[float]:
    """Centre of an arc given by R: positive up to half a turn, negative beyond."""
    first, second, _ = PLANES[c.plane]
    column = w.column("R")
    dx, dy = p[first] - before[first], p[second] - before[second]
    chord = math.hypot(dx, dy)
    if chord < TINY or not named:
        raise BlockFault(
            column, "an arc given by R must end elsewhere than it starts; give a full circle by I J K"
        )
    if not radius:
        raise BlockFault(column, "an arc of radius zero; correct R")
    half = chord / 2.0
    least = 0.00127  # mm, LinuxCNC's limit of a chord longer than the diameter
    if half - abs(radius) > least:
        raise BlockFault(
            column,
            f"R is too small: {abs(radius):.4f} mm, but the end lies {chord:.4f} mm away; {half:.4f} mm is the least",
        )
    if half > abs(radius):
        c.remark(
            f"R is {1000 * (half - abs(radius)):.2f} um smaller than half the distance; a half circle is taken",
            column,
        )
    height = math.sqrt(max(radius * radius - half * half, 0.0))
    side = (1.0 if clockwise else -1.0) * (1.0 if radius > 0 else -1.0)
    centre = list(before)
    centre[first] += dx / 2.0 + side * height * dy / chord
    centre[second] += dy / 2.0 - side * height * dx / chord
    return centre


def _swept(
    before: list[float],
    p: list[float],
    centre: list[float],
    first: int,
    second: int,
    clockwise: bool,
    turns: int,
) -> float:
    """Angle of the arc, rad, positive; equal end points mean a whole turn."""
    a = math.atan2(before[second] - centre[second], before[first] - centre[first])
    b = math.atan2(p[second] - centre[second], p[first] - centre[first])
    sweep = (a - b if clockwise else b - a) % (2.0 * math.pi)
    if sweep < FULL_CIRCLE:
        sweep += 2.0 * math.pi
    return sweep + 2.0 * math.pi * (turns - 1)


def _emit_arc(
    c: Control, w: Words, before: list[float], p: list[float], rotary: Point, centre: list[float], clockwise: bool,
    turns: int, sweep: float, column: int,
) -> None:  # fmt: skip
    first, second, normal = PLANES[c.plane]
    start, end = c.tip(), c.to_tip(p)
    radius = math.hypot(before[first] - centre[first], before[second] - centre[second])
    distance = math.hypot(radius * sweep, p[normal] - before[normal])
    middle_x = (before[0] + p[0]) / 2.0
    feed = feed_rate(c, w, distance, column, middle_x)
    _check_plane(c, column)
    move = make(c, "arc", start, end, rotary, feed)
    middle = c.to_tip(centre)
    c.emit(move._replace(centre=middle, turns=turns, clockwise=clockwise))
    c.rotary = rotary
    c.arrive(p, end)


def _check_plane(c: Control, column: int) -> None:
    """A rotation must leave the plane of an arc a principal plane."""
    if c.matrix is None:
        return
    normal = PLANES[c.plane][2]
    if abs(c.matrix[normal][normal] - 1.0) > TINY:
        raise BlockFault(
            column,
            f"the coordinates are turned about another axis than the normal of the plane {c.plane}; such arcs are not understood",
        )


def dwell(c: Control, seconds: float, column: int) -> None:
    """G4."""
    if seconds < 0:
        raise BlockFault(column, "a dwell cannot be negative; correct its time")
    here = c.tip()
    c.emit(make(c, "dwell", here, here, c.rotary, None)._replace(seconds=seconds))


def thread(c: Control, w: Words, column: int, lead: float) -> None:
    """G33 (G32): a line with `lead` mm per turn of the spindle; the feed along the path follows from the speed."""
    p, rotary = target(c, w)
    thread_to(c, p, rotary, column, lead)


def thread_to(c: Control, p: list[float], rotary: Point, column: int, lead: float) -> None:
    start, end = c.tip(), c.to_tip(p)
    turns = spindle_speed(c, (start[0] + end[0]) / 2.0 - c.shift[0])
    if not turns or not c.sense:
        raise BlockFault(column, "threads need a turning spindle; add S and M3 or M4 before this block")
    if lead <= 0:
        raise BlockFault(column, "the lead of a thread must be positive; correct it")
    c.emit(make(c, "thread", start, end, rotary, lead * turns))
    c.rotary = rotary
    c.arrive(p, end)
