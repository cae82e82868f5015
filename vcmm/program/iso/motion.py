"""Lines, arcs, threads and dwells: from words to moves.

The end point of an arc wins: where the programmed centre is not at equal distances from start and end, the radius goes
evenly with the angle from the one at the start to the one at the end, as in LinuxCNC and Fanuc controls; the centre stays
as programmed. Limits of the difference are those of LinuxCNC (`arc_limits`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vcmm.program.faults import BlockFault
from vcmm.program.frames import in_plane
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, ArcMisfit, IsoControl
from vcmm.program.iso.drawing import angle_of, at_angle, chamfer_of, cut_corner, draws
from vcmm.program.iso.lengths import length
from vcmm.program.iso.polar import polar_ends, radial_ends
from vcmm.program.iso.winding import flat, wound_arc, wound_line, wound_target
from vcmm.program.levels import SetupEntry
from vcmm.program.moves import PLANES, Point, point_of
from vcmm.program.probing import leave, touch
from vcmm.program.recorder import NO_TOOL

CENTRE_WORDS = "IJK"
NO_LENGTH_MM = 1e-12
FULL_CIRCLE = 1e-6  # rad: an arc that ends where it begins is a whole turn
MOST_TURNS = 10_000
CHORD = 0.001  # mm: how far straight lines may lie from the arc that they stand for
SAME_RADIUS = 0.001  # mm: below this the difference of the radii is rounding and not worth a remark


def target(c: IsoControl, w: IsoWords) -> tuple[Point, Point]:
    """Return the programmed end point and rotary position from the axis words of a block."""
    p = list(c.p)
    polar = polar_ends(c, w, p) if c.polar is not None else radial_ends(c, w, p)
    for i, axis in enumerate(AXES):
        number = w.take(axis)
        if number is not None and i not in polar:
            value = length(c, w, axis, number)
            if axis == "X" and c.diametral():
                value /= 2.0
            p[i] = value if c.absolute else p[i] + value
    if c.language.lathe:
        _increments(c, w, p)
    return wound_target(c, w, p)


def _increments(c: IsoControl, w: IsoWords, p: list[float]) -> None:
    """Read U, V and W of G-code system A: increments of X (a diameter), Y and Z."""
    for i, letter in enumerate("UVW"):
        number = w.take(letter)
        if number is None:
            continue
        if w.has(AXES[i]):
            raise BlockFault(w.column(letter), f"{AXES[i]} and {letter} stand in one block; keep one of them")
        value = length(c, w, letter, number)
        p[i] = c.p[i] + (value / 2.0 if letter == "U" and c.diametral() else value)


def line(c: IsoControl, w: IsoWords, rapid: bool) -> None:
    """Move along a line, G0 or G1. With G43.5 I J K are the direction of the tool, from its tip to the spindle, in workpiece axes."""
    if c.vectors and any(w.has(k) for k in "IJK"):
        x, y, z = (w.take(k) or 0.0 for k in "IJK")
        c.point_to((x, y, z))
    is_drawn = not rapid and draws(c)
    chamfer, angle = (chamfer_of(c, w), angle_of(c, w)) if is_drawn else (None, None)
    p, rotary = target(c, w)
    if c.winding is not None and c.winding.radius:
        wound_line(c, p, rapid, rotary)
        return
    start = c.p
    c.straight(p if angle is None else at_angle(c, w, p, angle), rapid, rotary)
    if chamfer is not None:
        cut_corner(c, start, chamfer[0], length(c, w, *chamfer), w.column(chamfer[0]))
    corner_words(c, w)


def probe(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Probe by G31, G38.2, G38.3: towards the programmed point until the probe answers; G38.4, G38.5: away from a surface until it is free. Not
    modal here, the motion before stays in force.

     Sources: FANUC B-64304EN, "skip function (G31)", #5061 to #5063 hold where it stopped, and the end point where nothing was met;
    LinuxCNC, "G38.n straight probe": G38.2 and G38.4 are alarms without contact, #5061 to #5063 and #5070 (1: contact).
    """
    w.take("P")
    c.column = column
    p, rotary = target(c, w)
    if rotary != c.rotary:
        raise BlockFault(column, f"{code} with a rotary axis: probe with linear axes only")
    away = code in ("G38.4", "G38.5")
    c.has_contact = (leave if away else touch)(c, p, c.tools.get(c.tool, NO_TOOL))
    what = (
        "leaves no surface: the probe touches none where it starts"
        if away
        else "meets no surface that the set-up states"
    )
    if not c.has_contact and code in ("G38.2", "G38.4"):
        raise BlockFault(column, f"{code} {what}: an alarm; check the target, [stock] and [[surfaces]]")
    if not c.has_contact:
        c.remark(f"{code} {what} and goes to its end point", column, every=True)


def corner_words(c: IsoControl, w: IsoWords) -> None:
    """Read ,R and ,C: the corner after this move is rounded or cut; R and C alone in the straight cuts of a lathe."""
    for letter, kind in (("R", "round"), ("C", "chamfer")):
        for word in (f",{letter}", letter if c.language.lathe and c.motion == "G1" else ""):
            if word and word in w.values and word not in w.used:
                size = abs(length(c, w, word, w.take(word) or 0.0))
                if size:
                    c.corner(size, kind)


def arc_limits(c: IsoControl) -> tuple[float, float, float]:
    """Return the largest difference of the radii, mm: never; and the pair (mm, share of the radius) of which one must be kept.

    LinuxCNC: 2 sqrt(2) least steps, a hundred times that in no case; the step is 0.01 mm or 0.001 inch.
    """
    step = 2.0 * math.sqrt(2.0) * (0.001 * 25.4 if c.unit > 1.0 else 0.01)
    return 100.0 * step, step, 0.001


class ArcEnds(NamedTuple):
    """Start and end of an arc as programmed; has_axis: an axis of the plane is in the block."""

    start: Point
    end: Point
    clockwise: bool
    has_axis: bool


def arc(c: IsoControl, w: IsoWords, clockwise: bool) -> None:
    """Execute an arc, G2 or G3."""
    plane = PLANES[c.plane]
    named = any(w.has(AXES[i]) for i in plane[:2]) or (c.language.lathe and any(w.has(k) for k in "UW"))
    start = c.p
    p, rotary = target(c, w)
    wound = c.winding is not None and c.winding.radius > 0
    if wound:
        start, p, named = point_of(flat(c, start, c.rotary)), point_of(flat(c, p, rotary)), True
    ends = ArcEnds(start, p, clockwise, named or (c.winding is not None and w.has("C")))
    turns = _turns(c, w)
    radius = w.take("R")
    if radius is not None and any(w.has(k) for k in CENTRE_WORDS) and c.language.words == "o":
        raise BlockFault(w.column("R"), "an arc takes R or a centre (I J K), not both; remove one of them")
    if (
        radius is None
        and not any(w.has(k) for k in CENTRE_WORDS)
        and c.language.words == "macro"
        and not c.setup.strict
    ):
        c.assume(
            "an arc without R and centre", "a straight line (FANUC parameter 3403 CIR = 0)", column=c.column
        )
        c.straight(p, False, rotary)
        return
    if radius is not None:
        for k in CENTRE_WORDS:
            w.take(k)
        centre = _centre_of_radius(c, ends, length(c, w, "R", radius), w.column("R"))
    else:
        centre = _centre_of_words(c, w, ends)
    centre[plane[2]] = start[plane[2]]
    c.arcs_seen = True
    if wound:
        wound_arc(c, list(start), list(p), centre, clockwise)
        return
    emit_arc(c, ends, (centre[0], centre[1], centre[2]), turns, rotary)
    corner_words(c, w)


def emit_arc(c: IsoControl, ends: ArcEnds, centre: Point, turns: int, rotary: Point) -> None:
    """Emit the arc in machine coordinates; a mirror turns its sense round."""
    plane_map = in_plane(c.world, c.plane)
    if plane_map is None:
        chords(c, ends, centre, turns)
        return
    distance = plane_map[0] * _arc_length(ends, centre, PLANES[c.plane], turns)
    feed = c.rate(distance, c.feeding((ends.start[0] + ends.end[0]) / 2.0))
    c.emit(
        "arc", c.world.apply(ends.end), rotary=rotary, feed=feed, centre=c.world.apply(centre),
        turns=turns, clockwise=ends.clockwise != plane_map[1],
    )  # fmt: skip
    c.p = ends.end


def chords(c: IsoControl, ends: ArcEnds, centre: Point, turns: int) -> None:
    """Make an arc out of the principal planes or scaled differently along its axes, as straight lines within CHORD of it."""
    first, second, normal = PLANES[c.plane]
    text = (
        f"the coordinates are turned about another axis than the normal of the plane {c.plane}, or scaled differently along its "
        "axes; such arcs are not understood"
    )
    c.assume("arcs in a tilted plane", f"straight lines within {CHORD * 1000:g} um", text, matters=False)
    before = ends.start
    radius = math.hypot(before[first] - centre[first], before[second] - centre[second])
    last = math.hypot(ends.end[first] - centre[first], ends.end[second] - centre[second])
    begin = math.atan2(before[second] - centre[second], before[first] - centre[first])
    sweep = _sweep(ends, centre, PLANES[c.plane], turns) * (-1.0 if ends.clockwise else 1.0)
    step = 2.0 * math.acos(max(0.0, 1.0 - CHORD / max(radius, last)))
    count = max(1, math.ceil(abs(sweep) / step))
    for k in range(1, count):
        share, point = k / count, list(ends.end)
        r, angle = radius + (last - radius) * share, begin + sweep * share
        point[first], point[second] = (
            centre[first] + r * math.cos(angle),
            centre[second] + r * math.sin(angle),
        )
        point[normal] = before[normal] + (ends.end[normal] - before[normal]) * share
        c.straight((point[0], point[1], point[2]), False)
    c.straight(ends.end, False)


def _turns(c: IsoControl, w: IsoWords) -> int:
    if c.language.words != "o":
        return 1
    turns = w.whole("P", 1, 1)
    if turns is not None and turns > MOST_TURNS:
        raise BlockFault(w.column("P"), f"an arc of {turns} turns; {MOST_TURNS} are the most, correct P")
    return 1 if turns is None else turns


def _centre_of_words(c: IsoControl, w: IsoWords, ends: ArcEnds) -> list[float]:
    """Return the centre from I J K; checks the radii."""
    first, second, normal = PLANES[c.plane]
    if w.has(CENTRE_WORDS[normal]) and w.values[CENTRE_WORDS[normal]] and c.language.words == "o":
        raise BlockFault(
            w.column(CENTRE_WORDS[normal]),
            f"{CENTRE_WORDS[normal]} is no centre word of the plane {c.plane}; choose the plane with G17, G18 or G19, or remove it",
        )
    numbers = [w.take(k) for k in CENTRE_WORDS]
    if numbers[first] is None and numbers[second] is None:
        c.fault(
            f"the arc has neither R nor a centre ({CENTRE_WORDS[first]} {CENTRE_WORDS[second]} in the plane {c.plane}); add one",
        )
    if c.arc_absolute and (numbers[first] is None or numbers[second] is None) and c.language.words == "o":
        c.fault("with absolute centres (G90.1) both centre words of the plane are required; add the other")
    centre = _centre(c, w, ends, numbers, c.arc_absolute)
    if c.language.survey and not c.arcs_seen and not c.arc_absolute and _misfit(c, ends, centre):
        other = _centre(c, w, ends, numbers, True)
        if not _misfit(c, ends, other):
            value, entry = (
                "from the work zero: they fit no relative centre",
                SetupEntry("", "arc_centre", '"absolute"'),
            )
            c.assume("how I J K count", value, blank=entry, column=c.column)
            c.arc_absolute, centre = True, other
    _check_radii(c, ends, centre)
    return centre


def _centre(
    c: IsoControl, w: IsoWords, ends: ArcEnds, numbers: list[float | None], absolute: bool
) -> list[float]:
    """Return the centre, its words counted from the work zero (absolute) or from the start."""
    centre = list(ends.start)
    for i in PLANES[c.plane][:2]:
        number = numbers[i]
        if number is None:
            continue
        value = length(c, w, CENTRE_WORDS[i], number)
        if not absolute:
            centre[i] = ends.start[i] + value
        else:
            centre[i] = value / 2.0 if i == 0 and c.diametral() and c.language.words == "o" else value
    return centre


def _radii(c: IsoControl, ends: ArcEnds, centre: list[float]) -> tuple[float, float]:
    first, second, _ = PLANES[c.plane]
    before, p, _, _ = ends
    return (
        math.hypot(before[first] - centre[first], before[second] - centre[second]),
        math.hypot(p[first] - centre[first], p[second] - centre[second]),
    )


def _misfit(c: IsoControl, ends: ArcEnds, centre: list[float]) -> bool:
    """Return whether the radii at start and end differ by more than a control takes."""
    r1, r2 = _radii(c, ends, centre)
    never, step, share = arc_limits(c)
    off = abs(r1 - r2)
    return min(r1, r2) < NO_LENGTH_MM or off > never or (off > step and off > share * max(r1, r2))


def _check_radii(c: IsoControl, ends: ArcEnds, centre: list[float]) -> None:
    first, second, _ = PLANES[c.plane]
    r1, r2 = _radii(c, ends, centre)
    if r1 < NO_LENGTH_MM or r2 < NO_LENGTH_MM:
        where = "start" if r1 < NO_LENGTH_MM else "end"
        c.fault(f"the centre of the arc lies on its {where} point: an arc of radius zero; check I J K")
    never, step, _ = arc_limits(c)
    off = abs(r1 - r2)
    if _misfit(c, ends, centre):
        hint = ""
        absolute = [centre[i] - (ends.start[i] if i in (first, second) else 0.0) for i in range(3)]
        if not c.arc_absolute and not _misfit(c, ends, absolute):
            hint = '; the words fit an absolute centre: write arc_centre = "absolute" in the set-up file'
        c.fault(
            f"the arc does not fit: radius {r1:.4f} mm at its start, {r2:.4f} mm at its end ({off * 1000:.1f} um apart; "
            f"allowed are {step * 1000:.1f} um, or 0.1 % up to {never:.2f} mm); correct the end point or the centre{hint}",
        )
    if off > SAME_RADIUS:
        text = (
            f"the radii of the arc at its start and end differ by {off * 1000:.1f} um ({r1:.4f} and {r2:.4f} mm); "
            "the end point is kept, the radius changes evenly on the way"
        )
        c.misfits.append(ArcMisfit("radii", c.line, c.column, off * 1000, text))


def _centre_of_radius(c: IsoControl, ends: ArcEnds, radius: float, column: int) -> list[float]:
    """Return the centre of an arc given by R: positive up to half a turn, negative beyond."""
    first, second, _ = PLANES[c.plane]
    before, p, clockwise, named = ends
    dx, dy = p[first] - before[first], p[second] - before[second]
    chord = math.hypot(dx, dy)
    if chord < NO_LENGTH_MM or not named:
        what = "an arc given by R must end elsewhere than it starts; give a full circle by I J K"
        if c.language.words == "macro" and not c.language.haas and not chord:
            what = "an arc given by R that ends where it starts is one of 0 degrees on a FANUC, which does not move; give a full circle by I J K, or remove the block"
        raise BlockFault(column, what)
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
        short = 1000 * (half - abs(radius))
        text = f"R is {short:.2f} um smaller than half the distance; a half circle is taken"
        c.misfits.append(ArcMisfit("R", c.line, column, short, text))
    height = math.sqrt(max(radius * radius - half * half, 0.0))
    side = (1.0 if clockwise else -1.0) * (1.0 if radius > 0 else -1.0)
    centre = list(before)
    centre[first] += dx / 2.0 + side * height * dy / chord
    centre[second] += dy / 2.0 - side * height * dx / chord
    return centre


def _arc_length(ends: ArcEnds, centre: Point, plane: tuple[int, int, int], turns: int) -> float:
    """Return the length of the path, mm; equal end points mean a whole turn."""
    first, second, normal = plane
    radius = math.hypot(ends.start[first] - centre[first], ends.start[second] - centre[second])
    return math.hypot(radius * _sweep(ends, centre, plane, turns), ends.end[normal] - ends.start[normal])


def _sweep(ends: ArcEnds, centre: Point, plane: tuple[int, int, int], turns: int) -> float:
    """Return the angle swept, rad, positive."""
    first, second, _ = plane
    before, p, clockwise, _ = ends
    a = math.atan2(before[second] - centre[second], before[first] - centre[first])
    b = math.atan2(p[second] - centre[second], p[first] - centre[first])
    sweep = (a - b if clockwise else b - a) % (2.0 * math.pi)
    return sweep + 2.0 * math.pi * (turns - (sweep >= FULL_CIRCLE))


def thread(c: IsoControl, w: IsoWords, lead: float) -> None:
    """Cut a thread, G33 (G32): a line with `lead` mm per turn of the spindle; the feed along the path follows from the speed."""
    p, rotary = target(c, w)
    thread_to(c, p, lead, rotary)


def thread_to(c: IsoControl, p: Point, lead: float, rotary: Point | None = None) -> None:
    """Cut a thread to a programmed point."""
    start, end = c.tip(), c.world.apply(p)
    turns = c.feeding((start[0] + end[0]) / 2.0 - c.world.shift[0])
    if not turns or not c.sense:
        c.fault("threads need a turning spindle; add S and M3 or M4 before this block")
    if lead <= 0:
        c.fault("the lead of a thread must be positive; correct it")
    c.emit("thread", end, rotary=rotary, feed=lead * turns)
    c.p = p
