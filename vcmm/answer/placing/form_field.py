"""Form of the real surface as a random field, for the part of the form that a few points do not see.

Zero mean, given standard deviation along the normal. Round features: lobes 2 to 15 in the angle (power falling as 1/k^2,
as on turned and ground parts), constant, linear and quadratic along the axis, barrel and bend; planes and lines: Legendre
polynomials of degree 2 to 5 (1/k^2); spheres: spherical harmonics of degree 2 to 6. A known form of the drawing,
`form = { lobes, amplitude }`, is added with a phase that is not known. LOCAL_VARIANCE_SHARE of the variance differs from point to point.
What a fit over the whole surface would take up is projected out: it is size, place and direction, not form.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vcmm.answer.placing.motions import Motions
from vcmm.core.pose import Array
from vcmm.part.form import ROUND, Lobes
from vcmm.part.part import Feature, frame, normal, surface_point

DEFAULT = 0.5e-3  # mm: standard deviation of the form where none is stated
LOCAL_VARIANCE_SHARE = 0.1
LOBES, DEGREE, HARMONICS = 15, 5, 6


def form_factor(
    motions: Motions, points: Array, spread: float, lobes: Lobes | None, reference: tuple[Array, Array]
) -> tuple[Array, float]:
    """Return (factor (n, k), standard deviation of the short part) mm: form = factor @ standard normals.

    reference: points and normals all over the measured surface: there the fit sees nothing of the field, and its
    variance has the mean spread^2 (1 - LOCAL_VARIANCE_SHARE).
    """
    feature = motions.feature
    shape = _basis(feature)
    there, here = shape(reference[0]), shape(points)
    jac = motions.rows(*reference)
    taken = np.linalg.lstsq(jac, there, rcond=None)[0]
    normals = normal(feature, points)
    there, here = there - jac @ taken, here - motions.rows(points, normals) @ taken
    size = np.sqrt(np.mean(np.sum(there**2, axis=1))) if there.shape[1] else 0.0
    factor = (
        here * (spread * np.sqrt(1.0 - LOCAL_VARIANCE_SHARE) / size)
        if size > 1e-12
        else np.zeros((len(points), 0))
    )
    if lobes is not None and feature.kind in ROUND:
        around = lobes.lobes * _angle(feature, points)
        stated = np.abs(lobes.amplitude) / np.sqrt(2.0) * np.stack([np.cos(around), np.sin(around)], axis=1)
        factor = np.concatenate([factor, stated], axis=1)
    return factor, spread * np.sqrt(LOCAL_VARIANCE_SHARE)


def _basis(feature: Feature) -> Callable[[Array], Array]:
    """Return points (n, 3) -> columns (n, k), each of the weight that its power has."""
    if feature.kind in ("plane", "line"):
        return lambda points: _polynomials(feature, points)
    if feature.kind == "sphere":
        return lambda points: _spherical(feature, points)
    if feature.kind in ("circle", "cylinder", "cone", "torus"):
        return lambda points: _lobe_columns(feature, points)
    return lambda points: np.zeros((len(points), 0))


def _angle(feature: Feature, points: Array) -> Array:
    u, v, _ = frame(feature)
    arm = points - feature.point
    return np.asarray(np.arctan2(arm @ v, arm @ u))


def _lobe_columns(feature: Feature, points: Array) -> Array:
    angle = _angle(feature, points)
    along = np.zeros(len(points))
    if feature.extent:
        along = 2.0 * ((points - feature.point) @ feature.axis) / feature.extent[0] - 1.0
    if feature.kind == "torus":
        tube = feature.sizes[1]
        along = ((points - feature.point) @ feature.axis) / tube
    columns = []
    for degree in range(3 if feature.extent or feature.kind == "torus" else 1):
        height = np.polynomial.Legendre.basis(degree)(along) * np.sqrt(2 * degree + 1) / (1 + degree)
        for k in range(LOBES + 1):
            weight = 1.0 / max(k, 2) * height
            columns += [weight * np.cos(k * angle)] + ([weight * np.sin(k * angle)] if k else [])
    return np.stack(columns, axis=1)


def _polynomials(feature: Feature, points: Array) -> Array:
    u, v, w = frame(feature)
    arm = points - feature.point
    if feature.kind == "line":
        s = 2.0 * (arm @ w) / feature.extent[0] - 1.0
        legendre = [np.polynomial.Legendre.basis(k)(s) * np.sqrt(2 * k + 1) / k for k in range(2, DEGREE + 1)]
        return np.stack(legendre, axis=1)
    a, b = 2.0 * (arm @ u) / feature.extent[0], 2.0 * (arm @ v) / feature.extent[1]
    columns = []
    for i in range(DEGREE + 1):
        for j in range(DEGREE + 1 - i):
            if i + j >= 2:
                scale = np.sqrt((2 * i + 1) * (2 * j + 1)) / (i + j)
                columns.append(
                    scale * np.polynomial.Legendre.basis(i)(a) * np.polynomial.Legendre.basis(j)(b)
                )
    return np.stack(columns, axis=1)


def _spherical(feature: Feature, points: Array) -> Array:
    from scipy.special import sph_harm_y

    arm = (points - feature.point) / np.linalg.norm(points - feature.point, axis=1, keepdims=True)
    polar, turn = np.arccos(np.clip(arm[:, 2], -1.0, 1.0)), np.arctan2(arm[:, 1], arm[:, 0])
    columns = []
    for degree in range(2, HARMONICS + 1):
        for order in range(degree + 1):
            y = np.sqrt(4 * np.pi) / degree * sph_harm_y(degree, order, polar, turn)
            columns += [y.real] if order == 0 else [np.sqrt(2.0) * y.real, np.sqrt(2.0) * y.imag]
    return np.stack(columns, axis=1)


def surface_grid(feature: Feature, n: int = 24, margin: float = 0.0) -> Array:
    """Return the points (k, 3) spread evenly over a feature, `margin` mm inside its edges; the nominal points of kind points, none of a mesh."""
    turn = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    if feature.kind == "plane":
        a, b = (np.linspace(-1.0, 1.0, _odd(n)) * max(0.5 * e - margin, 0.25 * e) for e in feature.extent)
        return surface_point(feature, *(g.ravel() for g in np.meshgrid(a, b, indexing="ij")))
    if feature.kind in ("cylinder", "cone"):
        inner = min(margin, 0.25 * feature.extent[0])
        along = np.linspace(inner, feature.extent[0] - inner, max(5, _odd(n // 4)))
        return surface_point(feature, *(g.ravel() for g in np.meshgrid(turn, along, indexing="ij")))
    if feature.kind == "line":
        inner = min(margin, 0.25 * feature.extent[0])
        return surface_point(feature, np.linspace(inner, feature.extent[0] - inner, n))
    if feature.kind == "circle":
        return surface_point(feature, turn)
    if feature.kind == "sphere":
        count = np.arange(8 * n)
        return surface_point(
            feature, count * np.pi * (3.0 - np.sqrt(5.0)), np.arcsin(1.0 - 2.0 * (count + 0.5) / (8 * n))
        )
    if feature.kind == "torus":
        tube = np.linspace(0.0, 2.0 * np.pi, n // 2, endpoint=False)
        return surface_point(feature, *(g.ravel() for g in np.meshgrid(turn, tube, indexing="ij")))
    if feature.nominal is not None:
        return feature.nominal.points
    return feature.point[None] if feature.kind == "point" else np.zeros((0, 3))


def _odd(n: int) -> int:
    return max(3, n // 2 * 2 + 1)
