"""Decide whether the part conforms as a whole: all its tolerances judged together, with the common errors of their measurements (JCGM 106:2012, 8.4).

The true values of sizes, distances and angles are sampled together from the linear model: common errors (a temperature, a scale,
a datum) move them together. A known bias that is left in a value is carried as its own decision carries it: the probability is
that of the true values, y - bias, and no decision is made that values off by |bias|, either way, would change. Where no tolerance is
rejected by itself, a part is rejected by the values beyond a limit alone, each against that one limit: a probability that is small because
U is wide, of values within their limits, speaks against no part. An extreme
value is known by itself only; with it the joint probability lies between two bounds: at least 1 less the sum of
the probabilities of non-conformity, at most the smallest (Frechet).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from vcmm.answer.evaluation.judgement import limits_of
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.montecarlo import simulate
from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.answer.evaluation.sampling import with_products
from vcmm.answer.evaluation.truth import Additive
from vcmm.answer.evaluation.widened_law import WidenedLaw
from vcmm.core.run import Array
from vcmm.part.gps.decision import ACCEPT, CONFORMS, REJECT, REJECTED, UNDECIDED

TRIALS = 100_000
FORMS = 5  # names the stream of forms between points


@dataclass(frozen=True)
class JointJudgement:
    """least <= probability that all true values lie within their limits <= most; equal where no extreme value is among them.

    independent: the product, as if nothing were shared. reason: why there is no result (then the numbers are NaN), else empty.
    """

    names: tuple[str, ...]
    least: float
    most: float
    independent: float
    decision: str
    reason: str = ""


def judged_jointly(
    model: LinearModel, results: Sequence[CharacteristicResult], readings: Sequence[float], seed: int
) -> JointJudgement | None:
    """Judge all toleranced characteristics together, with the indicated values `readings` of each of `results`; return None for fewer than
    two of them."""
    toleranced = [(c, y) for c, y in zip(results, readings) if c.decision is not None]
    if len(toleranced) < 2:
        return None
    names = tuple(c.name for c, _ in toleranced)
    hidden = [c.name for c, _ in toleranced if c.decision is not None and c.decision.p_conform is None]
    if hidden:
        reason = f"coverage is not demonstrated of {', '.join(hidden)}"
        return JointJudgement(names, math.nan, math.nan, math.nan, UNDECIDED, reason)
    alone = [float(c.decision.p_conform or 0.0) for c, _ in toleranced if c.decision is not None]
    together = [pair for pair in toleranced if isinstance(pair[0].truth, Additive)]
    common = _common(model, together, seed) if together else _Share(1.0, 1.0, 1.0)
    others = [p for p, (c, _) in zip(alone, toleranced) if not isinstance(c.truth, Additive)]
    doubt = sum(1.0 - p for p in others)
    least, most = max(common.true - doubt, 0.0), min([common.true, *alone])
    each = [c.decision.text for c, _ in toleranced if c.decision is not None]
    decision = _decision(each, common.least - doubt, common.beyond)
    return JointJudgement(names, min(least, most), most, math.prod(alone), decision)


def _decision(each: Sequence[str], least: float, most: float) -> str:
    """Return the decision: a part with a tolerance that is not kept does not conform; it conforms where all are kept, one by one and together.
    most: the share within the one limit that each value lies beyond."""
    if REJECTED in each or most <= REJECT:
        return REJECTED
    return CONFORMS if set(each) == {CONFORMS} and least >= ACCEPT else UNDECIDED


@dataclass(frozen=True)
class _Share:
    """Shares of common draws in which all lie within their limits: the true values; values off by a bias that is left in, both ways; either
    way, within the one limit that each value lies beyond."""

    true: float
    least: float
    beyond: float


def _common(model: LinearModel, together: Sequence[tuple[CharacteristicResult, float]], seed: int) -> _Share:
    order = [c.name for c in model.characteristics]
    numbers = tuple(order.index(c.name) for c, _ in together)
    counts, rng = np.zeros(3), np.random.default_rng([seed, FORMS])
    for drawn in _drawn_values(model, numbers, seed):
        inside = np.ones((3, len(drawn)), dtype=bool)
        for k, (c, y) in enumerate(together):
            inside &= _within(c, y, drawn[:, k] + _by_form(c, len(drawn), rng))
        counts += inside.sum(axis=1)
    return _Share(*(float(x) for x in counts / TRIALS))


_DRAWN: WeakKeyDictionary[LinearModel, dict[tuple[tuple[int, ...], int], list[Array]]] = WeakKeyDictionary()


def _drawn_values(model: LinearModel, numbers: tuple[int, ...], seed: int) -> list[Array]:
    """Return the indications of sampled machines (TRIALS, k) of characteristics number `numbers`, in blocks: the same for all parts of a
    batch, and cached with their model."""
    blocks_of = _DRAWN.setdefault(model, {})
    if (numbers, seed) not in blocks_of:
        terms, values = with_products(model, model.terms())
        start = np.zeros(len(terms[0].gain) if terms else len(model.q0))
        start[: len(model.q0)] = model.q0
        blocks = simulate(start, terms, seed=seed, trials=TRIALS)
        blocks_of[numbers, seed] = [np.ascontiguousarray(values(block)[:, list(numbers)]) for block in blocks]
    return blocks_of[numbers, seed]


def _by_form(c: CharacteristicResult, count: int, rng: np.random.Generator) -> Array:
    """Sample the effect (m,) of a form between the points, for every characteristic by itself."""
    if not isinstance(c.truth, Additive) or not isinstance(c.truth.law, WidenedLaw):
        return np.zeros(count)
    return np.asarray(rng.choice(c.truth.law.sizes, count) * rng.choice([-1.0, 1.0], count))


def _within(c: CharacteristicResult, y: float, drawn: Array) -> Array:
    """Return whether the true value lies within its limits (3, m), when y is read and the machine would have indicated `drawn`; besides whether
    values do that are off by a bias that is left in (`Additive.ways`), both ways, and either way within the one limit that y lies beyond.
    """
    assert isinstance(c.truth, Additive)
    low, high = limits_of(c) or (-math.inf, math.inf)
    middle = y - c.truth.shift - c.truth.error
    read = y - c.truth.shift - (drawn - c.truth.at)
    ways = [read + d for d in (*c.truth.ways(), 0.0)]
    lower, true, upper, _ = ((low <= x) & (x <= high) for x in ways)
    least, most = low if middle < low else -math.inf, high if middle > high else math.inf
    beyond = np.any([(least <= x) & (x <= most) for x in ways], axis=0)
    return np.array([true, lower & upper, beyond])
