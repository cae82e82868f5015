"""Totals of a program: numbers of moves, path lengths, cutting time at the programmed feed, extents."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from vcmm.program.moves import ORIGIN, PLANES, Move, Point, Program
from vcmm.program.setup import Setup


@dataclass(frozen=True)
class ProgramSummary:
    """Lengths mm, times s. Extents are of the tip: lowest and highest corner; None without a move."""

    counts: dict[str, int]
    lengths: dict[str, float]
    cutting_time: float
    dwell_time: float
    machine: tuple[Point, Point] | None
    work: tuple[Point, Point] | None
    cutting: tuple[Point, Point] | None

    def as_json(self) -> dict[str, Any]:
        def box(b: tuple[Point, Point] | None) -> list[list[float]] | None:
            return None if b is None else [list(b[0]), list(b[1])]

        return {
            "moves": self.counts, "path_mm": self.lengths, "cutting_time_s": self.cutting_time, "dwell_time_s": self.dwell_time,
            "extent_machine_mm": box(self.machine), "extent_work_mm": box(self.work), "extent_cutting_mm": box(self.cutting),
        }  # fmt: skip

    def rows(self, program: Program) -> Iterator[tuple[str, str]]:
        """Yield the lines for a table."""
        yield "cutting time at the programmed feed", f"{self.cutting_time:.1f} s"
        if self.dwell_time:
            yield "dwells", f"{self.dwell_time:.1f} s"
        for name, box in (("machine", self.machine), ("work", self.work)):
            if box is not None:
                label = "work coordinates (zeros of the set-up)" if name == "work" else f"{name} coordinates"
                yield f"extent of the tip, {label}", _box(box)
        if self.cutting is not None:
            yield "extent of the cuts, machine coordinates", _box(self.cutting)
        if program.tools:
            yield "tools", ", ".join(program.tools.values())


def _box(box: tuple[Point, Point]) -> str:
    return ", ".join(f"{axis} {a:.3f} to {b:.3f} mm" for axis, a, b in zip("XYZ", *box))


def arc_angle(move: Move) -> float:
    """Return the angle swept by an arc, rad, positive."""
    assert move.centre is not None
    a, b, _ = PLANES[move.plane]
    begin = math.atan2(move.start[b] - move.centre[b], move.start[a] - move.centre[a])
    end = math.atan2(move.end[b] - move.centre[b], move.end[a] - move.centre[a])
    sweep = (begin - end if move.clockwise else end - begin) % (2.0 * math.pi)
    return (sweep if sweep > 1e-6 else sweep + 2.0 * math.pi) + 2.0 * math.pi * (move.turns - 1)


def move_length(move: Move) -> float:
    """Return the path of the tip, mm: of an arc with its mean radius and its rise."""
    if move.centre is None:
        return math.dist(move.start, move.end)
    a, b, n = PLANES[move.plane]
    radii = [math.hypot(p[a] - move.centre[a], p[b] - move.centre[b]) for p in (move.start, move.end)]
    return math.hypot(sum(radii) / 2.0 * arc_angle(move), move.end[n] - move.start[n])


def _points(move: Move) -> Iterator[Point]:
    """Yield the points that span the extent of a move: ends, and where an arc turns back along an axis."""
    yield move.start
    yield move.end
    if move.centre is None:
        return
    a, b, _ = PLANES[move.plane]
    radius = math.hypot(move.start[a] - move.centre[a], move.start[b] - move.centre[b])
    begin = math.atan2(move.start[b] - move.centre[b], move.start[a] - move.centre[a])
    sweep, sign = arc_angle(move), -1.0 if move.clockwise else 1.0
    for quarter in range(4):
        angle = quarter * math.pi / 2.0
        if (sign * (angle - begin)) % (2.0 * math.pi) <= sweep:
            point = list(move.start)
            point[a] = move.centre[a] + radius * math.cos(angle)
            point[b] = move.centre[b] + radius * math.sin(angle)
            yield (point[0], point[1], point[2])


def extent(points: Sequence[Point]) -> tuple[Point, Point] | None:
    """Return the lowest and highest corner."""
    if not points:
        return None
    columns = list(zip(*points))
    return (
        (min(columns[0]), min(columns[1]), min(columns[2])),
        (max(columns[0]), max(columns[1]), max(columns[2])),
    )


class SummaryBuilder:
    """Totals of moves that come in pieces. The first move has an unknown start, which does not count."""

    def __init__(self, setup: Setup | None = None) -> None:
        self.offsets = setup.offsets if setup else {}
        self.counts: dict[str, int] = {}
        self.lengths: dict[str, float] = {}
        self.cutting = self.dwells = 0.0
        self.boxes: list[tuple[Point, Point] | None] = [None, None, None]  # machine, work, cuts
        self.begun = False

    def add(self, moves: Sequence[Move]) -> None:
        """Add the next moves."""
        everything, work, cuts = [], [], []
        for move in moves:
            self._count(move)
            points = list(_points(move)) if move.centre is not None else [move.start, move.end]
            points = points if self.begun else points[1:]
            self.begun = True
            everything += points
            zero = self.offsets.get(move.offset, ORIGIN)
            if move.rewritable:
                work += (
                    points
                    if zero == ORIGIN
                    else [(p[0] - zero[0], p[1] - zero[1], p[2] - zero[2]) for p in points]
                )
            if move.kind in ("line", "arc", "thread"):
                cuts += points
        for k, points in enumerate((everything, work, cuts)):
            old = self.boxes[k]
            self.boxes[k] = extent([*points, *(old or ())])

    def _count(self, move: Move) -> None:
        size = move_length(move)
        self.counts[move.kind] = self.counts.get(move.kind, 0) + 1
        self.lengths[move.kind] = self.lengths.get(move.kind, 0.0) + size
        self.dwells += move.seconds
        if move.feed:
            turned = 0.0 if size else math.degrees(math.dist(move.rotary_start, move.rotary_end))
            self.cutting += (size or turned) / move.feed * 60.0

    def total(self) -> ProgramSummary:
        return ProgramSummary(self.counts, self.lengths, self.cutting, self.dwells, *self.boxes)


def summary(moves: Sequence[Move], setup: Setup | None = None) -> ProgramSummary:
    """Return the totals of a program."""
    builder = SummaryBuilder(setup)
    builder.add(moves)
    return builder.total()
