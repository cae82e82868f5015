"""Gauss-Newton descent of a whole batch of elements on centred, scaled data.

Every member stops on its own and is then frozen, so its result is the same bits alone, in a batch and in any
shard. A step that would raise the sum of squares is taken back and damped (Levenberg-Marquardt); near the
nominal element that never happens and the steps are pure Gauss-Newton. Rounding in the normal equations slows
the last steps but does not move the point where J^T d = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vcmm.part.fit.elements import RX, RY, Array, Element, Mask, frames, jacobian

MAX_STEPS = 100
_EPS = float(np.finfo(np.float64).eps)


class State(NamedTuple):
    """Elements in centred, scaled coordinates: point (B, 3), unit axis (B, 3), sizes (B, s)."""

    point: Array
    axis: Array
    sizes: Array


class Equations(NamedTuple):
    """Normal equations of a state: matrix (B, p, p), gradient (B, p), cost = sum of squares (B,)."""

    matrix: Array
    gradient: Array
    cost: Array


class TurnedData(NamedTuple):
    """Element frames (B, 3, 3), and the data (B, 3, n) turned into them: all that follows from the axes alone."""

    frame: Array
    data: Array


def turned_to(data: Array, axis: Array) -> TurnedData:
    """Return the data (B, 3, n) turned into the frames of axes (B, 3)."""
    frame = frames(axis)
    return TurnedData(frame, frame @ data)


def to_local(data: Array, state: State, turned: TurnedData | None = None) -> tuple[Array, Array]:
    """Return the data (B, 3, n) in the element frames, and the frames (B, 3, 3). turned: given where it is already computed."""
    frame, along = turned or turned_to(data, state.axis)
    return along - frame @ state.point[..., None], frame


def seat(element: Element, state: State) -> State:
    """Return the same elements, their points at the foot of the centroid (the origin) where they are arbitrary."""
    along = np.sum(state.point * state.axis, axis=-1)
    if element.kind == "plane":
        return state._replace(point=along[:, None] * state.axis)
    if not element.slides:
        return state
    sizes = state.sizes
    if element.kind == "cone":  # the radius is stated at the point
        sizes = sizes - np.stack([along * np.tan(sizes[:, 1]), np.zeros_like(along)], axis=-1)
    return State(state.point - along[:, None] * state.axis, state.axis, sizes)


def _equations(
    element: Element, free: tuple[int, ...], data: Array, state: State, turned: TurnedData | None
) -> tuple[Equations, Array]:
    local, frame = to_local(data, state, turned)
    d, jac, _ = jacobian(element, free, local, state.sizes)
    matrix = jac @ jac.swapaxes(-1, -2)
    gradient = (jac @ d[..., None])[..., 0]
    return Equations(matrix, gradient, np.sum(d * d, axis=-1)), frame


def move_state(element: Element, free: tuple[int, ...], state: State, frame: Array, step: Array) -> State:
    """Return the state after the step (B, p): displacement and small rotation in the element frame, then the sizes."""
    motion = np.zeros((len(step), 5))
    motion[:, free] = step[:, : len(free)]
    point = state.point + (motion[:, None, :3] @ frame)[:, 0]
    axis = state.axis
    if RX in free or RY in free:  # w x a with w = wu u + wv v is wv u - wu v
        axis = axis + motion[:, RY, None] * frame[:, 0] - motion[:, RX, None] * frame[:, 1]
        axis = axis / np.sqrt(np.sum(axis * axis, axis=-1, keepdims=True))
    return seat(element, State(point, axis, state.sizes + step[:, len(free) :]))


def _solve(equations: Equations, damping: Array) -> Array:
    """Return the damped step (B, p). 1e-15 of the trace keeps a singular matrix solvable; rank is judged at the end."""
    p = equations.gradient.shape[-1]
    diagonal = np.einsum("bii->bi", equations.matrix)
    extra = damping[:, None] * diagonal + 1e-15 * np.sum(diagonal, axis=-1, keepdims=True) + 1e-300
    matrix = equations.matrix + extra[:, :, None] * np.eye(p)
    return np.linalg.solve(matrix, -equations.gradient[..., None])[..., 0]


def _choose(mask: Mask, yes: NamedTuple, no: NamedTuple) -> tuple[Array, ...]:
    """Choose row by row: from `yes` where mask (B,), else from `no`."""
    return tuple(np.where(mask.reshape((-1,) + (1,) * (a.ndim - 1)), a, b) for a, b in zip(yes, no))


def magnitude(state: State) -> Array:
    """Return the size (B,) of the numbers that meet in a distance, in extents of the data: it sets the rounding floor."""
    sizes = np.sum(np.abs(state.sizes), axis=-1)
    return 1.0 + np.sqrt(np.sum(state.point * state.point, axis=-1)) + sizes


def _is_done(equations: Equations, step: Array, state: State, m: int, tolerance: float) -> Mask:
    """Step (B, p) below `tolerance`, or the surface moves by less than the rounding of the distances."""
    size, length = magnitude(state), np.max(np.abs(step), axis=-1)
    change = np.einsum("bi,bij,bj->b", step, equations.matrix, step) / m
    # a long step that moves nothing is a singular matrix (a saddle), not a minimum
    rounding = (change <= (4.0 * _EPS * size) ** 2) & (length <= 1e-6 * size)
    return (length <= tolerance * size) | rounding


def _is_no_worse(cost: Array, before: Array, m: int, state: State) -> Mask:
    """Return whether a cost (B,) exceeds the one before by no more than the rounding of m distances explains."""
    rounding = 16.0 * _EPS * magnitude(state) * np.sqrt(m)
    return np.sqrt(cost) <= np.sqrt(before) * (1.0 + 1e-13) + rounding


def descend(
    element: Element, free: tuple[int, ...], data: Array, start: State, tolerance: float
) -> tuple[State, Mask, Array, Array]:
    """Descend to the least-squares state of each member; return it, the mask (B,) of the converged ones, normal matrix (B, p, p) and
    frame (B, 3, 3) there.

    data (B, 3, n): centred on the centroid and scaled to extent 1.
    """
    m = element.rows * data.shape[2]
    state = trial = seat(element, start)
    damping = np.zeros(len(data))
    done = np.zeros(len(data), dtype=bool)
    turned_data = (
        None if RX in free or RY in free else turned_to(data, trial.axis)
    )  # the axes stay as they are
    equations, frame = _equations(element, free, data, trial, turned_data)
    for _ in range(MAX_STEPS):
        step = _solve(equations, damping)
        finished = ~done & (damping < 1e-3) & _is_done(equations, step, state, m, tolerance)
        trial = move_state(element, free, state, frame, step)
        now, turned = _equations(element, free, data, trial, turned_data)
        better = ~done & _is_no_worse(now.cost, equations.cost, m, state)
        if better.all():
            state, equations, frame = trial, now, turned
        else:
            state = State(*_choose(better, trial, state))
            equations = Equations(*_choose(better, now, equations))
            frame = np.where(better[:, None, None], turned, frame)
        eased = np.where(damping > 1e-6, damping / 8.0, 0.0)
        damping = np.where(better, eased, np.maximum(8.0 * damping, 1e-3))
        done |= finished
        if done.all():
            break
    return state, done, equations.matrix, frame
