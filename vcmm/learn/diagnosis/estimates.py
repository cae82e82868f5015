"""Parameters of an answer in the units of reports, under the names of the contract.

Pairs (cosine, sine) are shown as an amplitude, element vectors as an rms or sd. Values are those of the best fit; uncertainties
and intervals are those of draws from the joint posterior of sizes and scanned values.

Sizes and scanned values of one term together: draws from their joint posterior, the other terms projected out.

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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Posterior, posterior, without_span
from vcmm.core.effect import OF_AN_ANGLE, Effect, basis, parameter
from vcmm.core.run import Array
from vcmm.core.units import in_unit
from vcmm.learn.diagnosis.candidates import Option, linear_parameters
from vcmm.learn.diagnosis.constants import LEAST_FRACTION, SECURE, VANISHING_SHARE, VERY_STRONG
from vcmm.learn.diagnosis.problem import Problem, generator
from vcmm.learn.diagnosis.refine import (
    MOMENTS,
    Refiner,
    at_value,
    scanned_names,
    search_half_width,
    shift_value,
)
from vcmm.learn.diagnosis.scans import turns_round
from vcmm.learn.diagnosis.select import Selection, terms_basis

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
    """Return random numbers from the joint posterior of term i."""
    term = selection.terms[i]
    names = scanned_names(term.option)
    others = [t for j, t in enumerate(selection.terms) if j != i]
    basis = terms_basis(others, problem.m)
    given = _ConditionalFit(refiner, term.width, without_span(selection.y, basis), basis)
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
    normal = np.stack([_normal_draw(fits[w], selection.factor, rng) for w in which])
    means = np.stack([fits[w].mean for w in which])
    values = {n: np.array([_uniform_in(boxes[w][a], n, rng) for w in which]) for a, n in enumerate(names)}
    return TermDraws(means + normal * heavy, values)


@dataclass(frozen=True, eq=False)
class _ConditionalFit:
    """Data for the fit of a term: residual r (m,), white, outside the basis of the others."""

    refiner: Refiner
    width: float
    r: Array
    basis: Array

    def fit(self, option: Option) -> Posterior:
        return self._at(self._columns(option), self.width)

    def fits(self, option: Option) -> list[Posterior]:
        """Return the fits at every prior width."""
        x = self._columns(option)
        return [self._at(x, width) for width in SCALES]

    def _columns(self, option: Option) -> Array:
        return without_span(self.refiner.white.apply(option.columns), self.basis)

    def _at(self, x: Array, width: float) -> Posterior:
        return posterior(x, self.r, self.refiner.white.dof, np.full(x.shape[1], width))


def _normal_draw(fit: Posterior, factor: float, rng: np.random.Generator) -> Array:
    size, vector = np.linalg.eigh(factor * fit.covariance)
    return np.asarray(vector @ (np.sqrt(np.maximum(size, 0.0)) * rng.standard_normal(len(size))))


def _cells(
    option: Option, name: str, given: _ConditionalFit, problem: Problem, factor: float
) -> Sequence[tuple[float, float]]:
    """Return the intervals of a scanned value that together hold nearly all of its posterior, the others at their best."""
    assert option.effect is not None
    centre = float(getattr(option.effect, name))
    top = given.fit(option).log_evidence

    others = [n for n in scanned_names(option) if n != name]

    def has_fallen(value: float) -> bool:
        trial = at_value(option, name, value, problem)
        if trial is None:
            return True
        for other in others:  # the ridge of two values that depend on one another
            trial = given.refiner.along(trial, other, given.r, given.basis)
        return top - given.fit(trial).log_evidence > VERY_STRONG * factor

    if name in MOMENTS and "time_s" in problem.run.columns:
        return _gaps(problem.run.columns["time_s"], centre, has_fallen)
    span = search_half_width(option.effect, name, problem)
    count = min(len(scanned_names(option)), max(NODES))
    steps = span * np.geomspace(0.002 if count == 1 else 0.02, WIDEST, STEPS[count])
    end = _end_of_lobes if name == "period" else _first_fall
    low, high = (end(centre, sign * steps, name, has_fallen) for sign in (-1.0, 1.0))
    edges = [shift_value(centre, s, name) for s in np.linspace(low, high, NODES[count] + 1)]
    return list(itertools.pairwise(edges))


def _first_fall(centre: float, steps: Array, name: str, has_fallen: HasFallen) -> float:
    """Return the first step of `moved` at which the evidence has fallen, the last where it does not."""
    return next((float(s) for s in steps if has_fallen(shift_value(centre, s, name))), float(steps[-1]))


def _end_of_lobes(centre: float, steps: Array, name: str, has_fallen: HasFallen) -> float:
    """Return the step after the last at which the evidence has not fallen: side lobes lie beyond a valley."""
    high = [i for i, s in enumerate(steps) if not has_fallen(shift_value(centre, s, name))]
    return float(steps[min(max(high, default=-1) + 1, len(steps) - 1)])


def _gaps(time: Array, centre: float, has_fallen: HasFallen) -> list[tuple[float, float]]:
    """Return the gaps between rows about a moment at which the evidence has not fallen, and the gap of the moment itself."""
    times = np.unique(time)
    at = int(np.clip(np.searchsorted(times, centre), 1, len(times) - 1))
    out = [(float(times[at - 1]), float(times[at]))]
    for step in (-1, 1):
        near = range(at + step, at + step * MOST_GAPS, step)
        inner = (k for k in near if 1 <= k < len(times))
        out += [
            (float(times[k - 1]), float(times[k]))
            for k in inner
            if not has_fallen((times[k - 1] + times[k]) / 2)
        ]
    return sorted(out)


def _middle(low: float, high: float, name: str) -> float:
    return (low + high) / 2 if name in MOMENTS else float(np.sqrt(low * high))


def _width(low: float, high: float, name: str) -> float:
    return max(high - low if name in MOMENTS else float(np.log(high / low)), LEAST_FRACTION)


def _uniform_in(cell: tuple[float, float], name: str, rng: np.random.Generator) -> float:
    (low, high), share = cell, rng.uniform()
    return low + share * (high - low) if name in MOMENTS else float(low * (high / low) ** share)


DRAWS = 2000
LENGTHS = ("amplitude", "arm")  # the length of the vector, not its rms
COVERAGE_ENDS = ((1.0 - SECURE) / 2.0, (1.0 + SECURE) / 2.0)


@dataclass(frozen=True)
class Estimate:
    """value, standard uncertainty and 95 % coverage interval in `unit`."""

    value: float
    u: float
    interval95: tuple[float, float]
    unit: str


def estimate_parameters(
    problem: Problem, selection: Selection, i: int, refiner: Refiner, seed: int
) -> dict[str, Estimate]:
    """Return all parameters of term i."""
    assert selection.fit is not None
    term, part = selection.terms[i], selection.span(i)
    mean, unit = selection.fit.mean[part], term.option.unit
    draws = draw_term(problem, selection, i, refiner, generator(seed, f"estimate {term.family.id}"), DRAWS)
    values = draws.sizes * unit
    if term.option.effect is None:
        return {"rms": _observed_rms(problem, term.option.columns, mean, draws.sizes)}
    out = _linear_estimates(problem, selection, i, mean * unit, values.std(axis=0), values)
    for name, those in draws.values.items():
        shown = unit_of(term.option.effect, name)
        best = float(getattr(term.option.effect, name))
        out[_shown_name(selection, i, name)] = _estimate(best, float(those.std()), those, shown)
    if turns_round(term.option.effect) and hasattr(
        term.option.effect, "period"
    ):  # a whole fraction of a turn
        period = float(term.option.effect.period)
        out["period"] = _estimate(period, 0.0, np.full(1, period), unit_of(term.option.effect, "period"))
    return out


def unit_of(effect: Effect, name: str) -> str:
    """Return the unit in which a parameter is shown; what is a length along a linear axis is an angle about one that turns."""
    shown = str(parameter(effect, name).metadata["show"])
    return OF_AN_ANGLE.get(shown, shown) if effect.about.along_axis and turns_round(effect) else shown


def _observed_rms(problem: Problem, columns: Array, mean: Array, values: Array) -> Estimate:
    """Return the rms of the observed change (m,), for a change that has no single component."""
    gram = columns.T @ columns / problem.m
    draws = np.sqrt(np.maximum(np.einsum("dk,kl,dl->d", values, gram, values), 0.0))
    unit = "urad" if problem.recording.kind == "angle" else "um"
    return _estimate(float(np.median(draws)), float(draws.std()), draws, unit)


def _linear_estimates(
    problem: Problem, selection: Selection, i: int, mean: Array, u: Array, values: Array
) -> dict[str, Estimate]:
    term = selection.terms[i]
    effect = term.option.effect
    assert effect is not None
    out: dict[str, Estimate] = {}
    names = linear_parameters(effect)
    arrays = any("[" in label or "@" in label for label in term.option.labels)
    if effect.diagnosis.size_name in LENGTHS or effect.diagnosis.elements(effect):
        shown = unit_of(effect, names[0])
        if str(getattr(effect, "component", ""))[1:2] in tuple("ABC"):
            shown = "urad"
        elif shown == "mm or rad":
            shown = "um"
        length = np.linalg.norm(values, axis=1)
        whole = _estimate(float(np.linalg.norm(mean)), float(length.std()), length, shown)
        each = enumerate(effect.diagnosis.elements(effect))
        return {effect.diagnosis.size_name: whole} | {
            f"{effect.diagnosis.size_name}_{e}": _estimate(mean[j], u[j], values[:, j], shown)
            for j, e in each
        }
    report = effect.diagnosis.report(effect, values[:, 0])
    if report is not None:
        name, draws, shown = report
        centre = effect.diagnosis.report(effect, mean[:1])
        assert centre is not None
        return {name: _estimate(float(centre[1][0]), float(draws.std()), draws, shown)}
    if arrays:
        size = {effect.diagnosis.size_name: _rms_estimate(problem, selection, i, mean, values)}
        return size | _single_numbers(selection, i, mean, u, values)
    for at, name in enumerate(names):
        shown = unit_of(effect, name)
        out[_shown_name(selection, i, name)] = _estimate(mean[at], u[at], values[:, at], shown)
    if {"sine", "cosine"} <= set(names):
        j, k = names.index("sine"), names.index("cosine")
        shown = unit_of(effect, "sine")
        pair = np.hypot(values[:, j], values[:, k])
        both = float(np.hypot(mean[j], mean[k]))
        out = {
            "amplitude": _estimate(both, float(pair.std()), pair, shown),
            **{k2: v for k2, v in out.items() if k2 != "amplitude"},
        }
    return out


def _single_numbers(
    selection: Selection, i: int, mean: Array, u: Array, values: Array
) -> dict[str, Estimate]:
    """Return the parameters of one number beside an array: the straight part of a lost motion."""
    option = selection.terms[i].option
    assert option.effect is not None
    out = {}
    for at, label in enumerate(option.labels):
        if "[" not in label and "@" not in label:
            shown = unit_of(option.effect, label)
            out[_shown_name(selection, i, label)] = _estimate(mean[at], u[at], values[:, at], shown)
    return out


def _shown_name(selection: Selection, i: int, name: str) -> str:
    """Return the name of the contract where the effect keeps a parameter under another; a pair keeps its own names."""
    effect = selection.terms[i].option.effect
    assert effect is not None
    if name in ("sine", "cosine"):
        return name
    return next(
        (alias for alias, name_of_alias in effect.about.aliases.items() if name_of_alias == name), name
    )


def _estimate(value: float, u: float, draws: Array, unit: str) -> Estimate:
    low, high = np.quantile(draws, COVERAGE_ENDS)
    low, high = min(low, value), max(high, value)  # draws of a length lie above the length of their mean
    return Estimate(
        in_unit(float(value), unit),
        in_unit(float(u), unit),
        (in_unit(float(low), unit), in_unit(float(high), unit)),
        unit,
    )


def _rms_estimate(problem: Problem, selection: Selection, i: int, mean: Array, values: Array) -> Estimate:
    """Return the rms of an array parameter: over the rows, about its mean, for a field; over the elements for random vectors.

    Of a field the part that the nuisance takes up in full (the line of a straightness, where the alignment is free) is not counted: no row
    tells it, so that its draws are those of the prior.

    The median of its posterior: the rms of the posterior mean is too small, since the mean is shrunk towards zero.
    """
    term = selection.terms[i]
    effect = term.option.effect
    assert effect is not None
    unit = unit_of(effect, linear_parameters(effect)[0])
    if any("@" in label for label in term.option.labels):
        rms = np.sqrt((values**2).mean(axis=1))
        return _estimate(float(np.median(rms)), float(rms.std()), rms, unit)
    six = np.concatenate([basis(effect, n, problem.run) for n in linear_parameters(effect)], axis=2)
    turns = not np.any(six[:, :3])
    field = six[:, 3:] if turns else six[:, :3]
    field = field - field.mean(axis=0)  # a constant is the pose, or the zero of the axis
    flat = field.reshape(-1, field.shape[2])
    free = flat @ (term.option.unit[:, None] * invisible_directions(problem.nuisance, term.option.columns))
    flat = flat - free @ np.linalg.lstsq(free, flat, rcond=None)[0]
    gram = flat.T @ flat / problem.run.n
    rms = np.sqrt(np.maximum(np.einsum("dk,kl,dl->d", values, gram, values), 0.0))
    return _estimate(float(np.median(rms)), float(rms.std()), rms, "urad" if turns else "um")


def invisible_directions(nuisance: Array, columns: Array) -> Array:
    """Return the directions (k, r) of the numbers of a term of which the nuisance (m, p) leaves less than VANISHING_SHARE of the signal; columns (m, k)."""
    u, size, v = np.linalg.svd(columns, full_matrices=False)
    large = size > VANISHING_SHARE * size.max(initial=0.0)
    signals = u[:, large]
    if nuisance.shape[1]:
        signals = signals - nuisance @ np.linalg.lstsq(nuisance, signals, rcond=None)[0]
    _, share, w = np.linalg.svd(signals, full_matrices=False)
    return np.hstack([v[~large].T, (v[large].T / size[large]) @ w[share <= VANISHING_SHARE].T])


def estimates_json(estimates: Mapping[str, Estimate]) -> dict[str, dict[str, object]]:
    return {
        k: {"value": e.value, "u": e.u, "interval95": list(e.interval95), "unit": e.unit}
        for k, e in estimates.items()
    }
