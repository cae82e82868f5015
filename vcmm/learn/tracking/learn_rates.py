"""Rates by their evidence: the likelihood of every recording as the ones before predict it, times the prior of the rates.

The state is integrated out by the filter itself (Schweppe, IEEE Trans. Inf. Theory 11 (1965) 61). The search goes along the groups, one
step on the grid of each at a time, until none is better. What no recording sees is left out first: all numbers of a group have one
prior, so that a group may be turned to the few combinations that are seen, without any change of the evidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.changes import Jump, update
from vcmm.learn.tracking.compress import SeenRecording, turn_columns
from vcmm.learn.tracking.quantities import TrackedMachine
from vcmm.learn.tracking.rates import WALKS, GroupRates, first_state, mean_walk, motion_of

FIRST = 4  # recordings: rates are learnt after 4, 8, 16 ... of them
SEEN = 1e-10  # of the largest information: what is below is not seen
SWEEPS = 4
NEGLIGIBLE = 6.0  # nats below the best: no longer asked


@dataclass(frozen=True, eq=False)
class SeenNumbers:
    """The state without what no recording sees: seen recordings, jumps, groups (g',) and number of coefficients z."""

    recordings: tuple[SeenRecording, ...]
    jumps: tuple[Jump, ...]
    groups: Array
    stated: int


def is_due(count: int) -> bool:
    """Whether rates are learnt after so many recordings: 4, 8, 16 ..."""
    return count >= FIRST and (count & (count - 1)) == 0


def columns_for(seen: SeenRecording, stated: int) -> Array:
    """(r, stated + 2 g): b and w show alike."""
    return np.concatenate([seen.columns, seen.columns[:, stated:]], axis=1)


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
    turned = []
    for jump in jumps:
        own = grown.T @ jump.columns[stated : stated + len(groups)]
        none = np.zeros((count, own.shape[1]))
        turned.append(Jump(jump.name, np.concatenate([none, own, np.zeros_like(own)])))
    return SeenNumbers(
        tuple(turn_columns(r, whole) for r in recordings),
        tuple(turned),
        np.array(left[count:], dtype=np.intp),
        count,
    )


def _seen_ways(gram: Array) -> Array:
    if not gram.size:
        return np.zeros((len(gram), 0))
    size, ways = np.linalg.eigh(gram)
    return np.asarray(ways[:, size > SEEN * max(float(size[-1]), 1e-300)])


def log_evidence(seen: SeenNumbers, rates: tuple[GroupRates, ...]) -> float:
    """ln of the likelihood of all recordings, each given those before, and of the prior of the rates."""
    motion = motion_of(seen.groups, seen.stated, rates)
    state, total, before = first_state(motion, seen.stated), 0.0, None
    for one in seen.recordings:
        days = 0.0 if before is None else one.when - before
        state = motion.step(state, days)
        new = update(state, columns_for(one, seen.stated), one.value, seen.jumps, days)
        state, before = new.state, one.when
        total += new.log_likelihood
    return total + sum(r.log_prior for r in rates)


def learn_rates(
    tracked: TrackedMachine,
    recordings: Sequence[SeenRecording],
    jumps: Sequence[Jump],
    start: tuple[GroupRates, ...],
) -> tuple[GroupRates, ...]:
    """The rates of the highest evidence that steps along the groups find from `start`."""
    seen = seen_numbers(tracked, recordings, jumps)
    unseen = start
    start = tuple(replace(r, mean=-1.0) for r in start)
    present = sorted(set(seen.groups.tolist()))  # of a group that no recording sees nothing is learnt
    best, value = start, log_evidence(seen, start)
    for _ in range(SWEEPS):
        before = best
        for k in present:
            for other in best[k].neighbours():
                tried = (*best[:k], other, *best[k + 1 :])
                found = log_evidence(seen, tried)
                if found > value + 1e-6:
                    best, value = tried, found
        if best == before:
            break
    return tuple(_with_mean(seen, best, k, value) if k in present else r for k, r in enumerate(unseen))


def _with_mean(seen: SeenNumbers, best: tuple[GroupRates, ...], k: int, top: float) -> GroupRates:
    """The rates of a group with the root mean square of its walk, the others at their best."""
    levels, logs = [best[k].walk], [top]
    for way in (1, -1):
        level = best[k].walk + way
        while 0 <= level < len(WALKS):
            found = log_evidence(seen, (*best[:k], replace(best[k], walk=level), *best[k + 1 :]))
            levels, logs = [*levels, level], [*logs, found]
            if found < top - NEGLIGIBLE:
                break
            level += way
    return replace(best[k], mean=mean_walk(np.array(logs), levels))
