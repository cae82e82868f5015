"""Rates by their evidence: the likelihood of every recording as the ones before predict it, times the prior of the rates.

The state is integrated out by a filter (Schweppe, IEEE Trans. Inf. Theory 11 (1965) 61). Walk, trend and
season of every group are drawn in turn from their posteriors over all levels that are still probable, the other rates as they were drawn last
(Gibbs sampler: Geman and Geman, IEEE Trans. PAMI 6 (1984) 721); the root of the mean of these posteriors' squares over SWEEPS rounds is
used. A swing and its time constant are searched along their grids. What no recording sees is left out first: all numbers
of a group have one prior, so that a group may be turned to the few combinations that are seen, without any change of the evidence.

The likelihood of all recordings for given rates, by covariances alone: fast, and exact enough for a ratio of likelihoods.

    P -> P - K (H P),   K = P H' (H P H' + I)^-1,   m -> m + K (y - H m)

The state that is kept goes by factors (vcmm.learn.tracking.kalman). Where an innovation is beyond chance the jumps are weighed as in
vcmm.learn.tracking.changes, and their mixture is joined to one Gaussian.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.chance import chance_beyond
from vcmm.learn.tracking.changes import ASK, MATTERS, SIZES, Jump, log_of_jumps, prior_of_change
from vcmm.learn.tracking.compress import SeenRecording, turn_columns
from vcmm.learn.tracking.kalman import Innovation, solve_lower
from vcmm.learn.tracking.quantities import TrackedMachine
from vcmm.learn.tracking.rates import (
    BLOCKS,
    GRIDS,
    GroupRates,
    WanderingMotion,
    first_state,
    log_priors,
    motion_of,
    nearest_level,
)


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
    return (*_mixture_moments(means, covariances, weights[kept] / weights[kept].sum()), total)


def _mixture_moments(means: list[Array], covariances: list[Array], weights: Array) -> tuple[Array, Array]:
    """Mean and covariance of a mixture."""
    mean = np.asarray(weights @ np.array(means))
    away = np.array(means) - mean
    return mean, np.asarray(np.tensordot(weights, np.array(covariances), 1) + (away.T * weights) @ away)


FIRST = 3  # recordings: rates are learnt after 3, 4, 6, 8, 12, 16, 24 ... of them
SEEN = 1e-4  # information on a number of the usual size: what is below is not seen
SWEEPS = 4  # of the Gibbs sampler that count, after one that does not
NEGLIGIBLE = 5.0  # nats below the best: no longer asked


@dataclass(frozen=True, eq=False)
class SeenNumbers:
    """The state without what no recording sees: seen recordings, jumps, groups (g',) and number of coefficients z."""

    recordings: tuple[SeenRecording, ...]
    jumps: tuple[Jump, ...]
    groups: Array
    stated: int


def is_due(count: int) -> bool:
    """Whether rates are learnt after so many recordings: 3, 4, 6, 8, 12, 16, 24 ..."""
    while count % 2 == 0 and count > 4:
        count //= 2
    return count in (FIRST, 4)


def columns_for(seen: SeenRecording, stated: int) -> Array:
    """(r, n): b, w and s show alike; c and v do not show."""
    grown = seen.columns[:, stated:]
    none = np.zeros((len(grown), 2 * grown.shape[1]))
    return np.concatenate([seen.columns, grown, grown, none], axis=1)


def seen_numbers(
    tracked: TrackedMachine, recordings: Sequence[SeenRecording], jumps: Sequence[Jump]
) -> SeenNumbers:
    """What is left of the state when every group is turned to what is seen of it."""
    stated, groups = tracked.stated, tracked.group_of_mode
    gram = np.sum([r.columns.T @ r.columns for r in recordings], axis=0)
    parts = [np.arange(stated)] + [stated + np.flatnonzero(groups == k) for k in range(len(tracked.groups))]
    ways = [_seen_ways(gram[np.ix_(p, p)]) for p in parts]
    whole = np.zeros((len(gram), sum(w.shape[1] for w in ways)))
    at, left = 0, []
    for k, (part, way) in enumerate(zip(parts, ways)):
        whole[part, at : at + way.shape[1]] = way
        at += way.shape[1]
        left += [k - 1] * way.shape[1]
    count = ways[0].shape[1]
    grown = whole[stated:, count:]
    turned = [Jump(j.name, _turn(j.columns[stated:], grown, count)) for j in jumps]
    return SeenNumbers(
        tuple(turn_columns(r, whole) for r in recordings),
        tuple(turned),
        np.array(left[count:], dtype=np.intp),
        count,
    )


def _turn(columns: Array, grown: Array, count: int) -> Array:
    """(n', k): the columns of a jump, block by block, for the turned numbers."""
    blocks = [grown.T @ part for part in np.split(columns, BLOCKS)]
    return np.concatenate([np.zeros((count, columns.shape[1])), *blocks])


def _seen_ways(gram: Array) -> Array:
    if not gram.size:
        return np.zeros((len(gram), 0))
    size, ways = np.linalg.eigh(gram)
    return np.asarray(ways[:, size > SEEN])


def log_evidence(seen: SeenNumbers, rates: tuple[GroupRates, ...]) -> float:
    """ln of the likelihood of all recordings, each given those before, and of the prior of the swings."""
    motion = motion_of(seen.groups, seen.stated, rates)
    return log_likelihood(seen.recordings, motion, seen.jumps) + sum(r.log_prior for r in rates)


def learn_rates(
    tracked: TrackedMachine,
    recordings: Sequence[SeenRecording],
    jumps: Sequence[Jump],
    start: tuple[GroupRates, ...],
) -> tuple[GroupRates, ...]:
    """The rates after all recordings, from those that were used until now.

    Random numbers are a function of the number of recordings alone.
    """
    seen = seen_numbers(tracked, recordings, jumps)
    shown = sorted(set(seen.groups.tolist()))  # of a group that no recording sees nothing is learnt
    rates = start
    for k in shown:
        rates = _best_swing(seen, rates, k)
    rng, used = np.random.default_rng(len(recordings)), rates
    variance = {(k, name): 0.0 for k in shown for name in GRIDS}
    evidence = cache(lambda levels: log_evidence(seen, levels))  # the rounds come back to the same levels
    for sweep in range(SWEEPS + 1):
        for k, name in variance:
            logs, levels = _conditional(evidence, rates, k, name)
            weights = np.exp(logs - logs.max())
            weights /= weights.sum()
            variance[k, name] += float(weights @ levels**2) / SWEEPS if sweep else 0.0
            rates = _with(rates, k, name, float(rng.choice(levels, p=weights)))
    for (k, name), value in variance.items():
        used = _with(used, k, name, float(np.sqrt(value)))
    return used


def _conditional(
    evidence: Callable[[tuple[GroupRates, ...]], float], rates: tuple[GroupRates, ...], k: int, name: str
) -> tuple[Array, Array]:
    """(ln of the posterior, level) of every level of one rate that is still probable, all others as they are."""
    grid, priors = np.array(GRIDS[name]), log_priors(name)
    found: dict[int, float] = {}

    def ask(level: int) -> float:
        found[level] = float(priors[level]) + evidence(_with(rates, k, name, float(grid[level])))
        return found[level]

    start = nearest_level(name, getattr(rates[k], name))
    ask(start)
    for way in (1, -1):
        level = start + way
        while 0 <= level < len(grid) and ask(level) > max(found.values()) - NEGLIGIBLE:
            level += way
    levels = sorted(found)
    return np.array([found[i] for i in levels]), grid[levels]


def _with(rates: tuple[GroupRates, ...], k: int, name: str, rate: float) -> tuple[GroupRates, ...]:
    """Rates with one of them replaced."""
    asked: dict[str, Any] = {name: rate}
    return (*rates[:k], replace(rates[k], **asked), *rates[k + 1 :])


def _best_swing(seen: SeenNumbers, rates: tuple[GroupRates, ...], k: int) -> tuple[GroupRates, ...]:
    """Steps along the swing and its time constant until none is better."""
    best, value = rates[k], log_evidence(seen, rates)
    steps = list(best.neighbours())
    while steps:
        other = steps.pop(0)
        reached = log_evidence(seen, (*rates[:k], other, *rates[k + 1 :]))
        if reached > value + 1e-6:
            best, value, steps = other, reached, other.neighbours()
    return (*rates[:k], best, *rates[k + 1 :])
