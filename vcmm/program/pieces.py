"""Lines and arcs of a plane as pieces: their meeting points, distances of points, cutting one at points, joining them to loops. Lengths
mm, angles rad."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

from vcmm.program.offsetting import ContourPiece, Vec

SAME_POINT_MM = 1e-6  # mm: closer points are one
TURN = 2.0 * math.pi


def radius_of(p: ContourPiece) -> float:
    """Return the radius of an arc."""
    assert p.centre is not None
    return math.dist(p.start, p.centre)


def length_of(p: ContourPiece) -> float:
    return math.dist(p.start, p.end) if p.centre is None else radius_of(p) * abs(p.sweep)


def point_at(p: ContourPiece, share: float) -> Vec:
    """Return a point of a piece, `share` of its length from its start."""
    if p.centre is None:
        return p.start[0] + share * (p.end[0] - p.start[0]), p.start[1] + share * (p.end[1] - p.start[1])
    first = math.atan2(p.start[1] - p.centre[1], p.start[0] - p.centre[0])
    at, radius = first + share * p.sweep, radius_of(p)
    return p.centre[0] + radius * math.cos(at), p.centre[1] + radius * math.sin(at)


def share_at(p: ContourPiece, point: Vec) -> float:
    """Return the share of a piece at which a point of its line or circle lies; beyond 1 where it is not on it. Negative before a line."""
    if p.centre is None:
        d = (p.end[0] - p.start[0], p.end[1] - p.start[1])
        return ((point[0] - p.start[0]) * d[0] + (point[1] - p.start[1]) * d[1]) / (d[0] ** 2 + d[1] ** 2)
    first = math.atan2(p.start[1] - p.centre[1], p.start[0] - p.centre[0])
    turn = (math.atan2(point[1] - p.centre[1], point[0] - p.centre[0]) - first) * math.copysign(1.0, p.sweep)
    turn %= TURN
    if TURN - turn < SAME_POINT_MM / max(radius_of(p), SAME_POINT_MM) and abs(p.sweep) < TURN - 1e-9:
        turn = 0.0
    return turn / abs(p.sweep)


def distance(p: ContourPiece, point: Vec) -> float:
    """Return the distance of a point from a piece."""
    share = share_at(p, point) if p.centre is None or math.dist(point, p.centre) > 0.0 else 0.0
    if 0.0 <= share <= 1.0:
        if p.centre is not None:
            return abs(math.dist(point, p.centre) - radius_of(p))
        return math.dist(point, point_at(p, share))
    return min(math.dist(point, p.start), math.dist(point, p.end))


def normal_at(p: ContourPiece, share: float) -> Vec:
    """Return the unit normal on the left of the way of travel."""
    if p.centre is None:
        length = math.dist(p.start, p.end)
        return -(p.end[1] - p.start[1]) / length, (p.end[0] - p.start[0]) / length
    a, b = point_at(p, share)
    s = math.copysign(1.0, p.sweep) / radius_of(p)
    return (p.centre[0] - a) * s, (p.centre[1] - b) * s


def reverse_piece(p: ContourPiece) -> ContourPiece:
    """Return the same way back."""
    return ContourPiece(p.end, p.start, p.centre, -p.sweep)


def parallel(p: ContourPiece, off: float) -> ContourPiece | None:
    """Return the piece beside a piece, on its left; None where an arc has no radius left."""
    if p.centre is not None and (p.sweep > 0.0) and radius_of(p) <= off + SAME_POINT_MM:
        return None
    n, m = normal_at(p, 0.0), normal_at(p, 1.0)
    start = (p.start[0] + off * n[0], p.start[1] + off * n[1])
    return ContourPiece(start, (p.end[0] + off * m[0], p.end[1] + off * m[1]), p.centre, p.sweep)


def meetings(a: ContourPiece, b: ContourPiece) -> list[Vec]:
    """Return the points of both: crossings, and ends of one that lie on the other."""
    ends = [p for p in (b.start, b.end) if distance(a, p) < SAME_POINT_MM] + [
        p for p in (a.start, a.end) if distance(b, p) < SAME_POINT_MM
    ]
    return [
        p for p in _line_points(a, b) if distance(a, p) < SAME_POINT_MM and distance(b, p) < SAME_POINT_MM
    ] + ends


def _line_points(a: ContourPiece, b: ContourPiece) -> list[Vec]:
    """Return the crossing points of the lines or circles of two pieces."""
    if a.centre is not None and b.centre is not None:
        r, s, apart = radius_of(a), radius_of(b), math.dist(a.centre, b.centre)
        if apart < SAME_POINT_MM:
            return []
        x = (apart * apart + r * r - s * s) / (2.0 * apart)
        u = ((b.centre[0] - a.centre[0]) / apart, (b.centre[1] - a.centre[1]) / apart)
        return _on_chord((a.centre[0] + x * u[0], a.centre[1] + x * u[1]), (-u[1], u[0]), r * r - x * x)
    line, other = (a, b) if a.centre is None else (b, a)
    n = normal_at(line, 0.0)
    t = (n[1], -n[0])
    if other.centre is None:
        d = (other.end[0] - other.start[0], other.end[1] - other.start[1])
        across = n[0] * d[0] + n[1] * d[1]
        if abs(across) < 1e-12 * (1.0 + math.hypot(*d)):
            return []
        share = (n[0] * (line.start[0] - other.start[0]) + n[1] * (line.start[1] - other.start[1])) / across
        return [point_at(other, share)]
    beside = n[0] * (line.start[0] - other.centre[0]) + n[1] * (line.start[1] - other.centre[1])
    foot = (other.centre[0] + beside * n[0], other.centre[1] + beside * n[1])
    return _on_chord(foot, t, radius_of(other) ** 2 - beside * beside)


def _on_chord(foot: Vec, along: Vec, square: float) -> list[Vec]:
    if square < -SAME_POINT_MM:
        return []
    half = math.sqrt(max(square, 0.0))
    return [(foot[0] + s * half * along[0], foot[1] + s * half * along[1]) for s in (1.0, -1.0)]


def cut(p: ContourPiece, points: Iterable[Vec]) -> Iterator[ContourPiece]:
    """Yield a piece cut at points of it; parts shorter than SAME_POINT_MM are left out."""
    length = length_of(p)
    inner = sorted(
        {s for s in (share_at(p, q) for q in points) if SAME_POINT_MM < s * length < length - SAME_POINT_MM}
    )
    shares = [0.0, *inner, 1.0]
    for begin, end in pairwise(shares):
        if (end - begin) * length > SAME_POINT_MM:
            yield ContourPiece(
                point_at(p, begin),
                point_at(p, end) if end < 1.0 else p.end,
                p.centre,
                p.sweep * (end - begin),
            )


def cut_all(pieces: Sequence[ContourPiece]) -> list[ContourPiece]:
    """Return all pieces cut where they meet; of parts that are one and the same the first."""
    out: list[ContourPiece] = []
    middles: list[Vec] = []
    boxes = [_box(p) for p in pieces]
    for i, p in enumerate(pieces):
        near = [other for j, other in enumerate(pieces) if j != i and _touch(boxes[i], boxes[j])]
        for part in cut(p, [q for other in near for q in meetings(p, other)]):
            middle = point_at(part, 0.5)
            if not any(
                abs(m[0] - middle[0]) < SAME_POINT_MM and _is_same(part, other)
                for m, other in zip(middles, out)
            ):
                out.append(part)
                middles.append(middle)
    return out


Box = tuple[float, float, float, float]


def _box(p: ContourPiece) -> Box:
    """Return the least and largest x and y."""
    xs, ys = zip(*extremes(p), strict=True)
    return min(xs), max(xs), min(ys), max(ys)


def _touch(a: Box, b: Box) -> bool:
    return (
        a[0] <= b[1] + SAME_POINT_MM
        and b[0] <= a[1] + SAME_POINT_MM
        and a[2] <= b[3] + SAME_POINT_MM
        and b[2] <= a[3] + SAME_POINT_MM
    )


def _is_same(a: ContourPiece, b: ContourPiece) -> bool:
    """Return whether two parts cover each other, whichever way they go."""
    if math.dist(point_at(a, 0.5), point_at(b, 0.5)) > SAME_POINT_MM:
        return False
    return (
        min(
            math.dist(a.start, b.start) + math.dist(a.end, b.end),
            math.dist(a.start, b.end) + math.dist(a.end, b.start),
        )
        < 4.0 * SAME_POINT_MM
    )


def loops(parts: Sequence[ContourPiece]) -> list[list[ContourPiece]]:
    """Return the parts joined end to start. Open ones are left out."""
    left, out = list(parts), []
    while left:
        ring = [left.pop(0)]
        while math.dist(ring[-1].end, ring[0].start) > 10.0 * SAME_POINT_MM:
            after = min(left, key=lambda p: math.dist(p.start, ring[-1].end), default=None)
            if after is None or math.dist(after.start, ring[-1].end) > 10.0 * SAME_POINT_MM:
                break
            left.remove(after)
            ring.append(after)
        else:
            out.append(ring)
    return out


def crossings(p: ContourPiece, axis: int, at: float) -> list[float]:
    """Return the crossings of a piece with the line on which a coordinate has one value: the other coordinate."""
    if p.centre is None:
        u, v = p.start[axis] - at, p.end[axis] - at
        if (u < 0) == (v < 0):
            return []
        return [p.start[1 - axis] + (p.end[1 - axis] - p.start[1 - axis]) * u / (u - v)]
    square = radius_of(p) ** 2 - (at - p.centre[axis]) ** 2
    if square <= 0.0:
        return []
    both = [p.centre[1 - axis] + s * math.sqrt(square) for s in (1.0, -1.0)]
    return [x for x in both if share_at(p, (x, at) if axis == 1 else (at, x)) <= 1.0]


def extremes(p: ContourPiece) -> list[Vec]:
    """Ends of a piece, and where an arc goes furthest along an axis."""
    out = [p.start, p.end]
    if p.centre is not None:
        (a, b), r = p.centre, radius_of(p)
        out += [q for q in ((a + r, b), (a - r, b), (a, b + r), (a, b - r)) if share_at(p, q) <= 1.0]
    return out
