"""Polar interpolation (G12.1, G112) and cylindrical interpolation (G7.1, G107): a plane wound onto a turning axis.

Source: FANUC B-64304EN-1, "polar coordinate interpolation", "cylindrical interpolation"; Haas operator's manuals, G107, G112.

Polar: X and C (Haas: X and Y, both radii) are rectangular coordinates over the end face about the turning axis. The moves are those
of the tip over the workpiece (`Move.is_tip_led`), and C turns so that the tool stays in the plane of X: C = atan2(y, x).
Cylindrical: the plane of a linear axis and the developed surface s = R C. Straight lines stay straight; arcs are wound as chords.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from vcmm.program.facing import EndFace, face_begins, face_ends
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl
from vcmm.program.iso.lengths import length, rotary_target
from vcmm.program.moves import PLANES, Point

ROTARY = "ABC"
CHORD = 0.001  # mm, between an arc of the developed surface and its chords


@dataclass(frozen=True, slots=True)
class Winding:
    """State of the winding. radius: of the cylinder, mm; 0: polar. linear: the axis whose words are arcs of the cylinder (Haas), else -1.

    axis: index of the rotary axis. modes_before: plane, diameter before. face: of polar interpolation.
    """

    radius: float
    axis: int
    linear: int
    modes_before: tuple[str, str]
    face: EndFace | None = None


def wind(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Switch winding: G12.1 G112 on, G13.1 G113 off, G7.1 and G107 with a radius on, with zero or none off."""
    c.free(f"{code} changes what the axes mean")
    if code in ("G13.1", "G113"):
        unwind(c)
    elif code in ("G12.1", "G112"):
        if c.winding is None:
            kept = (c.plane, c.diameter)
            c.winding = Winding(0.0, 2, -1, kept, face_begins(c))
            c.plane, c.wound_from = "XY", c.winding.face
            c.diameter = "" if c.language.haas else c.diameter  # Haas: X and Y are radii
    else:
        _cylinder(c, w, column)


def unwind(c: IsoControl) -> None:
    """Return to the axes themselves; behind polar interpolation C keeps its angle."""
    on, c.winding = c.winding, None
    if on is None:
        return
    c.plane, c.diameter = on.modes_before
    if on.face is not None:
        face_ends(c, on.face)


def _cylinder(c: IsoControl, w: IsoWords, column: int) -> None:
    """Read G7.1 C30.: the radius is behind the rotary axis. Haas: G107 A0 Y0 R30. or Q60., G107 alone ends it."""
    named = next((k for k, axis in enumerate(ROTARY) if w.has(axis)), None)
    if c.language.haas:
        radius = (
            abs(length(c, w, "R", w.take("R") or 0.0)) or abs(length(c, w, "Q", w.take("Q") or 0.0)) / 2.0
        )
        linear = next((i for i, axis in enumerate(AXES) if w.has(axis)), 1)
        w.used |= set("XYZABC")
    else:
        linear = -1
        radius = 0.0 if named is None else abs(length(c, w, ROTARY[named], w.take(ROTARY[named]) or 0.0))
    unwind(c)
    if radius:
        if named is None:
            raise BlockFault(column, "cylindrical interpolation needs the rotary axis, as in G7.1 C30.")
        c.winding = Winding(radius, named, linear, (c.plane, c.diameter))


def wound_target(c: IsoControl, w: IsoWords, p: list[float]) -> tuple[Point, Point]:
    """End point and rotary position of a block whose linear words are in p."""
    on = c.winding
    if on is None:
        return (p[0], p[1], p[2]), rotary_target(c, w)
    if not on.radius:
        number = w.take("C")
        if number is not None:
            p[1] = length(c, w, "C", number) + (0.0 if c.absolute else p[1])
        return (p[0], p[1], p[2]), c.rotary
    angles = list(rotary_target(c, w))
    if on.linear >= 0:
        here = angles[on.axis] * on.radius
        way = p[on.linear] if c.absolute else here + p[on.linear] - c.p[on.linear]
        angles[on.axis], p[on.linear] = way / on.radius, c.p[on.linear]
    return (p[0], p[1], p[2]), (angles[0], angles[1], angles[2])


def surface_feed(c: IsoControl, on: Winding, p: Point, rotary: Point) -> float | None:
    """Return the feed that takes as long as F along the developed surface: mm/min, deg/min where rotary axes alone move."""
    way = math.dist(p, c.p)
    arc = on.radius * abs(rotary[on.axis] - c.rotary[on.axis])
    whole = math.hypot(way, arc)
    feed = c.rate(whole, c.feeding(c.p[0]))
    if feed is None or not whole:
        return feed
    return feed * (way if way else math.degrees(arc / on.radius)) / whole


def flat(c: IsoControl, p: Point, rotary: Point) -> list[float]:
    """Return a point with the developed surface in place of the axis of its plane that is wound."""
    on, out = c.winding, list(p)
    assert on is not None
    out[_across(c)] = on.radius * rotary[on.axis]
    return out


def _across(c: IsoControl) -> int:
    """Return the axis of the plane that is wound: the linear one of Haas, of Fanuc the one beside the axis of the cylinder (Z, X)."""
    on = c.winding
    assert on is not None
    first, second, _ = PLANES[c.plane]
    if on.linear >= 0:
        return on.linear
    along = 2 if on.axis == 2 else on.axis
    return second if first == along else first


def wound_arc(
    c: IsoControl, start: list[float], end: list[float], centre: list[float], clockwise: bool
) -> None:
    """Make an arc of the developed surface as chords of it; start, end and centre as `flat` gives them."""
    on, (first, second, _) = c.winding, PLANES[c.plane]
    assert on is not None
    r0, r1 = (math.hypot(q[first] - centre[first], q[second] - centre[second]) for q in (start, end))
    begin, last = (math.atan2(q[second] - centre[second], q[first] - centre[first]) for q in (start, end))
    sweep = (begin - last if clockwise else last - begin) % (2.0 * math.pi) or 2.0 * math.pi
    count = max(1, math.ceil(sweep / (2.0 * math.acos(max(0.0, 1.0 - CHORD / max(r0, r1))))))
    across = _across(c)
    for k in range(1, count + 1):
        share = k / count
        angle = begin + sweep * share * (-1.0 if clockwise else 1.0)
        radius = r0 + (r1 - r0) * share
        q = [s + (e - s) * share for s, e in zip(start, end)]
        if k < count:
            q[first], q[second] = (
                centre[first] + radius * math.cos(angle),
                centre[second] + radius * math.sin(angle),
            )
        rotary = list(c.rotary)
        rotary[on.axis] = q[across] / on.radius
        q[across] = c.p[across]
        wound_line(c, (q[0], q[1], q[2]), False, (rotary[0], rotary[1], rotary[2]))


def wound_line(c: IsoControl, p: Point, rapid: bool, rotary: Point) -> None:
    """Make a straight line of the developed surface."""
    on = c.winding
    assert on is not None
    feed = None if rapid else surface_feed(c, on, p, rotary)
    c.emit("rapid" if rapid else "line", c.world.apply(p), rotary=rotary, feed=feed)
    c.p = p
