"""Clear an area of any shape: pockets less islands, rows in it, once round its edge, and the way of the tool from one to the next.

The centre of the tool may be wherever it is at least `distance` from every wall. The edge of that is made of lines and arcs beside the walls, and arcs
about their corners; all of them are cut where they meet, and what is too near to a wall is left out. Rows lie at most `step` apart, and the last
way is once round: what lies within `step` / 2 of either is cut, so nothing that the tool can reach is left where `step` is no more than its diameter.
Manuals leave the order to the control; a reader tells it. Lengths mm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from vcmm.program.clearing import PathPiece
from vcmm.program.contouring import is_closed
from vcmm.program.faults import BlockFault
from vcmm.program.moves import Move
from vcmm.program.offsetting import ContourPiece, Vec, piece_of, planar
from vcmm.program.pieces import (
    SAME_POINT_MM,
    crossings,
    cut_all,
    distance,
    extremes,
    length_of,
    loops,
    meetings,
    normal_at,
    parallel,
    point_at,
    radius_of,
    reverse_piece,
    share_at,
)

MOST_ROWS = 100_000
STEP_ASIDE = 1e-4  # mm from an edge, to see on which side the area lies
Ring = tuple[ContourPiece, ...]


@dataclass(frozen=True)
class Stroke:
    """A way at one height: from `start` along pieces."""

    start: Vec
    path: tuple[PathPiece, ...]

    @property
    def end(self) -> Vec:
        return self.path[-1].end


@dataclass(frozen=True)
class Area:
    """Allowed region of the tool centre: between the rings, each with the area on its left."""

    rings: tuple[Ring, ...]

    def strokes(self, step: float, along: int = 0, climb: bool = True) -> list[Stroke]:
        """Return the rows along an axis of the plane (0, 1), to and fro, then each ring: with the wall on the right (climb), or the other way."""
        out: list[Stroke] = []
        here = self.rings[0][0].start
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
        rings = self.rings if climb else [tuple(reverse_piece(p) for p in reversed(r)) for r in self.rings]
        return out + [
            Stroke(r[0].start, tuple(PathPiece(p.end, p.centre, p.sweep < 0.0) for p in r)) for r in rings
        ]

    def _rows(self, step: float, across: int) -> Iterator[list[tuple[Vec, Vec]]]:
        """Return the stretches of each row inside the area."""
        values = [q[across] for r in self.rings for p in r for q in extremes(p)]
        low, high = min(values), max(values)
        count = math.ceil((high - low) / step - 1e-9) if step > 0 else 1
        if count > MOST_ROWS:
            raise BlockFault(0, f"{count} rows are more than {MOST_ROWS}; make the step larger")
        corners = {q[across] for r in self.rings for p in r for q in (p.start, p.end)}
        for k in range(1, count):
            at = low + (high - low) * k / count
            while any(
                abs(at - c) < SAME_POINT_MM for c in corners
            ):  # a row through a corner would count it twice
                at += 3.0 * SAME_POINT_MM
            cuts = sorted(x for r in self.rings for p in r for x in crossings(p, across, at))
            pairs = zip(cuts[::2], cuts[1::2])
            yield [
                ((a, at), (b, at)) if across == 1 else ((at, a), (at, b))
                for a, b in pairs
                if b - a > SAME_POINT_MM
            ]

    def is_clear(self, begin: Vec, end: Vec) -> bool:
        """Return whether a straight way at one height stays in the area."""
        if math.dist(begin, end) < SAME_POINT_MM:
            return True
        way = ContourPiece(begin, end)
        shares = [0.0, 1.0, *(share_at(way, q) for r in self.rings for p in r for q in meetings(way, p))]
        for a, b in pairwise(sorted(min(max(s, 0.0), 1.0) for s in shares)):
            if (b - a) * math.dist(begin, end) > 4.0 * SAME_POINT_MM and not self.holds(
                point_at(way, 0.5 * (a + b))
            ):
                return False
        return True

    def holds(self, point: Vec) -> bool:
        """Return whether a point lies in the area, its edge counted in."""
        pieces = [p for r in self.rings for p in r]
        return any(distance(p, point) < SAME_POINT_MM for p in pieces) or _is_inside(pieces, point)


def _is_inside(pieces: Sequence[ContourPiece], point: Vec) -> bool:
    """Return whether a ray to the right crosses closed pieces an odd number of times."""
    at = point[1]
    while any(abs(at - q[1]) < SAME_POINT_MM / 10 for p in pieces for q in (p.start, p.end)):
        at += SAME_POINT_MM / 3
    return sum(x > point[0] for p in pieces for x in crossings(p, 1, at)) % 2 == 1


@dataclass(frozen=True)
class Walls:
    """Pockets less islands, and the edge of the remaining area, which is on its left."""

    pockets: tuple[Ring, ...]
    islands: tuple[Ring, ...]

    def holds(self, point: Vec) -> bool:
        return any(_is_inside(p, point) for p in self.pockets) and not any(
            _is_inside(p, point) for p in self.islands
        )

    def edge(self) -> list[ContourPiece]:
        out = []
        for part in cut_all([p for ring in (*self.pockets, *self.islands) for p in ring]):
            (a, b), n = point_at(part, 0.5), normal_at(part, 0.5)
            left, right = (
                self.holds((a + s * STEP_ASIDE * n[0], b + s * STEP_ASIDE * n[1])) for s in (1.0, -1.0)
            )
            if left != right:
                out.append(part if left else reverse_piece(part))
        return out


def area(contours: Sequence[tuple[Sequence[Move], str]], off: float) -> Area:
    """Return the area of the tool centre. contours: closed, with the side on which the tool goes beside each: inside of a pocket, outside
    of an island. off: mm from every wall.

     Raises BlockFault where one is not closed, where there is no pocket, or where the tool fits in nowhere.
    """
    rings: list[tuple[Ring, bool]] = []
    for moves, side in contours:
        if not is_closed(moves):
            raise BlockFault(0, "a contour to be cleared ends where it begins; close it")
        ring = tuple(p for p in map(piece_of, filter(planar, moves)) if length_of(p) > SAME_POINT_MM)
        rings.append((ring, (_signed(ring) > 0.0) == (side == "left")))
    walls = Walls(tuple(r for r, inside in rings if inside), tuple(r for r, inside in rings if not inside))
    if not walls.pockets:
        raise BlockFault(
            0,
            "the tool goes outside of every contour, which clears nothing; check RL and RR (G41 and G42) and the way of the contours",
        )
    edge = walls.edge()
    made = (
        edge
        if off <= 0.0
        else [p for p in cut_all(_beside(edge, off)) if _is_free(walls, edge, point_at(p, 0.5), off)]
    )
    outlines = loops(made)
    if not outlines:
        raise BlockFault(0, f"the tool fits in nowhere ({off:g} mm from every wall); take a smaller one")
    first = rings[0][0][0].start
    return Area(
        tuple(
            _begin_at(r, first)
            for r in sorted(outlines, key=lambda r: min(math.dist(p.start, first) for p in r))
        )
    )


def _beside(edge: Sequence[ContourPiece], off: float) -> list[ContourPiece]:
    """Return the pieces beside every piece on its left, and round every corner (clockwise: the area lies outside of it)."""
    out = [q for p in edge if (q := parallel(p, off)) is not None]
    for x, y in {p.start for p in edge}:
        east, west = (x + off, y), (x - off, y)
        out += [ContourPiece(east, west, (x, y), -math.pi), ContourPiece(west, east, (x, y), -math.pi)]
    return out


def _is_free(walls: Walls, edge: Sequence[ContourPiece], point: Vec, off: float) -> bool:
    return all(distance(p, point) > off - SAME_POINT_MM for p in edge) and walls.holds(point)


def _begin_at(ring: Sequence[ContourPiece], point: Vec) -> Ring:
    """Return a ring from its corner that is nearest to a point."""
    k = min(range(len(ring)), key=lambda i: math.dist(ring[i].start, point))
    return (*ring[k:], *ring[:k])


def _signed(ring: Sequence[ContourPiece]) -> float:
    """Return twice the area within closed pieces, positive counter-clockwise."""
    total = 0.0
    for p in ring:
        total += p.start[0] * p.end[1] - p.end[0] * p.start[1]
        if p.centre is not None:
            total += radius_of(p) ** 2 * (p.sweep - math.sin(p.sweep))
    return total
