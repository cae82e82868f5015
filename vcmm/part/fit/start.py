"""Start values from the points alone, in centred, scaled coordinates (see newton.State).

Plane and line: eigenvectors of the scatter matrix. Circle and sphere: linear algebraic fit, which minimises
sum (rho^2 - r^2)^2. Cylinder, cone, torus: the linear fit about each of many trial axes; the best few by
orthogonal distance are then fitted properly and the lowest wins. About fifty times slower than a nominal
start, and not safe for a torus of which less than a third of the ring was measured: that has more minima.
"""

from __future__ import annotations

import numpy as np

from vcmm.part.fit.elements import Array, Element, frames, jacobian
from vcmm.part.fit.newton import State, descend, to_local

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
    """Least squares (B, k) of design (B, k, n) against right (B, n); least norm where rank is missing."""
    matrix = design @ design.swapaxes(-1, -2)
    inverse = np.linalg.pinv(matrix, rcond=1e-13, hermitian=True)
    return (inverse @ (design @ right[..., None]))[..., 0]


def _round_fit(coordinates: Array) -> tuple[Array, Array]:
    """Centre (B, k) and radius (B,) of the algebraic circle (k = 2) or sphere (k = 3) through (B, k, n)."""
    ones = np.ones_like(coordinates[:, :1])
    solution = _linear(np.concatenate([2.0 * coordinates, ones], axis=1), np.sum(coordinates**2, axis=1))
    centre = solution[:, :-1]
    return centre, np.sqrt(np.maximum(solution[:, -1] + np.sum(centre**2, axis=-1), 1e-12))


def _about_axis(element: Element, data: Array, axis: Array) -> State:
    """Linear fit of circle, cylinder, cone or torus about a given axis direction (B, 3) through any point."""
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
    """Unit vectors (count, 3), evenly spread over half the sphere (Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    z, turn = k / count, k * np.pi * (3.0 - np.sqrt(5.0))
    return np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], axis=-1)


def _trial_axes(data: Array) -> Array:
    """Trial axes (B, k, 3): the principal axes of the points, then a lattice in their frame."""
    principal = np.swapaxes(np.linalg.eigh(data @ data.swapaxes(-1, -2))[1], -1, -2)
    return np.concatenate([principal, _hemisphere(TRIAL_AXES) @ principal], axis=1)


def _search(element: Element, free: tuple[int, ...], data: Array, axis: Array | None) -> State:
    """Best of many trial axes; with a known axis just the linear fit about it."""
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
