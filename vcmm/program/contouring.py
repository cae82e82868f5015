"""A contour beside which a tool goes, for the contour cycles of all languages. Moves of one plane, mm."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields

from vcmm.program.clearing import PathPiece
from vcmm.program.moves import PLANES, Move, Source
from vcmm.program.radius import RadiusCompensation, Style, centre_path
from vcmm.program.recorder import Recorder
from vcmm.program.rounding import round_corners

Flat = tuple[float, float]
LONG_LEAD_MM = 1e3  # mm, of a lead that is longer than any tool is wide
CLOSED = 1e-6  # mm from the end of a contour to its begin


READING_NOTES = frozenset(("assumptions", "unused_words", "misfits", "remarks", "remark_keys", "tool_names"))


@dataclass(eq=False)
class RecordedContour:
    """Moves in machine coordinates and as programmed, and the side on which the tool goes beside them."""

    moves: list[Move] = field(default_factory=list)
    programmed_moves: list[Move] = field(default_factory=list)
    side: str | None = None


@contextmanager
def record_contour(r: Recorder) -> Iterator[RecordedContour]:
    """Record the moves made inside as a contour; the state is unchanged but for READING_NOTES."""
    before = {f.name: getattr(r, f.name) for f in fields(r) if f.name not in READING_NOTES}
    r.moves, r.sides, r.corners, r.markers, r.tracer = [], [], [], [], None
    out = RecordedContour()
    yield out
    out.moves, _ = round_corners(r.moves, [None] * len(r.moves), r.corners, r.file)
    out.side = next((s.side for s in r.sides if s is not None), None)
    undo = r.world.undo
    out.programmed_moves = [
        m._replace(start=undo(m.start), end=undo(m.end), centre=m.centre and undo(m.centre))
        for m in out.moves
    ]
    for name, value in before.items():
        setattr(r, name, value)


def offset_contour(
    moves: Sequence[Move], side: str | None, radius: float, style: Style, file: str, closed: bool = False
) -> list[Move]:
    """Return the contour as the path of the tool centre, without ways in and out. closed: it begins and ends at a corner of its own."""
    if side is None or not radius:
        return list(moves)
    round_again = [moves[-1], *moves, moves[0]] if closed else list(moves)
    marked = [m._replace(source=Source(k + 1, 1, 1)) for k, m in enumerate(round_again)]
    path = [_lead(marked[0], False), *marked, _lead(marked[-1], True)]
    compensation = RadiusCompensation(side, radius, style)
    sides: list[RadiusCompensation | None] = [*[compensation] * (len(path) - 1), None]
    made = centre_path(path, sides, file)[1:-1]
    extra = 1 if closed else 0
    return [
        m._replace(source=moves[m.source.line - 1 - extra].source)
        for m in made
        if extra < m.source.line <= len(moves) + extra
    ]


def _lead(move: Move, behind: bool) -> Move:
    """Return a line into the contour along its first direction, or out of it along its last."""
    a, b = tangent(move, behind)
    first, second, _ = PLANES[move.plane]
    end = move.end if behind else move.start
    far = list(end)
    for k, value in ((first, a), (second, b)):
        far[k] += value * LONG_LEAD_MM * (1.0 if behind else -1.0)
    away = (far[0], far[1], far[2])
    line = move._replace(kind="line", centre=None, clockwise=None, turns=1)
    return line._replace(start=end, end=away) if behind else line._replace(start=away, end=end)


def flat(move: Move, at_end: bool) -> Flat:
    """Return the first or the last point of a move in its plane."""
    first, second, _ = PLANES[move.plane]
    point = move.end if at_end else move.start
    return point[first], point[second]


def tangent(move: Move, at_end: bool) -> Flat:
    """Return the direction of a move at one of its ends."""
    (a, b), (c, d) = flat(move, False), flat(move, True)
    if move.centre is None:
        length = math.hypot(c - a, d - b)
        return (c - a) / length, (d - b) / length
    first, second, _ = PLANES[move.plane]
    p = (c, d) if at_end else (a, b)
    x, y = p[0] - move.centre[first], p[1] - move.centre[second]
    length = math.hypot(x, y)
    return (y / length, -x / length) if move.clockwise else (-y / length, x / length)


def pieces(path: Sequence[Move]) -> list[PathPiece]:
    """Return the moves as pieces at one height."""
    out = []
    for move in path:
        first, second, _ = PLANES[move.plane]
        centre = None if move.centre is None else (move.centre[first], move.centre[second])
        out.append(PathPiece(flat(move, True), centre, bool(move.clockwise)))
    return out


def reverse(path: Sequence[Move]) -> list[Move]:
    """Return the same way back."""
    return [
        m._replace(start=m.end, end=m.start, clockwise=None if m.clockwise is None else not m.clockwise)
        for m in reversed(path)
    ]


def is_closed(path: Sequence[Move]) -> bool:
    """Return whether a contour ends where it begins."""
    return math.dist(flat(path[0], False), flat(path[-1], True)) < CLOSED
