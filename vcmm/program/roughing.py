"""Roughing of turned contours, for G71 and G72 of the G-code family and CYCLE95 of Sinumerik.

Points are (X as a radius, Z), mm. Passes are type I: each cuts up to where it first meets the contour; the contour itself, with the
allowance, is followed at the end.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from vcmm.program.faults import BlockFault
from vcmm.program.moves import Move

MOST_PASSES = 100_000
CHORD = 0.001  # mm, of arcs between the points of a section; passes end on the arc itself, and the contour keeps its arcs
Flat = tuple[float, float]  # X (radius), Z
Section = list[Flat]


class Rough(NamedTuple):
    """Depth of a pass, retraction (radii), allowances in X (radius) and Z, mm."""

    depth: float
    escape: float
    x: float
    z: float


class Cut(NamedTuple):
    """One move from where the tool is: straight, or an arc about `centre`."""

    end: Flat
    rapid: bool
    centre: Flat | None = None
    clockwise: bool = False
    turns: int = 1


class SectionChord(NamedTuple):
    """A straight piece of a section; centre: of the arc that both ends lie on, None where it is a line."""

    begin: Flat
    end: Flat
    centre: Flat | None


def passes(moves: Sequence[Move], begin: Flat, rough: Rough, order: str, column: int = 0) -> Iterator[Cut]:
    """Yield the cuts along the second axis of `order`, one below the other in the first; then the contour with its allowance.

    moves: the contour behind a first move that leads to it. begin: where the tool stands, which the allowance moves. Raises
    BlockFault at the column: too many passes.
    """
    a, b = (0, 1) if order == "XZ" else (1, 0)  # of Flat: across, along
    entry = moves[0].kind == "rapid"
    stretches = _stretches(moves[1:], rough)
    start = (begin[0] + rough.x, begin[1] + rough.z)
    first, last = stretches[0].begin, stretches[-1].end
    goal, level = first[a], start[a]
    down = 1.0 if goal > level else -1.0
    along = 1.0 if last[b] > start[b] else -1.0
    if abs(goal - level) / rough.depth > MOST_PASSES:
        raise BlockFault(column, f"more than {MOST_PASSES} passes; make the depth of cut larger")
    while (goal - (level + down * rough.depth)) * down > 1e-9:
        level += down * rough.depth
        end = _meeting(stretches, a, b, level, down)
        out = (level - down * rough.escape, end - along * min(rough.escape, abs(end - start[b])))
        yield Cut(_flat(a, level, start[b]), entry)
        yield Cut(_flat(a, level, end), False)
        yield Cut(_flat(a, *out), False)
        yield Cut(_flat(a, out[0], start[b]), True)
    yield Cut(first, entry)
    yield from follow_contour(moves[1:], rough.x, rough.z)


def follow_contour(moves: Sequence[Move], x: float, z: float) -> Iterator[Cut]:
    """Yield the contour moved by (x, z)."""
    for m in moves:
        end = (m.end[0] + x, m.end[2] + z)
        if m.centre is None:
            yield Cut(end, m.kind == "rapid")
        else:
            yield Cut(end, False, (m.centre[0] + x, m.centre[2] + z), bool(m.clockwise), m.turns)


def _flat(a: int, across: float, along: float) -> Flat:
    return (across, along) if a == 0 else (along, across)


def _meeting(stretches: Sequence[SectionChord], a: int, b: int, level: float, down: float) -> float:
    """Return the place where a pass at `level` first meets the contour, arcs on their circle; its end where it never does."""
    for p, q, centre in stretches:
        u, v = (p[a] - level) * down, (q[a] - level) * down
        if u >= 0.0 and v < 0.0:
            near = p[b] + (q[b] - p[b]) * u / (u - v)
            return near if centre is None else _on_circle(p, centre, (a, b), level, near)
    return stretches[-1].end[b]


def _on_circle(point: Flat, centre: Flat, axes: tuple[int, int], level: float, near: float) -> float:
    """Return the place of the circle through a point at `level`: of its two places the one nearer to `near`, mm."""
    a, b = axes
    half = math.sqrt(max(math.dist(point, centre) ** 2 - (level - centre[a]) ** 2, 0.0))
    return min(centre[b] - half, centre[b] + half, key=lambda place: abs(place - near))


def _stretches(moves: Sequence[Move], rough: Rough) -> list[SectionChord]:
    """Return the contour with its allowance in straight stretches, arcs within CHORD."""
    out: list[SectionChord] = []
    begin = (moves[0].start[0] + rough.x, moves[0].start[2] + rough.z)
    for m in moves:
        centre = None if m.centre is None else (m.centre[0] + rough.x, m.centre[2] + rough.z)
        for x, z in _points(m):
            end = (x + rough.x, z + rough.z)
            out.append(SectionChord(begin, end, centre))
            begin = end
    return out


def section_of(moves: Sequence[Move], rough: Rough) -> Section:
    """Return the contour with its allowance as a chain of points, arcs within CHORD."""
    stretches = _stretches(moves, rough)
    return [stretches[0].begin, *(s.end for s in stretches)]


def comes_back(moves: Sequence[Move], begin: Flat, order: str) -> bool:
    """Return whether the contour behind its first move comes back across (X of G71), so that one pass to its first meeting leaves a pocket."""
    across = [p[0 if order == "XZ" else 1] for p in section_of(moves[1:], Rough(1.0, 0.0, 0.0, 0.0))]
    out = begin[0 if order == "XZ" else 1] - across[0]  # zero: no pass at all
    return any((b - a) * math.copysign(1.0, out) < -1e-6 for a, b in itertools.pairwise(across) if out)


def _points(move: Move) -> Section:
    end = (move.end[0], move.end[2])
    if move.centre is None:
        return [end]
    cx, cz = move.centre[0], move.centre[2]
    radius = math.hypot(move.start[0] - cx, move.start[2] - cz)
    first = math.atan2(move.start[0] - cx, move.start[2] - cz)  # plane ZX: Z is its first axis
    last = math.atan2(end[0] - cx, end[1] - cz)
    sweep = (first - last if move.clockwise else last - first) % (2.0 * math.pi) or 2.0 * math.pi
    count = max(1, math.ceil(sweep / (2.0 * math.acos(max(0.0, 1.0 - CHORD / max(radius, CHORD))))))
    step = (-sweep if move.clockwise else sweep) / count
    inner = [
        (cx + radius * math.sin(first + k * step), cz + radius * math.cos(first + k * step))
        for k in range(1, count)
    ]
    return [*inner, end]
