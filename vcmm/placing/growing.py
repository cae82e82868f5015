"""Plans of growing number: touches added where a second helps most, exchanged, moved between features, and taken away again.

Standard strategies are tried on every feature along the way, so that none of them is better at the same number.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.pose import Array
from vcmm.placing.candidates import Problem, nearest
from vcmm.placing.design import Candidates, Design, best_candidate, exchanged, least
from vcmm.placing.goal import Goal
from vcmm.placing.standards import standard_points

Progress = Callable[[str, float], None]
MOST = 400  # touches
SETTLED = 48  # up to so many touches every number is exchanged anew, above every fourth


def growing(
    problem: Problem, goal: Goal, budget_s: float, change_s: float, most: int, progress: Progress
) -> list[Design]:
    """Designs of growing number, each exchanged."""
    c = problem.candidates
    design = _settled(problem, goal, Design(c, goal.target, least(c)))
    found = {design.n: design.copy()}
    fixed = change_s * (len(set(problem.styli.values())) - 1)
    spent = fixed + _touching(design)
    while spent < 1.15 * budget_s and design.n < most:
        f, i = _next(goal, design, c)
        if i < 0:
            break
        design.add(i)
        spent += float(c.seconds[f])
        if design.n <= SETTLED or design.n % 4 == 0:
            design = _settled(problem, goal, design)
        _keep(found, goal, design)
        progress("adding points", 0.2 + 0.5 * min(1.0, spent / (1.15 * budget_s)))
    _backward(found, goal, design)
    progress("ordering", 0.8)
    return _thinned([found[n] for n in sorted(found)])


def _touching(design: Design) -> float:
    """s for all touches, ways to neighbours included."""
    return float(sum(design.c.seconds[f] * n for f, n in enumerate(design.per_feature().values())))


def _keep(found: dict[int, Design], goal: Goal, design: Design) -> None:
    """The best design of each number."""
    if design.n not in found or goal.value(design) < goal.value(found[design.n]):
        found[design.n] = design.copy()


def _backward(found: dict[int, Design], goal: Goal, design: Design) -> None:
    """From the largest design down, the touch that is missed least leaves; better designs take their places."""
    design = design.copy()
    least_n = min(found)
    while design.n > least_n:
        losses = [(float(change.min()), int(design.rows_of[f][int(change.argmin())])) for f in range(len(design.rows_of))
                  if len(change := design.changes(f, -1))]  # fmt: skip
        loss, i = min(losses)
        if not np.isfinite(loss):
            return
        design.drop(i)
        if design.n <= SETTLED:
            design = _transferred(exchanged(design, passes=1), goal)
        _keep(found, goal, design)


def _transferred(design: Design, goal: Goal, most: int = 6) -> Design:
    """Touches moved from a feature where they are missed least to another where they help most, while that is better."""
    for _ in range(most):
        best, value = None, goal.value(design)
        for f in range(len(design.rows_of)):
            change = design.changes(f, -1)
            i = (
                int(design.rows_of[f][int(change.argmin())])
                if len(change) and np.isfinite(change.min())
                else -1
            )
            if i < 0:
                continue
            fewer = design.copy()
            fewer.drop(i)
            for g in range(len(design.rows_of)):
                j = best_candidate(fewer, g, True) if g != f else -1
                if j < 0:
                    continue
                trial = fewer.copy()
                trial.add(j)
                if goal.value(trial) < value * (1.0 - 1e-9):
                    best, value = trial, goal.value(trial)
        if best is None:
            return design
        design = best
    return design


def _settled(problem: Problem, goal: Goal, design: Design) -> Design:
    """Exchanged from where it is, and from standard strategies of about the same number on each feature; the best of them."""
    best = _transferred(exchanged(design, passes=2), goal)
    for f, name in enumerate(problem.candidates.names):
        n = best.per_feature()[name]
        radius = problem.scenario.plan.styli[problem.styli[name]].tip_radius
        for _, points in standard_points(problem.scenario.part.features[name], n + 2, radius):
            trial = _standing(problem, best, f, points, n) if len(points) >= n - 2 else None
            if trial is not None and goal.value(trial) < goal.value(best) * (1.0 - 1e-9):
                best = trial
    polished = _transferred(exchanged(best.copy(), passes=1), goal)
    return polished if goal.value(polished) <= goal.value(best) else best


def _standing(problem: Problem, design: Design, f: int, points: Array, n: int) -> Design | None:
    """The design with a standard strategy on one feature, the number of touches kept by more or fewer elsewhere."""
    found = nearest(problem.candidates, problem.candidates.names[f], points)
    if (found < 0).any():
        return None
    trial = design.copy()
    trial.counts[trial.rows_of[f]] = 0
    np.add.at(trial.counts, found, 1)
    try:
        trial.refresh()
    except ModelLimit:
        return None
    others = [g for g in range(len(trial.rows_of)) if g != f] or [f]
    for _ in range(max(0, n - len(points))):
        options = [i for g in others if (i := best_candidate(trial, g, True)) >= 0]
        if not options:
            return None
        trial.add(options[0])
    for _ in range(max(0, len(points) - n)):
        losses = [
            (float(c.min()), int(trial.rows_of[g][int(c.argmin())]))
            for g in others
            if len(c := trial.changes(g, -1))
        ]
        if not losses or not np.isfinite(min(losses)[0]):
            return None
        trial.drop(min(losses)[1])
    return trial


def _next(goal: Goal, design: Design, c: Candidates) -> tuple[int, int]:
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
