"""Does the part conform as a whole? All its tolerances judged together, with what their measurements share (JCGM 106:2012, 8.4).

The true values of sizes, distances and angles are drawn together from the linear model: what errs in common (a temperature, a scale,
a datum) moves them in common. An extreme value is known by itself only; with it the joint probability lies between two bounds:
at least 1 less all that is doubted, at most the smallest (Frechet).
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

    independent: the product, as if nothing were shared. reason: why nothing is told (then the numbers are NaN), else empty.
    """

    names: tuple[str, ...]
    least: float
    most: float
    independent: float
    decision: str
    reason: str = ""


def judged_jointly(
    model: LinearModel, found: Sequence[CharacteristicResult], readings: Sequence[float], seed: int
) -> JointJudgement | None:
    """Of all toleranced characteristics, `readings` what was indicated of each of `found`; None with fewer than two of them."""
    toleranced = [(c, y) for c, y in zip(found, readings) if c.decision is not None]
    if len(toleranced) < 2:
        return None
    names = tuple(c.name for c, _ in toleranced)
    hidden = [c.name for c, _ in toleranced if c.decision is not None and c.decision.p_conform is None]
    if hidden:
        reason = f"coverage is not demonstrated of {', '.join(hidden)}"
        return JointJudgement(names, math.nan, math.nan, math.nan, UNDECIDED, reason)
    alone = [float(c.decision.p_conform or 0.0) for c, _ in toleranced if c.decision is not None]
    together = [pair for pair in toleranced if isinstance(pair[0].truth, Additive)]
    common = _common(model, together, seed) if together else 1.0
    others = [p for p, (c, _) in zip(alone, toleranced) if not isinstance(c.truth, Additive)]
    least, most = max(common - sum(1.0 - p for p in others), 0.0), min([common, *others])
    text = CONFORMS if least >= ACCEPT else REJECTED if most <= REJECT else UNDECIDED
    return JointJudgement(names, least, most, math.prod(alone), text)


def _common(model: LinearModel, together: Sequence[tuple[CharacteristicResult, float]], seed: int) -> float:
    """Share of common draws in which all true values lie within their limits."""
    order = [c.name for c in model.characteristics]
    numbers = tuple(order.index(c.name) for c, _ in together)
    held, rng = 0, np.random.default_rng([seed, FORMS])
    for drawn in _drawn_values(model, numbers, seed):
        inside = np.ones(len(drawn), dtype=bool)
        for k, (c, y) in enumerate(together):
            inside &= _within(c, y, drawn[:, k] + _by_form(c, len(drawn), rng))
        held += int(inside.sum())
    return held / TRIALS


_DRAWN: WeakKeyDictionary[LinearModel, dict[tuple[tuple[int, ...], int], list[Array]]] = WeakKeyDictionary()


def _drawn_values(model: LinearModel, numbers: tuple[int, ...], seed: int) -> list[Array]:
    """What drawn machines indicate (TRIALS, k) of characteristics number `numbers`, in blocks: the same for all parts of a batch, and kept with their model."""
    known = _DRAWN.setdefault(model, {})
    if (numbers, seed) not in known:
        terms, values = with_products(model, model.terms())
        start = np.zeros(len(terms[0].gain) if terms else len(model.q0))
        start[: len(model.q0)] = model.q0
        blocks = simulate(start, terms, seed=seed, trials=TRIALS)
        known[numbers, seed] = [np.ascontiguousarray(values(block)[:, list(numbers)]) for block in blocks]
    return known[numbers, seed]


def _by_form(c: CharacteristicResult, count: int, rng: np.random.Generator) -> Array:
    """(m,): what a form between the points adds, of every characteristic by itself."""
    if not isinstance(c.truth, Additive) or not isinstance(c.truth.law, WidenedLaw):
        return np.zeros(count)
    return np.asarray(rng.choice(c.truth.law.sizes, count) * rng.choice([-1.0, 1.0], count))


def _within(c: CharacteristicResult, y: float, drawn: Array) -> Array:
    """Whether the true value lies within its limits (m,), when y is read and the machine would have indicated `drawn`."""
    assert isinstance(c.truth, Additive)
    low, high = limits_of(c) or (-math.inf, math.inf)
    true = y - c.truth.shift - (drawn - c.truth.at)
    return np.asarray((low <= true) & (true <= high))
