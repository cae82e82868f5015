"""Common datums (A-B, ISO 5459): one datum of two or more features together, by least squares of what they fix.

Axes (cylinders, cones, lines, circles and spheres on one axis): the line through the ends of all of them. Planes in one plane: the
plane through the corners of all of them. The common datum is a feature of its own, named "A-B".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array, dot, length, unit
from vcmm.part.fit import FittedElement, normal_matrix
from vcmm.part.gps.criteria import by_criterion
from vcmm.part.part import Characteristic, Feature, centre, frame

ON_AXIS = ("line", "cylinder", "cone", "circle", "sphere")
DRAWING_TOLERANCE = 1e-6  # mm, and sine: how well the drawing must have them on one axis or in one plane


def with_common(
    c: Characteristic,
    features: Mapping[str, Feature],
    fitted: Mapping[str, FittedElement] | None = None,
    criterion: Sequence[str] = (),
) -> tuple[Mapping[str, Feature], Mapping[str, FittedElement]]:
    """Return features and fitted elements with the common datums of a characteristic. UsageError: features that have none together."""
    if not c.common:
        return features, fitted or {}
    letters = dict(zip(c.datums, criterion))
    drawn, elements = dict(features), dict(fitted or {})
    for name, members in c.common:
        nominal = [features[m] for m in members]
        drawn[name] = _drawing_feature(c, name, nominal)
        if fitted is not None and all(m in fitted for m in members):
            letter = letters.get(name, "G")
            fitted_element = _common_element(nominal, [by_criterion(m, fitted[m], letter) for m in members])
            elements[name] = replace(fitted_element, also={letter: fitted_element})
    return drawn, elements


def _drawing_feature(c: Characteristic, name: str, members: Sequence[Feature]) -> Feature:
    first = members[0]
    if all(m.kind == "plane" for m in members):
        off = [
            abs((m.point - first.point) @ first.axis) + length(np.cross(m.axis, first.axis)) for m in members
        ]
        points = np.concatenate([_corners(m, m.point, m.axis) for m in members])
        u, v, w = frame(first)
        spread = [float(np.ptp(points @ d)) for d in (u, v)]
        middle = (
            sum((0.5 * (points @ d).max() + 0.5 * (points @ d).min()) * d for d in (u, v))
            + (first.point @ w) * w
        )
        _check(c, name, float(max(off)))
        return replace(first, name=name, point=np.asarray(middle), extent=tuple(spread))
    if any(m.kind not in ON_AXIS for m in members):
        raise UsageError(
            f'"{c.name}": the common datum {name} takes planes in one plane, or features on one axis.'
        )
    points = np.concatenate([_ends(m, centre(m), m.axis) for m in members])
    axis = unit(points[-1] - points[0]) if length(points[-1] - points[0]) > DRAWING_TOLERANCE else first.axis
    along = points @ axis
    start, end = points[np.argmin(along)], points[np.argmax(along)]
    off = [length(p - start - ((p - start) @ axis) * axis) for p in points]
    _check(c, name, float(max(off)))
    if length(end - start) <= DRAWING_TOLERANCE:
        raise UsageError(f'"{c.name}": the features of {name} lie at one place; together they give no axis.')
    radius = max([float(m.sizes[0]) for m in members if len(m.sizes)] or [1.0])
    return Feature(name, "cylinder", start, axis, np.array([radius]), extent=(float(length(end - start)),))


def _check(c: Characteristic, name: str, off: float) -> None:
    if off > DRAWING_TOLERANCE:
        raise UsageError(
            f'"{c.name}": in the drawing the features of the common datum {name} are {off:.4g} mm apart from one axis or plane.'
        )


def _common_element(members: Sequence[Feature], fitted: Sequence[FittedElement]) -> FittedElement:
    first = fitted[0]
    if members[0].kind == "plane":
        points = np.concatenate([_corners(m, f.point, f.axis) for m, f in zip(members, fitted)], axis=-2)
        middle, axis = _principal(points, 0)
        axis = np.where(dot(axis, first.axis) < 0, -1.0, 1.0)[..., None] * axis
        batch = middle.shape[:-1]
        none, flat = np.zeros((*batch, 0)), np.zeros((*batch, 1))
        plain = FittedElement("plane", middle, axis, none, flat, first.normals[:1])
        return replace(plain, moments=_moments(plain, points))
    points = np.concatenate([_ends(m, f.point, f.axis) for m, f in zip(members, fitted)], axis=-2)
    middle, axis = _principal(points, 2)
    way = points[..., -1, :] - points[..., 0, :]
    axis = np.where(dot(axis, way) < 0, -1.0, 1.0)[..., None] * axis
    sizes = np.full((*middle.shape[:-1], 1), 1.0)
    return FittedElement(
        "cylinder", middle, axis, sizes, np.zeros((*middle.shape[:-1], 1)), first.normals[:1]
    )


def _moments(plane: FittedElement, points: Array) -> Array:
    """Return the normal matrix of a plane through points (..., k, 3); of the first member of a batch, whose places are those of all."""
    point, axis = (a.reshape(-1, 3)[0] for a in (plane.point, plane.axis))
    return normal_matrix(
        replace(plane, point=point, axis=axis, sizes=np.zeros(0)), points.reshape(-1, *points.shape[-2:])[0]
    )


def _ends(feature: Feature, point: Array, axis: Array) -> Array:
    """Ends (..., 2, 3) of an axis, or its centre (..., 1, 3), about a point of the element in the middle of its points."""
    if not feature.extent:
        return point[..., None, :]
    half = 0.5 * feature.extent[0]
    return np.stack([point - half * axis, point + half * axis], axis=-2)


def _corners(feature: Feature, point: Array, axis: Array) -> Array:
    """Return the corners (..., 4, 3) of a plane in the direction of its nominal rectangle."""
    u, v, _ = frame(feature)
    places = [0.5 * (a * feature.extent[0] * u + b * feature.extent[1] * v) for a in (-1, 1) for b in (-1, 1)]
    arms = [p + feature.point - point for p in places]
    return np.stack([point + arm - dot(arm, axis)[..., None] * axis for arm in arms], axis=-2)


def _principal(points: Array, which: int) -> tuple[Array, Array]:
    """Return the mean (..., 3) of points (..., k, 3) and the direction of least (0) or most (2) spread."""
    middle = points.mean(axis=-2)
    arms = points - middle[..., None, :]
    return middle, np.linalg.eigh(np.einsum("...ki,...kj->...ij", arms, arms))[1][..., which]
