"""Search over the boxes of a fixture: a space-filling sample, DIRECT in rounds, then multistart descent and a compass.

DIRECT: Jones, Perttunen, Stuckman, J. Optim. Theory Appl. 79 (1993) 157 (locally biased: Gablonsky & Kelley 2001).
Descent: L-BFGS-B with differences of all coordinates in one call. Compass: steps along the coordinates that
are halved when none helps; it also serves where the objective has kinks (linear tables) or steps (nearest nodes).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.measuring.plan import Ints
from vcmm.placing.objective import Objective
from vcmm.placing.space import Box

DIFFERENCE = 1e-4  # of the box, for gradients
STEPS = (2e-2, 1e-5)  # first and last step of the compass
KEPT = 4  # boxes that are searched beyond the sample
STARTS = 20  # first steps of descent from so many
SHORT, FULL = 6, 6  # gradients of the first steps; starts that are followed to the end


@dataclass
class Counted:
    """The objective over one box, in unit coordinates; remembers how often it was asked and what it was told."""

    box: Box
    objective: Objective
    count: int = 0
    reached: int = 0  # of these, poses that nothing keeps from being used
    seen: list[tuple[Array, Array]] = field(default_factory=list)

    def __call__(self, unit: Array) -> Array:
        """(m, d) -> (m,); inf where the pose is not feasible."""
        unit = np.clip(np.atleast_2d(unit), 0.0, 1.0)
        six, ok = self.box.poses(unit)
        out = np.full(len(unit), np.inf)
        if ok.any():
            out[ok] = self.objective.values(six[ok])
        self.count += len(unit)
        self.reached += int(ok.sum())
        self.seen.append((unit, out))
        return out

    def best(self, count: int, apart: float = 0.05) -> list[tuple[float, Array]]:
        """The best coordinates found so far that lie `apart` from one another."""
        unit = np.concatenate([u for u, _ in self.seen])
        value = np.concatenate([v for _, v in self.seen])
        found: list[tuple[float, Array]] = []
        for i in np.argsort(value, kind="stable"):
            if not np.isfinite(value[i]) or len(found) == count:
                break
            if all(np.abs(unit[i] - other).max(initial=0.0) > apart for _, other in found):
                found.append((float(value[i]), unit[i]))
        return found


@dataclass(frozen=True, eq=False)
class Found:
    """The outcome of a search: coordinates in a box, pose, value, and what it cost."""

    box: Box
    unit: Array
    pose: Array
    value: float
    evaluations: int
    local: tuple[tuple[float, Array], ...]  # value and pose of the other minima that were polished


def search(
    objective: Objective,
    found: Sequence[Box],
    *,
    evaluations: int = 5000,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> Found:
    """The lowest value over all boxes with at most so many evaluations of the objective."""
    report = progress or (lambda text, share: None)
    asked = [Counted(box, objective) for box in found]
    sample = int(np.clip(0.25 * evaluations / len(asked), 16, 1024))
    for k, one in enumerate(asked):
        one(_sobol(one.box.d, sample, seed))
        report("sampling the fixture", 0.4 * (k + 1) / len(asked))
    every, asked = asked, sorted((a for a in asked if a.best(1)), key=lambda a: a.best(1)[0][0])
    if not asked:
        raise _nothing(every)
    for one in asked[:KEPT]:
        if one.box.d:
            _direct(one, int(0.25 * evaluations / min(KEPT, len(asked))))
        report("dividing rectangles", 0.6)
    minima = _polished(asked, evaluations, report)
    value, unit, one = min(minima, key=lambda item: item[0])
    six, _ = one.box.poses(unit[None])
    others = tuple((v, other.box.poses(u[None])[0][0]) for v, u, other in sorted(minima, key=lambda m: m[0]))
    return Found(one.box, unit, six[0], value, sum(a.count for a in asked), others)


def _nothing(asked: Sequence[Counted]) -> ModelLimit:
    """Why no pose of the sample has a value."""
    count, reached = sum(a.count for a in asked), sum(a.reached for a in asked)
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
    from scipy.stats import qmc

    if d == 0:
        return np.zeros((1, 0))
    return np.asarray(qmc.Sobol(d, seed=seed).random_base2(int(np.log2(count))))


def _direct(one: Counted, evaluations: int) -> None:
    """DIRECT with all rectangles of a round asked in one call (scipy's asks one pose at a time, which costs 20 times).

    A rectangle is divided along its longest sides; of each size the `EACH` lowest are divided where they lie on the lower
    right hull of (size, value), so that no slope of the objective is presumed.
    """
    d = one.box.d
    centre, level = np.full((1, d), 0.5), np.zeros((1, d), dtype=int)
    value = _finite(one(centre), one)
    while one.count and evaluations > 0:
        chosen = _potential(level, value)
        points, owner, axis = _thirds(centre, level, chosen)
        cut = slice(max(1, evaluations // 2))  # every entry is a pair of poses
        points, owner, axis = points[cut], owner[cut], axis[cut]
        found = _finite(one(points.reshape(-1, d)), one).reshape(-1, 2)
        evaluations -= found.size
        centre, level, value = _divided(centre, level, value, (points, owner, axis, found))


EACH = 3


def _finite(value: Array, one: Counted) -> Array:
    """Infeasible poses count as twice the worst that was seen, so that values can be compared."""
    worst = max(float(v[np.isfinite(v)].max()) for _, v in one.seen if np.isfinite(v).any())
    return np.where(np.isfinite(value), value, worst + abs(worst))


def _potential(level: Array, value: Array) -> Array:
    """Numbers of the rectangles to divide."""
    size = level.min(axis=1)
    best: list[tuple[int, float, Ints]] = []
    for s in np.unique(size):
        mine = np.flatnonzero(size == s)
        order = mine[np.argsort(value[mine], kind="stable")[:EACH]]
        best.append((int(s), float(value[order[0]]), order))
    hull: list[tuple[int, float, Ints]] = []
    for item in sorted(best, key=lambda b: -b[0]):  # from the smallest rectangles up
        while hull and hull[-1][1] >= item[1]:
            hull.pop()
        while len(hull) > 1 and _above(hull[-2], hull[-1], item):
            hull.pop()
        hull.append(item)
    return np.concatenate([order for _, _, order in hull])


def _above(a: tuple[int, float, Ints], b: tuple[int, float, Ints], c: tuple[int, float, Ints]) -> bool:
    """Whether b lies above the line from a to c over the size 3^-level."""
    xa, xb, xc = (3.0 ** -float(t[0]) for t in (a, b, c))
    return (b[1] - a[1]) * (xc - xa) > (c[1] - a[1]) * (xb - xa)


def _thirds(centre: Array, level: Array, chosen: Array) -> tuple[Array, Array, Array]:
    """Points (p, 2, d) a third of the side to both sides, the rectangle and the axis they belong to."""
    points, owner, axis = [], [], []
    for r in chosen:
        longest = level[r].min()
        for j in np.flatnonzero(level[r] == longest):
            step = np.zeros(centre.shape[1])
            step[j] = 3.0 ** -float(longest + 1)
            points.append(np.stack([centre[r] + step, centre[r] - step]))
            owner.append(r)
            axis.append(j)
    return np.array(points), np.array(owner), np.array(axis)


def _divided(
    centre: Array, level: Array, value: Array, asked: tuple[Array, Array, Array, Array]
) -> tuple[Array, Array, Array]:
    """The rectangles after a round: sides with the lower values are divided first, so that they stay in larger ones."""
    points, owner, axis, found = asked
    level = level.copy()
    centres, levels, values = [centre], [level], [value]
    for r in np.unique(owner):
        mine = np.flatnonzero(owner == r)
        for k in mine[np.argsort(found[mine].min(axis=1), kind="stable")]:
            level[r, axis[k]] += 1
            centres.append(points[k])
            levels.append(np.tile(level[r], (2, 1)))
            values.append(found[k])
    return np.concatenate(centres), np.concatenate(levels), np.concatenate(values)


def _polished(
    asked: Sequence[Counted], evaluations: int, report: Callable[[str, float], None]
) -> list[tuple[float, Array, Counted]]:
    """A few steps of descent from many starts, the rest of the way from the best of those, the compass at the end.

    What is left of the evaluations is shared out anew before every descent, so that starts that end early leave theirs to
    the others.
    """
    starts = [(v, u, one) for one in asked[:KEPT] for v, u in one.best(STARTS)]
    found = sorted(starts, key=lambda item: item[0])[:STARTS]
    for k, (value, unit, one) in enumerate(found):
        most = min(SHORT * (one.box.d + 1), _left(asked, evaluations) // (2 * (len(found) - k)))
        found[k] = (*_descended(one, unit, value, most), one)
        report("descending", 0.6 + 0.2 * (k + 1) / len(found))
    found = _different(found)
    for k, (value, unit, one) in enumerate(found[:FULL]):
        most = _left(asked, evaluations) * 2 // (3 * (min(FULL, len(found)) - k))
        found[k] = (*_descended(one, unit, value, most), one)
        report("descending", 0.8 + 0.15 * (k + 1) / FULL)
    found.sort(key=lambda item: item[0])
    for k, (value, unit, one) in enumerate(found[:3]):
        most = _left(asked, evaluations) // (2 if k < 2 else 1)
        found[k] = (*_compass(one, unit, value, most), one)
    return found


def _left(asked: Sequence[Counted], evaluations: int) -> int:
    return evaluations - sum(a.count for a in asked)


def _different(found: Sequence[tuple[float, Array, Counted]]) -> list[tuple[float, Array, Counted]]:
    """From the lowest up, without those that came to the same place."""
    kept: list[tuple[float, Array, Counted]] = []
    for value, unit, one in sorted(found, key=lambda item: item[0]):
        if all(one is not other or np.abs(unit - at).max(initial=0.0) > 0.01 for _, at, other in kept):
            kept.append((value, unit, one))
    return kept


def differences(ask: Callable[[Array], Array], unit: Array, step: float = DIFFERENCE) -> tuple[float, Array]:
    """Value and gradient (d,) by central differences, one-sided at the faces; 0 where a neighbour is not feasible."""
    d = len(unit)
    high, low = np.minimum(unit + step * np.eye(d), 1.0), np.maximum(unit - step * np.eye(d), 0.0)
    value = ask(np.concatenate([unit[None], high, low]))
    width = np.diag(high) - np.diag(low)
    with np.errstate(invalid="ignore"):
        slope = (value[1 : d + 1] - value[d + 1 :]) / width
    return float(value[0]), np.where(np.isfinite(slope), slope, 0.0)


def _forward(ask: Callable[[Array], Array], unit: Array, step: float = DIFFERENCE) -> tuple[float, Array]:
    """Value and gradient (d,) by one-sided differences into the box: half the evaluations, good enough to descend."""
    d = len(unit)
    step_of = np.where(unit > 0.5, -step, step)
    value = ask(np.concatenate([unit[None], unit + np.diag(step_of)]))
    with np.errstate(invalid="ignore"):
        slope = (value[1 : d + 1] - value[0]) / step_of
    return float(value[0]), np.where(np.isfinite(slope), slope, 0.0)


def _descended(one: Counted, unit: Array, value: float, evaluations: int) -> tuple[float, Array]:
    from scipy.optimize import minimize

    if not one.box.d or evaluations < 2 * (one.box.d + 1):
        return value, unit
    scale = max(abs(value), 1e-300)

    def asked(at: Array) -> tuple[float, Array]:
        found, slope = _forward(one, at)
        return (found / scale if np.isfinite(found) else 10.0), slope / scale

    most = evaluations // (one.box.d + 1)
    options: Any = {"maxfun": most, "maxiter": most, "ftol": 1e-9, "gtol": 1e-7}
    done = minimize(
        asked, unit, jac=True, method="L-BFGS-B", bounds=[(0.0, 1.0)] * one.box.d, options=options
    )
    return (float(done.fun) * scale, np.asarray(done.x)) if done.fun * scale < value else (value, unit)


def _compass(one: Counted, unit: Array, value: float, evaluations: int) -> tuple[float, Array]:
    d, step = one.box.d, STEPS[0]
    if not d:
        return value, unit
    last = np.zeros(d)
    while step > STEPS[1] and evaluations >= 2 * d + 1:
        around = np.concatenate([unit + step * np.eye(d), unit - step * np.eye(d), (unit + last)[None]])
        around = np.clip(around, 0.0, 1.0)
        found = one(around)
        evaluations -= len(around)
        k = int(found.argmin())
        if found[k] < value - 1e-12 * abs(value):
            last, unit, value = around[k] - unit, around[k], float(found[k])
        else:
            step, last = step / 2, np.zeros(d)
    return value, unit


def polished_from(
    objective: Objective, box: Box, unit: Array, before: Found, evaluations: int = 1000
) -> Found:
    """Descent and compass from one more start; the better of its end and what was found before."""
    one = Counted(box, objective)
    value = float(one(unit[None])[0])
    if box.d:
        value, unit = _descended(one, unit, value, evaluations // 2)
        value, unit = _compass(one, unit, value, evaluations // 2)
    count = before.evaluations + one.count
    if value >= before.value:
        return replace(before, evaluations=count)
    pose = box.poses(unit[None])[0][0]
    return Found(box, unit, pose, value, count, ((value, pose), *before.local))
