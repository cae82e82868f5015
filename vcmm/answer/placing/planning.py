"""The best points, styli and order under a time budget: the Pareto curve of U against measuring time.

    result = optimise_plan(scenario, budget_s=120.0)
    for p in result.pareto: print(p.minutes, p.per_feature, p.expanded)
    better = replace(scenario, plan=result.plan)

Points are added one by one where a second of measuring lowers the objective most, exchanged in between, and compared
with standard strategies of the same number on every feature, so that no standard strategy is better.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.answer.placing.candidates import TouchProblem, accessible, nearest, problem_of, spots
from vcmm.answer.placing.design import CRITERIA, Design, exchange_touches, fewest_touches
from vcmm.answer.placing.growing_plans import MOST_TOUCHES, growing, standard_points
from vcmm.answer.placing.motions import motions_of
from vcmm.answer.placing.plan_goal import PlanGoal, goal_of
from vcmm.answer.placing.plan_order import OrderedPlan, ordered_plan
from vcmm.core.blocks import Progress
from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.core.pose import Array
from vcmm.part.part import normal
from vcmm.task.measuring.plan import Plan
from vcmm.task.measuring.scenario import Scenario

CHANGE_S = 20.0  # s for another stylus or head orientation, where nothing else is stated


@dataclass(frozen=True)
class PlanPoint:
    """One plan of the curve. u, expanded: by characteristic, mm or rad, form of the part included."""

    seconds: float
    touches: int
    per_feature: Mapping[str, int]
    u: Mapping[str, float]
    expanded: Mapping[str, float]
    objective: float

    @property
    def minutes(self) -> float:
        return self.seconds / 60.0


@dataclass(frozen=True, eq=False)
class PlanResult:
    """pareto: no plan of it takes longer and is worse than another. plan: the best within the budget. styli: chosen ones."""

    pareto: tuple[PlanPoint, ...]
    choice: PlanPoint
    present: PlanPoint
    plan: Plan
    plans: tuple[Plan, ...]
    styli: Mapping[str, str]
    forms: Mapping[str, float]
    budget_s: float


def optimise_plan(
    scenario: Scenario,
    budget_s: float,
    *,
    weights: Mapping[str, float] | None = None,
    criterion: str = "U",
    forms: Mapping[str, float] | None = None,
    drift: tuple[float, float, float] = (0.0, 0.0, 0.0),
    change_s: float = CHANGE_S,
    most: int = MOST_TOUCHES,
    seed: int = 0,
    progress: Progress = lambda text, share: None,
) -> PlanResult:
    """Find points, styli and order that minimise the sum of weight (u / tolerance)^2 within a measuring time, at the pose given.

    Parameters
    ----------
    scenario
        The task; its part and styli are kept.
    budget_s
        Measuring time that the plan may take, s.
    weights
        Characteristic -> weight (1 each); without a tolerance u of the present plan replaces it.
    criterion
        "U", or "A" or "D" on the motions of the features.
    forms
        Feature -> standard deviation of its form, mm.
    drift
        Standard uncertainty of a linear drift along x, y, z, mm/s, beyond the inputs.
    change_s
        Seconds that a change of stylus takes.
    most
        Points that a plan may have at most.
    seed
        Seed of the search.
    progress
        Called with a description of the step and its share, 0 to 1.

    Returns
    -------
    PlanResult
        The chosen plan, and u against measuring time.

    Raises
    ------
    UsageError, ModelLimit
        Unknown names, places out of reach, or a budget in which the features cannot be measured at all.
    """
    known_forms = _forms(scenario, forms)
    _check(scenario, budget_s, weights, criterion)
    extra = standard_spots(scenario)
    progress("choosing styli", 0.05)
    styli = _styli(scenario, known_forms, weights, criterion, change_s)
    problem = problem_of(scenario, styli, spots(scenario, styli, extra), known_forms, drift)
    goal = goal_of(problem, weights, criterion, seed)
    present = _present(problem, goal, scenario, change_s)
    progress("adding points", 0.2)
    curve = growing(problem, goal, budget_s, change_s, min(most, MOST_TOUCHES), progress)
    points = [_point(problem, goal, d, change_s, seed) for d in curve]
    front = _front(points)
    chosen, route = _best_within(budget_s, front, points)
    pareto, plans = zip(*((p, r.plan) for p, r in front))
    return PlanResult(
        pareto, chosen, present, route.plan, plans, styli=styli, forms=known_forms, budget_s=budget_s
    )


def _best_within(
    budget_s: float, front: list[tuple[PlanPoint, OrderedPlan]], points: list[tuple[PlanPoint, OrderedPlan]]
) -> tuple[PlanPoint, OrderedPlan]:
    """Return the plan of the front with the smallest objective within the budget. Raises ModelLimit where even the shortest plan takes longer."""
    inside = [p for p in front if p[0].seconds <= budget_s]
    if not inside:
        least_s = min(p.seconds for p, _ in points)
        raise ModelLimit(
            f"the shortest plan takes {least_s:.4g} s, the budget is {budget_s:.4g} s; allow more time"
        )
    return min(inside, key=lambda p: p[0].objective)


def _check(scenario: Scenario, budget_s: float, weights: Mapping[str, float] | None, criterion: str) -> None:
    names = [c.name for c in scenario.part.characteristics]
    if not names:
        raise UsageError(
            "the part has no characteristics; add [[part.characteristics]], they say what the points are for"
        )
    for name, weight in (weights or {}).items():
        if name not in names:
            raise UsageError(f'weights names the unknown characteristic "{name}".{choose_from(name, names)}')
        if not weight >= 0.0:
            raise UsageError(f'the weight of "{name}" is {weight:g}; it must not be negative')
    if criterion not in CRITERIA:
        raise UsageError(f'criterion "{criterion}" is not known.{choose_from(criterion, CRITERIA)}')
    if not budget_s > 0.0:
        raise UsageError(f"the budget is {budget_s:g} s; it must be positive")


def _forms(scenario: Scenario, forms: Mapping[str, float] | None) -> dict[str, float]:
    for name in forms or {}:
        if name not in scenario.part.features:
            raise UsageError(
                f'forms names the unknown feature "{name}".{choose_from(name, scenario.part.features)}'
            )
    return {**scenario.surroundings.forms, **(forms or {})}


def _present_styli(scenario: Scenario) -> dict[str, str]:
    """Return feature -> stylus of the present plan."""
    out: dict[str, str] = {}
    for step in scenario.plan.steps:
        out.setdefault(step.feature, step.stylus)
    return out


def standard_spots(scenario: Scenario) -> dict[str, Array]:
    """Return the points of the standard strategies, so that they are candidates."""
    out: dict[str, Array] = {}
    for name, stylus in _present_styli(scenario).items():
        radius = scenario.plan.styli[stylus].tip_radius
        points = [p for _, p in standard_points(scenario.part.features[name], 25, radius)]
        if points:
            out[name] = np.asarray(np.unique(np.round(np.concatenate(points), 9), axis=0), dtype=np.float64)
    return out


def _styli(
    scenario: Scenario,
    forms: Mapping[str, float],
    weights: Mapping[str, float] | None,
    criterion: str,
    change_s: float,
) -> dict[str, str]:
    """Choose the stylus of each feature: the objective at a small exchanged plan, times its duration, by coordinate descent."""
    chosen = _present_styli(scenario)
    options = {f: [s for s in scenario.plan.styli if _reaches(scenario, f, s)] for f in chosen}
    for name, reaching in options.items():
        if not reaching:
            problem_of(
                scenario, {name: chosen[name]}, spots(scenario, {name: chosen[name]}), forms
            )  # says why
            raise ModelLimit(
                f'no stylus of the plan reaches "{name}" at this pose; add one, or turn the part'
            )
        if chosen[name] not in reaching:
            chosen[name] = reaching[0]
    if all(len(o) == 1 for o in options.values()):
        return chosen

    def score(styli: dict[str, str]) -> float:
        problem = problem_of(scenario, styli, spots(scenario, styli), forms)
        goal = goal_of(problem, weights, criterion, 0, plain=True)
        design = exchange_touches(
            Design(problem.candidates, goal.target, fewest_touches(problem.candidates, 3)), passes=1
        )
        changes = len(set(styli.values())) - 1
        touching = sum(problem.candidates.seconds[f] * n for f, n in enumerate(design.per_feature().values()))
        time = touching + change_s * changes
        return design.value() * time if criterion != "D" else design.value() + np.log(time)

    best = score(chosen)
    for name, reaching in options.items():
        for stylus in reaching:
            trial = {**chosen, name: stylus}
            if stylus != chosen[name] and (value := score(trial)) < best:
                chosen, best = trial, value
    return chosen


def _reaches(scenario: Scenario, feature: str, stylus: str) -> bool:
    """Return whether a stylus reaches enough of a feature to determine its fit, with a touch to spare."""
    from vcmm.answer.placing.form_field import surface_grid

    f = scenario.part.features[feature]
    present = [s.points for s in scenario.plan.steps if s.feature == feature]
    grid = np.concatenate([surface_grid(f, 12, scenario.plan.styli[stylus].tip_radius), *present])
    touched = grid[accessible(scenario, f, stylus, grid)]
    moving = motions_of(f)
    if len(touched) <= moving.count or f.free:
        return len(touched) > 0 and f.free
    jac = moving.rows(touched, normal(f, touched)) / moving.scale()
    return bool(np.linalg.matrix_rank(jac, tol=1e-6) == moving.count)


def _present(problem: TouchProblem, goal: PlanGoal, scenario: Scenario, change_s: float) -> PlanPoint:
    """Evaluate the plan as given, by the same model."""
    counts = np.zeros(len(problem.candidates.feature), dtype=np.intp)
    for step in scenario.plan.steps:
        numbers = nearest(problem.candidates, step.feature, step.points)
        np.add.at(counts, numbers[numbers >= 0], 1)
    try:
        design = Design(problem.candidates, goal.target, counts)
    except ModelLimit:  # the present plan cannot be carried out here
        design = Design(problem.candidates, goal.target, fewest_touches(problem.candidates))
    return _point(problem, goal, design, change_s, 0)[0]


def _point(
    problem: TouchProblem, goal: PlanGoal, design: Design, change_s: float, seed: int
) -> tuple[PlanPoint, OrderedPlan]:
    """Put a design into order and time it; drift of that order is part of u."""
    made = ordered_plan(problem, design, goal.rows, goal.target, change_s, seed)
    square = goal.variances(design)
    square = {n: v + made.drift.get(n, 0.0) for n, v in square.items()}
    u = {n: float(np.sqrt(max(v, 0.0))) for n, v in square.items()}
    k = _coverage_factor(problem.scenario.settings.p)
    value = goal.value(design) + made.penalty
    order = [c.name for c in problem.scenario.part.characteristics if c.name in u]
    u = {n: u[n] for n in order}
    point = PlanPoint(
        made.seconds, design.n, design.per_feature(), u, {n: k * v for n, v in u.items()}, value
    )
    return point, made


def _coverage_factor(p: float) -> float:
    from scipy.special import ndtri

    return float(ndtri(0.5 * (1.0 + p)))


def _front(points: list[tuple[PlanPoint, OrderedPlan]]) -> list[tuple[PlanPoint, OrderedPlan]]:
    """Return the plans that no quicker one equals or beats, by time."""
    out: list[tuple[PlanPoint, OrderedPlan]] = []
    for p in sorted(points, key=lambda p: (p[0].seconds, p[0].objective)):
        if not out or p[0].objective < out[-1][0].objective:
            out.append(p)
    return out
