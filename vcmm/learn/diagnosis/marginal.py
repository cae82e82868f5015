"""Sizes and scanned values of one term together: draws from their joint posterior, the other terms projected out.

    p(values, sizes | rows) = p(values | rows) p(sizes | values, rows)

The first factor is the evidence over a grid of the scanned values about their best (time constants, distances and periods even
in their logarithm, moments even in time), the second a normal law in closed form, widened to a t law by the unknown noise. So the
size of a drift with an uncertain lag carries what the lag leaves open, and the interval of a lag need not be symmetric.
A moment is known to lie between two rows and no better: every place between them fits alike. Side lobes of a period and moments
beyond a worse one count as far as they are probable. How large such an effect may be is not known: every width of the prior has
its weight, its evidence.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Posterior, posterior, without_span
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Option
from vcmm.learn.diagnosis.constants import NOTHING, VERY_STRONG
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import MOMENTS, Refiner, at_value, reach, scanned_names, shift_value
from vcmm.learn.diagnosis.select import Selection, basis_of

WIDEST = 4.0  # times the range of the search
STEPS = {1: 40, 2: 12, 3: 8}  # to find where the evidence has fallen
NODES = {1: 41, 2: 21, 3: 7}  # values per scanned parameter
MOST_GAPS = 60  # between rows, on either side of a moment
HasFallen = Callable[[float], bool]


@dataclass(frozen=True, eq=False)
class TermDraws:
    """sizes (D, k) in units of the option; values: scanned name -> (D,), canonical units."""

    sizes: Array
    values: dict[str, Array]


def draw_term(
    problem: Problem, selection: Selection, i: int, refiner: Refiner, rng: np.random.Generator, count: int
) -> TermDraws:
    """Draws of term i."""
    term = selection.terms[i]
    names = scanned_names(term.option)
    others = [t for j, t in enumerate(selection.terms) if j != i]
    basis = basis_of(others, problem.m)
    given = _FittedTo(refiner, term.width, without_span(selection.y, basis), basis)
    axes = [_cells(term.option, name, given, problem, selection.factor) for name in names]
    fits: list[Posterior] = []
    weights, boxes = [], []
    for box in itertools.product(*axes):
        option: Option | None = term.option
        for name, (low, high) in zip(names, box):
            option = at_value(option, name, _middle(low, high, name), problem) if option is not None else None
        if option is not None:
            wide = sum(np.log(_width(low, high, name)) for name, (low, high) in zip(names, box))
            for fit in given.fits(option):
                fits.append(fit)
                boxes.append(box)
                weights.append(fit.log_evidence / selection.factor + wide)
    chance = np.exp(np.array(weights) - np.logaddexp.reduce(weights))
    which = rng.choice(len(fits), count, p=chance / chance.sum())
    freedom = max(problem.m - problem.nuisance.shape[1] - sum(t.white.shape[1] for t in selection.terms), 3)
    heavy = np.sqrt(freedom / rng.chisquare(freedom, count))[:, None]
    normal = np.stack([_normal(fits[w], selection.factor, rng) for w in which])
    means = np.stack([fits[w].mean for w in which])
    values = {n: np.array([_between(boxes[w][a], n, rng) for w in which]) for a, n in enumerate(names)}
    return TermDraws(means + normal * heavy, values)


@dataclass(frozen=True, eq=False)
class _FittedTo:
    """What a term is fitted to: residual r (m,), white, outside the basis of the others."""

    refiner: Refiner
    width: float
    r: Array
    basis: Array

    def fit(self, option: Option) -> Posterior:
        return self._at(self._columns(option), self.width)

    def fits(self, option: Option) -> list[Posterior]:
        """At every prior width."""
        x = self._columns(option)
        return [self._at(x, width) for width in SCALES]

    def _columns(self, option: Option) -> Array:
        return without_span(self.refiner.white.apply(option.columns), self.basis)

    def _at(self, x: Array, width: float) -> Posterior:
        return posterior(x, self.r, self.refiner.white.dof, np.full(x.shape[1], width))


def _normal(fit: Posterior, factor: float, rng: np.random.Generator) -> Array:
    size, vector = np.linalg.eigh(factor * fit.covariance)
    return np.asarray(vector @ (np.sqrt(np.maximum(size, 0.0)) * rng.standard_normal(len(size))))


def _cells(
    option: Option, name: str, given: _FittedTo, problem: Problem, factor: float
) -> Sequence[tuple[float, float]]:
    """Intervals of a scanned value that together hold nearly all of its posterior, the others at their best."""
    assert option.effect is not None
    centre = float(getattr(option.effect, name))
    top = given.fit(option).log_evidence

    others = [n for n in scanned_names(option) if n != name]

    def fallen(value: float) -> bool:
        trial = at_value(option, name, value, problem)
        if trial is None:
            return True
        for other in others:  # the ridge of two values that depend on one another
            trial = given.refiner.along(trial, other, given.r, given.basis)
        return top - given.fit(trial).log_evidence > VERY_STRONG * factor

    if name in MOMENTS and "time_s" in problem.run.columns:
        return _gaps(problem.run.columns["time_s"], centre, fallen)
    span = reach(option.effect, name, problem)
    count = min(len(scanned_names(option)), max(NODES))
    steps = span * np.geomspace(0.002 if count == 1 else 0.02, WIDEST, STEPS[count])
    end = _last_beside if name == "period" else _fallen_at
    low, high = (end(centre, sign * steps, name, fallen) for sign in (-1.0, 1.0))
    edges = [shift_value(centre, s, name) for s in np.linspace(low, high, NODES[count] + 1)]
    return list(itertools.pairwise(edges))


def _fallen_at(centre: float, steps: Array, name: str, fallen: HasFallen) -> float:
    """The first step of `moved` at which the evidence has fallen, the last where it does not."""
    return next((float(s) for s in steps if fallen(shift_value(centre, s, name))), float(steps[-1]))


def _last_beside(centre: float, steps: Array, name: str, fallen: HasFallen) -> float:
    """The step after the last at which the evidence has not fallen: side lobes stand beyond a valley."""
    high = [i for i, s in enumerate(steps) if not fallen(shift_value(centre, s, name))]
    return float(steps[min(max(high, default=-1) + 1, len(steps) - 1)])


def _gaps(time: Array, centre: float, fallen: HasFallen) -> list[tuple[float, float]]:
    """The gaps between rows about a moment at which the evidence has not fallen, and the gap of the moment itself."""
    times = np.unique(time)
    at = int(np.clip(np.searchsorted(times, centre), 1, len(times) - 1))
    out = [(float(times[at - 1]), float(times[at]))]
    for step in (-1, 1):
        near = range(at + step, at + step * MOST_GAPS, step)
        inner = (k for k in near if 1 <= k < len(times))
        out += [
            (float(times[k - 1]), float(times[k])) for k in inner if not fallen((times[k - 1] + times[k]) / 2)
        ]
    return sorted(out)


def _middle(low: float, high: float, name: str) -> float:
    return (low + high) / 2 if name in MOMENTS else float(np.sqrt(low * high))


def _width(low: float, high: float, name: str) -> float:
    return max(high - low if name in MOMENTS else float(np.log(high / low)), NOTHING)


def _between(cell: tuple[float, float], name: str, rng: np.random.Generator) -> float:
    (low, high), share = cell, rng.uniform()
    return low + share * (high - low) if name in MOMENTS else float(low * (high / low) ** share)
