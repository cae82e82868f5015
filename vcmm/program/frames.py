"""Affine maps of programmed points, as controls stack them in their frames: shift, rotation, mirror, scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from vcmm.program.moves import ORIGIN, PLANES, Point, dot

Rows = tuple[Point, Point, Point]
UNITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class AffineMap(NamedTuple):
    """point -> matrix @ point + shift, mm."""

    matrix: Rows = UNITY
    shift: Point = ORIGIN

    def apply(self, p: Point) -> Point:
        if self.matrix is UNITY:
            return p[0] + self.shift[0], p[1] + self.shift[1], p[2] + self.shift[2]
        x, y, z = (dot(self.matrix[i], p) + self.shift[i] for i in range(3))
        return x, y, z

    def undo(self, p: Point) -> Point:
        """Return the point that `apply` takes to p."""
        d = (p[0] - self.shift[0], p[1] - self.shift[1], p[2] - self.shift[2])
        if self.matrix is UNITY:
            return d
        x, y, z = (dot(row, d) for row in inverse(self.matrix))
        return x, y, z

    def then(self, inner: AffineMap) -> AffineMap:
        """Return this map with another one inside it: the inner one is applied first."""
        if self.matrix is UNITY and inner.matrix is UNITY:
            return AffineMap(UNITY, self.apply(inner.shift))
        columns = list(zip(*inner.matrix))
        rows = [tuple(dot(row, (c[0], c[1], c[2])) for c in columns) for row in self.matrix]
        return AffineMap(_rows(rows), self.apply(inner.shift))


def _rows(rows: list[tuple[float, ...]]) -> Rows:
    a, b, c = ((r[0], r[1], r[2]) for r in rows)
    return a, b, c


def inverse(m: Rows) -> Rows:
    """Return the inverse, by cofactors; frames never have determinant zero (a scale of zero is refused where it is programmed)."""
    (a, b, c), (d, e, f), (g, h, i) = m
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return (
        ((e * i - f * h) / det, (c * h - b * i) / det, (b * f - c * e) / det),
        ((f * g - d * i) / det, (a * i - c * g) / det, (c * d - a * f) / det),
        ((d * h - e * g) / det, (b * g - a * h) / det, (a * e - b * d) / det),
    )


def cross(u: Sequence[float], v: Sequence[float]) -> Point:
    """Return the vector product."""
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def translation(p: Point) -> AffineMap:
    return AffineMap(UNITY, p)


def rotation(axis: int, angle: float) -> AffineMap:
    """Turn by an angle (rad, right-handed) about axis 0, 1 or 2."""
    if angle == 0.0:
        return AffineMap()
    u, v = (axis + 1) % 3, (axis + 2) % 3
    rows = [[0.0] * 3 for _ in range(3)]
    c, s = _exact(math.cos(angle)), _exact(math.sin(angle))
    rows[u][u], rows[u][v], rows[v][u], rows[v][v], rows[axis][axis] = c, -s, s, c, 1.0
    return AffineMap(_rows([tuple(r) for r in rows]))


def _exact(x: float) -> float:
    """Return the number rounded: cos 90 deg is 0, not 6e-17; a quarter turn then keeps round numbers round."""
    return float(round(x)) if abs(x - round(x)) < 1e-15 else x


def stretch(factors: Point) -> AffineMap:
    """Return the factors along the axes: -1 mirrors, others scale."""
    x, y, z = factors
    return AffineMap(((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)))


def in_plane(mapped: AffineMap, plane: str) -> tuple[float, bool] | None:
    """Return (scale, flipped) of a plane under a map; None where circles of the plane do not stay circles in that plane."""
    if mapped.matrix is UNITY:
        return 1.0, False
    first, second, normal = PLANES[plane]
    m = mapped.matrix
    a, b, c, d = m[first][first], m[first][second], m[second][first], m[second][second]
    if any(abs(m[normal][k]) > 1e-9 or abs(m[k][normal]) > 1e-9 for k in (first, second)):
        return None
    if abs(math.hypot(a, c) - math.hypot(b, d)) > 1e-9 or abs(a * b + c * d) > 1e-9:
        return None
    return math.hypot(a, c), a * d - b * c < 0


def with_axes(x: Sequence[float], z: Sequence[float]) -> AffineMap | None:
    """Return the plane square to z whose first axis is as near to x as it can be; None where the two are parallel or zero."""
    size = math.hypot(*z)
    if size < 1e-9:
        return None
    n = [v / size for v in z]
    along = sum(p * q for p, q in zip(x, n))
    first = [p - along * q for p, q in zip(x, n)]
    size = math.hypot(*first)
    if size < 1e-9:
        return None
    u = [v / size for v in first]
    v = [n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]]
    rows: Rows = tuple((_whole(u[k]), _whole(v[k]), _whole(n[k])) for k in range(3))  # type: ignore[assignment]
    return AffineMap() if rows == UNITY else AffineMap(rows)


def plane_through_angles(first: int, a: float, b: float) -> AffineMap | None:
    """Return the plane of two solid (projection) angles, rad; None where they make none.

    first: axis 0, 1 or 2 that the new first axis comes from; the next one in turn is the second, the one after it the third. Turned about
    the second by b, the first axis lies in the plane, and is its first axis; turned about the first by a, the second axis lies in it too.
    With X and Y: (cos b, 0, -sin b) and (0, cos a, sin a). Source: Siemens, SINUMERIK 840D, Function Manual Basic Functions K2, "Solid angles".
    """
    second, third = (first + 1) % 3, (first + 2) % 3
    along, across, normal = [0.0] * 3, [0.0] * 3, [0.0] * 3
    along[first], along[third] = math.cos(b), -math.sin(b)
    across[second], across[third] = math.cos(a), math.sin(a)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        normal[k] = along[i] * across[j] - along[j] * across[i]
    tilted = with_axes(along, normal)
    if tilted is None:
        return None
    return tilted.then(AffineMap((UNITY[first], UNITY[second], UNITY[third])))


def plane_of_axes(named: Sequence[int], degrees: Sequence[float | None]) -> AffineMap | None:
    """Return the plane of the solid angles of two axes, degrees by axis; None where there are not two, or where they make no plane."""
    if len(named) != 2:
        return None
    first = next(k for k in named if (k + 1) % 3 in named)  # XY, YZ, ZX
    a, b = (math.radians(degrees[k] or 0.0) for k in (first, (first + 1) % 3))
    return plane_through_angles(first, a, b)


def _whole(x: float) -> float:
    """Return a number rounded to the whole: 1 is 1, not 0.9999999999999999."""
    return float(round(x)) if abs(x - round(x)) < 1e-12 else x
