"""A choice of touches made into a plan: order, steps, the time it takes, what drift makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vcmm.core.pose import Array
from vcmm.fit.elements import MINIMUM_POINTS
from vcmm.measuring.plan import Plan, Step, touches
from vcmm.placing.candidates import Problem
from vcmm.placing.design import Design, Target
from vcmm.placing.order import Ints, Visit, ordered, ways


@dataclass(frozen=True, eq=False)
class Realised:
    """plan in measuring order; seconds as vcmm.measuring.plan reckons, with stylus changes; drift: variance by characteristic;
    penalty: what drift adds to the objective."""

    plan: Plan
    seconds: float
    drift: Mapping[str, float]
    penalty: float


def realised(
    problem: Problem, design: Design, rows: Mapping[str, slice], target: Target, change_s: float, seed: int
) -> Realised:
    """Put the touches of a design into order and time them."""
    c = problem.candidates
    which = np.repeat(np.arange(len(design.counts)), design.counts)
    visit = _visit(problem, design, which, target, change_s)
    price = 0.0
    base = visit.times(np.arange(len(which)))[-1]
    if visit.pull.size and target.criterion == "U":
        price = float(base) / max(
            design.value(), 1e-300
        )  # drift as bad as all else costs as much as the whole time
    order = readable(problem, which[ordered(visit, price, seed=seed)])
    plan = replace(problem.scenario.plan, steps=_steps(problem, order))
    placed = touches(plan, problem.scenario.pose, problem.scenario.machine, problem.scenario.constants)
    styli = [s.stylus for s in plan.steps]
    changes = sum(a != b for a, b in pairwise(styli))
    time = placed.run.column("time_s")
    read = design.sensitivities(target.rows)[:, order]
    moved = np.einsum(
        "rn,nd,n->rd",
        read,
        problem.drift[order],
        time + change_s * _changes_before(c.feature[order], problem),
    )
    square = np.sum(moved**2, axis=1)
    drift = {name: float(square[s].sum()) for name, s in rows.items()}
    penalty = float(target.weight @ square) if target.criterion == "U" else 0.0
    return Realised(plan, float(time[-1]) + change_s * changes, drift, penalty)


def readable(problem: Problem, order: Ints) -> Ints:
    """The order with visits joined that are too short for a step of a plan file: each step holds enough for a fit."""
    c = problem.candidates
    for f, name in enumerate(c.names):
        fewest = MINIMUM_POINTS.get(problem.motions[name].feature.kind, 1)
        visits = np.split(np.arange(len(order)), np.flatnonzero(np.diff(c.feature[order])) + 1)
        mine = [v for v in visits if c.feature[order[v[0]]] == f]
        if len(mine) > 1 and min(len(v) for v in mine) < fewest:
            others = [v for v in visits if c.feature[order[v[0]]] != f]
            place = sum(v[0] < mine[0][0] for v in others)
            order = order[np.concatenate([*others[:place], *mine, *others[place:]])]
    return order


def _changes_before(feature: Ints, problem: Problem) -> Array:
    """(n,) number of stylus changes before each touch."""
    styli = np.array([problem.styli[name] for name in problem.candidates.names])[feature]
    return np.concatenate([[0], np.cumsum(styli[1:] != styli[:-1])]).astype(float)


def _visit(problem: Problem, design: Design, which: Ints, target: Target, change_s: float) -> Visit:
    c, scenario = problem.candidates, problem.scenario
    touch = scenario.plan.touch
    names = [problem.styli[n] for n in c.names]
    stylus = np.array([names.index(names[f]) for f in range(len(names))])[c.feature[which]]
    tips = c.points[which] + c.normals[which] * touch.approach
    way = ways(tips, c.feature[which], stylus, touch.positioning, touch.clearance, change_s)
    read = np.sqrt(target.weight)[:, None] * design.sensitivities(target.rows)[:, which]
    pull = read[:, :, None] * problem.drift[which][None]
    return Visit(c.feature[which], 2.0 * touch.approach / touch.speed, way, pull)


def _steps(problem: Problem, order: Ints) -> tuple[Step, ...]:
    """Consecutive touches of one feature as one step."""
    c = problem.candidates
    cuts = np.flatnonzero(np.diff(c.feature[order])) + 1
    out = []
    for stretch in np.split(order, cuts):
        name = c.names[int(c.feature[stretch[0]])]
        out.append(Step(name, problem.styli[name], c.points[stretch], c.normals[stretch]))
    return tuple(out)
