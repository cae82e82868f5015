"""What a plan is judged by: u of every characteristic in units of its tolerance, form characteristics by draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.core.pose import Array
from vcmm.gps import characteristics as gps
from vcmm.placing.candidates import Problem
from vcmm.placing.design import Design, Target, least
from vcmm.placing.formcheck import FormCheck
from vcmm.placing.motions import outputs


@dataclass(frozen=True, eq=False)
class Goal:
    """Outputs by characteristic: rows of `target`, and form characteristics with their weight."""

    target: Target
    rows: Mapping[str, slice]
    forms: Mapping[str, tuple[FormCheck, float]]

    def variances(self, design: Design) -> dict[str, float]:
        found = design.variances()
        out = {name: float(found[s].sum()) for name, s in self.rows.items()}
        return out | {name: check.square(design) for name, (check, _) in self.forms.items()}

    def value(self, design: Design) -> float:
        extra = sum(weight * check.square(design) for check, weight in self.forms.values())
        return design.value() + extra


def goal_of(
    problem: Problem, weights: Mapping[str, float] | None, criterion: str, seed: int, plain: bool = False
) -> Goal:
    scenario = problem.scenario
    found = outputs(
        scenario.part.characteristics, scenario.part.features, problem.motions, scenario.plan.alignment
    )
    scale = _scales(problem, {n: o.rows for n, o in found.items()})
    share = {
        c.name: (weights or {}).get(c.name, 0.0 if weights else 1.0) for c in scenario.part.characteristics
    }
    rows, weight, where, at = [], [], {}, 0
    for name, o in found.items():
        rows.append(o.rows)
        weight += [share[name] / scale[name] ** 2] * len(o.rows)
        where[name] = slice(at, at + len(o.rows))
        at += len(o.rows)
    checks = {} if plain else _form_checks(problem, share, seed)
    total = sum(m.count for m in problem.motions.values())
    stacked = np.concatenate(rows) if rows else np.zeros((0, total))
    values = np.array(weight)
    if (
        criterion == "A"
    ):  # every motion as a length at the rim of its feature; characteristics are only reported
        lengths = np.concatenate([m.scale() for m in problem.motions.values()])
        stacked, values = (
            np.concatenate([stacked, np.diag(lengths)]),
            np.concatenate([0.0 * values, np.ones(total)]),
        )
    return Goal(Target(stacked, values, criterion), where, checks)


def _form_checks(
    problem: Problem, share: Mapping[str, float], seed: int
) -> dict[str, tuple[FormCheck, float]]:
    out = {}
    for c in problem.scenario.part.characteristics:
        if c.type in gps.FORM:
            check = FormCheck.of(problem, c.of[0], seed)
            out[c.name] = (check, share[c.name] / (c.zone or check.typical) ** 2)
    return out


def _scales(problem: Problem, rows: Mapping[str, Array]) -> dict[str, float]:
    """What u is measured by: the tolerance, else u of the present plan."""
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
            base = Design(problem.candidates, Target(empty, np.zeros(0), "D"), least(problem.candidates, 3))
        out[c.name] = float(np.sqrt(max(float(base.variances(rows[c.name]).sum()), 1e-24)))
    return out
