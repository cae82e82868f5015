"""When no pose is feasible: find the constraint, and its smallest relaxation, that makes some pose feasible.

For every constraint the others are kept and its own violation is minimised over the search space, first over the
given poses, then by a simplex search (Nelder & Mead, Computer Journal 7 (1965) 308) from the best of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vcmm.answer.placing.reach import CONSTRAINTS, Feasibility
from vcmm.core.errors import ModelLimit
from vcmm.core.pose import Array
from vcmm.task.measuring.fixture import pose_of

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
