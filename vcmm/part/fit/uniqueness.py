"""Decide whether an element that touches its points is unique: a statement about the contacts, to the first order.

An element by contact is held when every small motion makes it worse. Where some motion makes it worse by less than
`LOOSE` of the way (or than a few times form / radius, the part that the curvature adds), other places are as good
within what points can tell: a maximum inscribed circle between two opposite points slides along. The size is the
same wherever it lies; the place is one of several.
"""

from __future__ import annotations

import numpy as np

from vcmm.part.fit.elements import Array, Mask, Triple, frames, pose_column
from vcmm.part.fit.exchange import TOUCH, ContactProblem, Local, SettledState

LOOSE = 1e-6


def is_unique(problem: ContactProblem, data: Array, settled: SettledState) -> Mask:
    """Return the mask (B,) of the members of data (B, 3, n) whose contacts leave no motion free."""
    goal = problem.goal
    if goal.tangent:  # strictly convex where the points determine the element
        return np.ones(len(data), dtype=bool)
    at = problem.at(data, settled.state)
    metric = at.jac @ at.jac.swapaxes(-1, -2) / at.jac.shape[-1]
    if goal.convex:
        return _held_by_curvature(problem, at, settled, metric)
    from vcmm.part.fit._nearest_kernels import reaches

    side = np.where(at.d < 0.0, -1.0, 1.0) if goal.two_sided else np.ones_like(at.d)
    form = np.ptp(at.d, axis=-1)
    size = np.abs(settled.state.sizes[:, 0]) if problem.element.sizes else np.full(len(form), np.inf)
    loose = np.clip(4.0 * form / np.maximum(size, 1e-12), LOOSE, 0.05)
    out = np.zeros(len(data))
    reaches(np.ascontiguousarray(at.jac * side[:, None]), settled.contacts, metric, 4.0 / loose, out)
    perfect = goal.two_sided & (form <= TOUCH)  # a zone without width: every point touches both sides
    return np.asarray(perfect | (out < 1.0 / loose))


def _held_by_curvature(
    problem: ContactProblem, at: Local, settled_state: SettledState, metric: Array
) -> Mask:
    """Return whether a circumscribed element is unique by curvature: the problem curves upwards, and the contacts' own motions determine the pose."""
    touching = settled_state.contacts[:, None].astype(np.float64)
    rows = [at.jac * touching, *(row * touching for row in _crosswise(problem, at))]
    products = sum((row @ row.swapaxes(-1, -2) for row in rows), np.zeros(1))
    factor = np.linalg.inv(np.linalg.cholesky(metric + 1e-12 * np.eye(len(problem.free))))
    return np.asarray(np.linalg.eigvalsh(factor @ products @ factor.swapaxes(-1, -2))[:, 0] > 1e-6)


def _crosswise(problem: ContactProblem, at: Local) -> list[Array]:
    """Return how far a motion carries the surface along itself under each point of a circle, cylinder or sphere: one or
    two arrays of rows (B, p, n).
    """
    x, y, z = at.local[:, 0], at.local[:, 1], at.local[:, 2]
    height = z if problem.element.kind == "sphere" else np.zeros_like(z)
    rho = np.maximum(np.sqrt(x * x + y * y + height * height), 1e-150)
    if problem.element.kind == "sphere":
        turned = frames(np.stack([x, y, z], axis=-1) / rho[..., None])
        across: list[Triple] = [(turned[..., k, 0], turned[..., k, 1], turned[..., k, 2]) for k in (0, 1)]
    else:
        across = [(-y / rho, x / rho, 0.0)]
    columns = [[np.broadcast_to(pose_column(m, at.local, t), x.shape) for m in problem.free] for t in across]
    return [np.stack(each, axis=1) for each in columns]
