"""The likelihood of all recordings for given rates, by covariances alone: fast, and exact enough for a ratio of likelihoods.

    P -> P - K (H P),   K = P H' (H P H' + I)^-1,   m -> m + K (y - H m)

The state that is kept goes by factors (vcmm.learn.tracking.kalman). Where an innovation is beyond chance the jumps are weighed as in
vcmm.learn.tracking.changes, and their mixture is joined to one Gaussian.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.chance import chance_beyond
from vcmm.learn.tracking.changes import ASK, MATTERS, SIZES, Jump, log_of_jumps, prior_of_change
from vcmm.learn.tracking.compress import SeenRecording
from vcmm.learn.tracking.kalman import Innovation, solve_lower
from vcmm.learn.tracking.rates import WanderingMotion, first_state


def log_likelihood(
    recordings: Sequence[SeenRecording], motion: WanderingMotion, jumps: Sequence[Jump]
) -> float:
    """ln of the likelihood of every recording, each given those before."""
    start = first_state(motion)
    mean, covariance, before, total = start.mean, start.covariance, None, 0.0
    shown = motion.stated + 3 * len(motion.walk)
    for one in recordings:
        days = 0.0 if before is None else one.when - before
        if days > 0:
            mean, covariance = motion.carry(mean, days), motion.later(covariance, days)
        before = one.when
        grown = one.columns[:, motion.stated :]
        columns = np.concatenate([one.columns, grown, grown], axis=1)
        if not len(columns):
            continue
        mean, covariance, more = _taken_in(mean, covariance, (columns, shown), one.value, jumps, days)
        total += more
    return total


def _taken_in(
    mean: Array,
    covariance: Array,
    shown: tuple[Array, int],
    value: Array,
    jumps: Sequence[Jump],
    days: float,
) -> tuple[Array, Array, float]:
    """Mean and covariance after readings, and ln of their likelihood. shown: columns (r, k) of the first k numbers of the state."""
    columns, k = shown
    cross = columns @ covariance[:k]
    lower = np.asarray(np.linalg.cholesky(cross[:, :k] @ columns.T + np.eye(len(value))), dtype=np.float64)
    seen = Innovation(value - columns @ mean[:k], cross, lower)
    quiet, white = seen.log_likelihood, seen.white
    half = solve_lower(lower, cross)
    if not jumps:
        return mean + half.T @ white, covariance - half.T @ half, quiet
    p = prior_of_change(days)
    quiet += float(np.log1p(-p))
    if chance_beyond(len(value), float(white @ white)) > ASK:
        return mean + half.T @ white, covariance - half.T @ half, quiet
    logs = [quiet, *log_of_jumps(seen, columns, jumps, np.log(p / (len(jumps) * len(SIZES))))]
    top = max(logs)
    weights = np.exp(np.array(logs) - top)
    total = top + float(np.log(weights.sum()))
    weights /= weights.sum()
    kept = np.flatnonzero(weights > MATTERS)
    means, covariances = [], []
    for number in map(int, kept):
        wider = covariance
        if number:
            jump, size = jumps[(number - 1) // len(SIZES)], SIZES[(number - 1) % len(SIZES)]
            wider = covariance + size**2 * (jump.columns @ jump.columns.T)
        new = columns @ wider[:k]
        low = np.asarray(np.linalg.cholesky(new[:, :k] @ columns.T + np.eye(len(value))), dtype=np.float64)
        half = solve_lower(low, new)
        means.append(mean + half.T @ solve_lower(low, seen.value))
        covariances.append(wider - half.T @ half)
    return (*_joined(means, covariances, weights[kept] / weights[kept].sum()), total)


def _joined(means: list[Array], covariances: list[Array], weights: Array) -> tuple[Array, Array]:
    """Mean and covariance of a mixture."""
    mean = np.asarray(weights @ np.array(means))
    away = np.array(means) - mean
    return mean, np.asarray(np.tensordot(weights, np.array(covariances), 1) + (away.T * weights) @ away)
