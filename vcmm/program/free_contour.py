"""A contour whose elements are each determined only in part: all contours that fit, found by geometry.

Every unknown (a line or circle, a point between two elements) is computed as soon as the known data determine it to a few
candidates, and each of them is followed. All solutions of each such step are kept, so that the remaining ones at the end are all solutions. Values that no step
determines stay unknown, and are reported. Lengths in mm, angles in rad. Source of the words: see vcmm.program.heidenhain.free.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from vcmm.program.offsetting import Vec
from vcmm.program.tangents import Carrier, DirectedCircle, DirectedLine, meeting, touch_point

AGREE = 0.01  # mm and rad within which data that say a thing twice must agree, as the ends of an arc (recorder.ARC_TOLERANCE_MM)
MOST_CONTOURS = 64  # contours that fit: no more are looked for


class Coordinate(NamedTuple):
    """A value, counted from joint `joint` (the end of element joint - 1), or from zero."""

    value: float
    joint: int | None = None


class Reference(NamedTuple):
    """A direction counted from another: that of the element `element` where it is a line, `ends`: at its end."""

    element: int
    ends: bool = False


@dataclass(frozen=True)
class FreeElement:
    """Data of a block on a line or an arc. turn: centre angle; length: of a line, chord of an arc; closes: + or - of CLSD."""

    arc: bool
    tangential: bool
    clockwise: bool | None = None
    x: Coordinate | None = None
    y: Coordinate | None = None
    pole: Vec = (0.0, 0.0)
    pr: Coordinate | None = None
    pa: Coordinate | None = None
    angle: float | None = None
    angle_from: Reference | None = None
    length: float | None = None
    turn: float | None = None
    radius: float | None = None
    cx: Coordinate | None = None
    cy: Coordinate | None = None
    cpr: Coordinate | None = None
    cpa: Coordinate | None = None
    through: tuple[Vec, ...] = ()
    beside: tuple[Vec, float] | None = None
    parallel: Reference | DirectedLine | None = None
    apart: float | None = None
    closes: str = ""

    @property
    def is_full(self) -> bool:
        """Whether its end may be its start: where the block gives the end."""
        point = (self.x and self.y) or (self.pr and self.pa)
        return (
            bool(point) or bool(self.closes) or (self.turn is not None and self.turn > 2.0 * math.pi - 1e-9)
        )


@dataclass
class FreeContour:
    """Elements, what is known of them, and the direction in which the tool came."""

    elements: Sequence[FreeElement]
    joints: list[Vec | None]
    carriers: list[Carrier | None]
    before: float | None = None

    # -- what is known --
    def coordinate(self, c: Coordinate | None, axis: int) -> float | None:
        if c is None:
            return None
        if c.joint is None:
            return c.value
        point = self.joints[c.joint]
        return None if point is None else c.value + point[axis]

    def polar(self, c: Coordinate | None, pole: Vec, angular: bool) -> float | None:
        """Return the radius or angle about the pole."""
        if c is None or c.joint is None:
            return None if c is None else c.value
        point = self.joints[c.joint]
        if point is None:
            return None
        a, b = point[0] - pole[0], point[1] - pole[1]
        return c.value + (math.atan2(b, a) if angular else math.hypot(a, b))

    def end_tangent(self, i: int) -> float | None:
        """Return the direction at the end of element i; of what went before for i = -1."""
        if i < 0:
            return self.before
        return self.tangent(i, i + 1)

    def tangent(self, i: int, joint: int) -> float | None:
        """Return the direction of element i at a joint."""
        carrier, point = self.carriers[i], self.joints[joint]
        if isinstance(carrier, DirectedLine):
            return carrier.angle
        return None if carrier is None or point is None else carrier.tangent_at(point)

    def entry(self, i: int) -> float | None:
        """Return the direction that its block gives it at its start: AN, IAN, RAN."""
        e = self.elements[i]
        if e.angle is None or e.angle_from is None:
            return e.angle
        other = e.angle_from
        base = self.end_tangent(other.element) if other.ends else self.tangent(other.element, other.element)
        return None if base is None else base + e.angle

    def parallel_to(self, i: int) -> DirectedLine | None:
        other = self.elements[i].parallel
        line = self.carriers[other.element] if isinstance(other, Reference) else other
        return line if isinstance(line, DirectedLine) else None

    # -- points between elements --
    def loci(self, j: int) -> list[Carrier]:
        """Return the lines and circles on which joint j lies."""
        out: list[Carrier] = []
        if j > 0:
            e, start = self.elements[j - 1], self.joints[j - 1]
            x, y = self.coordinate(e.x, 0), self.coordinate(e.y, 1)
            out += [] if x is None else [DirectedLine(math.pi / 2.0, -x)]
            out += [] if y is None else [DirectedLine(0.0, y)]
            pr, pa = self.polar(e.pr, e.pole, False), self.polar(e.pa, e.pole, True)
            out += [] if pr is None else [DirectedCircle(e.pole, abs(pr))]
            out += [] if pa is None else [_through(e.pole, pa)]
            if e.length is not None and start is not None:
                out.append(DirectedCircle(start, e.length))
            out += [c for c in (self.carriers[j - 1],) if c is not None]
        if j < len(self.elements):
            e, end = self.elements[j], self.joints[j + 1]
            if e.length is not None and end is not None:
                out.append(DirectedCircle(end, e.length))
            out += [c for c in (self.carriers[j],) if c is not None]
        return out

    def points(self, j: int) -> list[Vec] | None:
        """Return the possible places of joint j; None where they are not determined."""
        point = self.exact(j)
        loci = self.loci(j)
        if point is not None:
            return [point]
        for k, a in enumerate(loci):
            for b in loci[k + 1 :]:
                where = meeting(a, b)
                if where is not None:
                    return [p for p in where if all(_distance(c, p) < AGREE for c in loci)]
        return None

    def exact(self, j: int) -> Vec | None:
        """Return the joint j where it closes the contour, follows from a centre angle or is where two elements touch."""
        for k, e in enumerate(self.elements):
            if e.closes == "-":
                begin = max((i for i in range(k + 1) if self.elements[i].closes == "+"), default=0)
                pair = {begin, k + 1}
                point = next((p for p in (self.joints[i] for i in pair) if p is not None), None)
                if j in pair and point is not None:
                    return point
        for i, sense in ((j - 1, 1.0), (j, -1.0)):
            if 0 <= i < len(self.elements) and (turn := self.elements[i].turn) is not None:
                c, p = self.carriers[i], self.joints[i if sense > 0 else i + 1]
                if isinstance(c, DirectedCircle) and p is not None:
                    return _rotate(p, c, sense * turn)
        if 0 < j < len(self.elements) and self.elements[j].tangential:
            a, b = self.carriers[j - 1], self.carriers[j]
            return None if a is None or b is None else touch_point(a, b)
        return None

    # -- whether all fits --
    def fits(self, i: int) -> bool:
        """Return whether element i, where it is known wholly, obeys every word of its block."""
        carrier, start, end, e = self.carriers[i], self.joints[i], self.joints[i + 1], self.elements[i]
        if carrier is None or start is None or end is None:
            return True
        if max(_distance(carrier, start), _distance(carrier, end)) > AGREE or not self._reaches(i, end):
            return False
        entry = self.entry(i)
        begin = carrier.angle if isinstance(carrier, DirectedLine) else carrier.tangent_at(start)
        came = self.end_tangent(i - 1) if e.tangential else None
        if any(
            a is not None and abs(math.remainder(a - begin, 2.0 * math.pi)) > AGREE for a in (entry, came)
        ):
            return False
        if e.length is not None and abs(math.dist(start, end) - e.length) > AGREE:
            return False
        if e.beside is not None and abs(_distance(carrier, e.beside[0]) - e.beside[1]) > AGREE:
            return False
        if any(_distance(carrier, p) > AGREE for p in e.through):
            return False
        if isinstance(carrier, DirectedLine):
            u = carrier.direction
            if not self._is_parallel(i, carrier, start):
                return False
            return (end[0] - start[0]) * u[0] + (end[1] - start[1]) * u[1] > 1e-6
        return self._arc_fits(i, carrier, start, end)

    def _reaches(self, i: int, end: Vec) -> bool:
        """Return whether the end point is the one that the block gives."""
        e = self.elements[i]
        x, y = self.coordinate(e.x, 0), self.coordinate(e.y, 1)
        if any(v is not None and abs(v - p) > AGREE for v, p in ((x, end[0]), (y, end[1]))):
            return False
        pr, pa = self.polar(e.pr, e.pole, False), self.polar(e.pa, e.pole, True)
        reach = math.dist(end, e.pole)
        if pr is not None and abs(abs(pr) - reach) > AGREE:
            return False
        turn = math.atan2(end[1] - e.pole[1], end[0] - e.pole[0])
        return pa is None or reach * abs(math.remainder(pa - turn, 2.0 * math.pi)) <= AGREE

    def _is_parallel(self, i: int, line: DirectedLine, start: Vec) -> bool:
        """Return whether a line lies beside the one that its block names, where that is known."""
        other, apart = self.parallel_to(i), self.elements[i].apart
        if other is None:
            return True
        if abs(math.sin(line.angle - other.angle)) > AGREE:
            return False
        return apart is None or abs(_distance(other, start) - apart) <= AGREE

    def _arc_fits(self, i: int, c: DirectedCircle, start: Vec, end: Vec) -> bool:
        e = self.elements[i]
        sweep = travel_angle(c, start, end, e.is_full)
        if sweep < 1e-9 or (e.radius is not None and abs(abs(c.rho) - e.radius) > AGREE):
            return False
        if e.turn is not None and abs(sweep - e.turn) * abs(c.rho) > AGREE:
            return False
        x, y = self.coordinate(e.cx, 0), self.coordinate(e.cy, 1)
        if any(v is not None and abs(v - p) > AGREE for v, p in ((x, c.centre[0]), (y, c.centre[1]))):
            return False
        cpr, cpa = self.polar(e.cpr, e.pole, False), self.polar(e.cpa, e.pole, True)
        if cpr is not None and abs(abs(cpr) - math.dist(c.centre, e.pole)) > AGREE:
            return False
        turn = math.atan2(c.centre[1] - e.pole[1], c.centre[0] - e.pole[0])
        if cpa is not None and abs(math.remainder(cpa - turn, 2.0 * math.pi)) > AGREE:
            return False
        spare = AGREE / abs(c.rho)
        return all(
            travel_angle(c, start, p, False) <= sweep + spare or math.dist(start, p) < AGREE
            for p in e.through
        )

    def length(self) -> float:
        """Return the length of the path, mm."""
        total = 0.0
        for i, c in enumerate(self.carriers):
            start, end = self.joints[i], self.joints[i + 1]
            if start is None or end is None:
                continue
            if isinstance(c, DirectedCircle):
                total += abs(c.rho) * travel_angle(c, start, end, self.elements[i].is_full)
            else:
                total += math.dist(start, end)
        return total


def travel_angle(c: DirectedCircle, start: Vec, end: Vec, full: bool) -> float:
    """Return the angle from one point to another in the sense of travel; a whole turn for one and the same where it may be `full`, else 0."""
    a = math.atan2(start[1] - c.centre[1], start[0] - c.centre[0])
    b = math.atan2(end[1] - c.centre[1], end[0] - c.centre[0])
    turn = math.fmod((b - a) * math.copysign(1.0, c.rho) + 4.0 * math.pi, 2.0 * math.pi)
    if min(turn, 2.0 * math.pi - turn) * abs(c.rho) < 1e-6:
        return 2.0 * math.pi if full else 0.0
    return turn


def _through(point: Vec, angle: float) -> DirectedLine:
    n = (-math.sin(angle), math.cos(angle))
    return DirectedLine(angle, n[0] * point[0] + n[1] * point[1])


def _rotate(point: Vec, c: DirectedCircle, turn: float) -> Vec:
    """Return a point carried round a circle in its sense."""
    turn = math.copysign(1.0, c.rho) * turn
    a, b = point[0] - c.centre[0], point[1] - c.centre[1]
    co, si = math.cos(turn), math.sin(turn)
    return c.centre[0] + a * co - b * si, c.centre[1] + a * si + b * co


def _distance(c: Carrier, p: Vec) -> float:
    """Return the distance of a point from a line or circle."""
    if isinstance(c, DirectedLine):
        n = c.normal
        return abs(n[0] * p[0] + n[1] * p[1] - c.offset)
    return abs(math.dist(p, c.centre) - abs(c.rho))
