"""Is an element that touches its points the only one? A statement about the contacts, to the first order.

An element by contact is held when every small motion makes it worse. Where some motion makes it worse by less than
`LOOSE` of the way (or than a few times form / radius, the part that the curvature adds), other places are as good
within what points can tell: a maximum inscribed circle between two opposite points slides along. The size is the
same wherever it lies; the place is one of several.
"""

from __future__ import annotations

import numpy as np

from vcmm.fit.elements import Array, Element, Mask
from vcmm.fit.exchange import Goal, Local, Settled, crosswise, linearised

LOOSE = 1e-6


def is_unique(element: Element, free: tuple[int, ...], goal: Goal, data: Array, found: Settled) -> Mask:
    """Mask (B,) of the members of data (B, 3, n) whose contacts leave no motion free."""
    if goal.tangent:  # strictly convex where the points determine the element
        return np.ones(len(data), dtype=bool)
    at = linearised(element, free, goal, data, found.state)
    metric = at.jac @ at.jac.swapaxes(-1, -2) / at.jac.shape[-1]
    if goal.convex:
        return _held_by_curvature(element, free, at, found, metric)
    from vcmm.fit._nearest_kernels import reaches

    side = np.where(at.d < 0.0, -1.0, 1.0) if goal.two_sided else np.ones_like(at.d)
    form = np.ptp(at.d, axis=-1)
    size = np.abs(found.state.sizes[:, 0]) if element.sizes else np.full(len(form), np.inf)
    loose = np.clip(4.0 * form / np.maximum(size, 1e-12), LOOSE, 0.05)
    out = np.zeros(len(data))
    reaches(np.ascontiguousarray(at.jac * side[:, None]), found.contacts, metric, 4.0 / loose, out)
    return np.asarray(out < 1.0 / loose)


def _held_by_curvature(
    element: Element, free: tuple[int, ...], at: Local, found: Settled, metric: Array
) -> Mask:
    """Circumscribed: a problem that curves upwards, held where the contacts' own motions determine the pose."""
    touching = found.contacts[:, None].astype(np.float64)
    rows = [at.jac * touching, *(row * touching for row in crosswise(element, free, at)[0])]
    held = sum((row @ row.swapaxes(-1, -2) for row in rows), np.zeros(1))
    factor = np.linalg.inv(np.linalg.cholesky(metric + 1e-12 * np.eye(len(free))))
    return np.asarray(np.linalg.eigvalsh(factor @ held @ factor.swapaxes(-1, -2))[:, 0] > 1e-6)
