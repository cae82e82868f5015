"""Sensitivity of a fitted element to small displacements of its points: analytic, from the Jacobian of the fit.

At a least-squares fit J^T d = 0. A displacement dx_i of point i changes d_i by n_i . dx_i, so the element
moves by -(J^T J)^-1 J^T (n . dx) (Forbes, Appl. Sci. 12 (2022) 2808). The terms left out are of the order
residual / radius.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.part.fit.checks import check_points, check_rank, element_of
from vcmm.part.fit.elements import RX, RY, Array, Element, FittedElement, frames, free_pose, jacobian
from vcmm.part.fit.gauss import centre_points


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives with respect to the displacement (n, 3) of each point: lengths in mm/mm, angles in rad/mm.

    point       (3, n, 3)
    axis        (3, n, 3)
    sizes       (s, n, 3)
    residuals   (n, n, 3), None unless requested: n^2 numbers, which only form needs
    deviations  (n, 3, n, 3) for point and line only: the vector from the element to each point. Its length
                is the residual, which itself has no derivative where it is 0.
    """

    point: Array
    axis: Array
    sizes: Array
    residuals: Array | None
    deviations: Array | None = None


@dataclass(frozen=True, eq=False)
class _Linear:
    """An element at its data in scaled units; columns of the Jacobian: `free` motions, then sizes."""

    element: Element
    free: tuple[int, ...]
    frame: Array  # (3, 3) rows u, v, a
    offset: Array  # (3,) from the element's point to the centroid of the data
    jac: Array  # (p, k, n)
    normals: Array  # (k, n, 3)
    scale: float


def sensitivity(
    fitted: FittedElement, points: Array, *, fixed_axis: Array | None = None, residuals: bool = True
) -> Sensitivity:
    """Return the sensitivity of `fitted` = gauss(kind, points (n, 3), fixed_axis=fixed_axis): one element, no batch.

    residuals=False leaves out those of the residuals, in memory and time proportional to n.
    First order in the displacement; the relative error is of the order residual / radius.
    UsageError: a batch, or points that are not those of the fit. ModelLimit: an undetermined direction.
    """
    element, points = element_of(fitted.kind), np.asarray(points, dtype=np.float64)
    has_axis = fixed_axis is not None
    check_points(element, points, has_axis, fitted.kind)
    if points.ndim != 2 or fitted.residuals.shape != points.shape[:1]:
        have, want = fitted.residuals.shape, points.shape
        raise UsageError(
            f"sensitivity takes one fit and its points (n, 3), not residuals {have}, points {want}."
        )
    free = free_pose(element, has_axis)
    if fitted.kind != "circle" or has_axis:
        linear = _linearise(element, free, fitted, points)
        return _assemble(linear, fitted, *_answer(linear, None, residuals))
    plane = element_of("plane")  # the plane of a circle is fitted first and answers first
    tilt = _answer(_linearise(plane, free_pose(plane, False), fitted, points), None, False)[0][1:]
    linear = _linearise(element, (*free, RX, RY), fitted, points)
    return _assemble(linear, fitted, *_answer(linear, tilt, residuals))


def _linearise(element: Element, free: tuple[int, ...], fitted: FittedElement, points: Array) -> _Linear:
    data, centroid, unit = centre_points(points[None])
    scale = float(unit[0, 0])
    axis = fitted.axis if element.has_axis else np.array([0.0, 0.0, 1.0])
    frame, offset = frames(axis), (centroid[0] - fitted.point) / scale
    sizes = fitted.sizes[: len(element.sizes)] / np.where(np.array(element.lengths, dtype=bool), scale, 1.0)
    _, jac, rows = jacobian(element, free, (frame @ (data[0] + offset[:, None]))[None], sizes[None])
    normals = [np.stack([np.broadcast_to(c, (1, len(points)))[0] for c in row[1]], axis=-1) for row in rows]
    jac = jac[0].reshape(-1, element.rows, len(points))
    return _Linear(
        element=element, free=free, frame=frame, offset=offset, jac=jac, normals=np.stack(normals) @ frame, scale=scale
    )  # fmt: skip


def _answer(linear: _Linear, tilt: Array | None, residuals: bool) -> tuple[Array, Array | None]:
    """Return the change (p, n, 3) of motions and sizes and (k, n, n, 3) of distances per displacement, in scaled units.

    tilt (2, n, 3): RX and RY where they are known beforehand (circle) instead of fitted. A point's displacement changes only its own
    distance, by its normal, so no array of n^2 numbers is needed.
    """
    p, k, n = linear.jac.shape
    answer = np.zeros((p, n, 3))
    fitted = np.ones(p, dtype=bool)
    fixed: list[int] = []
    if tilt is not None:
        fixed = [linear.free.index(RX), linear.free.index(RY)]
        answer[fixed], fitted[fixed] = tilt, False
    jac = linear.jac[fitted].reshape(-1, k * n)
    free = tuple(motion for motion, is_fitted in zip(linear.free, fitted) if is_fitted)
    check_rank(linear.element, free, (jac @ jac.T)[None], linear.frame[None], linear.element.kind)
    inverse = np.linalg.pinv(jac.T)
    answer[fitted] = -np.einsum("qkn,knc->qnc", inverse.reshape(-1, k, n), linear.normals)
    if tilt is not None:
        answer[fitted] -= np.tensordot(inverse @ linear.jac[fixed].reshape(2, k * n).T, tilt, axes=1)
    if not residuals:
        return answer, None
    change = np.tensordot(linear.jac, answer, axes=(0, 0))
    change[:, np.arange(n), np.arange(n)] += linear.normals
    return answer, change


def _assemble(linear: _Linear, fitted: FittedElement, answer: Array, change: Array | None) -> Sensitivity:
    """Convert motions in the element frame and scaled units to point, axis, sizes and residuals."""
    element, frame, n = linear.element, linear.frame, answer.shape[1]
    motion = np.zeros((5, n, 3))
    motion[list(linear.free)] = answer[: len(linear.free)]
    turn = np.tensordot(np.stack([frame[1], frame[0]]), motion[RX:] * [[[-1.0]], [[1.0]]], axes=(0, 0))
    point = np.tensordot(frame.T, motion[:3], axes=1)
    sizes = answer[len(linear.free) :] / np.where(element.lengths, 1.0, linear.scale)[:, None, None]
    if element.slides:  # the point follows the foot of the centroid
        slide = frame[2] / n + np.tensordot(linear.offset, turn, axes=1)
        point = point + frame[2][:, None, None] * slide
        if element.kind == "cone":
            sizes[0] += np.tan(fitted.sizes[1]) * slide
    if element.kind == "plane":
        point = point + ((np.eye(3) - np.outer(frame[2], frame[2])) / n)[:, None, :]
    if change is None:
        return Sensitivity(point, turn / linear.scale, sizes, None)
    if element.rows == 1:
        return Sensitivity(point, turn / linear.scale, sizes, change[0])
    across = linear.normals[:, 0]  # (k, 3): the same at every point
    weight = fitted.normals @ across.T  # (n, k)
    residuals = np.einsum("ik,kijc->ijc", weight, change)
    deviations = np.einsum("kx,kijc->ixjc", across, change)
    return Sensitivity(point, turn / linear.scale, sizes, residuals, deviations)


def linear_fit(fitted: FittedElement, sens: Sensitivity, displacement: Array) -> FittedElement:
    """Return the first-order fit after displacements (..., n, 3) mm of the points: a batch of elements like gauss().

    Axis renormalised; normals stay those of `fitted`, except for point and line, whose residuals are lengths
    of vectors. The radius of a full circle of 25 points, R 25 mm, 1 um noise, is within 0.1 nm of gauss().
    UsageError: displacement of another number of points.
    """
    displacement = np.asarray(displacement, dtype=np.float64)
    assert sens.residuals is not None
    n = sens.residuals.shape[0]
    if displacement.shape[-2:] != (n, 3):
        raise UsageError(f"displacement must have the shape (..., {n}, 3), got {displacement.shape}.")
    batch = displacement.shape[:-2]
    flat = displacement.reshape(*batch, 3 * n)
    axis = fitted.axis + _apply(sens.axis, flat)
    if element_of(fitted.kind).has_axis:
        axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    if sens.deviations is None:
        residuals = fitted.residuals + _apply(sens.residuals, flat)
        normals = np.broadcast_to(fitted.normals, (*batch, n, 3))
    else:
        moved = _apply(sens.deviations.reshape(3 * n, n, 3), flat).reshape(*batch, n, 3)
        residuals, normals = _lengths(fitted.residuals[:, None] * fitted.normals + moved, fitted.normals)
    point, sizes = fitted.point + _apply(sens.point, flat), fitted.sizes + _apply(sens.sizes, flat)
    return FittedElement(fitted.kind, point, axis, sizes, residuals, normals)


def _apply(operator: Array, flat: Array) -> Array:
    """Apply an operator (k, n, 3) to displacements (..., 3 n): (..., k)."""
    return flat @ operator.reshape(len(operator), flat.shape[-1]).T


def _lengths(vectors: Array, otherwise: Array) -> tuple[Array, Array]:
    """Return the length (..., n) and direction of vectors (..., n, 3); `otherwise` (n, 3) where the length is 0."""
    length = np.linalg.norm(vectors, axis=-1)
    some = (length > 0.0)[..., None]
    return length, np.where(some, vectors / np.where(some, length[..., None], 1.0), otherwise)
