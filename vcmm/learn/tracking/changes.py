"""Jumps: a collision, a new ball screw, a changed current. Find which quantity jumped before a recording, with a probability.

    p(h | y) ~ p(h) N(y; H m, I + H (P + B_h B_h') H'),   B_h the shapes of the quantities that jump, times SIZES

The hypotheses are each quantity alone, all of one axis, everything, and everything for a day or a few (a door left open, a bad set-up: it goes
back with a time constant of a day); their prior is one change of a machine in a year (an
assumption, RATE), shared out evenly. Posteriors of all that matter are joined to one Gaussian of the same mean and covariance (GPB1: Bar-Shalom,
Li & Kirubarajan, Estimation with Applications (2001), 11.6). Hypotheses are tested only where the innovation is beyond ASK by chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.learn.tracking.kalman import (
    GaussianState,
    Innovation,
    chance_beyond,
    condition,
    innovation,
    solve_lower,
    triangular,
)
from vcmm.learn.tracking.quantities import TrackedMachine, group_numbers
from vcmm.learn.tracking.rates import BLOCKS

SIZES = (1.0, 4.0)  # usual sizes
RATE = 1.0  # changes of a machine in a year
LEAST_TIME_DAYS = 1.0  # days: shortest time in which one may have come
ASK = 0.01
MATTERS = 1e-3  # probability below which a hypothesis is left out
EVERYTHING, PASSING = "everything", "everything, for a day or a few"


@dataclass(frozen=True, eq=False)
class Jump:
    """name: of the quantity or axis; columns (n, b): shapes in the state."""

    name: str
    columns: Array


@dataclass(frozen=True, eq=False)
class Update:
    """Result of an update. state: after the readings; log_likelihood of them; probability: of a change, and of each that matters by name."""

    state: GaussianState
    log_likelihood: float
    probability: float
    suspects: tuple[tuple[str, float], ...]


@lru_cache(maxsize=4)
def jumps_of(tracked: TrackedMachine) -> tuple[Jump, ...]:
    """Return all hypotheses: columns over the state; what passes jumps in p, which goes back, all else in b."""
    axes = dict.fromkeys(q.axis for q in tracked.quantities if q.axis)
    sets = {q.id: [q.id] for q in tracked.quantities}
    for axis in axes:
        of_axis = [q.id for q in tracked.quantities if q.axis == axis]
        if len(of_axis) > 1:
            sets[f"axis {axis}"] = of_axis
    if len(tracked.quantities) > 1:
        sets[EVERYTHING] = [q.id for q in tracked.quantities]
    g = tracked.growth.shape[1]
    out = []
    for name, ids in sets.items():
        numbers = tracked.stated + np.flatnonzero(group_numbers(tracked, ids))
        if len(numbers):
            out.append(Jump(name, _ones(tracked, numbers)))
    passing = np.arange(tracked.stated + (BLOCKS - 1) * g, tracked.stated + BLOCKS * g)
    return (*out, Jump(PASSING, _ones(tracked, passing))) if g else tuple(out)


def _ones(tracked: TrackedMachine, numbers: npt.NDArray[np.intp]) -> Array:
    """Return one column for each number of the state, as (n, k)."""
    out = np.zeros((tracked.stated + BLOCKS * tracked.growth.shape[1], len(numbers)))
    out[numbers, np.arange(len(numbers))] = 1.0
    return out


def prior_of_change(days: float) -> float:
    """Return the probability that at least one change came in so many days."""
    return float(-np.expm1(-RATE * max(days, LEAST_TIME_DAYS) / 365.25))


def update(state: GaussianState, columns: Array, value: Array, jumps: Sequence[Jump], days: float) -> Update:
    """Return the state after readings (unit noise) that came `days` after the last ones."""
    forecast = innovation(state, columns, value)
    p = prior_of_change(days) if jumps else 0.0
    quiet = np.log1p(-p) + forecast.log_likelihood
    if not jumps or not len(value) or chance_beyond(len(value), float(forecast.white @ forecast.white)) > ASK:
        return Update(condition(state, forecast), quiet, 0.0, ())
    logs = [quiet, *log_of_jumps(forecast, columns, jumps, np.log(p / (len(jumps) * len(SIZES))))]
    top = max(logs)
    weights = np.exp(np.array(logs) - top)
    total = top + float(np.log(weights.sum()))
    weights /= weights.sum()
    kept = np.flatnonzero(weights > MATTERS)
    parts = [_branch(state, forecast, columns, value, jumps, int(k)) for k in kept]
    joined = _join(parts, weights[kept] / weights[kept].sum())
    return Update(joined, total, float(1.0 - weights[0]), _by_name(weights, jumps))


def log_of_jumps(innovation: Innovation, columns: Array, jumps: Sequence[Jump], prior: float) -> list[float]:
    """Return ln (prior x likelihood) of every jump and size: the covariance grows by columns that are few (matrix determinant lemma)."""
    white, base, out = innovation.white, innovation.log_likelihood, []
    for jump in jumps:
        shown = jump.columns[: columns.shape[1]]
        moved = solve_lower(innovation.lower, columns @ shown)
        left, size, _ = np.linalg.svd(moved, full_matrices=False)
        along = (left.T @ white) ** 2
        for s in SIZES:
            grown = (s * size) ** 2
            out.append(prior + base + float(0.5 * (along * grown / (1 + grown) - np.log1p(grown)).sum()))
    return out


def _branch(
    state: GaussianState,
    forecast: Innovation,
    columns: Array,
    value: Array,
    jumps: Sequence[Jump],
    number: int,
) -> GaussianState:
    """Return the posterior of one hypothesis; 0: no change."""
    if number == 0:
        return condition(state, forecast)
    jump, size = jumps[(number - 1) // len(SIZES)], SIZES[(number - 1) % len(SIZES)]
    wider = GaussianState(state.mean, np.concatenate([state.factor, size * jump.columns], axis=1))
    return condition(wider, innovation(wider, columns, value))


def _join(parts: Sequence[GaussianState], weights: Array) -> GaussianState:
    """Return one Gaussian of the mean and covariance of the mixture."""
    if len(parts) == 1:
        return GaussianState(parts[0].mean, triangular(parts[0].factor))
    mean = sum((w * p.mean for w, p in zip(weights, parts)), np.zeros(len(parts[0].mean)))
    blocks = [np.sqrt(w) * p.factor for w, p in zip(weights, parts)]
    blocks += [np.sqrt(w) * (p.mean - mean)[:, None] for w, p in zip(weights, parts)]
    return GaussianState(mean, triangular(np.concatenate(blocks, axis=1)))


def _by_name(weights: Array, jumps: Sequence[Jump]) -> tuple[tuple[str, float], ...]:
    """Name and probability of every hypothesis that matters, both sizes together, the most probable first."""
    per = weights[1:].reshape(len(jumps), len(SIZES)).sum(axis=1)
    order = np.argsort(-per, kind="stable")
    return tuple((jumps[k].name, float(per[k])) for k in order if per[k] > MATTERS)
