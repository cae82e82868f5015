"""Learn rates by their evidence: the likelihood of every recording given the ones before it, times the prior of the rates.

The state is integrated out by a filter (vcmm.learn.tracking.evidence), for all levels of a rate at once. Walk, trend and
season of every group are drawn in turn from their posteriors over all levels that are still probable, the other rates as they were drawn last
(Gibbs sampler: Geman and Geman, IEEE Trans. PAMI 6 (1984) 721); the root of the mean of these posteriors' squares over SWEEPS rounds is
used. A swing and its time constant are searched along their grids. What no recording sees is left out first: all numbers
of a group have one prior, so that a group may be turned to the few combinations that are seen, without any change of the evidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.changes import Jump
from vcmm.learn.tracking.compress import SeenRecording, turn_columns
from vcmm.learn.tracking.evidence import log_likelihoods
from vcmm.learn.tracking.quantities import TrackedMachine
from vcmm.learn.tracking.rates import (
    BLOCKS,
    GRIDS,
    GroupRates,
    log_priors,
    motion_of,
    nearest_level,
)

Rates = tuple[GroupRates, ...]
FIRST = 3  # recordings: rates are learnt after 3, 4, 6, 8, 12, 16, 24 ... of them
SEEN = 1e-4  # information on a number of the usual size: what is below is not seen
SWEEPS = 4  # of the Gibbs sampler that count, after one that does not
NEGLIGIBLE = 5.0  # nats below the best: no longer asked


@dataclass(frozen=True, eq=False)
class SeenNumbers:
    """The state without numbers that no recording sees: seen recordings, jumps, groups (g',) and number of coefficients z."""

    recordings: tuple[SeenRecording, ...]
    jumps: tuple[Jump, ...]
    groups: Array
    stated: int


def is_due(count: int) -> bool:
    """Return whether rates are learnt after so many recordings: 3, 4, 6, 8, 12, 16, 24 ..."""
    while count % 2 == 0 and count > 4:
        count //= 2
    return count in (FIRST, 4)


def columns_for(recording: SeenRecording, stated: int) -> Array:
    """Return the columns (r, n) of a recording that was seen."""
    return of_whole_state(recording.columns, stated)


def of_whole_state(columns: Array, stated: int) -> Array:
    """Map (r, stated + g) -> (r, n): b, w, s and p show alike; c and v do not show."""
    grown = columns[:, stated:]
    none = np.zeros((len(grown), 2 * grown.shape[1]))
    return np.concatenate([columns, grown, grown, none, grown], axis=1)


def seen_numbers(
    tracked: TrackedMachine, recordings: Sequence[SeenRecording], jumps: Sequence[Jump]
) -> SeenNumbers:
    """Return the remaining state when every group is turned to its visible combinations."""
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
    """Return (n', k): the columns of a jump, block by block, for the turned numbers."""
    blocks = [grown.T @ part for part in np.split(columns, BLOCKS)]
    return np.concatenate([np.zeros((count, columns.shape[1])), *blocks])


def _seen_ways(gram: Array) -> Array:
    if not gram.size:
        return np.zeros((len(gram), 0))
    size, ways = np.linalg.eigh(gram)
    return np.asarray(ways[:, size > SEEN])


class Evidence:
    """ln of the likelihood of all recordings, each given those before, and of the prior of the swings; known ones are not asked again."""

    def __init__(self, numbers: SeenNumbers) -> None:
        self.numbers = numbers
        self.known: dict[Rates, float] = {}

    def of(self, many: Sequence[Rates]) -> list[float]:
        """Of each of many rates."""
        new = [r for r in dict.fromkeys(many) if r not in self.known]
        if new:
            motions = [motion_of(self.numbers.groups, self.numbers.stated, r) for r in new]
            logs = log_likelihoods(self.numbers.recordings, motions, self.numbers.jumps)
            for rates, log in zip(new, logs.tolist()):
                self.known[rates] = log + sum(r.log_prior for r in rates)
        return [self.known[r] for r in many]


def learn_rates(
    tracked: TrackedMachine,
    recordings: Sequence[SeenRecording],
    jumps: Sequence[Jump],
    start: Rates,
) -> Rates:
    """The rates after all recordings, from those that were used until now.

    Random numbers are a function of the number of recordings alone.
    """
    numbers = seen_numbers(tracked, recordings, jumps)
    shown = sorted(set(numbers.groups.tolist()))  # of a group that no recording sees nothing is learnt
    rates, evidence = start, Evidence(numbers)
    for k in shown:
        rates = _best_swing(evidence, rates, k)
    rng, used = np.random.default_rng(len(recordings)), rates
    variance = {(k, name): 0.0 for k in shown for name in GRIDS}
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


def _conditional(evidence: Evidence, rates: Rates, k: int, name: str) -> tuple[Array, Array]:
    """(ln of the posterior, level) of every level of one rate that is still probable, all others as they are."""
    grid = np.array(GRIDS[name])
    logs = log_priors(name) + evidence.of([_with(rates, k, name, float(level)) for level in grid])
    start = nearest_level(name, getattr(rates[k], name))
    top, kept = logs[start], [start]
    for way in (1, -1):
        level = start + way
        while 0 <= level < len(grid):
            kept.append(level)
            top = max(top, logs[level])
            if logs[level] <= top - NEGLIGIBLE:
                break
            level += way
    return logs[sorted(kept)], grid[sorted(kept)]


def _with(rates: Rates, k: int, name: str, rate: float) -> Rates:
    """Rates with one of them replaced."""
    change: dict[str, Any] = {name: rate}
    return (*rates[:k], replace(rates[k], **change), *rates[k + 1 :])


def _best_swing(evidence: Evidence, rates: Rates, k: int) -> Rates:
    """Steps along the swing and its time constant until none is better."""
    (value,) = evidence.of([rates])
    steps = [(*rates[:k], r, *rates[k + 1 :]) for r in rates[k].neighbours()]
    while steps:
        reached = evidence.of(steps)
        better = next((i for i, v in enumerate(reached) if v > value + 1e-6), None)
        if better is None:
            break
        rates, value = steps[better], reached[better]
        steps = [(*rates[:k], r, *rates[k + 1 :]) for r in rates[k].neighbours()]
    return rates
