"""Places of a touch: the surfaces that a set-up states, and the first contact of the tip on a straight way.

A program that probes (G31, G38.2) goes on with what the probe found. Nominally the ball meets the surface where ball and surface
touch; the additions of the machine and the probe are given by `Setup.read_out`, the mm by which each touch reads further along its way
(`vcmm.shop.machining.touched_zero` uses their effect on the path).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from vcmm.program.moves import ORIGIN, Point, dot, minus

GRAZING = 1e-9  # of a unit vector: a way along the surface never meets it
BEHIND = 1e-6  # mm: a tip this far inside the surface at the start still touches it there


class ProbeContact(NamedTuple):
    """One touch: tip (mm, machine axes) when the probe answers, unit way to it, outward normal of the surface."""

    line: int
    tip: Point
    along: Point
    normal: Point
    tool: int
    tool_offset: Point
    offset: str  # work offset in force
    rotary: Point


@dataclass(frozen=True)
class Face:
    """A plane that is touched: a point of it and its outward unit normal; low, high: the box on which it is a side, None: unbounded."""

    point: Point
    normal: Point
    box: tuple[Point, Point] | None = None

    def meets(self, start: Point, along: Point, radius: float) -> tuple[float, Point] | None:
        """Return (mm along the unit way until a ball of `radius` touches, outward normal there), None where it never does."""
        falling = -dot(along, self.normal)
        if falling < GRAZING:
            return None
        way = (dot(minus(start, self.point), self.normal) - radius) / falling
        if way < -BEHIND:
            return None
        foot = tuple(s + way * a - radius * n for s, a, n in zip(start, along, self.normal))
        if self.box is not None and any(
            not low - BEHIND <= f <= high + BEHIND for low, f, high in zip(self.box[0], foot, self.box[1])
        ):
            return None
        return max(way, 0.0), self.normal


@dataclass(frozen=True)
class BoxEdges:
    """Edges and corners of a box, met by a ball that overlaps them while its middle is beside the faces; a point meets none."""

    low: Point
    high: Point

    def meets(self, start: Point, along: Point, radius: float) -> tuple[float, Point] | None:
        """Return the same: the middle of the ball comes as near as its radius to an edge (a cylinder about it), or to a corner (a sphere)."""
        if radius <= 0.0:
            return None
        contacts = []
        for k in range(27):  # each axis: at its lower end, between both, at its upper end
            ends = (k % 3, k // 3 % 3, k // 9)
            fixed = [i for i in range(3) if ends[i] != 1]
            if len(fixed) < 2:
                continue
            at = [self.low[i] if ends[i] == 0 else self.high[i] for i in range(3)]
            met = self._near(start, along, radius, at, fixed)
            if met is not None:
                contacts.append(met)
        return min(contacts) if contacts else None

    def _near(
        self, start: Point, along: Point, radius: float, at: list[float], fixed: list[int]
    ) -> tuple[float, Point] | None:
        """Return where the distance from `at` along the axes `fixed` falls to the radius, with the foot on the edge."""
        b = sum((start[i] - at[i]) * along[i] for i in fixed)
        a = sum(along[i] ** 2 for i in fixed)
        c = sum((start[i] - at[i]) ** 2 for i in fixed) - radius * radius
        root = b * b - a * c
        if a < GRAZING**2 or root < 0.0 or b >= 0.0:
            return None
        way = (-b - math.sqrt(root)) / a
        middle = [s + way * d for s, d in zip(start, along)]
        beside = any(not self.low[i] <= middle[i] <= self.high[i] for i in range(3) if i not in fixed)
        outside = all((middle[i] - at[i]) * (1.0 if at[i] == self.high[i] else -1.0) > 0.0 for i in fixed)
        if way < -BEHIND or beside or not outside:
            return None
        x, y, z = ((middle[i] - at[i]) / radius if i in fixed else 0.0 for i in range(3))
        return max(way, 0.0), (x, y, z)


@dataclass(frozen=True)
class Round:
    """A bore (inside) or boss along Z that is touched: a point of its axis and its radius, mm; low, high: between which Z it stands.

    Its rims are not touched: the middle of the ball meets it between low and high, or passes.
    """

    point: Point
    radius: float
    inside: bool
    low: float = -math.inf
    high: float = math.inf

    def meets(self, start: Point, along: Point, radius: float) -> tuple[float, Point] | None:
        """Return the same: |start + way along - axis| = R - r inside, R + r outside (the nearer root outside, the farther inside)."""
        x, y = start[0] - self.point[0], start[1] - self.point[1]
        a, reach = along[0] ** 2 + along[1] ** 2, self.radius + (-radius if self.inside else radius)
        if a < GRAZING**2 or reach <= 0.0:
            return None
        b, c = x * along[0] + y * along[1], x * x + y * y - reach * reach
        root = b * b - a * c
        beyond = (
            c > 2.0 * reach * BEHIND if self.inside else c < -2.0 * reach * BEHIND
        )  # starts in the material
        if root < 0.0 or beyond:
            return None
        way = (-b + (math.sqrt(root) if self.inside else -math.sqrt(root))) / a
        if way < -BEHIND or not self.low - BEHIND <= start[2] + way * along[2] <= self.high + BEHIND:
            return None
        sign = -1.0 if self.inside else 1.0
        n = (sign * (x + way * along[0]) / reach, sign * (y + way * along[1]) / reach, 0.0)
        return max(way, 0.0), n


Surface = Face | BoxEdges | Round


def box_faces(low: Point, size: Point) -> tuple[Surface, ...]:
    """Return the six faces of a box, and its edges."""
    high = (low[0] + size[0], low[1] + size[1], low[2] + size[2])
    out: list[Surface] = [BoxEdges(low, high)]
    for i in range(3):
        for sign, corner in ((-1.0, low), (1.0, high)):
            normal = (sign * (i == 0), sign * (i == 1), sign * (i == 2))
            out.append(Face(corner, normal, (low, high)))
    return tuple(out)


def first_contact(
    surfaces: Sequence[Surface], start: Point, end: Point, radius: float, centre: Point = ORIGIN
) -> tuple[Point, Point, Point] | None:
    """Return (tip, unit way, outward normal) at the first touch between two tip positions, None where nothing is met.

    radius: of the ball; centre: its middle seen from the tip, mm.
    """
    length = math.dist(start, end)
    if not length:
        return None
    along = ((end[0] - start[0]) / length, (end[1] - start[1]) / length, (end[2] - start[2]) / length)
    ball = (start[0] + centre[0], start[1] + centre[1], start[2] + centre[2])
    met = [m for m in (s.meets(ball, along, radius) for s in surfaces) if m is not None and m[0] <= length]
    if not met:
        return None
    way, normal = min(met)
    return (
        (start[0] + way * along[0], start[1] + way * along[1], start[2] + way * along[2]), along, normal
    )  # fmt: skip


def stopped_at(start: Point, at: Point, end: Point) -> tuple[Point, Point, Point] | None:
    """Return a touch where a way passes a tip position, of a surface square to the way; None where it ends before or begins behind it."""
    length = math.dist(start, end)
    if not length:
        return None
    x, y, z = ((b - a) / length for a, b in zip(start, end))
    way = dot(minus(at, start), (x, y, z))
    if not -BEHIND <= way <= length:
        return None
    return (start[0] + way * x, start[1] + way * y, start[2] + way * z), (x, y, z), (-x, -y, -z)


def left_contact(
    surfaces: Sequence[Surface], start: Point, end: Point, radius: float, centre: Point = ORIGIN
) -> tuple[Point, Point, Point] | None:
    """Return (tip, unit way, outward normal) where a ball that touches at its start leaves on its way; None where it touches nothing there.

    A ball that lies on a surface leaves it at once: where it does is where it would touch on the way back.
    """
    length = math.dist(start, end)
    if not length:
        return None
    x, y, z = ((b - a) / length for a, b in zip(start, end))
    back = first_contact(surfaces, start, (start[0] - x, start[1] - y, start[2] - z), radius, centre)
    if back is None or math.dist(back[0], start) > 2.0 * BEHIND:
        return None
    return start, (x, y, z), back[2]
