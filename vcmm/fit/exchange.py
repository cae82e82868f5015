"""Elements that touch: minimax, circumscribed, inscribed and tangent elements of a whole batch.

Each step solves the problem with distances replaced by their tangents (the Jacobian that the Gauss fit uses); the
solution names the points of contact, the next step starts from there. Where the contacts determine the element
that is Newton's method on their equations; where they do not (a circumscribed circle that touches at two points)
the curvature of the distances of the touching points completes it. A step that would make the result worse is
taken back and shortened. Sequential programming for minimax problems: Madsen, J. Inst. Maths Applics 16 (1975) 321;
geometry: Anthony et al., NPL Report DITC 228/93 (Chebyshev), Forbes.

In coordinates scaled by the extent of the data, as in vcmm.fit.newton.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vcmm.fit.elements import Array, Element, Mask, Triple, frames, jacobian, pose_column
from vcmm.fit.newton import State, magnitude, moved, seated, to_local

MOST_STEPS = 100
FAR = 10.0  # a first step longer than this many ranges of the distances: the points do not surround the element
_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Goal:
    """What is wanted of the signed distances d of the points.

    two_sided   the largest |d| becomes smallest; else the largest d
    sized       sizes take part; else they stand still and the level is the change of the radius
    tangent     the sum of d^2 becomes smallest while no d is positive; no level
    sign        -1 turns the distances round (inscribed; material on the other side)
    """

    two_sided: bool = False
    sized: bool = False
    tangent: bool = False
    sign: float = 1.0

    @property
    def convex(self) -> bool:
        """Circumscribed: distances from a centre or axis curve upwards, which decides where contacts leave room."""
        return self.sign > 0.0 and not self.sized


class Settled(NamedTuple):
    """State; level (B,), 0 for a tangent element; contacts, lost and done, all masks."""

    state: State
    level: Array
    contacts: Mask  # (B, n)
    lost: Mask  # (B,): the first step ran away
    done: Mask  # (B,)


class Local(NamedTuple):
    """Signed distances d (B, n), their Jacobian (B, p, n), local points (B, 3, n), frames (B, 3, 3)."""

    d: Array
    jac: Array
    local: Array
    frame: Array
    normal: Triple


def linearised(element: Element, free: tuple[int, ...], goal: Goal, data: Array, state: State) -> Local:
    local, frame = to_local(data, state)
    d, jac, rows = jacobian(element, free, local, state.sizes)
    if not goal.sized:
        jac = jac[:, : len(free)]
    return Local(goal.sign * d, goal.sign * jac, local, frame, rows[0][1])


def _top(goal: Goal, d: Array) -> Array:
    """What is to become smallest (B,): the largest distance, or the sum of squares of a tangent element."""
    if goal.tangent:
        return np.sum(d * d, axis=-1)
    return np.max(np.abs(d) if goal.two_sided else d, axis=-1)


def crosswise(element: Element, free: tuple[int, ...], at: Local) -> tuple[list[Array], Array]:
    """How far the place that a point touches is moved along the surface of a circle, cylinder or sphere: one or two
    rows (B, p, n) per unit of each motion; and the distance rho (B, n) from centre or axis.
    """
    x, y, z = at.local[:, 0], at.local[:, 1], at.local[:, 2]
    height = z if element.kind == "sphere" else np.zeros_like(z)
    rho = np.maximum(np.sqrt(x * x + y * y + height * height), 1e-150)
    if element.kind == "sphere":
        turned = frames(np.stack([x, y, z], axis=-1) / rho[..., None])
        across: list[Triple] = [(turned[..., k, 0], turned[..., k, 1], turned[..., k, 2]) for k in (0, 1)]
    else:
        across = [(-y / rho, x / rho, 0.0)]
    columns = [[np.broadcast_to(pose_column(m, at.local, t), x.shape) for m in free] for t in across]
    return [np.stack(each, axis=1) for each in columns], rho


def _curvature(element: Element, free: tuple[int, ...], at: Local, weight: Array) -> Array:
    """Second derivative (B, p, p) of the weighted distances from a centre or axis: (1 - n n') / rho of each point."""
    rows, rho = crosswise(element, free, at)
    return sum(
        ((row * (weight / rho)[:, None]) @ row.swapaxes(-1, -2) for row in rows), np.zeros(1)
    )


def _metric(jac: Array) -> Array:
    """Mean square (B, p, p) by which a step moves the distances."""
    return jac @ jac.swapaxes(-1, -2) / jac.shape[-1]


class _Step(NamedTuple):
    step: Array  # (B, p)
    level: Array  # (B,) that the tangents promise
    weight: Array  # (B, n)


def _minimax(at: Local, goal: Goal, metric: Array, rounding: Array) -> _Step:
    from vcmm.fit._nearest_kernels import minimax_steps, tangent_steps

    step, level = np.zeros(at.jac.shape[:2]), np.zeros(len(at.d))
    weight = np.zeros(at.d.shape)
    jac, d = np.ascontiguousarray(at.jac), np.ascontiguousarray(at.d)
    if goal.tangent:
        tangent_steps(jac, d, metric, rounding, step, weight)
    else:
        minimax_steps(jac, d, goal.two_sided, metric, rounding, step, level, weight)
    return _Step(step, level, weight)


def settle(element: Element, free: tuple[int, ...], goal: Goal, data: Array, start: State) -> Settled:
    """Element of each member (B, 3, n) that fulfils the goal, from a start near it (the Gauss element)."""
    batch, n = len(data), data.shape[2]
    state = seated(element, start)
    damping = _first_damping(element, free, goal, data, state)
    least, weight = 1e-4 * damping, np.zeros((batch, n))
    lost, done = np.zeros(batch, dtype=bool), np.zeros(batch, dtype=bool)
    for round_ in range(MOST_STEPS):
        on = np.flatnonzero(~done & ~lost)
        if len(on) == 0:
            break
        here = State(*(a[on] for a in state))
        at = linearised(element, free, goal, data[on], here)
        size = magnitude(here)
        metric = _metric(at.jac)
        if not goal.tangent:
            lift = 1e-9 * np.einsum("bii->b", metric)[:, None, None] * np.eye(metric.shape[1])
            metric = damping[on, None, None] * (metric + lift)
        if goal.convex:
            metric = metric + _curvature(element, free, at, weight[on])
        found = _minimax(at, goal, metric, 4.0 * _EPS * size)
        shift = np.abs(np.einsum("bp,bpn->bn", found.step, at.jac)).max(axis=-1)
        before = _top(goal, at.d)
        if round_ == 0 and not goal.sized:
            lost[on] = shift > FAR * np.ptp(at.d, axis=-1) + 1e-9
        trial = moved(element, free, here, at.frame, _with_sizes(element, free, found.step))
        after = _top(goal, linearised(element, free, goal, data[on], trial).d)
        gained = goal.tangent | (after <= before + 4.0 * _EPS * size)
        done[on] = _is_done(goal, found, shift, before, size)
        state = _replaced(state, on[gained], State(*(a[gained] for a in trial)))
        weight[on[gained]] = np.abs(found.weight[gained])
        damping[on] = np.where(gained, np.maximum(damping[on] / 8.0, least[on]), 8.0 * damping[on])
    return _settled(element, free, goal, data, state, lost, done)


def _first_damping(element: Element, free: tuple[int, ...], goal: Goal, data: Array, state: State) -> Array:
    """One over the radius of curvature of the distances: 1 where it is that of the data or does not count."""
    if not goal.convex:
        return np.ones(len(data))
    top = _top(goal, linearised(element, free, goal, data, state).d) + state.sizes[:, 0]
    return 1.0 / np.clip(top, 1e-12, 1.0)


def _with_sizes(element: Element, free: tuple[int, ...], step: Array) -> Array:
    """The step with zeros for sizes that stand still."""
    missing = len(free) + len(element.sizes) - step.shape[1]
    return np.concatenate([step, np.zeros((len(step), missing))], axis=1) if missing else step


def _is_done(goal: Goal, found: _Step, shift: Array, before: Array, size: Array) -> Mask:
    """The step moves no distance, or it promises nothing more and hardly moves."""
    still = shift <= 1e-13 * size
    if goal.tangent:
        return still
    return still | ((before - found.level <= 8.0 * _EPS * size) & (shift <= 1e-8))


def _replaced(state: State, rows: Array, by: State) -> State:
    parts = [a.copy() for a in state]
    for part, new in zip(parts, by):
        part[rows] = new
    return State(*parts)


def _settled(
    element: Element, free: tuple[int, ...], goal: Goal, data: Array, state: State, lost: Mask, done: Mask
) -> Settled:
    d = linearised(element, free, goal, data, state).d
    level = np.zeros(len(d)) if goal.tangent else _top(goal, d)
    near = 1e-11 * (1.0 + magnitude(state))[:, None]
    reached = np.abs(d) if goal.two_sided else d
    return Settled(state, level, np.abs(reached - level[:, None]) <= near, lost, done)
