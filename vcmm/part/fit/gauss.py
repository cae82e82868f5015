"""Least-squares (Gauss, QIF LEASTSQUARES, ISO 1101 modifier G) association by orthogonal distance.

One call fits a whole batch, for example all trials of a Monte Carlo run: 10 000 cylinders of 50 points take a
fraction of a second from a nominal start.

Start values from the points alone, in centred, scaled coordinates (see newton.State).

Plane and line: eigenvectors of the scatter matrix. Circle and sphere: linear algebraic fit, which minimises
sum (rho^2 - r^2)^2. Cylinder, cone, torus: the linear fit about each of many trial axes; the best few by
orthogonal distance are then fitted properly and the lowest wins. About fifty times slower than a nominal
start, and not safe for a torus of which less than a third of the ring was measured: that has more minima.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core.errors import UsageError
from vcmm.part.fit.checks import check_convergence, check_points, check_rank, check_spread, element_of
from vcmm.part.fit.elements import (
    Array,
    Element,
    FittedElement,
    Mask,
    frames,
    free_pose,
    jacobian,
    rows_of,
    signed_residuals,
)
from vcmm.part.fit.newton import State, TurnedData, descend, to_local

TRIAL_AXES = 128
FINALISTS = 8


def algebraic_start(element: Element, free: tuple[int, ...], data: Array, axis: Array | None) -> State:
    """Start state for data (B, 3, n); `axis` (B, 3) where it is already known (circle, fixed axis)."""
    batch = len(data)
    zero, none = np.zeros((batch, 3)), np.empty((batch, 0))
    if element.kind in ("cylinder", "cone", "torus"):
        return _search(element, free, data, axis)
    if element.kind in ("plane", "line"):
        column = 0 if element.kind == "plane" else 2
        across = np.linalg.eigh(data @ data.swapaxes(-1, -2))[1][:, :, column]
        return State(zero, across if axis is None else axis, none)
    upright = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (batch, 3)) if axis is None else axis
    if element.kind == "point":
        return State(zero, upright, none)
    if element.kind == "sphere":
        centre, radius = _round_fit(data)
        return State(centre, upright, radius[:, None])
    return _about_axis(element, data, upright)


def _linear(design: Array, right: Array) -> Array:
    """Solve least squares (B, k) of design (B, k, n) against right (B, n); least norm where rank is missing."""
    matrix = design @ design.swapaxes(-1, -2)
    inverse = np.linalg.pinv(matrix, rcond=1e-13, hermitian=True)
    return (inverse @ (design @ right[..., None]))[..., 0]


def _round_fit(coordinates: Array) -> tuple[Array, Array]:
    """Return centre (B, k) and radius (B,) of the algebraic circle (k = 2) or sphere (k = 3) through (B, k, n)."""
    ones = np.ones_like(coordinates[:, :1])
    solution = _linear(np.concatenate([2.0 * coordinates, ones], axis=1), np.sum(coordinates**2, axis=1))
    centre = solution[:, :-1]
    return centre, np.sqrt(np.maximum(solution[:, -1] + np.sum(centre**2, axis=-1), 1e-12))


def _about_axis(element: Element, data: Array, axis: Array) -> State:
    """Fit a circle, cylinder, cone or torus linearly about a given axis direction (B, 3) through any point."""
    frame = frames(axis)
    local = frame @ data
    centre, radius = _round_fit(local[:, :2])
    across, height = centre, np.zeros(len(data))
    sizes = radius[:, None]
    rho = np.sqrt(np.sum((local[:, :2] - centre[..., None]) ** 2, axis=1))
    if element.kind == "cone":  # straight line of the radius over the height
        line = _linear(np.stack([np.ones_like(rho), local[:, 2]], axis=1), rho)
        sizes = np.stack([line[:, 0], np.arctan(line[:, 1])], axis=-1)
    if element.kind == "torus":  # circle in the half plane of radius and height
        middle, tube = _round_fit(np.stack([rho, local[:, 2]], axis=1))
        height = middle[:, 1]
        sizes = np.stack([middle[:, 0], tube], axis=-1)
    point = np.concatenate([across, height[:, None]], axis=-1)
    return State((point[:, None] @ frame)[:, 0], axis, sizes)


def _hemisphere(count: int) -> Array:
    """Return the unit vectors (count, 3), evenly spread over half the sphere (Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    z, turn = k / count, k * np.pi * (3.0 - np.sqrt(5.0))
    return np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], axis=-1)


def _trial_axes(data: Array) -> Array:
    """Return the trial axes (B, k, 3): the principal axes of the points, then a lattice in their frame."""
    principal = np.swapaxes(np.linalg.eigh(data @ data.swapaxes(-1, -2))[1], -1, -2)
    return np.concatenate([principal, _hemisphere(TRIAL_AXES) @ principal], axis=1)


def _search(element: Element, free: tuple[int, ...], data: Array, axis: Array | None) -> State:
    """Return the best of many trial axes; with a known axis only the linear fit about it."""
    if axis is not None:
        return _about_axis(element, data, axis)
    trials = _trial_axes(data)
    batch, count = trials.shape[:2]
    repeated = np.repeat(data, count, axis=0)
    state = _about_axis(element, repeated, trials.reshape(-1, 3))
    cost = _cost(element, repeated, state).reshape(batch, count)
    best = np.argsort(cost, axis=1, kind="stable")[:, :FINALISTS] + count * np.arange(batch)[:, None]
    finalists = State(*(a[best.ravel()] for a in state))
    repeated = np.repeat(data, best.shape[1], axis=0)
    state, done, _, _ = descend(element, free, repeated, finalists, 1e-9)
    cost = _cost(element, repeated, state) * np.where(done, 1.0, 4.0)
    winner = np.argmin(cost.reshape(batch, -1), axis=1) + best.shape[1] * np.arange(batch)
    return State(*(a[winner] for a in state))


def _cost(element: Element, data: Array, state: State) -> Array:
    """Sum of squared distances (B,); infinite for an impossible element."""
    local, _ = to_local(data, state)
    d, _, _ = jacobian(element, (), local, state.sizes)
    cost = np.sum(d * d, axis=-1)
    return np.where(np.isfinite(cost) & (state.sizes[:, 0] > 0.0), cost, np.inf)


_CHUNK = 16_384  # values per work array: the arrays of one chunk stay in the processor's cache


def gauss(
    kind: str,
    points: Array,
    start: FittedElement | None = None,
    *,
    fixed_axis: Array | None = None,
    tolerance: float = 1e-12,
) -> FittedElement:
    """Fit the least-squares element through points (..., n, 3) mm.

    start       nominal element of the same kind, alone or batched like the points; without it the start comes
                from the points (slower; see vcmm.part.fit.start). The axis of the result points the same way as
                start.axis; without start its largest component is positive.
    fixed_axis  (3,) or batched: the axis is not fitted but given, its sense included. Circle: fitted in
                projection along it, as CMMs do; a circle without it lies in the least-squares plane of its
                points, as the NIST 3-D circle does.
    tolerance   Gauss-Newton stops at a step below this, relative to the extent of the points

    The radius of a cone grows along +axis, whatever start and fixed_axis say.
    UsageError: kind, shapes, NaN. ModelLimit: too few points, a direction the points do not determine, no
    convergence. Method: Gauss-Newton on orthogonal distances (Forbes, NPL Report DITC 140/89).
    """
    element = element_of(kind)
    points = np.asarray(points, dtype=np.float64)
    check_points(element, points, fixed_axis is not None, kind)
    if start is not None and start.kind != kind:
        raise UsageError(
            f"start is a {start.kind}, but a {kind} is to be fitted. Give a start of the same kind."
        )
    batch, flat = points.shape[:-2], points.reshape(-1, *points.shape[-2:])
    begin = None if start is None else _flat_start(element, start, batch)
    axis = None if fixed_axis is None else _flatten(_unit(fixed_axis, "fixed_axis"), batch, "fixed_axis")
    if kind == "circle" and axis is None:
        bare = None if begin is None else begin._replace(sizes=np.empty((len(flat), 0)))
        axis = _associate(element_of("plane"), flat, bare, None, tolerance, "plane of the circle")[1]
    fit = _associate(element, flat, begin, axis, tolerance, kind)
    check_spread(element, flat, axis is not None, kind)
    point, axis, sizes, residuals, normals = (a.reshape(*batch, *a.shape[1:]) for a in fit)
    return FittedElement(kind, point, axis, sizes, residuals, normals)


def _flat_start(element: Element, start: FittedElement, batch: tuple[int, ...]) -> State:
    """Start as a state of the flattened batch; UsageError for a batch, axis or number that does not fit."""
    axis = _unit(start.axis, "the axis of start") if element.has_axis else start.axis
    if start.sizes.shape[-1] != len(element.sizes):
        raise UsageError(
            f"start has {start.sizes.shape[-1]} sizes, a {element.kind} has {len(element.sizes)}."
        )
    return State(*(_flatten(a, batch, "start") for a in (start.point, axis, start.sizes)))


def _unit(axis: Array, name: str) -> Array:
    """Return the axis (..., 3) at length 1; raises UsageError for a vector that is no direction."""
    axis = np.asarray(axis, dtype=np.float64)
    length = np.sqrt(np.sum(axis * axis, axis=-1, keepdims=True))
    if axis.shape[-1:] != (3,) or not (np.isfinite(length) & (length > 0.0)).all():
        raise UsageError(f"{name} must be 3 finite numbers that are not all zero, such as (0, 0, 1).")
    return axis / length


def _flatten(values: Array, batch: tuple[int, ...], name: str) -> Array:
    """Broadcast values (..., k) to the batch of the points, as (B, k)."""
    if not np.isfinite(values).all():
        raise UsageError(f"{name} holds a number that is not finite: {values}.")
    try:
        return np.broadcast_to(values, (*batch, values.shape[-1])).reshape(math.prod(batch), values.shape[-1])
    except ValueError:
        shapes = f"{name} has the batch {values.shape[:-1]}, the points have {batch}"
        raise UsageError(f"{shapes}. Give one {name}, or one for each set of points.") from None


Fit = tuple[Array, Array, Array, Array, Array]  # point, axis, sizes, residuals, normals


def _associate(
    element: Element, points: Array, start: State | None, axis: Array | None, tolerance: float, name: str
) -> Fit:
    """Fit all members (B, n, 3), chunk by chunk, then judge rank and convergence of the whole batch."""
    free = free_pose(element, axis is not None)
    size = max(1, _CHUNK // (points.shape[1] * element.rows))
    if start is None and axis is None and element.kind in ("cylinder", "cone", "torus"):
        size = max(1, 16 * size // TRIAL_AXES)
    parts = []
    for first in range(0, len(points), size):
        chunk = slice(first, first + size)
        begin = None if start is None else State(*(a[chunk] for a in start))
        fixed = None if axis is None else axis[chunk]
        parts.append(_fit_chunk(element, free, points[chunk], begin, fixed, tolerance))
    *fit, frame, matrix, done = (np.concatenate(column) for column in zip(*parts))
    check_rank(element, free, matrix, frame, name)
    check_convergence(element, done, name)
    return fit[0], fit[1], fit[2], fit[3], fit[4]


def centre_points(points: Array) -> tuple[Array, Array, Array]:
    """Return points (B, n, 3) as data (B, 3, n) about the centroid (B, 3) in units of `scale` (B, 1).

    The scale is a power of two near the rms extent, so scaling does not round.
    """
    data = np.ascontiguousarray(np.swapaxes(points, -1, -2))
    centroid = np.mean(data, axis=-1)
    data = data - centroid[..., None]
    extent = np.sqrt(np.sum(data * data, axis=(-1, -2)) / data.shape[-1])
    scale = np.exp2(np.round(np.log2(np.where(extent > 0.0, extent, 1.0))))[:, None]
    return data / scale[..., None], centroid, scale


def _fit_chunk(
    element: Element,
    free: tuple[int, ...],
    points: Array,
    start: State | None,
    axis: Array | None,
    tolerance: float,
) -> tuple[NDArray[Any], ...]:
    """Fit, then frames, normal matrices and mask of the converged members of a chunk (B, n, 3)."""
    data, centroid, scale = centre_points(points)
    unit = np.where(np.array(element.lengths, dtype=bool), scale, 1.0)
    if start is None or element.kind in ("point", "line", "plane"):
        begin = algebraic_start(element, free, data, axis)
    else:
        upright = np.array([0.0, 0.0, 1.0])
        wanted = (
            axis if axis is not None else start.axis if element.has_axis else np.tile(upright, (len(data), 1))
        )
        begin = State((start.point - centroid) / scale, wanted, start.sizes / unit)
    fitted, done, matrix, fitted_frame = descend(element, free, data, begin, tolerance)
    state = _orient(element, fitted, start, axis is not None)
    turned = TurnedData(fitted_frame, fitted_frame @ data) if state is fitted else None
    local, frame = to_local(data, state, turned)
    residuals, normals = signed_residuals(rows_of(element, local, state.sizes), frame, local[:, 0].shape)
    shown = state.axis if element.has_axis else np.zeros_like(state.axis)
    point = state.point * scale + centroid
    judged = done & _is_possible(element, state)
    return point, shown, state.sizes * unit, residuals * scale, normals, fitted_frame, matrix, judged


def _is_possible(element: Element, state: State) -> Mask:
    """Return the mask (B,) of possible states: radii positive, apex angle of a cone below 180 degrees."""
    angle = state.sizes[:, 1] if element.kind == "cone" else np.zeros(len(state.sizes))
    return np.all(state.sizes[:, : sum(element.lengths)] > 0.0, axis=-1) & (angle < 0.5 * np.pi)


def _orient(element: Element, state: State, start: State | None, is_fixed: bool) -> State:
    """Turn the axes to the promised side: cones grow; else fixed, start, or largest component positive."""
    axis = state.axis
    if element.kind == "cone":  # half a turn more is the same cone
        angle = state.sizes[:, 1:] - np.pi * np.round(state.sizes[:, 1:] / np.pi)
        sizes = np.concatenate([state.sizes[:, :1], np.abs(angle)], axis=-1)
        return State(state.point, axis * np.copysign(1.0, angle), sizes)
    if is_fixed or not element.has_axis:
        return state
    if start is None:
        along = np.take_along_axis(axis, np.argmax(np.abs(axis), axis=-1)[:, None], axis=-1)
    else:
        along = np.sum(axis * start.axis, axis=-1, keepdims=True)
    return state._replace(axis=np.where(along < 0.0, -axis, axis)) if (along < 0.0).any() else state
