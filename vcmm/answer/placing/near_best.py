"""Flatness of the optimum: a map of the objective over the table, the region within 2 %, a convenient pose in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.placing.fixture_boxes import PoseBox
from vcmm.answer.placing.objective import Objective
from vcmm.answer.placing.search import SearchOutcome
from vcmm.core.run import Array
from vcmm.task.measuring.fixture import DOFS

WITHIN = 0.02
ROUND = ((100.0, 90.0), (50.0, 45.0), (20.0, 15.0), (10.0, 10.0), (5.0, 5.0), (1.0, 1.0))  # mm, deg


@dataclass(frozen=True, eq=False)
class Map:
    """values (ny, nx) of the objective over two degrees of freedom, the others at the best pose; NaN: not allowed.

    With one degree of freedom ny = 1; without any, both axes have one entry.
    """

    names: tuple[str, ...]
    x: Array
    y: Array
    values: Array

    def axis_values(self, k: int) -> tuple[str, Array]:
        """Name with unit and values of one degree of freedom (0 or 1), in mm or deg; of none an empty name."""
        if k >= len(self.names):
            return "", (self.x, self.y)[k]
        turns = self.names[k].startswith("turn")
        return f"{self.names[k]} / {'deg' if turns else 'mm'}", np.degrees(
            (self.x, self.y)[k]
        ) if turns else (self.x, self.y)[k]


@dataclass(frozen=True, eq=False)
class Region:
    """Poses within `within` of the best. share: of the feasible poses of the scan; box: name -> range, all poses of
    which are within it (checked on `pose_count` poses); convenient: a rounded pose (6,) within it, or None, and its value.
    """

    within: float
    share: float
    box: dict[str, tuple[float, float]]
    pose_count: int
    convenient: Array | None
    convenient_value: float


def values_at(objective: Objective, box: PoseBox, poses: Array) -> Array:
    """Return the objective at poses (m, 6); NaN where the fixture or a constraint does not allow them."""
    unit = box.unit(poses)
    _, ok = box.poses(np.clip(unit, 0.0, 1.0))
    ok &= ((unit >= -1e-9) & (unit <= 1 + 1e-9)).all(axis=1)
    ok &= box.travels.feasible(poses)
    out = np.full(len(poses), np.nan)
    if ok.any():
        out[ok] = objective.values(poses[ok])
    return np.where(np.isfinite(out), out, np.nan)


def table_map(objective: Objective, outcome: SearchOutcome, nodes: int = 33) -> Map:
    """Return the objective over x and y where both are free, else over the first two free degrees of freedom."""
    names = [f.name for f in outcome.box.freedoms]
    names = ["x", "y"] if {"x", "y"} <= set(names) else names[:2]
    axes = [np.linspace(*_ends(outcome, n), nodes) for n in names]
    x = axes[0] if names else outcome.pose[:1]
    y = axes[1] if len(names) > 1 else outcome.pose[1:2]
    poses = np.tile(outcome.pose, (len(x) * len(y), 1))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    for j, name in enumerate(names):
        poses[:, DOFS.index(name)] = grid[:, j]
    return Map(tuple(names), x, y, values_at(objective, outcome.box, poses).reshape(len(y), len(x)))


def _ends(outcome: SearchOutcome, name: str) -> tuple[float, float]:
    """Return the range of one degree of freedom that the fixture and the travels allow, at the best orientation."""
    f = next(f for f in outcome.box.freedoms if f.name == name)
    if name.startswith("turn"):
        return f.low, f.high
    i = DOFS.index(name)
    low, high = outcome.box.travels.intervals(outcome.pose[None])
    a, b = max(f.low, float(low[0, i])), min(f.high, float(high[0, i]))
    return (a, b) if b > a else (a, a + 1e-6)


def region(objective: Objective, outcome: SearchOutcome, values: Array, seed: int) -> Region:
    """Return the poses within 2 % of the best one. values: those of the scan."""
    limit = outcome.value + WITHIN * abs(outcome.value)
    share = float((values <= limit).mean()) if len(values) else 0.0
    box, checked = _box_within(objective, outcome, limit, seed)
    pose, value = _convenient(objective, outcome, limit)
    return Region(WITHIN, share, box, checked, pose, value)


def _box_within(
    objective: Objective, outcome: SearchOutcome, limit: float, seed: int
) -> tuple[dict[str, tuple[float, float]], int]:
    """Return a box about the best pose that stays within the limit: how exactly the operator must place the part there."""
    names = [f.name for f in outcome.box.freedoms]
    if not names:
        return {}, 0
    rng = np.random.default_rng([seed, 13])
    draws = np.concatenate([_corners(len(names), rng), rng.random((150, len(names)))])
    box, checked = _box_about(objective, outcome, outcome.pose, limit, draws)
    nothing = {n: (float(outcome.pose[DOFS.index(n)]),) * 2 for n in names}
    return (box, checked) if checked else (nothing, 0)


def _box_about(
    objective: Objective, outcome: SearchOutcome, centre: Array, limit: float, draws: Array
) -> tuple[dict[str, tuple[float, float]], int]:
    """Return a box about a centre, from the ranges of each freedom alone, shrunk until all poses tried stay within the limit."""
    ends = {f.name: _line(objective, outcome, centre, f.name, limit) for f in outcome.box.freedoms}
    scale = 1.0
    for _ in range(6):
        box = {}
        for name, (low, high) in ends.items():
            here = float(centre[DOFS.index(name)])
            box[name] = (here + scale * (low - here), here + scale * (high - here))
        if _inside(objective, outcome, box, draws, limit):
            return box, len(draws)
        scale *= 0.7
    return {}, 0


def _line(
    objective: Objective, outcome: SearchOutcome, centre: Array, name: str, limit: float
) -> tuple[float, float]:
    """Return the range of one degree of freedom about a pose that stays within the limit, the others kept."""
    i, here = DOFS.index(name), float(centre[DOFS.index(name)])
    grid = np.unique(np.concatenate([np.linspace(*_ends(outcome, name), 41), [here]]))
    poses = np.tile(centre, (len(grid), 1))
    poses[:, i] = grid
    good = values_at(objective, outcome.box, poses) <= limit
    at = int(np.searchsorted(grid, here))
    low = high = at
    while low > 0 and good[low - 1]:
        low -= 1
    while high < len(grid) - 1 and good[high + 1]:
        high += 1
    return float(grid[low]), float(grid[high])


def _corners(d: int, rng: np.random.Generator) -> Array:
    """Return all corners of the unit cube, at most 64 of them."""
    from itertools import product

    corners = np.array(list(product((0.0, 1.0), repeat=d)))
    return corners if len(corners) <= 64 else rng.permutation(corners)[:64]


def _inside(
    objective: Objective,
    outcome: SearchOutcome,
    box: dict[str, tuple[float, float]],
    draws: Array,
    limit: float,
) -> bool:
    poses = np.tile(outcome.pose, (len(draws), 1))
    for j, (name, (low, high)) in enumerate(box.items()):
        poses[:, DOFS.index(name)] = low + draws[:, j] * (high - low)
    return bool((values_at(objective, outcome.box, poses) <= limit).all())


def _convenient(objective: Objective, outcome: SearchOutcome, limit: float) -> tuple[Array | None, float]:
    """Return the most coarsely rounded pose that is still within the limit."""
    free = [DOFS.index(f.name) for f in outcome.box.freedoms]
    for mm, deg in ROUND if free else ():
        pose = outcome.pose.copy()
        for i in free:
            step = mm if i < 3 else np.radians(deg)
            pose[i] = np.round(pose[i] / step) * step
        value = float(values_at(objective, outcome.box, pose[None])[0])
        if value <= limit:
            return pose, value
    return None, float("nan")
