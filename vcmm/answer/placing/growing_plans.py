"""Plans of growing number: touches added where a second helps most, exchanged, moved between features, and taken away again.

Standard strategies are tried on every feature along the way, so that none of them is better at the same number.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vcmm.answer.placing.candidates import TouchProblem, nearest
from vcmm.answer.placing.design import (
    Design,
    TouchCandidates,
    best_candidate,
    exchange_touches,
    fewest_touches,
)
from vcmm.answer.placing.plan_goal import PlanGoal
from vcmm.core.blocks import Progress
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.pose import Array
from vcmm.part.part import Feature
from vcmm.task.measuring.strategies import (
    Around,
    Birdcage,
    Even,
    Grid,
    Helix,
    Iso10360,
    Latitudes,
    Levels,
    Pattern,
    Polar,
    Ring,
    Spiral,
    Spread,
    plan_points,
)

MOST_TOUCHES = 400  # touches
MOST_TRANSFERS = 6  # touches moved between features, per number of touches
MOST_EXCHANGED = 48  # up to so many touches every number is exchanged anew, above every fourth


def growing(
    problem: TouchProblem, goal: PlanGoal, budget_s: float, change_s: float, most: int, progress: Progress
) -> list[Design]:
    """Return designs of growing number, each exchanged."""
    c = problem.candidates
    design = _settle(problem, goal, Design(c, goal.target, fewest_touches(c)))
    best = {design.n: design.copy()}
    fixed = change_s * (len(set(problem.styli.values())) - 1)
    spent = fixed + _touching(design)
    while spent < 1.15 * budget_s and design.n < most:
        f, i = _next(goal, design, c)
        if i < 0:
            break
        design.add(i)
        spent += float(c.seconds[f])
        if design.n <= MOST_EXCHANGED or design.n % 4 == 0:
            design = _settle(problem, goal, design)
        _keep(best, goal, design)
        progress("adding points", 0.2 + 0.5 * min(1.0, spent / (1.15 * budget_s)))
    _backward(best, goal, design)
    progress("ordering", 0.8)
    return _thin([best[n] for n in sorted(best)])


def _touching(design: Design) -> float:
    """Return the seconds of all touches, ways to neighbours included."""
    return float(sum(design.c.seconds[f] * n for f, n in enumerate(design.per_feature().values())))


def _keep(best: dict[int, Design], goal: PlanGoal, design: Design) -> None:
    """Keep the best design of each number."""
    if design.n not in best or goal.value(design) < goal.value(best[design.n]):
        best[design.n] = design.copy()


def _backward(best: dict[int, Design], goal: PlanGoal, design: Design) -> None:
    """Remove touches from the largest design down, the one that is missed least first; better designs take their places."""
    design = design.copy()
    least_n = min(best)
    while design.n > least_n:
        losses = [(float(change.min()), int(design.rows_of[f][int(change.argmin())])) for f in range(len(design.rows_of))
                  if len(change := design.changes(f, -1))]  # fmt: skip
        loss, i = min(losses)
        if not np.isfinite(loss):
            return
        design.drop(i)
        if design.n <= MOST_EXCHANGED:
            design = _transfer_touches(exchange_touches(design, passes=1), goal)
        _keep(best, goal, design)


def _transfer_touches(design: Design, goal: PlanGoal) -> Design:
    """Move touches from a feature where they are missed least to another where they help most, while that is better."""
    for _ in range(MOST_TRANSFERS):
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
                j = best_candidate(fewer, g) if g != f else -1
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


def _settle(problem: TouchProblem, goal: PlanGoal, design: Design) -> Design:
    """Exchange from the present design, and from standard strategies of about the same number on each feature; return the best of them."""
    best = _transfer_touches(exchange_touches(design, passes=2), goal)
    for f, name in enumerate(problem.candidates.names):
        n = best.per_feature()[name]
        radius = problem.scenario.plan.styli[problem.styli[name]].tip_radius
        for _, points in standard_points(problem.scenario.part.features[name], n + 2, radius):
            trial = _with_standard(problem, best, f, points, n) if len(points) >= n - 2 else None
            if trial is not None and goal.value(trial) < goal.value(best) * (1.0 - 1e-9):
                best = trial
    polished = _transfer_touches(exchange_touches(best.copy(), passes=1), goal)
    return polished if goal.value(polished) <= goal.value(best) else best


def _with_standard(problem: TouchProblem, design: Design, f: int, points: Array, n: int) -> Design | None:
    """Return the design with a standard strategy on one feature, the number of touches kept by more or fewer elsewhere."""
    standard = nearest(problem.candidates, problem.candidates.names[f], points)
    if (standard < 0).any():
        return None
    trial = design.copy()
    trial.counts[trial.rows_of[f]] = 0
    np.add.at(trial.counts, standard, 1)
    try:
        trial.refresh()
    except ModelLimit:
        return None
    others = [g for g in range(len(trial.rows_of)) if g != f] or [f]
    for _ in range(max(0, n - len(points))):
        options = [i for g in others if (i := best_candidate(trial, g)) >= 0]
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


def _next(goal: PlanGoal, design: Design, c: TouchCandidates) -> tuple[int, int]:
    """Return (feature, candidate) of the touch that lowers the objective most per second; -1 where none does."""
    options: list[tuple[float, int, int]] = []
    now = goal.value(design)
    for f in range(len(c.names)):
        i = best_candidate(design, f)
        tried = [i] if i >= 0 else []
        if any(check.feature == f for check, _ in goal.forms.values()):
            tried.append(_farthest(design, f))
        for j in tried:
            trial = design.copy()
            trial.add(j)
            options.append(((goal.value(trial) - now) / float(c.seconds[f]), f, j))
    if not options:
        return -1, -1
    gain, f, i = min(options)
    return (f, i) if gain < 0.0 else (f, i if design.n < MOST_TOUCHES else -1)


def _farthest(design: Design, f: int) -> int:
    """Return the candidate farthest from all touches of its feature."""
    rows = design.rows_of[f]
    p = design.c.points[rows]
    taken = p[design.counts[rows] > 0]
    apart = np.linalg.norm(p[:, None] - taken[None], axis=2).min(axis=1)
    return int(rows[int(np.argmax(apart))])


def _thin(designs: list[Design], most: int = 40) -> list[Design]:
    """Return at most so many designs, the first and last among them, more of the small ones."""
    if len(designs) <= most:
        return designs
    at = np.unique(np.round(np.geomspace(1, len(designs), most)).astype(int) - 1)
    return [designs[i] for i in at]


def standard_points(feature: Feature, most: int, margin: float) -> Iterator[tuple[str, Array]]:
    """Yield (name, points (n, 3)) of standard strategies with at most `most` touches, `margin` mm inside the edges."""
    for name, pattern in _patterns(feature, most, margin):
        try:
            points = plan_points(feature, pattern)[0]
        except UsageError:  # too few points for the fit, or the margin leaves nothing
            continue
        if len(points) <= most:
            yield f"{name} {len(points)}", points


def _patterns(f: Feature, most: int, margin: float) -> Iterator[tuple[str, Pattern]]:
    if f.kind == "plane":
        yield from (
            ("grid", Grid((a, b), margin)) for a in range(2, most) for b in range(2, most) if a * b <= most
        )
        yield from (("hammersley", Spread(n, margin)) for n in range(3, most + 1))
        yield from (("polar", Polar(r, n, margin)) for r in (1, 2, 3) for n in range(3, most) if r * n < most)
    elif f.kind == "line":
        yield from (("even", Even(n, margin)) for n in range(2, most + 1))
    elif f.kind == "circle":
        yield from (("even", Around(n)) for n in range(3, most + 1))
    elif f.kind == "sphere":
        yield "iso10360", Iso10360()
        yield from (("spiral", Spiral(n)) for n in range(4, most + 1))
        yield from (("levels", Latitudes((0.0, 0.7, 1.3), n)) for n in range(3, most // 3 + 1))
    elif f.kind in ("cylinder", "cone"):
        yield from _round(f, most, margin)
    elif f.kind == "torus":
        yield from (("grid", Ring((a, b))) for a in range(3, most) for b in range(3, most) if a * b <= most)


def _round(f: Feature, most: int, margin: float) -> Iterator[tuple[str, Pattern]]:
    low, high = margin, f.extent[0] - margin
    for levels in (2, 3, 4):
        at = tuple(float(z) for z in np.linspace(low, high, levels))
        yield from (("levels", Levels(at, n)) for n in range(3, most // levels + 1))
        yield from (("staggered", Levels(at, n, stagger=True)) for n in range(3, most // levels + 1))
    yield from (("helix", Helix(n, 2.0, margin)) for n in range(6, most + 1, 2))
    yield from (
        ("birdcage", Birdcage(2, n, lines, 3, margin))
        for n in range(4, most, 2)
        for lines in (2, 4)
        if 2 * n + 3 * lines <= most
    )
