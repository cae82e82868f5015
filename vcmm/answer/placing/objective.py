"""The objective of a placement: one number per pose, the smaller the better.

`Objective` is all that the search knows; `Uncertain` is that of a measuring task: a mixture of U, U/T, risk and cost
over the characteristics. A machine tool's cut part, or anything else that depends on a pose, may replace it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from vcmm.answer.evaluation.montecarlo import Term, marginal
from vcmm.answer.placing.closed_form import AtPoses, ClosedForm
from vcmm.answer.placing.extremes import ExtremeValues
from vcmm.answer.placing.rows import Rows
from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.risk import WrongDecisions, guard_band, wrong_decisions
from vcmm.part.part import Characteristic
from vcmm.task.measuring.fixture import OBJECTIVE_KINDS, Goal
from vcmm.task.measuring.plan import Ints
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import CORRECTED


class Objective(Protocol):
    """Interface of the search. values: poses (m, 6) that are feasible -> (m,); inf where the model does not reach.

    An objective may also have `gradient(poses) -> (m, 6)`, per mm and rad; without it differences are taken.
    """

    @property
    def unit(self) -> str: ...

    def values(self, poses: Array) -> Array: ...


@dataclass(frozen=True, eq=False)
class PoseSpread:
    """Results for all characteristics at m poses: u, U, bias (m, C), mm or rad."""

    u: Array
    expanded: Array
    bias: Array


@dataclass(frozen=True, eq=False)
class Uncertain:
    """Mixture of U, U/T, risk and cost of a measuring task."""

    closed: ClosedForm
    goal: Goal

    @classmethod
    def of(cls, scenario: Scenario, goal: Goal | None = None) -> Uncertain:
        """Raises UsageError for weights of unknown characteristics or an objective that needs tolerances that lack."""
        if not scenario.part.characteristics:
            raise UsageError(
                "the part has no characteristics; add [[part.characteristics]] with name, type and of"
            )
        rows = Rows.of(scenario)
        if not rows.machine.inputs:
            raise UsageError(
                "nothing is uncertain: add [repeatability], [errors] uncertainty or [[inputs]] to the machine or scenario"
            )
        closed, goal = ClosedForm.of(rows), complete(scenario, goal or Goal())
        return cls(closed.only(_read(closed, goal)), goal)

    @property
    def scenario(self) -> Scenario:
        return self.closed.rows.scenario

    @property
    def characteristics(self) -> tuple[Characteristic, ...]:
        return self.scenario.part.characteristics

    @property
    def unit(self) -> str:
        """Unit of the value: mm or rad for U alone, "1" for U/T and risk, "cost"."""
        kinds = [k for k, v in self.goal.mixture.items() if v]
        if kinds != ["U"]:
            return "cost" if kinds == ["cost"] else "1"
        return gps.unit(next(c for c in self.characteristics if self.weights[c.name]))

    @cached_property
    def weights(self) -> dict[str, float]:
        return {c.name: self.goal.weights.get(c.name, 0.0) for c in self.characteristics}

    @cached_property
    def smooth(self) -> tuple[int, ...]:
        """Numbers of the characteristics with a gradient: smooth ones, and forms that a known form dominates."""
        features = self.scenario.part.features
        return tuple(i for i, c in enumerate(self.characteristics) if gps.is_linear(c, features))

    @cached_property
    def _extremes(self) -> tuple[tuple[int, ...], ExtremeValues | None]:
        """Extreme values that count, and their evaluation; those of weight 0 cost nothing."""
        which = tuple(
            i for i, c in enumerate(self.characteristics) if i not in self.smooth and self.weights[c.name] > 0
        )
        return which, ExtremeValues(
            self.closed, tuple(self.characteristics[i] for i in which)
        ) if which else None

    @cached_property
    def gradient_rows(self) -> Array:
        """Change of the characteristics per displacement of each touch along its normal (C, n); rows of extreme values are 0."""
        model = self.closed.model
        rows = model.gradient() @ self.closed.operator
        rows[[i for i in range(len(rows)) if i not in self.smooth]] = 0.0
        return np.asarray(rows)

    @cached_property
    def factors(self) -> Array:
        """Coverage factor k of each characteristic (C,), from the exact law at the present pose; 1.96 for extremes."""
        scenario, p = self.scenario, self.scenario.settings.p
        normal = marginal(0.0, [_unit_term()], 0).interval(p, scenario.settings.kind)
        out = np.full(len(self.characteristics), (normal[1] - normal[0]) / 2)
        for i in self.smooth:
            out[i] = self._factor(i, out[i])
        return out

    def _factor(self, i: int, otherwise: float) -> float:
        terms = exact_terms(self.closed, self.gradient_rows[i], self.closed.reference)
        linear = marginal(0.0, terms, 0) if terms else None
        if linear is None or not linear.u > 0:
            return otherwise
        low, high = linear.interval(self.scenario.settings.p, self.scenario.settings.kind)
        return (high - low) / 2 / linear.u

    def spread(self, poses: Array) -> PoseSpread:
        """Return u, U and bias of all characteristics at poses (m, 6); extreme values of weight 0 are NaN."""
        parts = [
            self._spread(batch)
            for batch in self.closed.batches(np.atleast_2d(np.asarray(poses, dtype=float)))
        ]
        return PoseSpread(
            *(np.concatenate([getattr(p, n) for p in parts]) for n in ("u", "expanded", "bias"))
        )

    def _spread(self, batch: AtPoses) -> PoseSpread:
        shape = batch.m, len(self.characteristics)
        u, bias = np.full(shape, np.nan), np.zeros(shape)
        smooth = list(self.smooth)
        if smooth:
            weights = self.gradient_rows[smooth]
            first, second = batch.variances(weights)
            u[:, smooth] = np.sqrt(first.sum(axis=2) + second)
            if self.needs_bias:
                bias[:, smooth] = batch.systematic @ weights.T
        which, extremes = self._extremes
        if extremes is not None:
            bias[:, list(which)], u[:, list(which)] = extremes.moments(batch)
        return PoseSpread(u, u * self.factors, bias)

    @property
    def needs_bias(self) -> bool:
        """Whether known errors shift the value that is decided about."""
        wanted = any(self.goal.mixture.get(k) for k in ("risk", "cost"))
        return wanted and self.scenario.settings.known_bias != CORRECTED

    def values(self, poses: Array) -> Array:
        """Return the objective (m,); poses at which an effect is not known get inf."""
        poses = np.atleast_2d(np.asarray(poses, dtype=float))
        try:
            return self._values(poses)
        except ModelLimit:
            if len(poses) == 1:
                return np.array([np.inf])
            half = len(poses) // 2
            return np.concatenate([self.values(poses[:half]), self.values(poses[half:])])

    def _values(self, poses: Array) -> Array:
        spread = self.spread(poses)
        total = np.zeros(len(poses))
        for kind, share in self.goal.mixture.items():
            if share:
                total += share * self.part(kind, spread)
        return total

    def part(self, kind: str, spread: PoseSpread) -> Array:
        """Return one kind of objective (m,) from u, U and bias of the characteristics."""
        total = np.zeros(len(spread.u))
        for i, c in enumerate(self.characteristics):
            weight = self.weights[c.name]
            if not weight:
                continue
            if kind == "U":
                total += weight * spread.expanded[:, i]
            elif kind == "U/T":
                total += weight * spread.expanded[:, i] / width(c)
            else:
                judged = self.wrong_decisions(i, spread)
                total += weight * (judged.total if kind == "risk" else _cost(self.goal.costs, judged))
        return total

    def wrong_decisions(self, i: int, spread: PoseSpread) -> WrongDecisions:
        """Return the probabilities of wrong decisions about characteristic number i."""
        c = self.characteristics[i]
        nominal = gps.nominal(c, self.scenario.part.features)
        limits = gps.tolerance(c, nominal)
        assert limits is not None
        low, high = limits[0] - nominal, limits[1] - nominal
        low = -np.inf if gps.is_one_sided(c) else low
        guard = guard_band(self.scenario.settings.rule, spread.u[:, i], spread.expanded[:, i])
        return wrong_decisions(
            spread.u[:, i], spread.bias[:, i], (low, high), guard, process(c, self.goal, nominal)
        )


def _read(closed: ClosedForm, goal: Goal) -> Ints:
    """Return the numbers of the touches on features that a characteristic of some weight reads."""
    placed, part = closed.rows.touches, closed.rows.scenario.part
    counted = [c for c in part.characteristics if goal.weights.get(c.name)]
    names = {n for c in counted for n in gps.needs(c)}
    if any(c.type == "position" for c in counted):
        names = set(placed.rows)  # the alignment reads the others
    return np.sort(np.concatenate([placed.rows[n] for n in names if n in placed.rows]))


def _unit_term() -> Term:
    from vcmm.core.laws import Normal

    return Term("normal", Normal(1.0), np.ones((1, 1)), np.zeros((1, 2), dtype=np.uint32))


def exact_terms(closed: ClosedForm, weights: Array, six: Array) -> list[Term]:
    """Return the terms of one smooth characteristic at one pose, each with its own law (products left out)."""
    from vcmm.core.laws import MultivariateSamples

    terms = []
    for known_input, along in closed.along(six[None]):
        law, factor = known_input.input.spread(along.shape[1])
        if isinstance(law, MultivariateSamples):
            continue
        moved, gains = along @ factor, []
        for copy in range(known_input.copies):
            rows = known_input.codes == copy
            gains.append(weights[rows] @ moved[rows])
        gain = np.concatenate(gains)[None]
        terms.append(Term(known_input.input.id, law, gain, np.zeros((gain.shape[1], 2), dtype=np.uint32)))
    return terms


def width(c: Characteristic) -> float:
    """Return the width T of the tolerance, mm or rad."""
    if c.zone is not None:
        return float(c.zone)
    assert c.limits is not None
    return float(c.limits[1] - c.limits[0])


def process(c: Characteristic, goal: Goal, nominal: float) -> tuple[float, float]:
    """Return (mean, standard deviation) of the true values from nominal: as stated, else the middle and T/6."""
    low, high = (0.0, float(c.zone)) if c.zone is not None else (c.limits or (0.0, 0.0))
    middle, spread = goal.process.get(c.name, (0.0, (high - low) / 6))
    return (low + high) / 2 + middle, spread


def _cost(costs: Mapping[str, float], judged: WrongDecisions) -> Array:
    chances = {
        "accept_bad": judged.accept_bad,
        "reject_good": judged.reject_good,
        "undecided": judged.no_decision,
    }
    total: Array = np.zeros(len(judged.no_decision))
    for name, price in costs.items():
        total = total + price * chances[name]
    return total


def has_tolerance(c: Characteristic) -> bool:
    return c.zone is not None or (c.limits is not None and bool(np.isfinite(c.limits).all()))


def complete(scenario: Scenario, goal: Goal) -> Goal:
    """Return the goal with its defaults: U/T over toleranced characteristics, equal weights; by U where none is toleranced."""
    all_of_them = scenario.part.characteristics
    names = [c.name for c in all_of_them]
    for table in (goal.weights, goal.process):
        for name in table:
            if name not in names:
                raise UsageError(f'the part has no characteristic "{name}".{choose_from(name, names)}')
    with_limits = [c for c in all_of_them if has_tolerance(c)]
    mixture = dict(goal.mixture) or ({"U/T": 1.0} if with_limits else {"U": 1.0})
    limited = any(mixture.get(k) for k in OBJECTIVE_KINDS if k != "U")
    suits = with_limits if limited else list(all_of_them)
    weights = dict(goal.weights) or _equal(suits, limited)
    chosen = [c for c in all_of_them if weights.get(c.name)]
    for c in chosen if limited else []:
        if not has_tolerance(c):
            raise UsageError(
                f'"{c.name}" has no two-sided tolerance, which {" and ".join(mixture)} needs; add limits or zone, or set its weight to 0'
            )
    _one_dimension(chosen, mixture)
    return Goal(mixture, weights, goal.costs, goal.process)


def _equal(suits: list[Characteristic], limited: bool) -> dict[str, float]:
    if not suits:
        raise UsageError(
            'no characteristic has limits or a zone, which the objective needs; use objective = "U"'
        )
    return {c.name: 1.0 / len(suits) for c in suits}


def _one_dimension(chosen: list[Characteristic], mixture: Mapping[str, float]) -> None:
    units = {gps.unit(c) for c in chosen}
    if mixture.get("U") and len(units) > 1:
        raise UsageError(
            'lengths and angles cannot be added up: give weights to one of them only, or use objective = "U/T"'
        )
    if mixture.get("U") and sum(1 for v in mixture.values() if v) > 1:
        raise UsageError('"U" has a dimension and cannot be mixed with the others; use "U/T" in the mixture')
