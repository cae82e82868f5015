"""The best points, styli and order under a time budget: the Pareto curve of U against measuring time.

    result = optimise_plan(scenario, budget_s=120.0)
    for p in result.pareto: print(p.minutes, p.per_feature, p.expanded)
    better = replace(scenario, plan=result.plan)

Points are added one by one where a second of measuring lowers the objective most, exchanged in between, and compared
with standard strategies of the same number on every feature, so that no standard strategy is better.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.errors import ModelLimit, UsageError, choose_from
from vcmm.part import normal
from vcmm.placing.candidates import Problem, accessible, nearest, problem_of, spots
from vcmm.placing.design import CRITERIA, Candidates, Design, Target, best_candidate, exchanged, least
from vcmm.placing.formcheck import FormCheck
from vcmm.placing.motions import motions_of, outputs
from vcmm.placing.realised import Realised, realised
from vcmm.placing.standards import standard_points
from vcmm.plan import Plan
from vcmm.pose import Array
from vcmm.scenario import Scenario

CHANGE_S = 20.0  # s for another stylus or head orientation, where nothing else is said
MOST = 400  # touches
Progress = Callable[[str, float], None]


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
    chosen: PlanPoint
    present: PlanPoint
    plan: Plan
    plans: tuple[Plan, ...]
    styli: Mapping[str, str]
    forms: Mapping[str, float]
    budget_s: float


@dataclass(frozen=True, eq=False)
class _Goal:
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


def optimise_plan(
    scenario: Scenario,
    budget_s: float,
    *,
    weights: Mapping[str, float] | None = None,
    criterion: str = "U",
    forms: Mapping[str, float] | None = None,
    drift: tuple[float, float, float] = (0.0, 0.0, 0.0),
    change_s: float = CHANGE_S,
    most: int = MOST,
    seed: int = 0,
    progress: Progress = lambda text, share: None,
) -> PlanResult:
    """Points, styli and order that minimise sum weight (u / tolerance)^2 within a budget of seconds at the pose given.

    weights: characteristic -> weight (1 each); without a tolerance u of the present plan stands for it. criterion: U, or A
    or D on the motions of the features. forms: feature -> standard deviation of its form, mm. drift: standard uncertainty of a
    linear drift along x, y, z, mm/s, beyond the inputs. UsageError, ModelLimit: unknown names, places out of reach, or a
    budget in which the features cannot be measured at all.
    """
    known = _forms(scenario, forms)
    _check(scenario, budget_s, weights, criterion)
    extra = _standards(scenario)
    progress("choosing styli", 0.05)
    styli = _styli(scenario, known, weights, criterion, change_s)
    problem = problem_of(scenario, styli, spots(scenario, styli, extra), known, drift)
    goal = _goal(problem, weights, criterion, seed)
    present = _present(problem, goal, scenario, change_s)
    progress("adding points", 0.2)
    curve = _curve(problem, goal, budget_s, change_s, min(most, MOST), progress)
    points = [_point(problem, goal, d, change_s, seed) for d in curve]
    front = _front(points)
    inside = [p for p in front if p[0].seconds <= budget_s]
    if not inside:
        least_s = min(p.seconds for p, _ in points)
        raise ModelLimit(f"the shortest plan takes {least_s:.4g} s, the budget is {budget_s:.4g} s; allow more time")
    chosen = min(inside, key=lambda p: p[0].objective)
    pareto, plans = zip(*((p, r.plan) for p, r in front))
    return PlanResult(pareto, chosen[0], present, chosen[1].plan, plans, styli, known, budget_s)


def _check(scenario: Scenario, budget_s: float, weights: Mapping[str, float] | None, criterion: str) -> None:
    names = [c.name for c in scenario.part.characteristics]
    if not names:
        raise UsageError("the part has no characteristics; add [[part.characteristics]], they say what the points are for")
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
            raise UsageError(f'forms names the unknown feature "{name}".{choose_from(name, scenario.part.features)}')
    return {**scenario.surroundings.forms, **(forms or {})}


def _measured(scenario: Scenario) -> dict[str, str]:
    """feature -> stylus of the present plan."""
    out: dict[str, str] = {}
    for step in scenario.plan.steps:
        out.setdefault(step.feature, step.stylus)
    return out


def _standards(scenario: Scenario) -> dict[str, Array]:
    """Points of the standard strategies, so that they are candidates."""
    out = {}
    for name, stylus in _measured(scenario).items():
        radius = scenario.plan.styli[stylus].tip_radius
        found = [p for _, p in standard_points(scenario.part.features[name], 25, radius)]
        if found:
            out[name] = np.unique(np.round(np.concatenate(found), 9), axis=0)
    return out


def _styli(
    scenario: Scenario, forms: Mapping[str, float], weights: Mapping[str, float] | None, criterion: str, change_s: float
) -> dict[str, str]:
    """The stylus of each feature: the objective at a small exchanged plan, times its duration, by coordinate descent."""
    chosen = _measured(scenario)
    options = {f: [s for s in scenario.plan.styli if _reaches(scenario, f, s)] for f in chosen}
    for name, found in options.items():
        if not found:
            problem_of(scenario, {name: chosen[name]}, spots(scenario, {name: chosen[name]}), forms)  # says why
            raise ModelLimit(f'no stylus of the plan reaches "{name}" at this pose; add one, or turn the part')
        if chosen[name] not in found:
            chosen[name] = found[0]
    if all(len(o) == 1 for o in options.values()):
        return chosen

    def score(styli: dict[str, str]) -> float:
        problem = problem_of(scenario, styli, spots(scenario, styli), forms)
        goal = _goal(problem, weights, criterion, 0, plain=True)
        design = exchanged(Design(problem.candidates, goal.target, least(problem.candidates, 3)), passes=1)
        changes = len(set(styli.values())) - 1
        touching = sum(problem.candidates.seconds[f] * n for f, n in enumerate(design.per_feature().values()))
        time = touching + change_s * changes
        return design.value() * time if criterion != "D" else design.value() + np.log(time)

    best = score(chosen)
    for name, found in options.items():
        for stylus in found:
            trial = {**chosen, name: stylus}
            if stylus != chosen[name] and (value := score(trial)) < best:
                chosen, best = trial, value
    return chosen


def _reaches(scenario: Scenario, feature: str, stylus: str) -> bool:
    """Whether a stylus reaches enough of a feature to determine its fit, with a touch to spare."""
    from vcmm.placing.formfield import surface_grid

    f = scenario.part.features[feature]
    present = [s.points for s in scenario.plan.steps if s.feature == feature]
    grid = np.concatenate([surface_grid(f, 12, scenario.plan.styli[stylus].tip_radius), *present])
    touched = grid[accessible(scenario, f, stylus, grid)]
    moving = motions_of(f)
    if len(touched) <= moving.count or f.kind == "mesh":
        return len(touched) > 0 and f.kind == "mesh"
    jac = moving.rows(touched, normal(f, touched)) / moving.scale()
    return bool(np.linalg.matrix_rank(jac, tol=1e-6) == moving.count)


def _goal(problem: Problem, weights: Mapping[str, float] | None, criterion: str, seed: int, plain: bool = False) -> _Goal:
    scenario = problem.scenario
    found = outputs(scenario.part.characteristics, scenario.part.features, problem.motions, scenario.plan.alignment)
    scale = _scales(problem, {n: o.rows for n, o in found.items()})
    share = {c.name: (weights or {}).get(c.name, 0.0 if weights else 1.0) for c in scenario.part.characteristics}
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
    if criterion == "A":  # every motion as a length at the rim of its feature; characteristics are only reported
        lengths = np.concatenate([m.scale() for m in problem.motions.values()])
        stacked, values = np.concatenate([stacked, np.diag(lengths)]), np.concatenate([0.0 * values, np.ones(total)])
    return _Goal(Target(stacked, values, criterion), where, checks)


def _form_checks(problem: Problem, share: Mapping[str, float], seed: int) -> dict[str, tuple[FormCheck, float]]:
    from vcmm.gps import characteristics as gps

    out = {}
    for c in problem.scenario.part.characteristics:
        if c.type in gps.FORM:
            check = FormCheck.of(problem, c.of[0], seed)
            out[c.name] = (check, share[c.name] / (c.zone or check.typical) ** 2)
    return out


def _scales(problem: Problem, rows: Mapping[str, Array]) -> dict[str, float]:
    """What u is measured by: the tolerance, else u of the present plan."""
    from vcmm.gps import characteristics as gps

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


def _present(problem: Problem, goal: _Goal, scenario: Scenario, change_s: float) -> PlanPoint:
    """The plan as given, judged by the same model."""
    counts = np.zeros(len(problem.candidates.feature), dtype=np.intp)
    for step in scenario.plan.steps:
        found = nearest(problem.candidates, step.feature, step.points)
        np.add.at(counts, found[found >= 0], 1)
    try:
        design = Design(problem.candidates, goal.target, counts)
    except ModelLimit:  # the present plan cannot be carried out here
        design = Design(problem.candidates, goal.target, least(problem.candidates))
    return _point(problem, goal, design, change_s, 0)[0]


def _curve(
    problem: Problem, goal: _Goal, budget_s: float, change_s: float, most: int, progress: Progress
) -> list[Design]:
    """Designs of growing number, each exchanged."""
    c = problem.candidates
    design = _settled(problem, goal, Design(c, goal.target, least(c)))
    out = [design.copy()]
    fixed = change_s * (len(set(problem.styli.values())) - 1)
    spent = fixed + float(sum(c.seconds[f] * n for f, n in enumerate(design.per_feature().values())))
    while spent < 1.15 * budget_s and design.n < most:
        f, i = _next(goal, design, c)
        if i < 0:
            break
        design.add(i)
        spent += float(c.seconds[f])
        if len(out) < 12 or design.n % 4 == 0:
            design = _settled(problem, goal, design)
        out.append(design.copy())
        progress("adding points", 0.2 + 0.6 * min(1.0, spent / (1.15 * budget_s)))
    return _thinned(out)


def _settled(problem: Problem, goal: _Goal, design: Design) -> Design:
    """Exchanged from where it is, and from standard strategies of the same number on each feature; the best of them."""
    best = exchanged(design, passes=2)
    for f, name in enumerate(problem.candidates.names):
        rows, n = best.rows_of[f], best.per_feature()[name]
        radius = problem.scenario.plan.styli[problem.styli[name]].tip_radius
        for _, points in standard_points(problem.scenario.part.features[name], n, radius):
            if len(points) != n:
                continue
            found = nearest(problem.candidates, name, points)
            if (found < 0).any():
                continue
            trial = best.copy()
            trial.counts[rows] = 0
            np.add.at(trial.counts, found, 1)
            try:
                trial.refresh()
            except ModelLimit:
                continue
            if goal.value(trial) < goal.value(best) * (1.0 - 1e-9) or (trial.value() < best.value() and not goal.forms):
                best = trial
    polished = exchanged(best.copy(), passes=1)
    return polished if goal.value(polished) <= goal.value(best) else best


def _next(goal: _Goal, design: Design, c: Candidates) -> tuple[int, int]:
    """(feature, candidate) of the touch that lowers the objective most per second; -1 where none does."""
    found: list[tuple[float, int, int]] = []
    now = goal.value(design)
    for f in range(len(c.names)):
        i = best_candidate(design, f, True)
        options = [i] if i >= 0 else []
        if any(check.feature == f for check, _ in goal.forms.values()):
            options.append(_farthest(design, f))
        for j in options:
            trial = design.copy()
            trial.add(j)
            found.append(((goal.value(trial) - now) / float(c.seconds[f]), f, j))
    if not found:
        return -1, -1
    gain, f, i = min(found)
    return (f, i) if gain < 0.0 else (f, i if design.n < MOST else -1)


def _farthest(design: Design, f: int) -> int:
    """The candidate farthest from all touches of its feature."""
    rows = design.rows_of[f]
    p = design.c.points[rows]
    taken = p[design.counts[rows] > 0]
    apart = np.linalg.norm(p[:, None] - taken[None], axis=2).min(axis=1)
    return int(rows[int(np.argmax(apart))])


def _thinned(designs: list[Design], most: int = 40) -> list[Design]:
    """At most so many, the first and last among them, more of the small ones."""
    if len(designs) <= most:
        return designs
    at = np.unique(np.round(np.geomspace(1, len(designs), most)).astype(int) - 1)
    return [designs[i] for i in at]


def _point(
    problem: Problem, goal: _Goal, design: Design, change_s: float, seed: int
) -> tuple[PlanPoint, Realised]:
    """A design put into order and timed; drift of that order is part of u."""
    made = realised(problem, design, goal.rows, goal.target, change_s, seed)
    square = goal.variances(design)
    square = {n: v + made.drift.get(n, 0.0) for n, v in square.items()}
    u = {n: float(np.sqrt(max(v, 0.0))) for n, v in square.items()}
    k = _coverage_factor(problem.scenario.settings.p)
    value = goal.value(design) + made.penalty
    order = [c.name for c in problem.scenario.part.characteristics if c.name in u]
    u = {n: u[n] for n in order}
    point = PlanPoint(made.seconds, design.n, design.per_feature(), u, {n: k * v for n, v in u.items()}, value)
    return point, made


def _coverage_factor(p: float) -> float:
    from scipy.special import ndtri

    return float(ndtri(0.5 * (1.0 + p)))


def _front(points: list[tuple[PlanPoint, Realised]]) -> list[tuple[PlanPoint, Realised]]:
    """Those that no quicker one equals or beats, by time."""
    out: list[tuple[PlanPoint, Realised]] = []
    for p in sorted(points, key=lambda p: (p[0].seconds, p[0].objective)):
        if not out or p[0].objective < out[-1][0].objective:
            out.append(p)
    return out


__all__ = ["PlanPoint", "PlanResult", "optimise_plan"]
