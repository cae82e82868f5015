"""Moves for the milling cycles of all languages: moves in the plane and along the tool, pieces at one height, helices.

Coordinates are those of the plane in force and the height along the tool, mm, in the program's own frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from vcmm.program.chords import arc_or_chords
from vcmm.program.clearing import PathPiece
from vcmm.program.drilling import whole_count
from vcmm.program.levels import SetupEntry
from vcmm.program.moves import PLANES, Point
from vcmm.program.recorder import Recorder

Flat = tuple[float, float]


@dataclass(frozen=True, eq=False)
class CycleCutter:
    """The tool of a milling cycle."""

    recorder: Recorder

    @property
    def height(self) -> float:
        """Along the tool."""
        return self.recorder.p[PLANES[self.recorder.plane][2]]

    def here(self) -> Flat:
        """Return the position of the tool in the plane."""
        first, second, _ = PLANES[self.recorder.plane]
        return self.recorder.p[first], self.recorder.p[second]

    def point(self, spot: Flat | None, height: float | None) -> Point:
        """Return a point from its coordinates in the plane and along the tool; None: as it is."""
        first, second, normal = PLANES[self.recorder.plane]
        point = list(self.recorder.p)
        if spot is not None:
            point[first], point[second] = spot
        if height is not None:
            point[normal] = height
        return point[0], point[1], point[2]

    def to(self, spot: Flat | None, height: float | None, rapid: bool) -> None:
        """Move straight, where that is a way."""
        point = self.point(spot, height)
        if point != self.recorder.p:
            self.recorder.straight(point, rapid)

    def follow(self, path: Sequence[PathPiece], height: float) -> None:
        """Follow pieces at one height."""
        for piece in path:
            if piece.centre is None:
                self.to(piece.end, None, False)
            else:
                arc_or_chords(
                    self.recorder,
                    self.point(piece.end, height),
                    self.point(piece.centre, height),
                    piece.clockwise,
                )

    @contextmanager
    def feed_at(self, feed: float) -> Iterator[None]:
        """Move at this feed, mm/min (or mm per turn, as the mode in force has it); the one in force where it is zero."""
        before = self.recorder.feed
        self.recorder.feed = feed or before
        yield
        self.recorder.feed = before

    def helix(self, middle: Flat, radius: float, heights: Flat, pitch: float, clockwise: bool) -> None:
        """Mill a helix from the tool's place on the circle, `pitch` mm a turn, from the one height to the other; the last turn is a part of one."""
        (a, b), (first, last) = middle, heights
        full = abs(last - first) / pitch
        turns = whole_count(math.floor(full + 1e-9))
        begin = math.atan2(self.here()[1] - b, self.here()[0] - a)
        way = -1.0 if clockwise else 1.0
        sense = math.copysign(pitch, last - first)
        if turns:
            reached = last if full - turns < 1e-9 else first + turns * sense
            arc_or_chords(
                self.recorder, self.point(self.here(), reached), self.point((a, b), first), clockwise, turns
            )
        if full - turns >= 1e-9:
            angle = begin + way * 2.0 * math.pi * (full - turns)
            end = (a + radius * math.cos(angle), b + radius * math.sin(angle))
            arc_or_chords(self.recorder, self.point(end, last), self.point((a, b), last), clockwise)

    def thread(self, middle: Flat, radius: float, heights: Flat, pitch: float, clockwise: bool) -> None:
        """Mill a thread from the middle in half a circle, a helix, and half a circle back; straight where the tool fills the hole."""
        if not radius:
            self.to(middle, heights[1], False)
            return
        a, b = middle
        self.follow([PathPiece((a + radius, b), (a + radius / 2, b), clockwise)], heights[0])
        self.helix(middle, radius, heights, pitch, clockwise)
        x, y = self.here()
        self.follow([PathPiece(middle, ((x + a) / 2, (y + b) / 2), clockwise)], heights[1])

    def radius(self, who: str) -> float:
        """Return the radius of the tool in the spindle, mm; 0 where it is unknown: the path then runs on the contour. who: what needs it,
        in a sentence."""
        tool = self.recorder.tool_data
        if tool.radius is None:
            self.recorder.assume(
                f"the diameter of tool {tool.number}", "0 mm: the path on the programmed contour",
                f"{who} needs the radius of tool {tool.number}; state its diameter in the set-up under [tools.{tool.number}]",
                blank=SetupEntry(f"tools.{tool.number}", "diameter", '"10 mm"'),
            )  # fmt: skip
        return tool.radius or 0.0


def equal_depths(top: float, floor: float, most: float) -> list[float]:
    """Return the depths of infeeds of one size, `most` at most, as few as that needs; one where `most` is zero."""
    count = max(1, whole_count(math.ceil((top - floor) / most - 1e-9))) if most > 0 else 1
    return [top + (floor - top) * (k + 1) / count for k in range(count)]
