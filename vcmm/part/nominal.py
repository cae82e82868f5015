"""Surfaces known by nominal points and normals only, as a CAD system exports them for inspection.

Next to a nominal point p with normal n the surface is that of second order: a point at h along n and t beside it lies

    d = h + k t^2 / (2 (1 + k h))        outside it, k the curvature of the surface in the direction of t

(expanded from the circle: (R + d)^2 = (R + h)^2 + t^2). The curvature is read from how the normals of the neighbours turn:
the symmetric map S with n_j - n = S (p_j - p), by least squares, smallest where the neighbours say nothing (square to a row
of points). It is exact on circles, cylinders and spheres, however coarse the points are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.core.pose import Array, Pose, dot, length, read_only_copy, unit

NEIGHBOURS = 6
SAME_FACE = 0.7071  # cosine: a neighbour whose normal is turned by more than 45 deg lies round an edge and tells no curvature
FLAT = 0.1  # of the largest singular value: directions in which the neighbours hardly spread
LEAST_RADIUS = 0.2  # of 1 + k h: a point so near to the centre of curvature has no foot worth the name
LEAST_POINTS = 3


@dataclass(frozen=True, eq=False)
class NominalPoints:
    """Nominal points (n, 3) mm and outward normals (n, 3), made of length 1. DataError: shapes, fewer than three, two at one place."""

    points: Array
    normals: Array

    def __post_init__(self) -> None:
        points, normals = (np.asarray(a, dtype=np.float64) for a in (self.points, self.normals))
        _check(points, normals)
        object.__setattr__(self, "points", read_only_copy(points))
        object.__setattr__(self, "normals", read_only_copy(unit(normals)))

    @cached_property
    def tree(self) -> object:
        from scipy.spatial import KDTree

        return KDTree(self.points)

    @cached_property
    def _neighbours(self) -> tuple[Array, npt.NDArray[np.intp]]:
        count = min(NEIGHBOURS + 1, len(self.points))
        apart, which = self.tree.query(self.points, count)  # type: ignore[attr-defined]
        return apart[:, 1:], which[:, 1:]

    @cached_property
    def reach(self) -> Array:
        """Distance beside each point to which the surface is taken as known, (n,) mm: that of its second nearest neighbour."""
        return self._neighbours[0][:, 1]

    @cached_property
    def curvature(self) -> Array:
        """Curvature as symmetric maps S (n, 3, 3) 1/mm, with no part along the normals."""
        apart, which = self._neighbours
        axes = np.linalg.svd(self.normals[:, None, :])[2][
            :, 1:
        ]  # (n, 2, 3): two directions square to each normal
        way, turn = (
            np.einsum("nki,nai->nka", a[which] - a[:, None], axes) / apart[..., None]
            for a in (self.points, self.normals)
        )
        same = (self.normals[which] * self.normals[:, None]).sum(axis=2) > SAME_FACE
        x, y, none = (way[..., 0] * same, way[..., 1] * same, np.zeros(same.shape))
        half = np.sqrt(0.5)  # the smallest S in its own norm counts the mixed entry twice
        rows = np.stack([np.stack([x, half * y, none], -1), np.stack([none, half * x, y], -1)], axis=2)
        flat = rows.reshape(len(rows), -1, 3)
        curvature = np.linalg.pinv(flat, rcond=FLAT) @ (turn * same[..., None]).reshape(len(rows), -1, 1)
        a, b, c = np.moveaxis(curvature[..., 0], -1, 0)
        plane = np.stack([np.stack([a, half * b], -1), np.stack([half * b, c], -1)], axis=1)
        return np.asarray(np.swapaxes(axes, 1, 2) @ plane @ axes)

    def nearest(self, points: Array) -> npt.NDArray[np.intp]:
        """Return the number of the nominal point nearest to each of points (..., 3), as (...)."""
        return np.asarray(self.tree.query(points)[1], dtype=np.intp)  # type: ignore[attr-defined]

    def to_frame(self, b_from_a: Pose) -> NominalPoints:
        """Return the same points in another frame."""
        return NominalPoints(b_from_a.apply(self.points), b_from_a.turn(self.normals))


def _check(points: Array, normals: Array) -> None:
    if points.ndim != 2 or points.shape[1:] != (3,) or points.shape != normals.shape:
        raise DataError(
            f"nominal points and normals must both be (n, 3), not {points.shape} and {normals.shape}."
        )
    if len(points) < LEAST_POINTS:
        raise DataError(f"{len(points)} nominal points make no surface; give {LEAST_POINTS} or more.")
    if not (np.all(np.isfinite(points)) and np.all(np.isfinite(normals))):
        raise DataError("nominal points and normals must be finite numbers.")
    if np.any(length(normals) < 0.5):
        bad = int(np.argmin(length(normals)))
        raise DataError(
            f"nominal point {bad + 1}: its normal has the length {length(normals)[bad]:.3g}; give a unit vector."
        )
    _, first, which = np.unique(points, axis=0, return_index=True, return_inverse=True)
    if len(first) < len(points):
        again = int(np.flatnonzero(first[which.ravel()] != np.arange(len(points)))[0])
        raise DataError(f"nominal point {again + 1} is in the file twice; remove one of the two.")


def distance_and_normal(surface: NominalPoints, points: Array) -> tuple[Array, Array]:
    """Return the distance (...) of points (..., 3) mm from the surface, + outwards, and the normals (..., 3) where they lie nearest to it."""
    near = surface.nearest(points)
    n, s = surface.normals[near], surface.curvature[near]
    height, beside = _parts(points - surface.points[near], n)
    turned = np.einsum("...ij,...j->...i", s, beside)
    stretch = _stretch(turned, beside, height)
    return height + 0.5 * dot(beside, turned) / stretch, unit(n + turned / stretch[..., None])


def travel_onto(
    surface: NominalPoints, feet: tuple[Array, Array], start: Array, way: Array, radius: Array
) -> Array:
    """Return the travel (..., m) along way (m, 3) from start (..., m, 3) until a ball of radius (m,) touches the surface next to feet (points
    and normals (m, 3) on it). The error of the tangent plane, t^2 / 2 (R + r), is 4 nm for 10 um beside a radius of 12 mm.
    """
    points, n = feet
    arm = start - points
    travel = (radius - (arm * n).sum(axis=-1)) / (way * n).sum(axis=-1)
    _, beside = _parts(arm + travel[..., None] * way, n)
    turned = np.einsum("mij,...mj->...mi", surface.curvature[surface.nearest(points)], beside)
    sunk = 0.5 * dot(beside, turned) / _stretch(turned, beside, radius)
    return np.asarray(travel - sunk / (way * n).sum(axis=-1))


def distance_beside_known(surface: NominalPoints, points: Array) -> Array:
    """Return how far (n,) mm points (n, 3) lie beside their nominal point beyond where the surface is known; negative or 0 within."""
    near = surface.nearest(points)
    _, beside = _parts(points - surface.points[near], surface.normals[near])
    return np.asarray(length(beside) - surface.reach[near])


def _parts(arm: Array, normals: Array) -> tuple[Array, Array]:
    """Split an arm into its part along the normals (...), and beside them (..., 3)."""
    height = (arm * normals).sum(axis=-1)
    return height, arm - height[..., None] * normals


def _stretch(turned: Array, beside: Array, height: Array) -> Array:
    """Return 1 + k h (...), the factor by which the parallel surface at height h is wider than the surface."""
    square = dot(beside, beside)
    bend = np.where(square > 0.0, dot(beside, turned) / np.where(square > 0.0, square, 1.0), 0.0)
    return np.asarray(np.maximum(1.0 + bend * height, LEAST_RADIUS))
