"""Parameters of an answer in the units of reports, under the names of the contract.

Pairs (cosine, sine) are shown as an amplitude, element vectors as an rms or sd. Values are those of the best fit; uncertainties
and intervals are those of draws from the joint posterior of sizes and scanned values (see marginal).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.core.effect import OF_AN_ANGLE, Effect, basis, parameter
from vcmm.core.run import Array
from vcmm.core.units import in_unit
from vcmm.learn.diagnosis.candidates import linear_parameters
from vcmm.learn.diagnosis.constants import SECURE
from vcmm.learn.diagnosis.marginal import draw_term
from vcmm.learn.diagnosis.problem import Problem, generator
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.scans import turns_round
from vcmm.learn.diagnosis.select import Selection

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


def estimates(
    problem: Problem, selection: Selection, i: int, refiner: Refiner, seed: int
) -> dict[str, Estimate]:
    """All parameters of term i."""
    assert selection.fit is not None
    term, part = selection.terms[i], selection.span(i)
    mean, unit = selection.fit.mean[part], term.option.unit
    draws = draw_term(problem, selection, i, refiner, generator(seed, f"estimate {term.family.id}"), DRAWS)
    values = draws.sizes * unit
    if term.option.effect is None:
        return {"rms": _rms_seen(problem, term.option.columns, mean, draws.sizes)}
    out = _linear(problem, selection, i, mean * unit, values.std(axis=0), values)
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
    """The unit in which a parameter is shown; what is a length along a linear axis is an angle about one that turns."""
    shown = str(parameter(effect, name).metadata["show"])
    return OF_AN_ANGLE.get(shown, shown) if effect.about.along_axis and turns_round(effect) else shown


def _rms_seen(problem: Problem, columns: Array, mean: Array, values: Array) -> Estimate:
    """rms of the observed change (m,), for a change that has no single component."""
    gram = columns.T @ columns / problem.m
    draws = np.sqrt(np.maximum(np.einsum("dk,kl,dl->d", values, gram, values), 0.0))
    unit = "urad" if problem.recording.kind == "angle" else "um"
    return _estimate(float(np.median(draws)), float(draws.std()), draws, unit)


def _linear(
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
    own = effect.diagnosis.report(effect, values[:, 0])
    if own is not None:
        name, draws, shown = own
        centre = effect.diagnosis.report(effect, mean[:1])
        assert centre is not None
        return {name: _estimate(float(centre[1][0]), float(draws.std()), draws, shown)}
    if arrays:
        size = {effect.diagnosis.size_name: _size(problem, selection, i, mean, values)}
        return size | _single(selection, i, mean, u, values)
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


def _single(selection: Selection, i: int, mean: Array, u: Array, values: Array) -> dict[str, Estimate]:
    """Parameters of one number that stand beside an array: the straight part of a lost motion."""
    option = selection.terms[i].option
    assert option.effect is not None
    out = {}
    for at, label in enumerate(option.labels):
        if "[" not in label and "@" not in label:
            shown = unit_of(option.effect, label)
            out[_shown_name(selection, i, label)] = _estimate(mean[at], u[at], values[:, at], shown)
    return out


def _shown_name(selection: Selection, i: int, name: str) -> str:
    """The name of the contract where the effect keeps a parameter under another; a pair keeps its own names."""
    effect = selection.terms[i].option.effect
    assert effect is not None
    if name in ("sine", "cosine"):
        return name
    return next((alias for alias, own in effect.about.aliases.items() if own == name), name)


def _estimate(value: float, u: float, draws: Array, unit: str) -> Estimate:
    low, high = np.quantile(draws, COVERAGE_ENDS)
    low, high = min(low, value), max(high, value)  # draws of a length lie above the length of their mean
    return Estimate(
        in_unit(float(value), unit),
        in_unit(float(u), unit),
        (in_unit(float(low), unit), in_unit(float(high), unit)),
        unit,
    )


def _size(problem: Problem, selection: Selection, i: int, mean: Array, values: Array) -> Estimate:
    """rms of an array parameter: over the rows, about its mean, for a field; over the elements for random vectors.

    The median of its posterior: the rms of the posterior mean is too small, since that is drawn towards zero.
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
    gram = np.einsum("nik,nil->kl", field, field) / problem.run.n
    rms = np.sqrt(np.maximum(np.einsum("dk,kl,dl->d", values, gram, values), 0.0))
    return _estimate(float(np.median(rms)), float(rms.std()), rms, "urad" if turns else "um")


def as_json(found: Mapping[str, Estimate]) -> dict[str, dict[str, object]]:
    return {
        k: {"value": e.value, "u": e.u, "interval95": list(e.interval95), "unit": e.unit}
        for k, e in found.items()
    }
