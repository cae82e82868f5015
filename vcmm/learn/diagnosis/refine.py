"""Continuous search of the scanned values of an option: time constants, periods, change points."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Whitener, posterior, without_span
from vcmm.core.effect import Effect, parameter_fields, with_parameter
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Option, rebuild_option
from vcmm.learn.diagnosis.constants import LEAST_FRACTION
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.scans import is_change, turns_round

WIDTH = SCALES[2]  # prior width of the search, typical amplitudes: the middle one of all that are averaged
ROUNDS, POINTS = 3, 7
MOMENTS = ("t1", "time", "start")  # parameters that are a time of the clock
BENT = 0.1  # of the range searched: where the curvature of the evidence is taken


@dataclass(frozen=True, eq=False)
class Refiner:
    """Callable: option, white residual, basis of the other terms -> the option at its best scanned values."""

    problem: Problem
    white: Whitener
    spectra: dict[str, Any] = field(default_factory=dict)  # id of an effect -> its spectrum (see sharpen)

    def __call__(self, option: Option, r: Array, basis: Array) -> Option:
        names = scanned_names(option)
        for _ in names:  # two values depend on one another
            for name in names:
                option = self.along(option, name, r, basis)
        return option

    def open_share(self, option: Option, r: Array, basis: Array) -> float:
        """Return ln of the share of the searched range that the rows leave open, all scanned values together; at most 0."""
        return sum(self._open(option, name, r, basis) for name in scanned_names(option))

    def _open(self, option: Option, name: str, r: Array, basis: Array) -> float:
        assert option.effect is not None
        span = search_half_width(option.effect, name, self.problem)
        centre, step = float(getattr(option.effect, name)), BENT * span
        trials = [
            at_value(option, name, shift_value(centre, s * step, name), self.problem) for s in (-1.0, 1.0)
        ]
        top = self.evidence(option, r, basis)
        fall = sum(top - self.evidence(t, r, basis) for t in trials if t is not None)
        bend = max(fall / step**2, LEAST_FRACTION)
        return min(0.0, 0.5 * float(np.log(2.0 * np.pi / bend)) - float(np.log(2.0 * span)))

    def along(self, option: Option, name: str, r: Array, basis: Array) -> Option:
        """Return the option at its best value of one scanned parameter."""
        assert option.effect is not None
        span = search_half_width(option.effect, name, self.problem)
        best, best_value = option, self.evidence(option, r, basis)
        for _ in range(ROUNDS):
            assert best.effect is not None
            centre = float(getattr(best.effect, name))
            for step in np.linspace(-1, 1, POINTS):
                trial = at_value(best, name, shift_value(centre, step * span, name), self.problem)
                value = -np.inf if trial is None or step == 0 else self.evidence(trial, r, basis)
                if trial is not None and value > best_value:
                    best, best_value = trial, value
            span /= POINTS / 2
        return best

    def evidence(self, option: Option, r: Array, basis: Array) -> float:
        x = without_span(self.white.apply(option.columns), basis)
        return posterior(x, r, self.white.dof, np.full(x.shape[1], WIDTH)).log_evidence


def scanned_names(option: Option) -> list[str]:
    """Return the names of the continuous non-linear parameters of an option; the periods of an axis that turns are no continuum."""
    if option.effect is None:
        return []
    return [
        f.name
        for f in parameter_fields(option.effect)
        if (len(f.metadata["scan"]) > 1 or is_change(f))
        and float(getattr(option.effect, f.name)) > 0
        and not (f.name == "period" and turns_round(option.effect))
    ]


def search_half_width(effect: Effect, name: str, problem: Problem) -> float:
    """Return half width of the search: relative (ln) for most, 0.4 / travel in frequency for periods, seconds for a step."""
    if name == "period":
        axis = getattr(effect, "axis", "")
        q = problem.run.position.get(axis)
        travel = float(np.ptp(q)) if q is not None else 0.0
        period = float(getattr(effect, name))
        return min(0.3, 0.4 * period / travel) if travel > 0 else 0.02
    if name in MOMENTS:
        time = problem.run.column("time_s")
        return float(np.ptp(time)) / max(problem.run.n, 1) * 3
    return 0.6


def shift_value(centre: float, step: float, name: str) -> float:
    return centre + step if name in MOMENTS else centre * float(np.exp(step))


def at_value(option: Option, name: str, value: float, problem: Problem) -> Option | None:
    """Return the same option with one scanned parameter changed."""
    assert option.effect is not None
    made = rebuild_option(option, problem, with_parameter(option.effect, name, value))
    if made is None or made.columns.shape != option.columns.shape:
        return None
    return replace(made, unit=made.unit)
