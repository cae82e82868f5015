"""Learn rates by their evidence: the likelihood of every recording given the ones before it, times the prior of the rates.

The state is integrated out by a filter (vcmm.learn.tracking.evidence), for many rates at once. CHAINS Markov chains go through the joint posterior of
all rates (Metropolis & Hastings: W. Hastings, Biometrika 57 (1970) 97), each rate in turn by one step of its grid or anew from its prior given
the others of its kind (vcmm.learn.tracking.rate_prior), a swing anew from its prior with the walk beside it or without. Rates of a kind are moved together as well
(J. Liu & C. Sabatti, Biometrika 87 (2000) 353): without it rates that are alike could hardly move. The chains begin in the prior, and
where they ended when rates were learnt last (resample-move: W. Gilks & C. Berzuini, J. R. Stat. Soc. B 63 (2001) 127); in the last of their rounds they are draws
from the posterior. What no recording sees is left out first: all numbers of a group have one prior, so that a group may be
turned to the few combinations that are seen, without any change of the evidence.
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
from vcmm.learn.tracking.rate_prior import kind_of, prior_of
from vcmm.learn.tracking.rates import (
    BLOCKS,
    GRIDS,
    SWINGS,
    TAUS,
    GroupRates,
    motion_of,
    root_mean_square,
    swing_priors,
)

Rates = tuple[GroupRates, ...]
FIRST = 3  # recordings: rates are learnt after 3, 4, 6, 8, 12, 16, 24 ... of them
SEEN = 1e-4  # information on a number of the usual size: what is below is not seen
CHAINS = 6
SWEEPS, FEW = (
    3,
    64,
)  # rounds of each chain: SWEEPS + FEW / recordings, for the first times begin in the prior and cost little
KEPT = 2  # rounds that count, the last: so many, or half of them


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


def columns_for(seen: SeenRecording, stated: int) -> Array:
    """Return the columns (r, n) of a recording that was seen."""
    return of_whole_state(seen.columns, stated)


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
    """ln of the likelihood of all recordings, each given those before; known ones are not asked again."""

    def __init__(self, seen: SeenNumbers) -> None:
        self.seen = seen
        self.known: dict[Rates, float] = {}

    def of(self, many: Sequence[Rates]) -> Array:
        """Of each of many rates."""
        asked = [r for r in dict.fromkeys(many) if r not in self.known]
        if asked:
            motions = [motion_of(self.seen.groups, self.seen.stated, r) for r in asked]
            logs = log_likelihoods(self.seen.recordings, motions, self.seen.jumps)
            self.known |= dict(zip(asked, logs.tolist()))
        return np.array([self.known[r] for r in many])


def learn_rates(
    tracked: TrackedMachine,
    recordings: Sequence[SeenRecording],
    jumps: Sequence[Jump],
    before: Sequence[Rates] = (),
) -> tuple[Rates, ...]:
    """Draws from the posterior of the rates after all recordings, each as probable as another; the last CHAINS are where the chains stand.

    before: what this gave after fewer recordings. Random numbers are a function of the number of recordings alone. Rates of a group
    that no recording sees are what the others of its kind tell.
    """
    seen = seen_numbers(tracked, recordings, jumps)
    shown = set(seen.groups.tolist())
    kinds = _kinds_of(tracked, shown)
    sampler = _Sampler(Evidence(seen), kinds, np.random.default_rng(len(recordings)))
    chains = [_on_levels(r, shown) for r in before[-CHAINS:]] or [
        sampler.of_prior(len(tracked.groups)) for _ in range(CHAINS)
    ]
    out: list[Rates] = []
    for sweep in range(rounds := SWEEPS + FEW // len(recordings)):
        chains = sampler.sweep(chains)
        out += chains if sweep >= rounds - max(KEPT, rounds // 2) else []
    return tuple(out)


def root_mean_squares(draws: Sequence[Rates]) -> Rates:
    """Of walk, trend, season and swing of every group; the time constant of a swing is that of most of its variance."""
    out = []
    for own in zip(*draws):
        walk, trend, season = (float(np.sqrt(np.mean([getattr(r, k) ** 2 for r in own]))) for k in GRIDS)
        square = [[SWINGS[r.swing] ** 2 if r.tau == t else 0.0 for r in own] for t in range(len(TAUS))]
        sums = np.sum(square, axis=1)
        out.append(
            GroupRates(
                walk, trend, season, nearest_swing(float(np.sqrt(sums.sum() / len(own)))), int(sums.argmax())
            )
        )
    return tuple(out)


def nearest_swing(size: float) -> int:
    """The level of SWINGS next to a size, by its square."""
    return int(np.abs(np.square(SWINGS) - size**2).argmin())


def _kinds_of(tracked: TrackedMachine, shown: set[int]) -> list[tuple[list[int], list[int]]]:
    """Of every kind the numbers of its groups that recordings see, and of those that none sees."""
    kinds = [kind_of(g) for g in tracked.groups]
    own = [[k for k, name in enumerate(kinds) if name == kind] for kind in dict.fromkeys(kinds)]
    return [([k for k in part if k in shown], [k for k in part if k not in shown]) for part in own]


@dataclass(frozen=True, eq=False)
class _Sampler:
    """kinds: groups that are seen and not seen, of every kind. Every method takes the chains one step on, in proposals for all of them at once."""

    evidence: Evidence
    kinds: list[tuple[list[int], list[int]]]
    rng: np.random.Generator

    def of_prior(self, count: int) -> Rates:
        """Rates of so many groups."""
        out: Rates = (GroupRates(0.0, 0.0, 0.0),) * count
        for shown, _ in self.kinds:
            for i, k in enumerate(shown):
                for name in GRIDS:
                    out = self._anew(out, k, name, shown[:i])[0]
                out = self._swing_anew(out, k)
        return out

    def sweep(self, chains: list[Rates]) -> list[Rates]:
        """Every rate once."""
        for shown, unseen in self.kinds:
            for name in GRIDS:
                if len(shown) > 1:
                    chains = self._choose(chains, [self._together(r, shown, name) for r in chains])
                for k in shown:
                    others = [j for j in shown if j != k]
                    chains = self._choose(chains, [self._moved(r, k, name, others) for r in chains])
            for k in shown:
                chains = self._choose(
                    chains, [self._swung(r, k, [j for j in shown if j != k]) for r in chains]
                )
            for k in unseen:
                chains = [_told_by_others(r, k, shown) for r in chains]
        return chains

    def _choose(self, chains: list[Rates], asked: list[tuple[Rates, float]]) -> list[Rates]:
        """Metropolis & Hastings; asked: of every chain its proposal with ln of prior over prior, less that of its making."""
        gain = (
            self.evidence.of([r for r, _ in asked]) - self.evidence.of(chains) + [more for _, more in asked]
        )
        taken = np.log(self.rng.random(len(chains))) < gain
        return [new if yes else old for old, (new, _), yes in zip(chains, asked, taken)]

    def _moved(self, rates: Rates, k: int, name: str, others: list[int]) -> tuple[Rates, float]:
        """One rate a step up or down, or anew from its prior."""
        if self.rng.random() < 0.5:
            return self._anew(rates, k, name, others)
        level = _level(rates, k, name)
        new = level + int(self.rng.choice([-1, 1]))
        if not 0 <= new < len(GRIDS[name]):
            return rates, 0.0
        logs = prior_of(name).of_one_more([_level(rates, j, name) for j in others])
        return _with(rates, k, name, new), float(logs[new] - logs[level])

    def _anew(self, rates: Rates, k: int, name: str, others: list[int]) -> tuple[Rates, float]:
        """One rate from its prior given others of its kind: what is asked of it is the likelihood alone."""
        logs = prior_of(name).of_one_more([_level(rates, j, name) for j in others])
        return _with(rates, k, name, int(self.rng.choice(len(logs), p=np.exp(logs)))), 0.0

    def _together(self, rates: Rates, shown: list[int], name: str) -> tuple[Rates, float]:
        """All rates of a kind that have a size a step up or down."""
        prior, levels = prior_of(name), [_level(rates, k, name) for k in shown]
        step = int(self.rng.choice([-1, 1]))
        new = [v + step if v >= prior.first else v for v in levels]
        if new == levels or any(
            not prior.first <= v < len(GRIDS[name]) for v, old in zip(new, levels) if v != old
        ):
            return rates, 0.0
        out = rates
        for k, v in zip(shown, new):
            out = _with(out, k, name, v)
        return out, prior.of_all(new) - prior.of_all(levels)

    def _swung(self, rates: Rates, k: int, others: list[int]) -> tuple[Rates, float]:
        """A swing anew from its prior, half of the time with the walk: either explains much of what the other does."""
        out = self._swing_anew(rates, k)
        return self._anew(out, k, "walk", others) if self.rng.random() < 0.5 else (out, 0.0)

    def _swing_anew(self, rates: Rates, k: int) -> Rates:
        levels, tau = swing_priors(), int(self.rng.integers(len(TAUS)))
        swing = int(self.rng.choice(len(levels), p=levels))
        return (*rates[:k], replace(rates[k], swing=swing, tau=tau if swing else 0), *rates[k + 1 :])


def _told_by_others(rates: Rates, k: int, shown: list[int]) -> Rates:
    """Rates of a group that no recording sees: the root mean squares that the others of its kind leave of its prior; no swing, which the date of the file holds."""
    asked: dict[str, Any] = {}
    for name in GRIDS:
        logs = prior_of(name).of_one_more([_level(rates, j, name) for j in shown])
        asked[name] = root_mean_square(logs, np.array(GRIDS[name]))
    return (*rates[:k], replace(rates[k], **asked), *rates[k + 1 :])


def _on_levels(rates: Rates, shown: set[int]) -> Rates:
    """Groups that are seen now on the nearest levels of the grids: until they are, their rates lie between."""
    for k in shown:
        for name, grid in GRIDS.items():
            rates = _with(
                rates, k, name, int(np.abs(np.square(grid) - getattr(rates[k], name) ** 2).argmin())
            )
    return rates


def _level(rates: Rates, k: int, name: str) -> int:
    return GRIDS[name].index(getattr(rates[k], name))


def _with(rates: Rates, k: int, name: str, level: int) -> Rates:
    """Rates with one of them on another level."""
    asked: dict[str, Any] = {name: GRIDS[name][level]}
    return (*rates[:k], replace(rates[k], **asked), *rates[k + 1 :])
