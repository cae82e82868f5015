"""The deepest of many places along a path, looked for between the steps at which it was asked first."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vcmm.core.run import Array
from vcmm.cutting.contactmap import Ints

ROUNDS, ACROSS = 7, 9  # the bracket shrinks to a quarter in each round: 0.3 mm to 0.02 um
TURNS = 1e-6  # mm: what moves by no more than this differently, from step to step, is not searched
LOWER = 1e-7  # mm: a place between steps counts if it is so much deeper than they

Heights = Callable[[Ints, Array], tuple[Array, Array]]
"""Height (n, m) of the surface over points (n,) if the tool stood at offsets (n, m) only, and by how much it is moved
there off its path (n, m, 3), mm."""


def deepest_between(heights: Heights, count: int, steps: Array) -> tuple[Ints, Array]:
    """Which of `count` points (m,) are cut deepest between the steps (k,), ascending, and at which offset (m,).

    A point is searched where the tool is moved differently at the steps beside its deepest one; without that the steps
    themselves, which hold the contact of the programmed path, are the answer. Each round asks at ACROSS places of the
    bracket and goes on about the deepest; one minimum per bracket is taken for granted.
    """
    points = np.arange(count)
    s, moved = heights(points, np.broadcast_to(steps, (count, len(steps))))
    best = np.clip(np.argmin(s, axis=1), 1, len(steps) - 2)
    beside = moved[points[:, None], best[:, None] + [-1, 1]] - moved[points, best][:, None]
    differs = np.linalg.norm(beside, axis=2).max(axis=1) > TURNS
    open_ = np.flatnonzero(differs & np.isfinite(s.min(axis=1)))
    if not len(open_):
        return open_, np.zeros(0)
    best = best[open_]
    before = low = s[open_].min(axis=1)
    at, middle = steps[best], 0.5 * (steps[best + 1] + steps[best - 1])
    reach, rows = 0.5 * (steps[best + 1] - steps[best - 1]), np.arange(len(open_))
    for _ in range(ROUNDS):
        tried = middle[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, ACROSS)
        s, _moved = heights(open_, tried)
        pick = np.argmin(s, axis=1)
        found, middle = s[rows, pick], tried[rows, pick]
        at, low = np.where(found < low, middle, at), np.minimum(found, low)
        reach = reach * 2.0 / (ACROSS - 1)
    deeper = low < before - LOWER
    return open_[deeper], at[deeper]
