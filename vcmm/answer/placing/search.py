"""Search over the boxes of a fixture: a space-filling sample, then multistart descent and a compass.

Descent: L-BFGS-B with differences of all coordinates in one call. Compass: steps along the coordinates that
are halved when none helps; it also serves where the objective has kinks (linear tables) or steps (nearest nodes).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vcmm.answer.placing.fixture_boxes import PoseBox
from vcmm.answer.placing.objective import Objective
from vcmm.answer.placing.sobol import sobol
from vcmm.core.blocks import Progress
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array

DIFFERENCE = 1e-4  # of the box, for gradients
STEPS = (2e-2, 1e-5)  # first and last step of the compass
MOST_BOXES = 4  # boxes that are searched beyond the sample
STARTS = 40  # first steps of descent from so many
FIRST_STEP_GRADIENTS, FULL_STARTS = 6, 12  # gradients of the first steps; starts that are followed to the end
MOST_MINIMA = 20  # minima that stand in the outcome


@dataclass
class CountedObjective:
    """The objective over one box, in unit coordinates; counts its evaluations and keeps their values."""

    box: PoseBox
    objective: Objective
    count: int = 0
    feasible: int = 0  # number of feasible poses among them
    history: list[tuple[Array, Array]] = field(default_factory=list)

    def __call__(self, unit: Array) -> Array:
        """Evaluate the objective: (m, d) -> (m,); inf where the pose is not feasible."""
        unit = np.clip(np.atleast_2d(unit), 0.0, 1.0)
        six, ok = self.box.poses(unit)
        out = np.full(len(unit), np.inf)
        if ok.any():
            out[ok] = self.objective.values(six[ok])
        self.count += len(unit)
        self.feasible += int(ok.sum())
        self.history.append((unit, out))
        return out

    def best(self, count: int, apart: float = 0.05) -> list[tuple[float, Array]]:
        """Return the best coordinates found so far that lie `apart` from one another."""
        unit = np.concatenate([u for u, _ in self.history])
        value = np.concatenate([v for _, v in self.history])
        lowest: list[tuple[float, Array]] = []
        for i in np.argsort(value, kind="stable"):
            if not np.isfinite(value[i]) or len(lowest) == count:
                break
            if all(np.abs(unit[i] - other).max(initial=0.0) > apart for _, other in lowest):
                lowest.append((float(value[i]), unit[i]))
        return lowest


@dataclass(frozen=True, eq=False)
class SearchOutcome:
    """The outcome of a search: coordinates in a box, pose, value, and what it cost."""

    box: PoseBox
    unit: Array
    pose: Array
    value: float
    evaluations: int
    local: tuple[tuple[float, Array], ...]  # value and pose of the lowest ends of descents


def search(
    objective: Objective,
    boxes: Sequence[PoseBox],
    *,
    evaluations: int = 5000,
    seed: int = 0,
    progress: Progress | None = None,
) -> SearchOutcome:
    """Search for the lowest value over all boxes with at most so many evaluations of the objective."""
    report = progress or (lambda text, share: None)
    objectives = [CountedObjective(box, objective) for box in boxes]
    sample = int(np.clip(0.25 * evaluations / len(objectives), 16, 1024))
    for k, counted in enumerate(objectives):
        counted(_sobol(counted.box.d, sample, seed))
        report("sampling the fixture", 0.6 * (k + 1) / len(objectives))
    every, objectives = (
        objectives,
        sorted((a for a in objectives if a.best(1)), key=lambda a: a.best(1)[0][0]),
    )
    if not objectives:
        raise _nothing(every)
    minima = _polish_minima(objectives, evaluations, report)
    value, unit, counted = min(minima, key=lambda item: item[0])
    six, _ = counted.box.poses(unit[None])
    others = tuple(
        (v, other.box.poses(u[None])[0][0])
        for v, u, other in sorted(minima, key=lambda m: m[0])[:MOST_MINIMA]
    )
    return SearchOutcome(counted.box, unit, six[0], value, sum(a.count for a in objectives), others)


def _nothing(objectives: Sequence[CountedObjective]) -> ModelLimit:
    """Return why no pose of the sample has a value."""
    count, reached = sum(a.count for a in objectives), sum(a.feasible for a in objectives)
    if not reached:
        return ModelLimit(
            f"none of the {count} poses that were tried can be used: fixture, travels and the other constraints leave a range that is "
            "too narrow to be found; widen the ranges of the fixture"
        )
    return ModelLimit(
        f"{reached} of the {count} poses that were tried can be reached, but each of them lies where an error of the machine is not "
        "known; widen the range in which it is known, or move the fixture into it"
    )


def _sobol(d: int, count: int, seed: int) -> Array:
    if d == 0:
        return np.zeros((1, 0))
    return sobol(d, 2 ** int(np.log2(count)), np.random.default_rng(seed))


def _polish_minima(
    objectives: Sequence[CountedObjective], evaluations: int, report: Progress
) -> list[tuple[float, Array, CountedObjective]]:
    """Descend a few steps from many starts, the rest of the way from the best of those, with the compass at the end.

    The remaining evaluations are divided anew before every descent, so that starts that end early leave theirs to
    the others.
    """
    starts = [(v, u, counted) for counted in objectives[:MOST_BOXES] for v, u in counted.best(STARTS)]
    kept = sorted(starts, key=lambda item: item[0])[:STARTS]
    for k, (value, unit, counted) in enumerate(kept):
        most = min(
            FIRST_STEP_GRADIENTS * (counted.box.d + 1),
            _evaluations_left(objectives, evaluations) // (2 * (len(kept) - k)),
        )
        kept[k] = (*_descend(counted, unit, value, most), counted)
        report("descending", 0.6 + 0.2 * (k + 1) / len(kept))
    kept = _different(kept)
    for k, (value, unit, counted) in enumerate(kept[:FULL_STARTS]):
        most = _evaluations_left(objectives, evaluations) * 2 // (3 * (min(FULL_STARTS, len(kept)) - k))
        kept[k] = (*_descend(counted, unit, value, most), counted)
        report("descending", 0.8 + 0.15 * (k + 1) / FULL_STARTS)
    kept.sort(key=lambda item: item[0])
    for k, (value, unit, counted) in enumerate(kept[:3]):
        most = _evaluations_left(objectives, evaluations) // (2 if k < 2 else 1)
        kept[k] = (*_compass(counted, unit, value, most), counted)
    return kept


def _evaluations_left(objectives: Sequence[CountedObjective], evaluations: int) -> int:
    return evaluations - sum(a.count for a in objectives)


def _different(
    minima: Sequence[tuple[float, Array, CountedObjective]],
) -> list[tuple[float, Array, CountedObjective]]:
    """Return the minima from the lowest up, without those that came to the same place."""
    kept: list[tuple[float, Array, CountedObjective]] = []
    for value, unit, counted in sorted(minima, key=lambda item: item[0]):
        if all(counted is not other or np.abs(unit - at).max(initial=0.0) > 0.01 for _, at, other in kept):
            kept.append((value, unit, counted))
    return kept


def differences(ask: Callable[[Array], Array], unit: Array, step: float = DIFFERENCE) -> tuple[float, Array]:
    """Return value and gradient (d,) by central differences, one-sided at the faces; 0 where a neighbour is not feasible."""
    d = len(unit)
    high, low = np.minimum(unit + step * np.eye(d), 1.0), np.maximum(unit - step * np.eye(d), 0.0)
    value = ask(np.concatenate([unit[None], high, low]))
    width = np.diag(high) - np.diag(low)
    with np.errstate(invalid="ignore"):
        slope = (value[1 : d + 1] - value[d + 1 :]) / width
    return float(value[0]), np.where(np.isfinite(slope), slope, 0.0)


def _forward(ask: Callable[[Array], Array], unit: Array, step: float = DIFFERENCE) -> tuple[float, Array]:
    """Return value and gradient (d,) by one-sided differences into the box: half the evaluations, good enough to descend."""
    d = len(unit)
    step_of = np.where(unit > 0.5, -step, step)
    value = ask(np.concatenate([unit[None], unit + np.diag(step_of)]))
    with np.errstate(invalid="ignore"):
        slope = (value[1 : d + 1] - value[0]) / step_of
    return float(value[0]), np.where(np.isfinite(slope), slope, 0.0)


def _descend(counted: CountedObjective, unit: Array, value: float, evaluations: int) -> tuple[float, Array]:
    from scipy.optimize import minimize

    if not counted.box.d or evaluations < 2 * (counted.box.d + 1):
        return value, unit
    scale = max(abs(value), 1e-300)

    def scaled_value(at: Array) -> tuple[float, Array]:
        here, slope = _forward(counted, at)
        return (here / scale if np.isfinite(here) else 10.0), slope / scale

    most = evaluations // (counted.box.d + 1)
    options: Any = {"maxfun": most, "maxiter": most, "ftol": 1e-9, "gtol": 1e-7}
    done = minimize(
        scaled_value, unit, jac=True, method="L-BFGS-B", bounds=[(0.0, 1.0)] * counted.box.d, options=options
    )
    return (float(done.fun) * scale, np.asarray(done.x)) if done.fun * scale < value else (value, unit)


def _compass(counted: CountedObjective, unit: Array, value: float, evaluations: int) -> tuple[float, Array]:
    d, step = counted.box.d, STEPS[0]
    if not d:
        return value, unit
    last = np.zeros(d)
    while step > STEPS[1] and evaluations >= 2 * d + 1:
        around = np.concatenate([unit + step * np.eye(d), unit - step * np.eye(d), (unit + last)[None]])
        around = np.clip(around, 0.0, 1.0)
        values = counted(around)
        evaluations -= len(around)
        k = int(values.argmin())
        if values[k] < value - 1e-12 * abs(value):
            last, unit, value = around[k] - unit, around[k], float(values[k])
        else:
            step, last = step / 2, np.zeros(d)
    return value, unit


def polished_from(
    objective: Objective, box: PoseBox, unit: Array, before: SearchOutcome, evaluations: int = 1000
) -> SearchOutcome:
    """Run descent and compass from one more start; return the better of its end and the previous outcome."""
    counted = CountedObjective(box, objective)
    value = float(counted(unit[None])[0])
    if box.d:
        value, unit = _descend(counted, unit, value, evaluations // 2)
        value, unit = _compass(counted, unit, value, evaluations // 2)
    count = before.evaluations + counted.count
    if value >= before.value:
        return replace(before, evaluations=count)
    pose = box.poses(unit[None])[0][0]
    return SearchOutcome(box, unit, pose, value, count, ((value, pose), *before.local))
