"""Fit elements that touch the points: minimax, circumscribed, inscribed and tangent elements of a whole batch.

Each round solves the problem with distances replaced by their tangents (the Jacobian that the Gauss fit uses); the
solution names the points of contact, the next round starts from there. Where the contacts determine the element
that is Newton's method on their equations; where they do not (a circumscribed circle that touches at two points)
the curvature of the touching distances completes it. A step that would make the result worse is bent once along the
curved distances, else shortened. Sequential programming for minimax problems: Madsen, J. Inst. Maths Applics 16
(1975) 321; the bend ("second-order correction"): Fletcher, Practical Methods of Optimization, 14.4; elements:
Anthony et al., Reference software for finding Chebyshev best-fit geometric elements, Precision Eng. 19 (1996) 28.

In coordinates scaled by the extent of the data, as in vcmm.part.fit.newton.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vcmm.part.fit.elements import Array, Element, Mask, jacobian
from vcmm.part.fit.newton import State, magnitude, move_state, seat, to_local

MOST_ROUNDS = 100
ROUNDS_FOR_PROMISE = 12  # rounds after which a promise of 1e-13 of the extent is no longer waited for
# a first step longer than this many ranges of the distances: the points do not surround the element
MOST_FIRST_STEP_RANGES = 10.0
TOUCH = 1e-11  # of the extent: a point so near to the level touches
FLAT = 1e-8  # what a motion costs beside the largest departure, of 1: with it the answer is one, and no longer by more than 1e-7
NUMBERS = 2_000_000  # in a block of rows, 16 MB
Ints = NDArray[np.intp]
_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class ContactGoal:
    """Goal for the signed distances d of the points.

    two_sided   the largest |d| becomes smallest; else the largest d
    sized       sizes take part; else they are fixed and the level is the change of the radius
    tangent     the sum of d^2 becomes smallest while no d is positive; no level
    sign        -1 turns the distances round (inscribed; material on the other side)
    """

    two_sided: bool = False
    has_size: bool = False
    tangent: bool = False
    sign: float = 1.0

    @property
    def convex(self) -> bool:
        """Whether the goal is convex (circumscribed): distances from a centre or axis curve upwards, which holds where contacts leave room."""
        return self.sign > 0.0 and not self.has_size


class Local(NamedTuple):
    """Distances d (B, n) as the goal counts them, their Jacobian (B, p, n), local points (B, 3, n), frames."""

    d: Array
    jac: Array
    local: Array
    frame: Array


@dataclass(frozen=True)
class ContactProblem:
    """An element, its free motions (vcmm.part.fit.elements.free_pose) and the goal."""

    element: Element
    free: tuple[int, ...]
    goal: ContactGoal

    def at(self, data: Array, state: State) -> Local:
        """Return the distances of data (B, 3, n) and their derivatives by the motions, and by the sizes where these are free."""
        local, frame = to_local(data, state)
        d, jac, _ = jacobian(self.element, self.free, local, state.sizes)
        if not self.goal.has_size:
            jac = jac[:, : len(self.free)]
        return Local(self.goal.sign * d, self.goal.sign * jac, local, frame)

    def move(self, state: State, frame: Array, step: Array) -> State:
        """Return the state after a step (B, p), sizes kept where they are not free."""
        missing = len(self.free) + len(self.element.sizes) - step.shape[1]
        padded = np.concatenate([step, np.zeros((len(step), missing))], axis=1)
        return move_state(self.element, self.free, state, frame, padded)

    def top(self, d: Array) -> Array:
        """Return the quantity to minimise (B,): the largest distance, or the sum of squares of a tangent element."""
        if self.goal.tangent:
            return np.sum(d * d, axis=-1)
        return np.max(np.abs(d) if self.goal.two_sided else d, axis=-1)


class SettledState(NamedTuple):
    """State; level (B,), 0 for a tangent element; masks of contacts (B, n), lost and is_done (B,).

    lost: the first step ran away, the points do not surround the element.
    """

    state: State
    level: Array
    contacts: Mask
    is_lost: Mask
    is_done: Mask


class _Step(NamedTuple):
    """Step (B, p), the level (B,) that the tangents promise, multipliers (B, n) with the sign of their side."""

    step: Array
    level: Array
    weight: Array


def settle(problem: ContactProblem, data: Array, start: State) -> SettledState:
    """Find the element of each member (B, 3, n) that fulfils the goal, from a start near it (the Gauss element)."""
    state = seat(problem.element, start)
    damping = 1.0 / _radius(problem, problem.at(data, state), state)
    least, weight = 1e-4 * damping, np.zeros((len(data), data.shape[2]))
    lost, done = np.zeros(len(data), dtype=bool), np.zeros(len(data), dtype=bool)
    for round_ in range(MOST_ROUNDS):
        on = np.flatnonzero(~done & ~lost)
        if len(on) == 0:
            break
        here, points = _rows(state, on), data[on]
        at = problem.at(points, here)
        metric = _metric(problem, points, here, at, weight=weight[on], damping=damping[on], round_=round_)
        step = _solve(problem.goal, at, metric, weight[on], 4.0 * _EPS * magnitude(here))
        trial, gained = _try_step(problem, points, here, at, metric, step)
        shift = np.abs(np.einsum("bp,bpn->bn", step.step, at.jac)).max(axis=-1)
        if round_ == 0 and not problem.goal.has_size:
            lost[on] = shift > MOST_FIRST_STEP_RANGES * np.ptp(at.d, axis=-1) + 1e-9
        done[on] = _is_done(problem, here, at, step, shift, round_)
        state = _replace_members(state, on[gained], _rows(trial, gained))
        weight[on] = step.weight
        damping[on] = np.where(gained, np.maximum(damping[on] / 8.0, least[on]), 8.0 * damping[on])
    return _settle(problem, data, state, lost, done)


def least_largest(left: Array, basis: Array) -> Array:
    """Return the smallest largest |departure| (...) over motions along `basis` (k, f), whose columns are of length 1 and orthogonal.

    left (..., k): residuals of least squares, so that their largest is at most sqrt(k) times too large and scales them.
    """
    from vcmm.part.fit._nearest_kernels import minimax_steps

    k, f = basis.shape
    flat, many = left.reshape(-1, k), max(NUMBERS // (k * f), 1)
    scale = np.maximum(np.abs(flat).max(axis=-1, keepdims=True), 1e-300)
    step = np.zeros((len(flat), f))
    for at in range(0, len(flat), many):
        d = flat[at : at + many] / scale[at : at + many]
        n = len(d)
        jac, metric = (np.tile(a, (n, 1, 1)) for a in (basis.T, FLAT * np.eye(f)))
        argument, level, weight = np.zeros((n, f)), np.zeros(n), np.zeros((n, k))
        minimax_steps(jac, d, True, metric, np.full(n, 1e-12), argument, level, weight)
        step[at : at + many] = argument
    moved = flat + scale * (step @ basis.T)
    return np.asarray(np.abs(moved).max(axis=-1).reshape(left.shape[:-1]))


def _radius(problem: ContactProblem, at: Local, state: State) -> Array:
    """Return the radius of curvature (B,) of the distances; 1, the extent of the data, where it is no smaller."""
    if not problem.goal.convex:
        return np.ones(len(at.d))
    return np.clip(problem.top(at.d) + state.sizes[:, 0], 1e-12, 1.0)


def _metric(
    problem: ContactProblem, data: Array, state: State, at: Local, weight: Array, damping: Array, round_: int
) -> Array:
    """Return the cost of a step (B, p, p): mean square of the distances moved, times the damping, and curvature where the
    first rounds have not settled it. A tangent element wants that mean square itself.
    """
    mean = at.jac @ at.jac.swapaxes(-1, -2) / at.jac.shape[-1]
    if problem.goal.tangent:
        return mean
    lift = 1e-9 * np.einsum("bii->b", mean)[:, None, None] * np.eye(mean.shape[1])
    metric = damping[:, None, None] * (mean + lift)
    line = problem.goal.convex and problem.element.slides
    if round_ >= (1 if line else 3):
        metric = metric + _curvature(problem, data, state, at, weight)
    return np.asarray(metric)


def _curvature(problem: ContactProblem, data: Array, state: State, at: Local, weight: Array) -> Array:
    """Return the second derivative (B, p, p) of the distances, weighted (B, n) by the multipliers; made positive.

    From differences of the weighted Jacobian: where the weights are those of contact its sum vanishes, and the
    derivative does not depend on how motions are written. What matters is the motion that the contacts leave free;
    across it the curvature is raised, which changes nothing where they hold.
    """
    p = at.jac.shape[1]
    small = 1e-4 * _radius(problem, at, state)
    columns = []
    for j in range(p):
        step = np.zeros((len(weight), p))
        step[:, j] = small
        jacs = [problem.at(data, problem.move(state, at.frame, way * step)).jac for way in (1.0, -1.0)]
        columns.append(np.einsum("bn,bpn->bp", weight, jacs[0] - jacs[1]) / (2.0 * small[:, None]))
    second = np.stack(columns, axis=-1)
    second = 0.5 * (second + second.swapaxes(-1, -2))
    touching = at.jac * (weight != 0.0)[:, None]
    second = second + np.abs(second).max(axis=(-1, -2), keepdims=True) * (
        touching @ touching.swapaxes(-1, -2)
    )
    values, vectors = np.linalg.eigh(second)
    return np.asarray((vectors * np.maximum(values, 0.0)[:, None]) @ vectors.swapaxes(-1, -2))


def _solve(goal: ContactGoal, at: Local, metric: Array, likely: Array, rounding: Array) -> _Step:
    """Solve the problem with straight distances. likely (B, n): not 0 where contact is expected."""
    from vcmm.part.fit._nearest_kernels import minimax_steps, tangent_steps

    step, level, weight = np.zeros(at.jac.shape[:2]), np.zeros(len(at.d)), likely.copy()
    jac, d = np.ascontiguousarray(at.jac), np.ascontiguousarray(at.d)
    if goal.tangent:
        tangent_steps(jac, d, metric, rounding, step, weight)
    else:
        minimax_steps(jac, d, goal.two_sided, metric, rounding, step, level, weight)
    return _Step(step, level, weight)


def _try_step(
    problem: ContactProblem, data: Array, state: State, at: Local, metric: Array, step: _Step
) -> tuple[State, Mask]:
    """Return the state after the step, bent where the straight one loses, and the mask (B,) of the members that lose nothing."""
    trial = problem.move(state, at.frame, step.step)
    if problem.goal.tangent:
        return trial, np.ones(len(data), dtype=bool)
    rounding = 4.0 * _EPS * magnitude(state)
    limit = problem.top(at.d) + rounding
    d = problem.at(data, trial).d
    gained = problem.top(d) <= limit
    again = np.flatnonzero(~gained)
    if len(again) == 0:
        return trial, gained
    jac = at.jac[again]
    straight = at._replace(d=d[again] - np.einsum("bp,bpn->bn", step.step[again], jac), jac=jac)
    bent = _solve(problem.goal, straight, metric[again], step.weight[again], rounding[again])
    second = problem.move(_rows(state, again), at.frame[again], bent.step)
    gained[again] = problem.top(problem.at(data[again], second).d) <= limit[again]
    return _replace_members(trial, again, second), gained


def _is_done(
    problem: ContactProblem, state: State, at: Local, step: _Step, shift: Array, round_: int
) -> Mask:
    """Return whether the step moves no distance, or promises nothing more and hardly moves; after many rounds the promise
    decides alone: the place is then not determined to the last digit.
    """
    size = magnitude(state)
    still = shift <= 1e-13 * size
    if problem.goal.tangent:
        return np.asarray(still)
    promise, moves = (8.0 * _EPS, 1e-8) if round_ < ROUNDS_FOR_PROMISE else (1e-13, 1e-4)
    return np.asarray(still | ((problem.top(at.d) - step.level <= promise * size) & (shift <= moves)))


def _rows(state: State, which: Ints | Mask) -> State:
    return State(*(a[which] for a in state))


def _replace_members(state: State, which: Ints, by: State) -> State:
    parts = [a.copy() for a in state]
    for part, new in zip(parts, by):
        part[which] = new
    return State(*parts)


def _settle(problem: ContactProblem, data: Array, state: State, lost: Mask, done: Mask) -> SettledState:
    d = problem.at(data, state).d
    level = np.zeros(len(d)) if problem.goal.tangent else problem.top(d)
    reached = np.abs(d) if problem.goal.two_sided else d
    near = TOUCH * (1.0 + magnitude(state))[:, None]
    return SettledState(state, level, np.abs(reached - level[:, None]) <= near, lost, done)
