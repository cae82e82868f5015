"""Objective of a plan: u of every characteristic in units of its tolerance, form characteristics by draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.answer.placing.candidates import TouchProblem
from vcmm.answer.placing.design import Design, Target, fewest_touches
from vcmm.answer.placing.motions import outputs
from vcmm.core.pose import Array
from vcmm.part.gps import characteristics as gps

DRAWS = 200


@dataclass(frozen=True, eq=False)
class FormCheck:
    """Draws of one feature: errors (N_f, draws) that touches share, scatter (N_f, draws) of one touch each, true range."""

    feature: int
    common: Array
    scatter: Array
    short: Array
    true: Array

    @classmethod
    def of(cls, problem: TouchProblem, feature: str, seed: int) -> FormCheck:
        """Return draws of the true range, that of the form less its least-squares element, over all candidates."""
        c = problem.candidates
        f = c.names.index(feature)
        rows = c.of(f)
        rng = np.random.default_rng([seed, f])
        z = rng.normal(size=(c.common.shape[1], DRAWS))
        form = c.common[rows, problem.form] @ z[problem.form]
        jac = c.rows[f]
        rest = form - jac @ np.linalg.lstsq(jac, form, rcond=None)[0]
        scatter = c.touch[rows, None] * rng.normal(size=(len(rows), DRAWS))
        short = c.short[rows, None] * rng.normal(size=(len(rows), DRAWS))
        return cls(f, c.common[rows] @ z, scatter, short, np.ptp(rest, axis=0))

    @property
    def typical(self) -> float:
        """Mean true range, mm."""
        return float(np.mean(self.true))

    def square(self, design: Design) -> float:
        """Return the mean square of measured - true range, mm^2."""
        rows = design.rows_of[self.feature]
        w = design.counts[rows]
        used = np.flatnonzero(w)
        jac = design.c.rows[self.feature][used]
        error = (self.common + self.short)[used] + self.scatter[used] / np.sqrt(w[used])[:, None]
        fitted = design.inverse[self.feature] @ ((jac.T * w[used]) @ error)
        return float(np.mean((np.ptp(error - jac @ fitted, axis=0) - self.true) ** 2))


@dataclass(frozen=True, eq=False)
class PlanGoal:
    """Outputs by characteristic: rows of `target`, and form characteristics with their weight."""

    target: Target
    rows: Mapping[str, slice]
    forms: Mapping[str, tuple[FormCheck, float]]

    def variances(self, design: Design) -> dict[str, float]:
        square = design.variances()
        out = {name: float(square[s].sum()) for name, s in self.rows.items()}
        return out | {name: check.square(design) for name, (check, _) in self.forms.items()}

    def value(self, design: Design) -> float:
        extra = sum(weight * check.square(design) for check, weight in self.forms.values())
        return design.value() + extra


def goal_of(
    problem: TouchProblem, weights: Mapping[str, float] | None, criterion: str, seed: int, plain: bool = False
) -> PlanGoal:
    scenario = problem.scenario
    by_name = outputs(
        scenario.part.characteristics, scenario.part.features, problem.motions, scenario.plan.alignment
    )
    scale = _scales(problem, by_name)
    share = {
        c.name: (weights or {}).get(c.name, 0.0 if weights else 1.0) for c in scenario.part.characteristics
    }
    rows, weight, where, at = [], [], {}, 0
    for name, goal in by_name.items():
        rows.append(goal)
        weight += [share[name] / scale[name] ** 2] * len(goal)
        where[name] = slice(at, at + len(goal))
        at += len(goal)
    checks = {} if plain else _form_checks(problem, share, seed)
    total = sum(m.count for m in problem.motions.values())
    stacked = np.concatenate(rows) if rows else np.zeros((0, total))
    values = np.array(weight)
    if (
        criterion == "A"
    ):  # every motion as a length at the rim of its feature; characteristics are only reported
        lengths = np.concatenate([m.scale() for m in problem.motions.values()])
        stacked = np.concatenate([stacked, np.diag(lengths)])
        values = np.concatenate([0.0 * values, np.ones(total)])
    return PlanGoal(Target(stacked, values, criterion), where, checks)


def _form_checks(
    problem: TouchProblem, share: Mapping[str, float], seed: int
) -> dict[str, tuple[FormCheck, float]]:
    out = {}
    for c in problem.scenario.part.characteristics:
        if c.type in gps.FORM:
            check = FormCheck.of(problem, c.of[0], seed)
            out[c.name] = (check, share[c.name] / (c.zone or check.typical) ** 2)
    return out


def _scales(problem: TouchProblem, rows: Mapping[str, Array]) -> dict[str, float]:
    """Return the scale of u by characteristic: the tolerance, else u of the present plan."""
    out = {}
    base = None
    for c in problem.scenario.part.characteristics:
        if c.name not in rows:
            continue
        limits = gps.tolerance(c, gps.nominal(c, problem.scenario.part.features))
        if limits is not None:
            out[c.name] = limits[1] - limits[0]
            continue
        if base is None:
            empty = np.zeros((0, rows[c.name].shape[1]))
            base = Design(
                problem.candidates, Target(empty, np.zeros(0), "D"), fewest_touches(problem.candidates, 3)
            )
        out[c.name] = float(np.sqrt(max(float(base.variances(rows[c.name]).sum()), 1e-24)))
    return out
