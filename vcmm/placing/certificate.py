"""How much better any pose could still be than the one that was found.

Three statements of rising strength, none of them a proof: a dense scan on poses of its own found none better; the
slopes measured on the scan bound what can hide between its poses; and if every influence were as small as at its own
best pose of the scan, all at once, the objective would still be so large (a floor that no pose of the scan can pass).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.placing.objective import Objective, Spread, Uncertain
from vcmm.placing.search import Found, differences
from vcmm.placing.space import Box
from vcmm.run import Array

SLOPES = 24  # lowest poses of the scan whose slopes are measured


@dataclass(frozen=True, eq=False)
class Scan:
    """Feasible poses drawn evenly over the fixture, (m, 6), their values (m,), and the share of draws that is feasible."""

    box: tuple[int, ...]
    unit: tuple[Array, ...]
    poses: Array
    values: Array
    share: float


@dataclass(frozen=True)
class Certificate:
    """scanned: poses of the scan. better: by which share of the value the best of them is better (0: none).

    hidden: share by which a pose between those of the scan could be better, by the slopes measured. floor: share by
    which a pose could be better at most if every influence were at its own least (None where that cannot be told).
    spacing: largest distance of any pose from one of the scan, in units of the fixture's ranges.
    """

    method: str
    scanned: int
    better: float
    hidden: float
    floor: float | None
    spacing: float

    @property
    def text(self) -> str:
        floor = (
            "" if self.floor is None else f"; no more than {self.floor:.2%} by the floor of the influences"
        )
        found = "none better" if self.better <= 0 else f"one better by {self.better:.3%}"
        return (
            f"{found} among {self.scanned} further poses (spacing {self.spacing:.3f} of the ranges); by the slopes measured a "
            f"pose between them could be better by {self.hidden:.2%}{floor}"
        )


def scan(
    objective: Objective, boxes: Sequence[Box], count: int, seed: int, progress: Callable[[str, float], None]
) -> Scan:
    """Even draws over all boxes, in batches."""
    units, poses, values, numbers, drawn = [], [], [], [], 0
    each = max(16, count // len(boxes))
    for k, box in enumerate(boxes):
        unit = np.random.default_rng([seed, 7, k]).random((each, box.d)) if box.d else np.zeros((1, 0))
        unit = _spread_out(unit, seed + 1000 + k)
        six, ok = box.poses(unit)
        drawn += len(unit)
        found = np.full(len(unit), np.inf)
        for at in range(0, len(unit), 512):
            s = slice(at, at + 512)
            if ok[s].any():
                found[np.flatnonzero(ok[s]) + at] = objective.values(six[s][ok[s]])
            progress("scanning for the certificate", (k + at / len(unit)) / len(boxes))
        kept = np.isfinite(found)
        units.append(unit[kept])
        poses.append(six[kept])
        values.append(found[kept])
        numbers.append(k)
    total = np.concatenate(values)
    return Scan(tuple(numbers), tuple(units), np.concatenate(poses), total, len(total) / max(drawn, 1))


def _spread_out(unit: Array, seed: int) -> Array:
    """A scrambled Sobol set of the same shape: more even than independent draws."""
    if unit.shape[1] == 0:
        return unit
    from scipy.stats import qmc

    power = int(np.ceil(np.log2(len(unit))))
    return np.asarray(qmc.Sobol(unit.shape[1], seed=seed).random_base2(power)[: len(unit)])


def certify(objective: Objective, boxes: Sequence[Box], found: Found, seen: Scan) -> Certificate:
    """What the scan says about the outcome of the search."""
    best = found.value
    better = max(0.0, (best - float(seen.values.min())) / abs(best)) if best else 0.0
    spacing, hidden, at = 0.0, 0.0, 0
    for k, unit in zip(seen.box, seen.unit):
        values = seen.values[at : at + len(unit)]
        at += len(unit)
        if not len(unit) or boxes[k].d == 0:
            continue
        reach = _spacing(unit)
        spacing = max(spacing, float(reach.max()))
        hidden = max(
            hidden, _hidden(objective, boxes[k], unit, values, best, float(np.quantile(reach, 0.95)))
        )
    floor = _floor(objective, seen.poses, best) if isinstance(objective, Uncertain) else None
    if floor is not None:
        hidden = min(hidden, floor)
    return Certificate("dense scan, slopes and floor", len(seen.values), better, hidden, floor, spacing)


def _spacing(unit: Array) -> Array:
    """Distances (2000,) of even draws to the nearest pose of the scan."""
    from scipy.spatial import cKDTree

    probes = np.random.default_rng(11).random((2000, unit.shape[1]))
    return np.asarray(cKDTree(unit).query(probes)[0])


def _hidden(objective: Objective, box: Box, unit: Array, values: Array, best: float, reach: float) -> float:
    """Share of `best` by which a pose near the lowest of the scan could be better: value - |slope| x spacing."""

    def ask(at: Array) -> Array:
        six, ok = box.poses(np.clip(at, 0.0, 1.0))
        out = np.full(len(at), np.inf)
        if ok.any():
            out[ok] = objective.values(six[ok])
        return out

    lowest = np.argsort(values)[:SLOPES]
    least = np.inf
    for i in lowest:
        value, slope = differences(ask, unit[i], 1e-3)
        if np.isfinite(value):
            least = min(least, value - float(np.linalg.norm(slope)) * reach)
    return max(0.0, (best - least) / abs(best)) if best and np.isfinite(least) else 0.0


def _floor(objective: Uncertain, poses: Array, best: float) -> float | None:
    """Share of `best` that could be gained if every influence were at its least over the scan, all at once.

    For mixtures of U and U/T of smooth characteristics; None for others, whose objective is no sum of influences.
    """
    mixture = {k for k, v in objective.goal.mixture.items() if v}
    counted = [i for i, c in enumerate(objective.characteristics) if objective.weights[c.name]]
    if not mixture <= {"U", "U/T"} or any(i not in objective.smooth for i in counted) or not best:
        return None
    chosen = poses[:: max(1, len(poses) // 1500)]
    first, second = objective.closed.variances(chosen, objective.gradient_rows)
    u = np.sqrt(first.min(axis=0).sum(axis=1) + second.min(axis=0))[None]
    least = Spread(u, u * objective.factors, np.zeros_like(u))
    value = sum(
        share * float(objective.part(k, least)[0]) for k, share in objective.goal.mixture.items() if share
    )
    return max(0.0, (best - value) / abs(best))
