"""Collapsed Monte Carlo: trials of K linear quantities y = start + sum_j gain_j z_j cost random numbers only.

    for block in simulate(start, terms, seed=1, trials=1_000_000): ...      # blocks (m, K)

Columns without effect are dropped. With `fold` the normal terms are replaced by at most K normals under the stream
name "gaussian" (their joint law is the same, their single values are not kept); without it every input is sampled
from its own stream, as common random numbers between poses, machines or "with and without an effect" need.
Trial number t is the same number for number in any block, shard (`first`) and worker: the inner product adds the
lanes of a trial one after another, in numpy and in numba alike, and leaves nothing to the matrix library.
JCGM 101:2008 (propagation of distributions), JCGM 102:2011 (several outputs).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType

import numpy as np

from vcmm.answer.evaluation import streams
from vcmm.answer.evaluation.interval import Linear, check_interval
from vcmm.answer.evaluation.summary import STATEMENT_KINDS, Accumulator, Summary, summarise, tolerance
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import Array, Joint, Law, MultivariateNormal, MultivariateSamples, Normal, row_factor
from vcmm.core.memory import keep_in_hand

__all__ = [
    "Accumulator",
    "Summary",
    "Term",
    "adaptive",
    "covariance",
    "marginal",
    "simulate",
    "summarise",
    "uncertainty",
]

_BATCH = 10_000  # trials of the adaptive Monte Carlo at a time (JCGM 101, 7.9.4)
_LANES = 32  # lanes drawn at a time: 32 x 2048 numbers stay in the second cache


@dataclass(frozen=True, eq=False)
class Term:
    """One input acting on K quantities: `name` of its stream, its law, gain (K, L), lanes (L, 2) uint32.

    A lane is (component, copy), see vcmm.answer.evaluation.streams; a scalar law holds for every lane. For a joint law the component
    says which of its quantities the lane is.
    """

    name: str
    law: Law | Joint
    gain: Array
    lanes: Array

    def __post_init__(self) -> None:
        gain, lanes = np.asarray(self.gain, float), np.ascontiguousarray(self.lanes, np.uint32)
        if gain.ndim != 2 or lanes.shape != (gain.shape[1], 2):
            text = f"gain {gain.shape} must be (K, L) and lanes {lanes.shape} (L, 2)"
            raise UsageError(f"Term {self.name}: {text}.")
        if not np.isfinite(gain).all():
            raise ModelLimit(f"Term {self.name}: the gain has entries that are not finite.")
        object.__setattr__(self, "gain", gain)
        object.__setattr__(self, "lanes", lanes)


def _active(terms: Sequence[Term]) -> list[Term]:
    """Return terms with joint normals turned into independent ones, without lanes that act on nothing."""
    kept = []
    for term in terms:
        term = _independent(term) if isinstance(term.law, MultivariateNormal) else term
        on = term.gain.any(axis=0) & (term.law.scale != 0 if isinstance(term.law, Law) else True)
        if on.any():
            kept.append(replace(term, gain=term.gain[:, on], lanes=term.lanes[on]))
    return kept


def _independent(term: Term) -> Term:
    """Return a joint normal law as r standard normals per copy: the factor goes into the gain."""
    assert isinstance(term.law, MultivariateNormal)
    factor = term.law.factor
    gains, lanes = [], []
    for copy in np.unique(term.lanes[:, 1]):
        mine = term.lanes[:, 1] == copy
        gains.append(term.gain[:, mine] @ factor[term.lanes[mine, 0]])
        lanes.append([(component, copy) for component in range(factor.shape[1])])
    return Term(term.name, Normal(1.0), np.concatenate(gains, axis=1), np.concatenate(lanes))


def _fold(terms: Sequence[Term]) -> list[Term]:
    """Fold all normal terms into at most K standard normals of the stream "gaussian"."""
    gains = [term.gain * term.law.u for term in terms if isinstance(term.law, Normal)]
    rest = [term for term in terms if not isinstance(term.law, Normal)]
    if not gains:
        return rest
    factor = row_factor(np.concatenate(gains, axis=1))
    lanes = [(k, 0) for k in range(factor.shape[1])]
    return [Term("gaussian", Normal(1.0), factor, np.array(lanes)), *rest]


@dataclass(frozen=True, eq=False)
class _LaneGroup:
    """Lanes of one standard shape, keys and lanes (L, 2), gain (K, L) times scale."""

    shape: streams.Drawable
    keys: Array
    lanes: Array
    gain: Array


def _groups(terms: Sequence[Term], seed: int) -> list[_LaneGroup]:
    """Gather the lanes of all terms, in order, by shape of law."""
    by_law: dict[streams.Drawable, list[tuple[Array, Array, Array]]] = {}
    for term in terms:
        assert not isinstance(term.law, MultivariateNormal)
        law, scale = (term.law.shape, term.law.scale) if isinstance(term.law, Law) else (term.law, 1.0)
        keys = np.tile(np.array(streams.key(seed, term.name), np.uint32), (len(term.lanes), 1))
        by_law.setdefault(law, []).append((keys, term.lanes, term.gain * scale))
    return [
        _LaneGroup(law, *(np.concatenate([p[i] for p in parts], axis=i // 2) for i in range(3)))
        for law, parts in by_law.items()
    ]


_Step = Callable[[Array, int], None]  # (y (K, m), first trial): adds some lanes


def _steps(groups: Sequence[_LaneGroup], fast: ModuleType | None) -> list[_Step]:
    """Return the steps that add trials, in order: lanes with a table by one call of the numba twin, all others by numpy."""
    steps: list[_Step] = []
    for tabled, some in itertools.groupby(groups, lambda g: streams.is_tabled(g.shape)):
        together = list(some)
        steps += (
            [_by_kernel(fast, together)]
            if fast and tabled
            else [partial(_add_trials, g, fast) for g in together]
        )
    return steps


def _by_kernel(fast: ModuleType, groups: Sequence[_LaneGroup]) -> _Step:
    """Return one call for all lanes of these groups, without the interpreter lock and with its numbers in the cache."""
    tables = np.stack([streams.table(g.shape).nodes for g in groups])
    which = np.repeat(np.arange(len(groups)), [len(g.lanes) for g in groups])
    ids = np.concatenate([np.concatenate([g.keys, g.lanes], axis=1) for g in groups])
    gain = np.concatenate([g.gain for g in groups], axis=1)
    spans = np.array([_acting(gain[:, j : j + fast.GROUP]) for j in range(0, len(ids), fast.GROUP)])
    return lambda y, first: fast.trials(y, first, tables, which, ids, gain, spans=spans)


def _acting(gain: Array) -> tuple[int, int]:
    """Return first and last + 1 of the quantities that some lanes act on: scatter of a touch moves its own feature alone."""
    on = np.flatnonzero(gain.any(axis=1))
    return (int(on[0]), int(on[-1]) + 1) if len(on) else (0, 0)


def _add_trials(group: _LaneGroup, fast: ModuleType | None, y: Array, first: int) -> None:
    """Add trials of the lanes of a group to y piece by piece, each small enough for the second cache."""
    done, count = 0, y.shape[1]
    while done < count:
        size = min(streams.BLOCK - (first + done) % streams.BLOCK, count - done)
        for j in range(0, len(group.lanes), _LANES):
            s, z = slice(j, j + _LANES), np.empty((len(group.lanes[j : j + _LANES]), size))
            streams.standard(group.shape, group.keys[s], group.lanes[s], first + done, z, fast)
            k = slice(*_acting(group.gain[:, s]))
            (fast.accumulate if fast else _accumulate)(y[k], done, group.gain[k, s], z)
        done += size


def simulate(
    start: Array,
    terms: Sequence[Term],
    *,
    seed: int,
    trials: int,
    first: int = 0,
    fold: bool = True,
    block: int = 8192,
    of: int = 0,
) -> Iterator[Array]:
    """Yield trials first .. first + trials - 1 of y = start + sum of gain z, in blocks (m <= block, K).

    `start` (K,) is y where every deviation is zero. Each block is a new array in which every quantity is
    contiguous. To share work, let worker i take its own `first` and `trials`; the trials are the same bits. of: trials of
    the whole job, which say whether compiled kernels are worth loading.
    Raises UsageError when shapes do not fit, ModelLimit when trials leave 0..2^43.
    """
    streams.check_range(first, max(trials, 0))
    start = np.asarray(start, float)
    for term in terms:
        if len(term.gain) != len(start):
            raise UsageError(
                f"Term {term.name}: gain has {len(term.gain)} rows, start has {len(start)} values."
            )
    if trials < 0 or block < 1:
        raise UsageError(f"trials = {trials} must not be negative and block = {block} must be positive.")
    active = _active(terms)
    groups = _groups(_fold(active) if fold else active, seed)
    lanes = sum(len(g.lanes) for g in groups)
    fast = streams.kernels(max(trials, of) * lanes * (8 + len(start)) // 8)
    keep_in_hand()  # blocks take turns on the same memory: else clearing its pages stops other threads, up to two thirds of the time
    steps, end = _steps(groups, fast), first + trials
    return (_block(start, steps, at, min(block, end - at)).T for at in range(first, end, block))


def _block(start: Array, steps: Sequence[_Step], at: int, count: int) -> Array:
    """Return trials at .. at + count - 1, (K, count); rows a little apart: at powers of two they would share places of the cache."""
    y = np.empty((len(start), count + 8))[:, :count]
    y[:] = start[:, None]
    for add in steps:
        add(y, at)
    return y


def _accumulate(y: Array, at: int, gain: Array, z: Array) -> None:
    """Add as vcmm.answer.evaluation._stream_kernels.accumulate does, in numpy: y[:, at : at + n] += gain @ z (L, n), lane after lane."""
    part = y[:, at : at + z.shape[1]]
    for j in range(len(z)):
        part += gain[:, j, None] * z[j]


def _copies(term: Term) -> Iterator[tuple[Array, Array]]:
    """Yield the gain (K, l) and components (l,) of each independent copy of a joint input."""
    for copy in np.unique(term.lanes[:, 1]):
        mine = term.lanes[:, 1] == copy
        yield term.gain[:, mine], term.lanes[mine, 0]


def covariance(terms: Sequence[Term]) -> Array:
    """Return the closed-form covariance (K, K) = G Sigma G^T of the outputs (JCGM 100, 5; JCGM 102, 6.2).

    Raises ModelLimit for t-laws with nu <= 2, which have none; `uncertainty` gives inf there.
    """
    total = np.zeros((len(terms[0].gain),) * 2) if terms else np.zeros((0, 0))
    for term in _active(terms):
        if isinstance(term.law, MultivariateSamples):
            for gain, which in _copies(term):
                total += gain @ term.law.covariance[np.ix_(which, which)] @ gain.T
            continue
        assert isinstance(term.law, Law)
        if not math.isfinite(term.law.u):
            raise ModelLimit(f"Term {term.name} ({term.law.name}) has no variance: use intervals, or nu > 2.")
        total += term.law.u**2 * (term.gain @ term.gain.T)
    return total


def uncertainty(terms: Sequence[Term]) -> Array:
    """Return closed-form standard uncertainties (K,) of the outputs; inf where a t-law with nu <= 2 acts."""
    endless = [t for t in terms if isinstance(t.law, Law) and not math.isfinite(t.law.u)]
    u = np.sqrt(np.diag(covariance([t for t in terms if t not in endless])))
    u = u if len(u) or not terms else np.zeros(len(terms[0].gain))
    for term in endless:
        u = np.where(term.gain.any(axis=1), math.inf, u)
    return u


def marginal(start: float, terms: Sequence[Term], output: int) -> Linear:
    """Return the exact law of output number `output` (vcmm.answer.evaluation.interval): intervals, u, and the scale of an Accumulator."""
    gains: list[tuple[Law, Array]] = []
    for term in _active(terms):
        if isinstance(term.law, Law):
            gains.append((term.law, term.gain[output]))
            continue
        assert isinstance(term.law, MultivariateSamples)
        for gain, which in _copies(term):
            weights = np.bincount(which, gain[output], term.law.values.shape[1])
            gains.append((term.law.project(weights), np.ones(1)))
    return Linear(start, gains)


def adaptive(
    run: Callable[[int, int], Array],
    *,
    digits: int = 2,
    p: float = 0.95,
    kind: str = "symmetric",
    u0: float | None = None,
    most: int = 10_000_000,
) -> Summary:
    """Run the adaptive Monte Carlo of JCGM 101:2008, 7.9: trials until mean, u and interval ends are stable.

    `run(first, count)` returns trials (count,). Batches of max(10 000, 100 / (1 - p)) trials go on until twice the
    standard deviation of the average of each of the four results is below the numerical tolerance of u given to
    `digits` digits; the large-sample formulas (`Summary.numerical_error`) must say so too, else two batches that
    agree by luck would stop it. With `u0` (the closed-form u) the tolerance is fixed beforehand, which avoids its jump when u
    crosses a power of ten and the bias of stopping early. Stops at `most` trials with a warning.
    """
    check_interval(p, kind, STATEMENT_KINDS)
    size = max(_BATCH, math.ceil(100 / (1 - p)))
    total: Accumulator | None = None
    results: list[list[float]] = []
    while True:
        values = np.asarray(run(len(results) * size, size), float)
        of_block = summarise(values)
        total = total or Accumulator(of_block.mean, _width(u0, of_block))
        total.add(values)
        results.append(_stability_results(of_block, p, kind))
        summary = total.summary()
        delta = tolerance(_width(u0, summary), digits)
        if _stable(results, delta) and 2 * summary.numerical_error(p) <= delta:
            return summary
        if (len(results) + 1) * size > most:
            text = f"{summary.trials} trials did not reach {digits} stable digits (JCGM 101, 7.9)."
            return replace(summary, warnings=(*summary.warnings, text))


def _stability_results(batch: Summary, p: float, kind: str) -> list[float]:
    """Return the results of one batch that must become stable: finite ends of the interval, mean and u."""
    moments = [batch.mean, batch.u] if math.isfinite(batch.u) else [batch.u]
    return [v for v in batch.interval(p, kind) if math.isfinite(v)] + moments


def _width(u0: float | None, summary: Summary) -> float:
    """Return u0 if it is given and finite, else the u of the trials, else a width from the middle of the trials; never 0."""
    low, high = summary.interval(0.6827)
    return next((w for w in (u0 or 0.0, summary.u, (high - low) / 2) if 0 < w < math.inf), 1.0)


def _stable(results: Sequence[Sequence[float]], delta: float) -> bool:
    """Return whether JCGM 101, 7.9.4 e to h is met: 2 s of the average over the batches within delta for all results."""
    if len(results) < 2:
        return False
    s = np.std(results, axis=0, ddof=1) / math.sqrt(len(results))
    return bool((2 * s <= delta).all())
