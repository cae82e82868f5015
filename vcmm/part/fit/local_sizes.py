"""Local sizes of round features from points in sections (ISO 14405-1, ISO 17450-3): two-point LP and spherical LS.

Sections are square to the least-squares axis; points belong to one section when their heights lie together. A
two-point size is the distance of two opposite points, seen from the centre of the section's least-squares circle: the
sum of their two radii, so that a pair that is not quite opposite errs by form only, not by the cosine. A spherical
size is the largest sphere with its centre in the plane of the section that holds no point of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.part.fit.criteria import associate
from vcmm.part.fit.elements import Array, FittedElement
from vcmm.part.fit.gauss import gauss

OPPOSITE = 0.02  # rad by which two points may miss being opposite
TOGETHER = 0.02  # of the radius: points whose heights differ by less lie in one section

Ints = NDArray[np.intp]


def two_point_radii(points: Array, base: FittedElement) -> Array:
    """Return half the two-point sizes (..., k) of points (..., n, 3) on the Gauss element `base`; k pairs, found on the first
    member of the batch. UsageError: not for this kind. ModelLimit: no opposite points.
    """
    points = np.asarray(points, dtype=np.float64)
    groups = [np.arange(points.shape[-2])] if base.kind == "sphere" else sections(points, base)
    radii = []
    for rows in groups:
        arms = points[..., rows, :] - _centre(points[..., rows, :], base)[..., None, :]
        if base.kind != "sphere":
            axis = base.axis[..., None, :]
            arms = arms - np.sum(arms * axis, axis=-1, keepdims=True) * axis
        radius = np.linalg.norm(arms, axis=-1)
        radii += [
            0.5 * (radius[..., i] + radius[..., j]) for i, j in _pairs(_first(arms / radius[..., None]))
        ]
    if not radii:
        raise ModelLimit(
            f"{base.kind}: no two measured points lie opposite each other within {OPPOSITE:g} rad, so there is no "
            "two-point size (LP): measure an even number of evenly spread points on every level."
        )
    return np.stack(radii, axis=-1)


def sphere_radii(points: Array, base: FittedElement) -> Array:
    """Return the radii (..., k) of the spherical sizes of points (..., n, 3) on the Gauss element `base`, one per section.

    UsageError: not for this kind. ModelLimit: a section that does not surround its sphere.
    """
    points = np.asarray(points, dtype=np.float64)
    groups = [rows for rows in sections(points, base) if len(rows) >= 3]
    if not groups:
        raise ModelLimit(
            f"{base.kind}: no section has three points, so there is no spherical size (LS); measure on levels."
        )
    circles = [
        associate("circle", "X", points[..., rows, :], fixed_axis=base.axis).element for rows in groups
    ]
    return np.stack([circle.sizes[..., 0] for circle in circles], axis=-1)


def sections(points: Array, base: FittedElement) -> list[Ints]:
    """Return the rows of the points in each section, lowest first, from the first member of the batch."""
    if base.kind not in ("circle", "cylinder"):
        raise UsageError(
            f"a {base.kind} has no sections; local sizes in sections are for circle and cylinder."
        )
    axis, point = _first(base.axis[..., None, :])[0], _first(base.point[..., None, :])[0]
    height = (_first(points) - point) @ axis
    order = np.argsort(height, kind="stable")
    radius = float(base.sizes.reshape(-1, base.sizes.shape[-1])[0, 0])
    breaks = np.flatnonzero(np.diff(height[order]) > TOGETHER * radius) + 1
    return [np.sort(rows) for rows in np.split(order, breaks)] if base.kind == "cylinder" else [order]


def _centre(points: Array, base: FittedElement) -> Array:
    """Return the centre (..., 3) of the section's least-squares circle, or of the element where it has too few points."""
    if base.kind == "sphere":
        return base.point
    if points.shape[-2] < 3:
        away = points.mean(axis=-2) - base.point
        return np.asarray(base.point + np.sum(away * base.axis, axis=-1, keepdims=True) * base.axis)
    return gauss("circle", points, fixed_axis=base.axis).point


def _first(values: Array) -> Array:
    """Return the first member (n, 3) of a batch (..., n, 3)."""
    return values.reshape(-1, *values.shape[-2:])[0]


def _pairs(directions: Array) -> list[tuple[int, int]]:
    """Pair each point with the one most nearly opposite, where it is opposite enough; every pair once."""
    along = directions @ directions.T
    partner = np.argmin(along, axis=1)
    pairs = {(min(i, int(j)), max(i, int(j))) for i, j in enumerate(partner)}
    return sorted(pair for pair in pairs if along[pair] <= -np.cos(OPPOSITE))
