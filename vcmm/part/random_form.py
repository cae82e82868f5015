"""Families of part forms: possible shapes of a surface of which only the way of manufacture is known.

"smooth"  Gaussian random surfaces of several correlation lengths: low orders are large, as on turned, milled and ground parts
"single"  one lobe number or one wave alone, as clamping in a chuck or a vice leaves it
Both are used for a part of which nothing else is known.

Every form is orthogonal to the least-squares element of its surface (it has no size, place or direction) and has the range
largest - smallest = 1 over the whole surface. Coordinates are relative to the extent of the feature.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.pose import Array
from vcmm.part.part import Feature, centre, frame, normal, surface_point

SMOOTH, SINGLE = "smooth", "single"
LENGTHS = (0.15, 0.25, 0.45, 0.8)  # correlation lengths of "smooth" over the extent (diameter, side)
LOBES = (2, 3, 4, 5, 6, 7)
ROUND = ("circle", "cylinder", "cone", "sphere")
JITTER = 1e-8  # of the variance, so that a smooth covariance can be factorised


def random_forms(feature: Feature, points: Array, count: int, family: str, rng: np.random.Generator) -> Array:
    """Return forms (count, n) at points (n, 3) of a feature along its outward normal, range 1 over the whole surface.

    Features: line, plane, circle, cylinder, cone, sphere.
    """
    dense = whole_surface(feature)
    there, here = {SMOOTH: _smooth, SINGLE: _single}[family](feature, dense, points, count, rng)
    design = _element_motions(feature, dense)
    left, size, right = np.linalg.svd(design, full_matrices=False)
    kept = size > 1e-9 * size[0]
    coefficients = (there @ left[:, kept] / size[kept]) @ right[kept]
    there = there - coefficients @ design.T
    here = here - coefficients @ _element_motions(feature, points).T
    both = np.concatenate([there, here], axis=1)
    return np.asarray(here / (both.max(axis=1) - both.min(axis=1))[:, None])


def whole_surface(feature: Feature) -> Array:
    """Return the points (N, 3) close together over the whole feature, its edges included."""
    turn = np.arange(48) * (2 * np.pi / 48)
    if feature.kind == "circle":
        return surface_point(feature, np.arange(180) * (2 * np.pi / 180))
    if feature.kind == "line":
        return surface_point(feature, np.linspace(0.0, feature.extent[0], 61))
    if feature.kind == "plane":
        u, v = (np.linspace(-0.5, 0.5, 15) * side for side in feature.extent)
        return surface_point(feature, u[:, None], v[None, :]).reshape(-1, 3)
    if feature.kind == "sphere":
        latitude = np.arcsin(np.linspace(-1.0, 1.0, 11))
        return surface_point(feature, turn[::2, None], latitude[None, :]).reshape(-1, 3)
    along = np.linspace(0.0, feature.extent[0], 7)
    return surface_point(feature, turn[:, None], along[None, :]).reshape(-1, 3)


def _relative(feature: Feature, points: Array) -> Array:
    """Return coordinates (n, d) in shares of the extent: along u and v of a plane, direction and share of length of an axis."""
    u, v, w = frame(feature)
    arm = points - feature.point
    if feature.kind == "plane":
        return np.stack([arm @ u / feature.extent[0], arm @ v / feature.extent[1]], axis=1)
    if feature.kind == "line":
        return (arm @ w / feature.extent[0])[:, None]
    away = normal(feature, points)
    if feature.kind in ("circle", "sphere"):
        return np.asarray(0.5 * away)
    return np.concatenate([0.5 * away, (arm @ w / feature.extent[0])[:, None]], axis=1)


def _smooth(
    feature: Feature, dense: Array, points: Array, count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return Gaussian surfaces at the dense points, and their values between these (n,), each length with its share of the draws."""
    d, p = _relative(feature, dense), _relative(feature, points)
    parts = []
    for i, length in enumerate(LENGTHS):
        here = len(range(i, count, len(LENGTHS)))
        among, between = (np.exp(-_squared_distances(a, d) / (2 * length**2)) for a in (d, p))
        root = np.linalg.cholesky(among + JITTER * np.eye(len(d)))
        white = rng.standard_normal((here, len(d)))
        there = white @ root.T
        parts.append((there, np.linalg.solve(root.T, white.T).T @ between.T))
    return np.concatenate([a for a, _ in parts]), np.concatenate([b for _, b in parts])


def _squared_distances(a: Array, b: Array) -> Array:
    return np.asarray(((a[:, None, :] - b[None, :, :]) ** 2).sum(axis=2))


def _single(
    feature: Feature, dense: Array, points: Array, count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return one lobe number with any phase, one bow or saddle with any axis; equal numbers of each order."""
    order = rng.permutation(np.resize(LOBES, count))[:, None]
    phase = rng.uniform(0, 2 * np.pi, (count, 1))
    there, here = (_wave(feature, x, order, phase) for x in (dense, points))
    return there, here


def _wave(feature: Feature, points: Array, order: Array, phase: Array) -> Array:
    """Return waves (count, n): lobes round an axis; along a line; across a plane in any direction, a saddle when that is a diagonal."""
    if feature.kind in ROUND:
        u, v, _ = frame(feature)
        away = normal(feature, points)
        return np.asarray(np.cos(order * np.arctan2(away @ v, away @ u)[None] + phase))
    at = _relative(feature, points)[None]
    if feature.kind == "line":
        return np.asarray(np.cos(np.pi * (order - 1) * at[..., 0] + phase))
    across = np.cos(phase) * at[..., 0] + np.sin(phase) * at[..., 1]
    return np.asarray(np.cos(np.pi * (order // 2) * across))


def _element_motions(feature: Feature, points: Array) -> Array:
    """Return how the surface of the element moves along its normal when it is shifted, turned or sized, as (n, 7 or 8)."""
    n, arm = normal(feature, points), points - centre(feature)
    columns = [n, np.cross(arm, n), np.ones((len(points), 1))]
    if feature.kind == "cone":
        columns.append((arm @ feature.axis)[:, None])
    return np.concatenate(columns, axis=1)
