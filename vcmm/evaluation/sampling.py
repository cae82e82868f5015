"""Monte Carlo over the linear model (or with exact trials) for the characteristics that need it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.evaluation.certify import out_of_range
from vcmm.evaluation.exact import draw_inputs, exact_values
from vcmm.evaluation.linear import LinearModel
from vcmm.evaluation.montecarlo import Accumulator, Summary, Term, adaptive, simulate
from vcmm.evaluation.streams import copy_code
from vcmm.measuring.settings import Settings

BUDGET_TRIALS = 20_000
EXACT_BLOCK = 500
Progress = Callable[[str, float], None]


class Sampler:
    """Draws q for a task and evaluates the characteristics; products of two Inputs are multiplied trial by trial."""

    def __init__(
        self, model: LinearModel, terms: Sequence[Term], settings: Settings, progress: Progress
    ) -> None:
        self.model, self.terms, self.settings, self.progress = model, terms, settings, progress
        self.wide, self.values = with_products(model, terms)
        rows = self.wide[0].gain.shape[0] if self.wide else len(model.q0)
        self.start = np.concatenate([model.q0, np.zeros(rows - len(model.q0))])

    def summaries(self, needed: Sequence[int]) -> dict[int, Summary]:
        """Distribution of the chosen characteristics."""
        if self.settings.engine == "exact":
            return self._exact(needed)
        if self.settings.digits:
            return {i: self._adaptive(i) for i in needed}
        accumulators = [Accumulator(*place) for place in self._places(needed)]
        done = 0
        for block in simulate(self.start, self.wide, seed=self.settings.seed, trials=self.settings.trials):
            values = self._values(block)
            for i, accumulator in zip(needed, accumulators):
                accumulator.add(values[:, i])
            done += len(block)
            self.progress("Monte Carlo", done / self.settings.trials)
        return {i: a.summary() for i, a in zip(needed, accumulators)}

    def _values(self, block: Array) -> Array:
        """Characteristics of a block of draws. A ModelLimit there means draws of no use, not a wrong pose."""
        try:
            return self.values(block)
        except ModelLimit as error:
            raise out_of_range(error) from None

    def _trials(self, first: int, count: int) -> Array:
        blocks = simulate(self.start, self.wide, seed=self.settings.seed, trials=count, first=first)
        return np.concatenate([self._values(b) for b in blocks])

    def _adaptive(self, i: int) -> Summary:
        """JCGM 101, 7.9; the tolerance is fixed by a pilot, so that it cannot jump."""
        self.progress(f"adaptive Monte Carlo, {self.settings.digits} digits", 0.5)
        u0 = float(self._trials(0, 8192)[:, i].std())
        chosen = self.settings
        return adaptive(
            lambda first, count: self._trials(first, count)[:, i],
            digits=chosen.digits, p=chosen.p, kind=chosen.kind, u0=max(u0, 1e-15),
        )  # fmt: skip

    def _places(self, needed: Sequence[int]) -> list[tuple[float, float]]:
        """Centre and width of every histogram from a first block; the width is robust against infinite variance."""
        return [
            _place(column) for column in self._trials(0, min(8192, self.settings.trials))[:, list(needed)].T
        ]

    def _exact(self, needed: Sequence[int]) -> dict[int, Summary]:
        accumulators: list[Accumulator] = []
        for first in range(0, self.settings.trials, EXACT_BLOCK):
            count = min(EXACT_BLOCK, self.settings.trials - first)
            values = exact_values(self.model, draw_inputs(self.model, self.settings.seed, first, count))
            accumulators = accumulators or [Accumulator(*_place(values[:, i])) for i in needed]
            for i, accumulator in zip(needed, accumulators):
                accumulator.add(values[:, i])
            self.progress("exact trials", (first + count) / self.settings.trials)
        return {i: a.summary() for i, a in zip(needed, accumulators)}

    def alone(self) -> Array:
        """(terms, C): standard deviation with one Input at a time over that with all, on the same draws.

        A non-linear output has no sensitivity coefficient; what the inputs do only together is `interaction`.
        """
        trials = min(BUDGET_TRIALS, self.settings.trials)
        total = self._spread(self.wide, trials, self.start, self.values)
        out = []
        for done, term in enumerate(self.terms):
            self.progress("budget", done / len(self.terms))
            out.append(self._spread([term], trials, self.model.q0, self.model.values))
        return np.array(out).reshape(-1, len(total)) / np.where(total > 0, total, 1.0)

    def _spread(
        self, terms: Sequence[Term], trials: int, start: Array, values: Callable[[Array], Array]
    ) -> Array:
        blocks = simulate(start, terms, seed=self.settings.seed, trials=trials, fold=False)
        return np.concatenate([values(b) for b in blocks]).std(axis=0)


def _place(values: Array) -> tuple[float, float]:
    low, centre, high = np.quantile(values, [0.1587, 0.5, 0.8413])
    return float(centre), max(float(high - low) / 2, 1e-12)


def with_products(model: LinearModel, terms: Sequence[Term]) -> tuple[list[Term], Callable[[Array], Array]]:
    """Terms whose extra rows carry the departures that meet in products, and the evaluation that multiplies them."""
    pairs = [
        ((p.first, a), (p.second, b), gain) for p in model.products for a, b, gain in model.product_gains(p)
    ]
    carried = sorted({end for first, second, _ in pairs for end in (first, second)})
    if not carried:
        return list(terms), model.values
    k, place = len(model.q0), {end: i for i, end in enumerate(carried)}

    def values(block: Array) -> Array:
        q = block[:, :k].copy()
        for first, second, gain in pairs:
            q += (block[:, k + place[first]] * block[:, k + place[second]])[:, None] * gain
        return model.values(q)

    return [_widened(model, j, t, carried) for j, t in enumerate(terms)], values


def _widened(model: LinearModel, j: int, term: Term, carried: Sequence[tuple[int, int]]) -> Term:
    """The term with one more row per carried (Influence, copy): the departure itself, canonical units."""
    rows = np.zeros((len(carried), term.gain.shape[1]))
    influence = model.influences[j]
    for i, (number, copy) in enumerate(carried):
        if number == j:
            lane = np.flatnonzero(term.lanes[:, 1] == copy_code(influence.copies[copy]))[0]
            rows[i, lane] = influence.input.spread(1)[1][0, 0]
    return replace(term, gain=np.concatenate([term.gain, rows]))
