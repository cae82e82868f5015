"""Offset curves in a plane: pieces (line, arc) of moves, their parallel curves, and the joint of two parallel curves at a corner.

Offsets are signed, h > 0 to the left of the direction of travel. The parallel curve of a line lies at h along its left
normal; that of an arc is the arc about the same centre with radius R - h (counterclockwise) or R + h (clockwise).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vcmm.program.moves import PLANES, Move, Point

Vec = tuple[float, float]
# mm: how near to both parallel curves the middle of a corner must be that is one by rounding alone
CORNER_TOLERANCE = 1e-5
MEETING_REACH_WIDTHS = 10.0  # times the width of such a corner: a meeting further away is none
NO_MOTION_MM = 1e-12  # mm: shorter is no motion in the plane
JOINED_CORNER_MM = 1e-10  # mm: corners whose rounding would be smaller than this are joined in one point


class ContourPiece(NamedTuple):
    """A programmed line (centre None) or arc in the plane; sweep in rad, positive counterclockwise, 0 for a line."""

    start: Vec
    end: Vec
    centre: Vec | None = None
    sweep: float = 0.0


class Joint(NamedTuple):
    """Joint of one parallel curve with the next: the first ends at `end`, `via` are corners of extra lines, or an arc about `pivot`."""

    end: Vec
    start: Vec
    via: tuple[Vec, ...] = ()
    pivot: Vec | None = None
    turn: float = 0.0  # change of direction at the corner, rad, positive to the left


class NoMeeting(Exception):
    """The parallel curves of an inside corner do not meet: the tool cannot reach it."""


def minus(a: Vec, b: Vec) -> Vec:
    return a[0] - b[0], a[1] - b[1]


def moved_along(a: Vec, direction: Vec, by: float) -> Vec:
    return a[0] + by * direction[0], a[1] + by * direction[1]


def left_normal(a: Vec) -> Vec:
    return -a[1], a[0]


def dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Vec, b: Vec) -> float:
    return a[0] * b[1] - a[1] * b[0]


def unit(a: Vec) -> Vec:
    length = math.hypot(*a)
    return a[0] / length, a[1] / length


def tangent(piece: ContourPiece, at: Vec) -> Vec:
    """Return the unit direction of travel at the start or the end of a piece."""
    if piece.centre is None:
        return unit(minus(piece.end, piece.start))
    return (
        left_normal(unit(minus(at, piece.centre)))
        if piece.sweep > 0
        else left_normal(unit(minus(piece.centre, at)))
    )


def parallel_point(piece: ContourPiece, at: Vec, h: float) -> Vec:
    """Return the point of the parallel curve that belongs to the start or end `at`."""
    return moved_along(at, left_normal(tangent(piece, at)), h)


def parallel_radius(piece: ContourPiece, h: float) -> float:
    """Return the radius of the parallel curve of an arc; zero or below: the tool is too big for the arc."""
    assert piece.centre is not None
    return math.dist(piece.start, piece.centre) - math.copysign(h, h * piece.sweep)


def turn_between(a: ContourPiece, b: ContourPiece) -> float:
    """Change of direction at the corner, rad in (-pi, pi], positive to the left."""
    before, after = tangent(a, a.end), tangent(b, b.start)
    return math.atan2(cross(before, after), dot(before, after))


def corner(a: ContourPiece, b: ContourPiece, h: float, rounding: str) -> Joint:
    """Return the joint of the parallel curves of a and b, which follow one another in a.end.

    rounding of outside corners: "arc" about the programmed corner, or "lines" along the tangents (the intersection up to
    a change of direction of 90 deg, beyond it one line across, h beyond each perpendicular).
    """
    turn = turn_between(a, b)
    ends = parallel_point(a, a.end, h), parallel_point(b, b.start, h)
    if _smooth(a, b, h, turn):
        middle = 0.5 * (ends[0][0] + ends[1][0]), 0.5 * (ends[0][1] + ends[1][1])
        return Joint(middle, middle, turn=turn)
    if is_inside(a, b, h):
        point = _inside_point(a, b, h, turn)
        return Joint(point, point, turn=turn)
    if rounding == "arc":
        return Joint(ends[0], ends[1], pivot=a.end, turn=turn)
    return _square_corner(a, b, h, ends, turn)


def _inside_point(a: ContourPiece, b: ContourPiece, h: float, turn: float) -> Vec:
    """Return the meeting point of the parallel curves. Tangents that differ by rounding alone need not meet at all, or meet far away, where one
    piece is an arc: then the point between their ends serves, which is within ROUNDED of both."""
    first, second = parallel_point(a, a.end, h), parallel_point(b, b.start, h)
    middle = 0.5 * (first[0] + second[0]), 0.5 * (first[1] + second[1])
    rounded = _beside_both(a, b, h, turn) < CORNER_TOLERANCE
    try:
        point = _meeting(a, b, h)
    except NoMeeting:
        if rounded:
            return middle
        raise
    return middle if rounded and math.dist(point, middle) > MEETING_REACH_WIDTHS * abs(h * turn) else point


def is_inside(a: ContourPiece, b: ContourPiece, h: float) -> bool:
    """Return True for an inside corner. Where the path turns straight back the curvatures decide on which side it closes."""
    turn = turn_between(a, b)
    if math.pi - abs(turn) > 1e-9:
        return turn * h > 0
    return (_curvature(a) + _curvature(b)) * h < -1e-12


def _curvature(piece: ContourPiece) -> float:
    return (
        0.0 if piece.centre is None else math.copysign(1 / math.dist(piece.start, piece.centre), piece.sweep)
    )


def _smooth(a: ContourPiece, b: ContourPiece, h: float, turn: float) -> bool:
    """Return True where one shared point is within JOINED_CORNER_MM of both parallel curves, so that neither arc nor cut is needed.

    The middle of two points |h turn| apart lies h turn^2 / 8 inside the rounding and (h turn / 2)^2 / (2 R) off a
    parallel arc of radius R.
    """
    return _beside_both(a, b, h, turn) < JOINED_CORNER_MM


def _beside_both(a: ContourPiece, b: ContourPiece, h: float, turn: float) -> float:
    radii = [parallel_radius(p, h) for p in (a, b) if p.centre is not None]
    return abs(h) * turn**2 / 8 + sum((h * turn) ** 2 / (8 * max(radius, 1e-12)) for radius in radii)


def _square_corner(a: ContourPiece, b: ContourPiece, h: float, ends: tuple[Vec, Vec], turn: float) -> Joint:
    before, after = tangent(a, a.end), tangent(b, b.start)
    if abs(turn) <= math.pi / 2 + 1e-12:
        reach = abs(h) * math.tan(abs(turn) / 2)
        via: tuple[Vec, ...] = (moved_along(ends[0], before, reach),)
    else:
        via = (moved_along(ends[0], before, abs(h)), moved_along(ends[1], after, -abs(h)))
    end, start = ends
    if a.centre is None:  # a line simply runs on to the first corner
        end, via = via[0], via[1:]
    if b.centre is None:
        if via:
            start, via = via[-1], via[:-1]
        else:
            start = end
    return Joint(end, start, via, turn=turn)


def _meeting(a: ContourPiece, b: ContourPiece, h: float) -> Vec:
    """Return the intersection of the parallel curves nearest to the programmed corner."""
    if a.centre is None and b.centre is None:
        n, m = left_normal(tangent(a, a.end)), left_normal(tangent(b, b.start))
        scale = h / (1 + dot(n, m))
        return a.end[0] + scale * (n[0] + m[0]), a.end[1] + scale * (n[1] + m[1])
    if a.centre is None:
        crossings = _line_circle(a, b, h)
    elif b.centre is None:
        crossings = _line_circle(b, a, h)
    else:
        crossings = _circle_circle(a, b, h)
    if not crossings:
        raise NoMeeting
    return min(crossings, key=lambda p: math.dist(p, a.end))


def _line_circle(line: ContourPiece, arc: ContourPiece, h: float) -> list[Vec]:
    assert arc.centre is not None
    direction = tangent(line, line.start)
    foot = moved_along(line.start, left_normal(direction), h)
    middle = moved_along(foot, direction, dot(minus(arc.centre, foot), direction))
    left_over = parallel_radius(arc, h) ** 2 - math.dist(middle, arc.centre) ** 2
    if left_over < 0:
        return []
    half = math.sqrt(left_over)
    return [moved_along(middle, direction, half), moved_along(middle, direction, -half)]


def _circle_circle(a: ContourPiece, b: ContourPiece, h: float) -> list[Vec]:
    assert a.centre is not None
    assert b.centre is not None
    apart = math.dist(a.centre, b.centre)
    r, s = parallel_radius(a, h), parallel_radius(b, h)
    if apart < 1e-12:
        return []
    reach = (apart**2 + r**2 - s**2) / (2 * apart)
    left_over = r**2 - reach**2
    if left_over < 0:
        return []
    direction = unit(minus(b.centre, a.centre))
    foot, half = moved_along(a.centre, direction, reach), math.sqrt(left_over)
    return [moved_along(foot, left_normal(direction), half), moved_along(foot, left_normal(direction), -half)]


def trimmed_sweep(piece: ContourPiece, start: Vec, end: Vec) -> float:
    """Return the signed sweep of the parallel arc between its joints; of the opposite sign or zero where nothing remains of it."""
    assert piece.centre is not None
    sign = math.copysign(1.0, piece.sweep)
    lost = sign * _angle(piece.centre, piece.start, start) % (2 * math.pi)
    spared = sign * _angle(piece.centre, end, piece.end) % (2 * math.pi)
    lost, spared = (0.0 if 2 * math.pi - x < 1e-3 else x for x in (lost, spared))
    return piece.sweep - sign * (lost + spared)


def _angle(centre: Vec, start: Vec, end: Vec) -> float:
    """Return the angle from start to end about the centre, rad in (-pi, pi]."""
    a, b = minus(start, centre), minus(end, centre)
    return math.atan2(cross(a, b), dot(a, b))


def sweep_of(start: Vec, end: Vec, centre: Vec, clockwise: bool, turns: int) -> float:
    """Return the signed sweep of an arc; start and end within 1e-9 mm of one another are a full circle."""
    sign = -1.0 if clockwise else 1.0
    angle = sign * _angle(centre, start, end) % (2 * math.pi)
    if math.dist(start, end) < 1e-9 or angle == 0.0:
        angle = 2 * math.pi
    return sign * (angle + 2 * math.pi * (turns - 1))


# -- moves and pieces ---------------------------------------------------------------------------------------------------
def planar(move: Move) -> bool:
    """Return True for a move with motion in its plane."""
    first, second, _ = PLANES[move.plane]
    moved = (
        math.hypot(move.end[first] - move.start[first], move.end[second] - move.start[second]) > NO_MOTION_MM
    )
    return move.kind == "arc" or (move.kind != "dwell" and moved)


def piece_of(move: Move) -> ContourPiece:
    """Return a move as a piece of its plane."""
    first, second, _ = PLANES[move.plane]
    start, end = (move.start[first], move.start[second]), (move.end[first], move.end[second])
    if move.centre is None:
        return ContourPiece(start, end)
    centre = (move.centre[first], move.centre[second])
    return ContourPiece(start, end, centre, sweep_of(start, end, centre, bool(move.clockwise), move.turns))


def in_space(plane: str, point: Vec, height: float) -> Point:
    """Return a point of the plane at a height along its normal."""
    first, second, normal = PLANES[plane]
    out = [0.0, 0.0, 0.0]
    out[first], out[second], out[normal] = point[0], point[1], height
    return out[0], out[1], out[2]
