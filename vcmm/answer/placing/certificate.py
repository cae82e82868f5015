"""Estimate how much better any pose could still be than the result of the search.

Three statements, none of them a bound or a proof: the best of a dense scan of poses that the search never saw; the gain that the
slopes measured on that scan allow for poses between; and the objective if every influence were as small
as at its own best pose of the scan, all at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.streams import key
from vcmm.answer.placing.fixture_boxes import PoseBox
from vcmm.answer.placing.objective import Objective, PoseSpread, Uncertain
from vcmm.answer.placing.search import SearchOutcome, differences, polished_from
from vcmm.answer.placing.sobol import sobol
from vcmm.core.blocks import Progress
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array

SLOPES = 24  # lowest poses of the scan whose slopes are measured


LEAST_SHOWN = 5e-6  # shares below it are printed as 0.000 %: no better pose


@dataclass(frozen=True, eq=False)
class Scan:
    """Feasible poses sampled evenly over the fixture, (m, 6), their values (m,), and the share of draws that is feasible."""

    box: tuple[int, ...]
    unit: tuple[Array, ...]
    poses: Array
    values: Array
    share: float


@dataclass(frozen=True)
class Certificate:
    """scan_count: poses of the scan. better: by which share of the value the best of them is better (0: none).

    earlier: by which share a scan before this one was better than the result of the search; it went on from there (0:
    there was none). hidden_gain: estimate of the share by which a pose between those of the scan could be better, by the
    slopes measured. floor: share by which the objective would be smaller if every influence were as small as at its own
    best pose, of the scan or the one found; an estimate over these poses (None where the objective is no sum of influences).
    spacing: largest distance from the scan that was seen at even draws, in units of the fixture's ranges.
    """

    method: str
    scan_count: int
    better: float
    hidden_gain: float
    floor: float | None
    spacing: float
    earlier: float = 0.0

    @property
    def text(self) -> str:
        verdict = "none better" if self.better < LEAST_SHOWN else f"one better by {self.better:.3%}"
        before = (
            f" (a scan before this one had found one better by {self.earlier:.3%}, from where the search went on)"
            if self.earlier > 0
            else ""
        )
        floor = (
            ""
            if self.floor is None
            else f", with every influence as small as at its own best of these poses, all at once, by {self.floor:.2%}"
        )
        slopes = f"by the slopes measured a pose between them could be better by {self.hidden_gain:.2%}"
        if self.hidden_gain >= 1.0:
            slopes = "too coarse for the slopes measured to say what lies between them (scan more)"
        return (
            f"{verdict} among {self.scan_count} poses that the search never saw{before}, spacing {self.spacing:.3f} of the ranges; "
            f"estimates, no bounds: {slopes}{floor}"
        )


def scan(objective: Objective, boxes: Sequence[PoseBox], count: int, seed: int, progress: Progress) -> Scan:
    """Evaluate scrambled Sobol points in all boxes, more even than independent draws, in batches."""
    units, poses, values, numbers, drawn = [], [], [], [], 0
    each = max(16, count // len(boxes))
    for k, box in enumerate(boxes):
        unit = _even(box.d, each, [seed, 7, k])
        six, ok = box.poses(unit)
        drawn += len(unit)
        value = np.full(len(unit), np.inf)
        for at in range(0, len(unit), 512):
            s = slice(at, at + 512)
            if ok[s].any():
                value[np.flatnonzero(ok[s]) + at] = objective.values(six[s][ok[s]])
            progress("scanning for the certificate", (k + at / len(unit)) / len(boxes))
        kept = np.isfinite(value)
        units.append(unit[kept])
        poses.append(six[kept])
        values.append(value[kept])
        numbers.append(k)
    total = np.concatenate(values)
    if not len(total):
        raise ModelLimit(
            f"none of the {drawn} poses of the scan can be used, though the search found one: widen the ranges of the fixture, or "
            "scan more poses"
        )
    return Scan(tuple(numbers), tuple(units), np.concatenate(poses), total, len(total) / max(drawn, 1))


def _even(d: int, count: int, seed: Sequence[int]) -> Array:
    """Return even points (count, d); one point where nothing is free."""
    if d == 0:
        return np.zeros((1, 0))
    return sobol(d, count, np.random.default_rng(seed).spawn(1)[0])  # the stream that scipy would take


def scan_after(
    objective: Objective,
    boxes: Sequence[PoseBox],
    outcome: SearchOutcome,
    count: int,
    seed: int,
    progress: Progress,
) -> tuple[SearchOutcome, Scan, float]:
    """Return the outcome of a search, a scan that neither it nor any polish has seen, and `Certificate.earlier`.

    Where a first scan finds a better pose, the search goes on from there, once, and a scan of other poses follows.
    """
    first_scan = scan(objective, boxes, count, _seed(seed, 1), progress)
    if first_scan.values.min() >= outcome.value:
        return outcome, first_scan, 0.0
    k = int(first_scan.values.argmin())
    sizes = np.cumsum([len(u) for u in first_scan.unit])
    number = int(np.searchsorted(sizes, k, side="right"))
    start = first_scan.unit[number][k - (sizes[number - 1] if number else 0)]
    better = polished_from(objective, boxes[first_scan.box[number]], start, outcome)
    again = scan(objective, boxes, count, _seed(seed, 2), progress)
    return better, again, (outcome.value - float(first_scan.values[k])) / abs(outcome.value)


def _seed(seed: int, number: int) -> int:
    """Return a seed that no other use of `seed` shares."""
    return int(key(seed, f"placement scan {number}")[0])


def certify(
    objective: Objective,
    boxes: Sequence[PoseBox],
    pose: Array,
    best: float,
    last_scan: Scan,
    earlier: float = 0.0,
) -> Certificate:
    """Return the certificate of a scan for a pose (6,) with the value `best`."""
    better = max(0.0, (best - float(last_scan.values.min())) / abs(best)) if best else 0.0
    spacing, hidden, at = 0.0, 0.0, 0
    for k, unit in zip(last_scan.box, last_scan.unit):
        values = last_scan.values[at : at + len(unit)]
        at += len(unit)
        if not len(unit) or boxes[k].d == 0:
            continue
        reach = _spacing(unit)
        spacing = max(spacing, float(reach.max()))
        hidden = max(
            hidden, _hidden_gain(objective, boxes[k], unit, values, best, float(np.quantile(reach, 0.95)))
        )
    floor = _floor(objective, last_scan.poses, pose, best) if isinstance(objective, Uncertain) else None
    method = "dense scan and slopes" if floor is None else "dense scan, slopes and least influences"
    return Certificate(
        method, len(last_scan.values), better, hidden, floor=floor, spacing=spacing, earlier=earlier
    )


def _spacing(unit: Array) -> Array:
    """Return the distances (2000,) of even draws to the nearest pose of the scan."""
    from scipy.spatial import cKDTree

    probes = np.random.default_rng(11).random((2000, unit.shape[1]))
    return np.asarray(cKDTree(unit).query(probes)[0])


def _hidden_gain(
    objective: Objective, box: PoseBox, unit: Array, values: Array, best: float, reach: float
) -> float:
    """Return the share of `best` by which a pose near the lowest of the scan could be better: value - |slope| x spacing."""

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


def _floor(objective: Uncertain, poses: Array, chosen: Array, best: float) -> float | None:
    """Return the share of `best` saved if every influence were at its least over the scan and the best pose, all at once.

    For mixtures of U and U/T of smooth characteristics; None for others, whose objective is no sum of influences. The
    poses are a sample: at others an influence may be smaller still.
    """
    mixture = {k for k, v in objective.goal.mixture.items() if v}
    counted = [i for i, c in enumerate(objective.characteristics) if objective.weights[c.name]]
    if not mixture <= {"U", "U/T"} or any(i not in objective.smooth for i in counted) or not best:
        return None
    tried = np.concatenate([chosen[None], poses[:: max(1, len(poses) // 1500)]])
    first, second = objective.closed.variances(tried, objective.gradient_rows)
    u = np.sqrt(first.min(axis=0).sum(axis=1) + second.min(axis=0))[None]
    least = PoseSpread(u, u * objective.factors, np.zeros_like(u))
    value = sum(
        share * float(objective.part(k, least)[0]) for k, share in objective.goal.mixture.items() if share
    )
    return max(0.0, (best - value) / abs(best))  # the pose found counts: only rounding is below 0
