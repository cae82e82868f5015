"""Find the best pose of a scenario, its gain and the certainty of the gain; and which of several machines suits the part.

When no pose is feasible: find the constraint, and its smallest relaxation, that makes some pose feasible.

For every constraint the others are kept and its own violation is minimised over the search space, first over the
given poses, then by a simplex search (Nelder & Mead, Computer Journal 7 (1965) 308) from the best of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.checks import remarks
from vcmm.answer.evaluation.result import UncertaintyResult
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.placing.advice import UNSEEN_SHARE_OF_U
from vcmm.answer.placing.certificate import LEAST_SHOWN, Scan, certify, scan_after
from vcmm.answer.placing.confirmation import confirm
from vcmm.answer.placing.fixture_boxes import (
    PoseBox,
    all_boxes,
    boxes,
    default_fixture,
    probe_poses,
    unreachable,
)
from vcmm.answer.placing.hindrances import Constraint, Hindrance
from vcmm.answer.placing.near_best import region, table_map
from vcmm.answer.placing.objective import Uncertain
from vcmm.answer.placing.reach import CONSTRAINTS, Feasibility
from vcmm.answer.placing.reach import Feasibility as Reach
from vcmm.answer.placing.result import At, PlacementResult
from vcmm.answer.placing.search import SearchOutcome, search
from vcmm.answer.placing.travels import Travels
from vcmm.core.blocks import Progress
from vcmm.core.errors import ModelLimit
from vcmm.core.pose import Array
from vcmm.task.measuring.fixture import Fixture, Goal, Placement, pose_of, six_of
from vcmm.task.measuring.scenario import Scenario

STRICT = 1e3  # weight of the constraints that are kept, per mm, against the one that gives way
ADVICE = {
    "load": "use a machine that carries the part",
    "size": "use a larger machine, or another orientation",
    "fixture": "allow other slots, turns or faces",
    "travel": "move the range of poses, or use another stylus",
    "table": "raise the part",
    "direction": "add a stylus of another direction, or raise steepest",
    "approach": "reduce approach",
    "shaft": "use a thinner shaft or another stylus",
    "extension": "use a longer stylus",
    "head": "use a longer stylus",
    "quill": "use a longer stylus or an extension",
    "clamps": "move the clamps",
    "moves": "reduce clearance, or add a stylus",
}


@dataclass(frozen=True, eq=False)
class Relaxation:
    """If `constraint` gave way by `amount` (mm; an angle as the arc at the part's rim) alone, `pose` (6,) would be feasible."""

    constraint: str
    amount: float
    pose: Array


def relaxation(
    check: Feasibility,
    poses: npt.ArrayLike,
    low: npt.ArrayLike | None = None,
    high: npt.ArrayLike | None = None,
    polish: int = 200,
) -> tuple[Relaxation, ...]:
    """Return the smallest relaxation of each single constraint that opens a pose, smallest first; empty where no single one does.

    poses (m, 6): the search space as points. low, high (6,): its range, in which the best points are improved by at most
    `polish` evaluations each; without them only the points count. amount 0 means that a pose is feasible as it is.
    """
    six = np.atleast_2d(np.asarray(poses, dtype=np.float64))
    lacks = check.amounts(six)
    out = []
    for c, name in enumerate(CONSTRAINTS):
        others = np.delete(lacks, c, axis=1).sum(axis=1)
        score = lacks[:, c] + STRICT * others
        best = int(np.argmin(score))
        pose, amount, rest = six[best], float(lacks[best, c]), float(others[best])
        if low is not None and high is not None and (rest > 0.0 or amount > 0.0):
            pose, amount, rest = _polish(check, c, pose, np.asarray(low), np.asarray(high), polish)
        if rest == 0.0:
            out.append(Relaxation(name, amount, pose))
    if any(r.amount == 0.0 for r in out):
        return tuple(r for r in out if r.amount == 0.0)[:1]
    return tuple(sorted(out, key=lambda r: r.amount))


def _polish(
    check: Feasibility, c: int, pose: Array, low: Array, high: Array, evaluations: int
) -> tuple[Array, float, float]:
    """Search for the pose near `pose` within its range where constraint c is violated least and the others are kept."""
    from scipy.optimize import minimize

    free = np.flatnonzero(high > low)

    def full(x: Array) -> Array:
        out = pose.copy()
        out[free] = low[free] + np.clip(x, 0.0, 1.0) * (high - low)[free]
        return out

    def score(x: Array) -> float:
        a = check.amounts(full(x))[0]
        return float(a[c] + STRICT * (a.sum() - a[c]))

    begin = (pose[free] - low[free]) / (high - low)[free] if len(free) else np.zeros(0)
    if len(free):
        simplex = np.vstack([begin, begin + np.where(begin > 0.5, -0.1, 0.1) * np.eye(len(free))])
        options: Any = {"maxfev": evaluations, "initial_simplex": simplex, "xatol": 1e-7, "fatol": 1e-6}
        begin = minimize(score, begin, method="Nelder-Mead", options=options).x
    at = full(begin)
    a = check.amounts(at)[0]
    return at, float(a[c]), float(a.sum() - a[c])


def no_reachable_pose(
    openings: tuple[Relaxation, ...], check: Feasibility, nearest: npt.ArrayLike
) -> ModelLimit:
    """Return the error for a search space without a feasible pose. nearest (6,): the pose with the smallest violation."""
    if openings:
        opening = openings[0]
        also = ", ".join(f"{r.constraint} by {r.amount:.4g} mm" for r in openings[1:3])
        text = (
            f"no reachable pose: the smallest relaxation that opens one is {opening.constraint} by {opening.amount:.4g} mm; "
            f"{ADVICE[opening.constraint]}" + (f" (or relax {also})" if also else "")
        )
    else:
        text = "no reachable pose, and no single constraint opens one"
    places = check.problems(pose_of(np.asarray(nearest)))
    worst = "; ".join(p.text for p in places[:3])
    return ModelLimit(text + (f". At the nearest pose: {worst}" if worst else ""))


EVALUATIONS, SCANNED = 5000, 4096
SAME_OBJECTIVE_SHARE = 1e-9  # of the objective: rounding noise is no better pose
TRIALS = 100_000  # of the full evaluation at the present and the best pose


def place(
    scenario: Scenario,
    *,
    fixture: Fixture | None = None,
    goal: Goal | None = None,
    constraints: Sequence[Constraint] | None = None,
    seed: int | None = None,
    evaluations: int = EVALUATIONS,
    scanned: int = SCANNED,
    trials: int | None = None,
    progress: Progress | None = None,
) -> PlacementResult:
    """Place a part: return the best pose that was found for a scenario, with certificate, map, flatness and a confirmed gain.

    fixture, goal: those of the scenario's [placement] unless given. constraints: what a pose must keep beside the travels;
    by default room for stylus, head and quill, access, load and clamps ([surroundings]), () for none.
    Raises ModelLimit when no pose can be reached, UsageError for an objective that does not suit the part.
    """
    report = progress or (lambda text, share: None)
    planned = scenario.placement or Placement()
    fixture = fixture or planned.fixture or default_fixture()
    objective = Uncertain.of(scenario, goal or planned.goal)
    scenario.settings.with_changes(trials=trials, seed=seed)
    seed = scenario.settings.seed if seed is None else seed
    travels, six = Travels(objective.closed.rows), six_of(scenario.pose)
    reach = None
    if constraints is None:
        report("room for stylus, head and part", 0.0)
        reach = Reach.of(scenario, fixture)
    further: Sequence[Constraint] = (reach,) if reach is not None else constraints or ()
    problems = _problems(scenario, travels, further)
    allowed = _boxes(fixture, six, travels, further, reach)
    left_out = unreachable(fixture, six, travels, further, allowed)
    objective = _at_reference(objective, allowed, problems)
    outcome = search(objective, allowed, evaluations=evaluations, seed=seed, progress=report)
    outcome, scan, earlier = scan_after(objective, allowed, outcome, scanned, seed, report)
    present = None if problems else _at(objective, six)
    placed = _report_outcome(
        objective, allowed, outcome, (scan, earlier), present=present, seed=seed, report=report
    )
    placed = _evaluate_poses(placed, problems, trials, report)
    return replace(placed, warnings=(*left_out, *placed.warnings))


def _boxes(
    fixture: Fixture, six: Array, travels: Travels, further: Sequence[Constraint], reach: Reach | None
) -> list[PoseBox]:
    """Return the boxes of a fixture; where none can be reached, raise an error with the smallest relaxation that opens one."""
    boxes(fixture, six, travels)  # the travels alone: their message says which end to move
    try:
        return boxes(fixture, six, travels, further)
    except ModelLimit:
        if reach is None:
            raise
        poses = np.concatenate([probe_poses(box) for box in all_boxes(fixture, six, travels, further)])
        low, high = poses.min(axis=0), poses.max(axis=0)
        nearest = poses[int(reach.violation(poses).argmin())]
        raise no_reachable_pose(relaxation(reach, poses, low, high), reach, nearest) from None


def _problems(scenario: Scenario, travels: Travels, further: Sequence[Constraint]) -> tuple[Hindrance, ...]:
    out: list[Hindrance] = list(travels.problems(scenario.pose))
    for box in further:
        out += box.problems(scenario.pose)
    return tuple(out)


def _at_reference(
    objective: Uncertain, allowed: Sequence[PoseBox], problems: Sequence[Hindrance]
) -> Uncertain:
    """Return the objective with coverage factors at the present pose; where that cannot be used, at the first pose that can."""
    if not problems:
        return objective
    six, ok = allowed[0].poses(np.random.default_rng(3).random((256, allowed[0].d)))
    closed = objective.closed
    if ok.any():
        closed = replace(closed, at=six[ok][0])
    return replace(objective, closed=closed)


def _at(objective: Uncertain, six: Array) -> At:
    spread = objective.spread(six[None])
    return At(six, float(objective.values(six[None])[0]), spread.u[0], spread.expanded[0])


def _pose_distance(pose: Array, other: Array) -> float:
    """Return how far two poses (6,) are from one another, mm; a turn counts as on an arm of 100 mm."""
    turn = (pose[3:] - other[3:] + np.pi) % (2 * np.pi) - np.pi
    return float(np.linalg.norm(np.concatenate([pose[:3] - other[:3], 100.0 * turn])))


def _report_outcome(
    objective: Uncertain,
    allowed: Sequence[PoseBox],
    outcome: SearchOutcome,
    last_scan: tuple[Scan, float],
    *,
    present: At | None,
    seed: int,
    report: Progress,
) -> PlacementResult:
    """Return the outcome of the search with all statements about it except the full evaluations."""
    scan, earlier = last_scan
    order = np.argsort(scan.values, kind="stable")
    middle, last = order[len(order) // 2], order[-1]
    best = _at(objective, outcome.pose)
    if present is not None and present.value <= best.value * (1 + SAME_OBJECTIVE_SHARE):
        best = present  # nothing better was found: the part stays where it is
    elif (
        present is not None and len(allowed) == 1
    ):  # of poses that are equally good the one nearest to the present
        equal = [pose for value, pose in outcome.local if value <= best.value * (1 + SAME_OBJECTIVE_SHARE)]
        near = min(equal, key=lambda pose: _pose_distance(pose, present.pose), default=best.pose)
        best = best if near is best.pose else _at(objective, near)
        outcome = replace(
            outcome, pose=best.pose, value=best.value
        )  # map and convenient pose are of this one
    report("drawing the map", 0.0)
    chart = table_map(objective, outcome)
    flat = region(objective, outcome, scan.values, seed)
    certificate = certify(objective, allowed, best.pose, best.value, scan, earlier)
    confirmation = None
    if present is not None and best is not present:
        confirmation = confirm(objective, present.pose, best.pose, seed, report)
    return PlacementResult(
        objective=objective, label=outcome.box.label, best=best, present=present, problems=(),
        median=_at(objective, scan.poses[middle]), worst=_at(objective, scan.poses[last]), minima=outcome.local,
        evaluations=outcome.evaluations, feasible_share=scan.share, certificate=certificate, map=chart, region=flat,
        confirmation=confirmation, before=None, after=None, seed=seed, warnings=(),  # type: ignore[arg-type]
    )  # fmt: skip


def _evaluate_poses(
    placed: PlacementResult, problems: tuple[Hindrance, ...], trials: int | None, report: Progress
) -> PlacementResult:
    """Run full evaluations at the present and the best pose, and collect the warnings."""
    scenario = placed.objective.scenario
    settings = replace(
        scenario.settings, trials=trials or min(scenario.settings.trials, TRIALS), seed=placed.seed
    )

    def full(at: At) -> UncertaintyResult:
        return evaluate(scenario.at(pose_of(at.pose)).task(), settings, report)

    after = full(placed.best)
    before = None if placed.present is None else full(placed.present)
    notes = [
        *remarks(scenario),
        *_notes(placed, problems),
        *_known_bias(placed, before, after),
        *after.warnings,
    ]
    return replace(
        placed, problems=problems, before=before, after=after, warnings=tuple(dict.fromkeys(notes))
    )


def _known_bias(
    placed: PlacementResult, before: UncertaintyResult | None, after: UncertaintyResult
) -> list[str]:
    """Return a warning about a known bias left in U, which is no part of the objective, where it removes the gain of the pose."""
    if before is None or placed.best is placed.present:
        return []
    weights = placed.objective.weights
    worse = [
        f"{new.name} from {_with_unit(old.expanded, old.unit)} to {_with_unit(new.expanded, new.unit)}"
        for old, new in zip(before.characteristics, after.characteristics)
        if weights.get(new.name) and new.bias_in_U and new.expanded > (1 + UNSEEN_SHARE_OF_U) * old.expanded
    ]
    if not worse:
        return []
    return [
        f"the gain leaves the known bias aside; U with it grows at the pose found: {'; '.join(worse)}; correct the bias "
        '([job] known_bias = "corrected"), or leave the part where it is'
    ]


def _with_unit(value: float, unit: str) -> str:
    return f"{value * 1e3:.2g} um" if unit == "mm" else f"{value * 1e6:.2g} urad"


def _notes(placed: PlacementResult, problems: Sequence[Hindrance]) -> list[str]:
    out = []
    if problems:
        out.append(
            "the present pose cannot be used: "
            + "; ".join(p.text for p in problems[:3])
            + "; no gain over it can be stated"
        )
    objective = placed.objective
    extremes = [
        c.name
        for i, c in enumerate(objective.characteristics)
        if i not in objective.smooth and objective.weights[c.name]
    ]
    if extremes:
        out.append(
            f"{', '.join(extremes)}: an extreme value; the search used an approximation (normal inputs, few common draws), the "
            "gain and the results at the two poses are those of the full Monte Carlo"
        )
    sure = placed.confirmation
    if sure is not None and not sure.is_confirmed:
        out.append(
            f"the gain of {sure.gain:.3g} is not larger than twice its standard error {sure.u_gain:.2g}: the two poses are as good"
        )
    if placed.certificate.better >= LEAST_SHOWN:
        out.append(
            f"a pose of the scan is better by {placed.certificate.better:.3%}; search with more evaluations"
        )
    return out
