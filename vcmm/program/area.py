"""Clears an area of any shape: closed contours beside which the tool goes, rows between them, and how it gets from one to the next.

Rows lie at most `step` apart, and the last way is once round each contour; what lies within `step` / 2 of a row, or of a contour, is cut, and
nothing else is left where `step` is no more than the diameter of the tool. Manuals leave the order to the control; a reader tells it. Lengths mm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from vcmm.program.clearing import PathPiece
from vcmm.program.contouring import beside, flat, is_closed, pieces
from vcmm.program.faults import BlockFault
from vcmm.program.moves import PLANES, Move
from vcmm.program.radius import Style

Flat = tuple[float, float]
SAME = 1e-6  # mm: closer points are one
MOST_ROWS = 100_000


@dataclass(frozen=True)
class Stroke:
    """A way at one height: from `start` along pieces."""

    start: Flat
    path: tuple[PathPiece, ...]

    @property
    def end(self) -> Flat:
        return self.path[-1].end


@dataclass(frozen=True)
class Area:
    """Where the centre of the tool may be: between the rings, each the way beside one contour."""

    rings: tuple[tuple[Move, ...], ...]

    def strokes(self, step: float, along: int = 0) -> list[Stroke]:
        """Rows along an axis of the plane (0, 1), to and fro, then each ring."""
        out: list[Stroke] = []
        here = flat(self.rings[0][0], False)
        for row in self._rows(step, 1 - along):
            left = [*row]
            while left:  # the nearest end of the nearest piece of the row first
                begin, end = min(
                    (way for a, b in left for way in ((a, b), (b, a))),
                    key=lambda way: math.dist(here, way[0]),
                )
                left = [s for s in left if s not in ((begin, end), (end, begin))]
                out.append(Stroke(begin, (PathPiece(end),)))
                here = end
        return out + [Stroke(flat(r[0], False), tuple(pieces(r))) for r in self.rings]

    def _rows(self, step: float, across: int) -> Iterator[list[tuple[Flat, Flat]]]:
        """Stretches of each row inside the area."""
        low, high = self._span(across)
        count = math.ceil((high - low) / step - 1e-9) if step > 0 else 1
        if count > MOST_ROWS:
            raise BlockFault(0, f"{count} rows are more than {MOST_ROWS}; make the step larger")
        corners = {flat(m, end)[across] for r in self.rings for m in r for end in (False, True)}
        for k in range(1, count):
            at = low + (high - low) * k / count
            while any(abs(at - c) < SAME for c in corners):  # a row through a corner would count it twice
                at += 3.0 * SAME
            cuts = sorted(x for r in self.rings for m in r for x in _cuts(m, across, at))
            pairs = zip(cuts[::2], cuts[1::2])
            yield [
                ((a, at), (b, at)) if across == 1 else ((at, a), (at, b)) for a, b in pairs if b - a > SAME
            ]

    def _span(self, axis: int) -> tuple[float, float]:
        values = [p[axis] for r in self.rings for m in r for p in _extremes(m)]
        return min(values), max(values)

    def is_clear(self, begin: Flat, end: Flat) -> bool:
        """Whether a straight way at one height stays in the area."""
        if math.dist(begin, end) < SAME:
            return True
        shares = [0.0, 1.0]
        for r in self.rings:
            for m in r:
                shares += _shares(begin, end, m)
        shares.sort()
        for a, b in pairwise(shares):
            if (b - a) * math.dist(begin, end) > 2.0 * SAME:
                half = 0.5 * (a + b)
                middle = (begin[0] + half * (end[0] - begin[0]), begin[1] + half * (end[1] - begin[1]))
                if not self.holds(middle):
                    return False
        return True

    def holds(self, point: Flat) -> bool:
        """Whether a point lies in the area, its edge counted in."""
        if any(_apart(m, point) < SAME for r in self.rings for m in r):
            return True
        at = point[1]
        while any(
            abs(at - flat(m, end)[1]) < SAME / 10 for r in self.rings for m in r for end in (False, True)
        ):
            at += SAME / 3
        return sum(x > point[0] for r in self.rings for m in r for x in _cuts(m, 1, at)) % 2 == 1


def area(contours: Sequence[tuple[Sequence[Move], str]], distance: float, style: Style, file: str) -> Area:
    """contours: closed, with the side on which the tool goes beside each, `distance` from it.

    Raises BlockFault where one is not closed, the tool does not fit in, or two ways cross (contours that overlap, or are too near for the tool).
    """
    rings: list[tuple[Move, ...]] = []
    for moves, side in contours:
        if not is_closed(moves):
            raise BlockFault(0, "a contour to be cleared ends where it begins; close it")
        ring = tuple(m for m in beside(moves, side, distance, style, file, True) if _extent(m) > SAME)
        if not ring or _signed(ring) * _signed(moves) <= 0:
            raise BlockFault(
                0,
                f"the tool does not fit into the contour ({distance:g} mm from its wall on all sides); take a smaller one",
            )
        rings.append(ring)
    made = Area(tuple(rings))
    if _cross(made.rings):
        raise BlockFault(
            0, f"the ways {distance:g} mm beside the contours cross: contours that overlap or leave the tool no room are not understood; "
            "write them as one contour, or take a smaller tool",
        )  # fmt: skip
    _check_nesting(made, [_signed(m) > 0.0 if side == "left" else _signed(m) < 0.0 for m, side in contours])
    return made


def _check_nesting(made: Area, pockets: Sequence[bool]) -> None:
    """A pocket (the tool goes inside) lies in nothing else, an island in one pocket."""
    for k, ring in enumerate(made.rings):
        point = flat(ring[0], False)
        around = [n for n, other in enumerate(made.rings) if n != k and Area((other,)).holds(point)]
        if [pockets[n] for n in around] != ([] if pockets[k] else [True]):
            what = (
                "a pocket lies within another contour"
                if pockets[k]
                else "an island lies outside the pockets, or in another island"
            )
            raise BlockFault(0, f"{what}; check the contours and their sides (RL and RR, G41 and G42)")


def _extent(m: Move) -> float:
    return math.inf if m.centre is not None else math.dist(flat(m, False), flat(m, True))


def _signed(moves: Sequence[Move]) -> float:
    """Twice the area within closed moves, positive counter-clockwise."""
    total = 0.0
    for m in moves:
        (a, b), (c, d) = flat(m, False), flat(m, True)
        total += a * d - c * b
        if m.centre is not None:
            _, radius, _, sweep = _arc(m)
            total += radius * radius * (sweep - math.sin(sweep))
    return total


def _arc(m: Move) -> tuple[Flat, float, float, float]:
    """Centre, radius, first angle and sweep (rad, positive counter-clockwise)."""
    one, two, _ = PLANES[m.plane]
    assert m.centre is not None
    c = (m.centre[one], m.centre[two])
    p, q = flat(m, False), flat(m, True)
    first, last = math.atan2(p[1] - c[1], p[0] - c[0]), math.atan2(q[1] - c[1], q[0] - c[0])
    turn = 2.0 * math.pi
    sweep = ((first - last) if m.clockwise else (last - first)) % turn
    sweep = turn if sweep < 1e-12 or turn - sweep < 1e-12 else sweep
    return c, math.dist(p, c), first, -sweep if m.clockwise else sweep


def _on_arc(m: Move, point: Flat) -> bool:
    """Whether a point of its circle is on an arc."""
    c, radius, first, sweep = _arc(m)
    at = (math.atan2(point[1] - c[1], point[0] - c[0]) - first) * math.copysign(1.0, sweep) % (2.0 * math.pi)
    spare = 1e-9 / max(radius, 1e-9)
    return at <= abs(sweep) + spare or at >= 2.0 * math.pi - spare


def _cuts(m: Move, axis: int, at: float) -> list[float]:
    """Where a move crosses the line on which a coordinate has one value: the other coordinate."""
    p, q = flat(m, False), flat(m, True)
    if m.centre is None:
        u, v = p[axis] - at, q[axis] - at
        return [p[1 - axis] + (q[1 - axis] - p[1 - axis]) * u / (u - v)] if (u < 0) != (v < 0) else []
    c, radius, _, _ = _arc(m)
    half = radius * radius - (at - c[axis]) ** 2
    if half <= 0.0:
        return []
    out = [c[1 - axis] + s * math.sqrt(half) for s in (1.0, -1.0)]
    return [x for x in out if _on_arc(m, (x, at) if axis == 1 else (at, x))]


def _extremes(m: Move) -> list[Flat]:
    """Ends of a move, and where an arc goes furthest along an axis."""
    out = [flat(m, False), flat(m, True)]
    if m.centre is not None:
        c, r, _, _ = _arc(m)
        out += [
            p
            for p in ((c[0] + r, c[1]), (c[0] - r, c[1]), (c[0], c[1] + r), (c[0], c[1] - r))
            if _on_arc(m, p)
        ]
    return out


def _apart(m: Move, point: Flat) -> float:
    """Distance of a point from a move."""
    p, q = flat(m, False), flat(m, True)
    if m.centre is not None:
        c, radius, _, _ = _arc(m)
        if math.dist(point, c) > 0.0 and _on_arc(m, point):
            return abs(math.dist(point, c) - radius)
        return min(math.dist(point, p), math.dist(point, q))
    d = (q[0] - p[0], q[1] - p[1])
    share = ((point[0] - p[0]) * d[0] + (point[1] - p[1]) * d[1]) / (d[0] ** 2 + d[1] ** 2)
    share = min(max(share, 0.0), 1.0)
    return math.dist(point, (p[0] + share * d[0], p[1] + share * d[1]))


def _shares(begin: Flat, end: Flat, m: Move) -> list[float]:
    """Where a straight way meets a move: parts of its length between 0 and 1."""
    length = math.dist(begin, end)
    u = ((end[0] - begin[0]) / length, (end[1] - begin[1]) / length)

    def turned(p: Flat) -> Flat:
        a, b = p[0] - begin[0], p[1] - begin[1]
        return a * u[0] + b * u[1], b * u[0] - a * u[1]

    p, q = turned(flat(m, False)), turned(flat(m, True))
    if m.centre is None:
        if (p[1] < 0) == (q[1] < 0):
            return []
        out = [p[0] + (q[0] - p[0]) * p[1] / (p[1] - q[1])]
    else:
        c, radius, _, _ = _arc(m)
        x, y = turned(c)
        half = radius * radius - y * y
        spots = [x + s * math.sqrt(half) for s in (1.0, -1.0)] if half > 0 else []
        out = [s for s in spots if _on_arc(m, (begin[0] + s * u[0], begin[1] + s * u[1]))]
    return [s / length for s in out if 0.0 < s < length]


def _cross(rings: Sequence[Sequence[Move]]) -> bool:
    """Whether two moves of the rings cross other than where one follows the other."""
    every = [(k, i, m) for k, r in enumerate(rings) for i, m in enumerate(r)]
    for n, (k, i, a) in enumerate(every):
        for other, j, b in every[n + 1 :]:
            count = len(rings[k])
            follow = k == other and (j - i in (1, count - 1))
            for p in _meetings(a, b):
                ends = [flat(a, False), flat(a, True)]
                if not (follow and any(math.dist(p, e) < 1e-4 for e in ends)):
                    return True
    return False


def _meetings(a: Move, b: Move) -> list[Flat]:
    """Points of two moves."""
    if a.centre is not None and b.centre is not None:
        (c, r, _, _), (d, s, _, _) = _arc(a), _arc(b)
        apart = math.dist(c, d)
        if apart < SAME or apart > r + s or apart < abs(r - s):
            return []
        x = (apart * apart + r * r - s * s) / (2.0 * apart)
        h = math.sqrt(max(r * r - x * x, 0.0))
        u = ((d[0] - c[0]) / apart, (d[1] - c[1]) / apart)
        spots = [(c[0] + x * u[0] - t * h * u[1], c[1] + x * u[1] + t * h * u[0]) for t in (1.0, -1.0)]
        return [p for p in spots if _on_arc(a, p) and _on_arc(b, p)]
    line, other = (a, b) if a.centre is None else (b, a)
    p, q = flat(line, False), flat(line, True)
    return [(p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1])) for s in _shares(p, q, other)]
