"""Lines and circles with a way of travel, in a plane: those that touch others, their meeting points, all solutions of each task.

A line has the direction t = (cos a, sin a) and lies where n.q = d, n = (-sin a, cos a) being the normal on its left. A circle has a
centre c and a radius rho, positive where it is travelled counter-clockwise; a point is a circle of radius zero. They touch, travelled the same way:

    line and circle      n.c - d = rho                     two circles     |c1 - c2| = |rho1 - rho2|

Source: T. E. Cecil, Lie Sphere Geometry, chapter 1 (oriented contact): the differences of such equations of circles are linear in x, y and rho.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from vcmm.program.frames import cross
from vcmm.program.offsetting import Vec

ROUNDING_ERROR = 1e-9  # mm, rad: what arithmetic leaves
Row = tuple[float, float, float, float]  # a x + b y + c rho = e


class DirectedLine(NamedTuple):
    """angle: rad from X; offset: of the line along its left normal, mm."""

    angle: float
    offset: float

    @property
    def direction(self) -> Vec:
        return math.cos(self.angle), math.sin(self.angle)

    @property
    def normal(self) -> Vec:
        return -math.sin(self.angle), math.cos(self.angle)

    def foot(self, point: Vec) -> Vec:
        """Return the point of the line that is nearest."""
        n = self.normal
        beside = self.offset - n[0] * point[0] - n[1] * point[1]
        return point[0] + beside * n[0], point[1] + beside * n[1]


class DirectedCircle(NamedTuple):
    """rho: radius, mm; positive counter-clockwise."""

    centre: Vec
    rho: float

    def tangent_at(self, point: Vec) -> float:
        """Return the direction of travel at a point of it, rad."""
        out = math.atan2(point[1] - self.centre[1], point[0] - self.centre[0])
        return out + math.copysign(math.pi / 2.0, self.rho)


Carrier = DirectedLine | DirectedCircle


def line_at(angle: float, touching: DirectedCircle) -> DirectedLine:
    """Return the line of this direction that touches a circle."""
    n = (-math.sin(angle), math.cos(angle))
    return DirectedLine(angle, n[0] * touching.centre[0] + n[1] * touching.centre[1] - touching.rho)


def lines_touching(a: DirectedCircle, b: DirectedCircle) -> list[DirectedLine]:
    """Return the lines with n.(a - b) = rho_a - rho_b: two lines at most; none where one circle lies in the other or both have one centre."""
    v = (a.centre[0] - b.centre[0], a.centre[1] - b.centre[1])
    apart, lift = math.hypot(*v), a.rho - b.rho
    if apart < ROUNDING_ERROR or abs(lift) > apart + ROUNDING_ERROR:
        return []
    half = math.acos(max(-1.0, min(1.0, lift / apart)))
    middle = math.atan2(v[1], v[0]) - math.pi / 2.0
    return [line_at(angle, a) for angle in {middle + half, middle - half}]


def touch_row(line: DirectedLine) -> Row:
    """Return the circles that touch a line."""
    n = line.normal
    return n[0], n[1], -1.0, line.offset


def rows_at(point: Vec, angle: float) -> tuple[Row, Row]:
    """Return the circles through a point in this direction: c = point + rho n."""
    return (1.0, 0.0, math.sin(angle), point[0]), (0.0, 1.0, -math.cos(angle), point[1])


def circles(
    rows: Iterable[Row], touching: Sequence[DirectedCircle], beside: Sequence[tuple[Vec, float]] = ()
) -> list[DirectedCircle] | None:
    """Return all circles that obey the rows and touch the others; None where these do not determine them.

    beside: points, and how far the centre is from each; used where the radius is known by a row of its own.
    """
    linear = [*rows]
    rho = next((e / c for a, b, c, e in linear if a == b == 0.0 and c), None)
    spheres: list[tuple[Vec, float, float]]  # x2 + y2 - k rho2 - 2 a x - 2 b y + 2 k rho0 rho + rest = 0
    if rho is None:
        spheres = [(t.centre, t.rho, 1.0) for t in touching]
    else:
        spheres = [(t.centre, abs(rho - t.rho), 0.0) for t in touching] + [(p, r, 0.0) for p, r in beside]
    equations = [_equation(*s) for s in spheres]
    for other in equations[1:]:
        linear.append(_difference(equations[0], other))
    kept = _independent(linear)
    if len(kept) == 3:
        return [_circle(_solve_three(kept))]
    if len(kept) < 2 or not equations:
        return None
    points = _on_sphere(kept, equations[0])
    return None if points is None else [_circle(p) for p in points]


Equation = tuple[float, float, float, float, float]  # k, and the factors of x, y, rho and 1


def _equation(centre: Vec, radius: float, k: float) -> Equation:
    """Return the equation |c - centre|^2 = (rho - radius)^2 (k = 1), or = radius^2 (k = 0)."""
    a, b = centre
    rest = a * a + b * b - radius * radius
    return k, -2.0 * a, -2.0 * b, 2.0 * radius * k, rest


def _difference(equation: Equation, other: Equation) -> Row:
    return other[1] - equation[1], other[2] - equation[2], other[3] - equation[3], equation[4] - other[4]


def _independent(rows: Sequence[Row]) -> list[Row]:
    """Return the first rows of which none follows from those before (Gram-Schmidt; 1e-7 of its length is nothing)."""
    kept: list[Row] = []
    basis: list[tuple[float, float, float]] = []
    for row in rows:
        length = math.sqrt(row[0] ** 2 + row[1] ** 2 + row[2] ** 2)
        if length < ROUNDING_ERROR:
            continue
        rest = [v / length for v in row[:3]]
        for b in basis:
            along = sum(x * y for x, y in zip(rest, b))
            rest = [x - along * y for x, y in zip(rest, b)]
        left = math.sqrt(sum(v * v for v in rest))
        if left > 1e-7 and len(basis) < 3:
            basis.append((rest[0] / left, rest[1] / left, rest[2] / left))
            kept.append((row[0] / length, row[1] / length, row[2] / length, row[3] / length))
    return kept


Triple = tuple[float, float, float]


def _solve_three(rows: Sequence[Row]) -> Triple:
    """Solve three rows by Cramer's rule."""
    a, b, c = rows
    bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
    volume = sum(x * y for x, y in zip(a[:3], bc))
    x, y, rho = ((a[3] * bc[i] + b[3] * ca[i] + c[3] * ab[i]) / volume for i in range(3))
    return x, y, rho


def _on_sphere(rows: Sequence[Row], equation: Equation) -> list[Triple] | None:
    """Return the points on the sphere of the line p + s v that two rows leave. None: all of them."""
    a, b = rows
    v = cross(a, b)
    p = _solve_three([a, b, (*v, 0.0)])
    k, fx, fy, fr, rest = equation
    size = math.sqrt(sum(x * x for x in v))
    v = (v[0] / size, v[1] / size, v[2] / size)
    square = v[0] ** 2 + v[1] ** 2 - k * v[2] ** 2
    linear = 2.0 * (p[0] * v[0] + p[1] * v[1] - k * p[2] * v[2]) + fx * v[0] + fy * v[1] + fr * v[2]
    constant = p[0] ** 2 + p[1] ** 2 - k * p[2] ** 2 + fx * p[0] + fy * p[1] + fr * p[2] + rest
    if max(abs(square), abs(linear), abs(constant)) < 1e-9 * (1.0 + sum(x * x for x in p)):
        return None
    return [(p[0] + s * v[0], p[1] + s * v[1], p[2] + s * v[2]) for s in quadratic(square, linear, constant)]


def quadratic(square: float, linear: float, constant: float) -> list[float]:
    """Return the real roots; a double one once, also where rounding makes it just complex."""
    if abs(square) < 1e-12:
        return [] if abs(linear) < 1e-12 else [-constant / linear]
    inside = linear * linear - 4.0 * square * constant
    scale = linear * linear + abs(4.0 * square * constant) + 1e-300
    if inside < -1e-9 * scale:
        return []
    root = math.sqrt(inside) if inside > 1e-12 * scale else 0.0
    return (
        [(-linear - root) / (2.0 * square), (-linear + root) / (2.0 * square)]
        if root
        else [-linear / (2.0 * square)]
    )


def _circle(p: Triple) -> DirectedCircle:
    return DirectedCircle((p[0], p[1]), p[2])


def meeting(a: Carrier, b: Carrier) -> list[Vec] | None:
    """Return the points where two cross or touch, two at most; None where they are one and the same (or parallel, where no point
    is shared)."""
    if isinstance(a, DirectedLine) and isinstance(b, DirectedLine):
        n, m = a.normal, b.normal
        across = n[0] * m[1] - n[1] * m[0]
        if abs(across) < ROUNDING_ERROR:
            return None
        return [((a.offset * m[1] - b.offset * n[1]) / across, (n[0] * b.offset - m[0] * a.offset) / across)]
    if isinstance(a, DirectedCircle) and isinstance(b, DirectedCircle):
        v = (b.centre[0] - a.centre[0], b.centre[1] - a.centre[1])
        apart = math.hypot(*v)
        if apart < ROUNDING_ERROR:
            return None
        along = (apart * apart + a.rho * a.rho - b.rho * b.rho) / (2.0 * apart)
        n = (v[0] / apart, v[1] / apart)
        return _both_sides(a.centre, n, along, a.rho)
    line, circle = (a, b) if isinstance(a, DirectedLine) else (b, a)
    assert isinstance(line, DirectedLine)
    assert isinstance(circle, DirectedCircle)
    n = line.normal
    along = line.offset - n[0] * circle.centre[0] - n[1] * circle.centre[1]
    return _both_sides(circle.centre, n, along, circle.rho)


def _both_sides(centre: Vec, n: Vec, along: float, radius: float) -> list[Vec]:
    """Return the points of a circle that lie `along` the direction n from its centre. Within 1e-6 mm of touching they touch."""
    foot = (centre[0] + along * n[0], centre[1] + along * n[1])
    if abs(along) > abs(radius) + 1e-6:
        return []
    half = math.sqrt(max(0.0, radius * radius - along * along)) if abs(along) < abs(radius) - 1e-9 else 0.0
    if not half:
        return [foot]
    return [(foot[0] - s * half * n[1], foot[1] + s * half * n[0]) for s in (1.0, -1.0)]


def touch_point(a: Carrier, b: Carrier) -> Vec | None:
    """Return the touching point of two; None where they are one and the same, or two lines."""
    if isinstance(a, DirectedLine):
        return a.foot(b.centre) if isinstance(b, DirectedCircle) else None
    if isinstance(b, DirectedLine):
        return b.foot(a.centre)
    v = (b.centre[0] - a.centre[0], b.centre[1] - a.centre[1])
    apart = math.hypot(*v)
    if apart < ROUNDING_ERROR:
        return None
    reach = a.rho if a.rho > b.rho else -a.rho  # c2 = c1 + (rho1 - rho2) w, and the point is c1 + rho1 w
    return a.centre[0] + reach * v[0] / apart, a.centre[1] + reach * v[1] / apart
