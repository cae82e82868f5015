"""A law widened by a form: y = x + s d, s = -1 or 1 with the same probability, d one of given sizes.

    P(Y <= y) = mean over the sizes of [F(y - d) + F(y + d)] / 2         F of x, on a table between its far quantiles

The direction in which an unseen form moves a result is unknown, so the law keeps its middle (JCGM 101:2008, 6.4; law of total
probability).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from vcmm.answer.evaluation.interval import Linear, check_interval
from vcmm.answer.evaluation.summary import STATEMENT_KINDS, Summary
from vcmm.core.laws import Array

# scales on either side that the table reaches, closer together towards the middle; its places
REACH_SCALES = 60.0
TABLE_PLACES = 1201
SPLITS = 41  # of the probability outside, for the shortest interval
HALVINGS = 60


@dataclass(frozen=True, eq=False)
class WidenedLaw:
    """Table (n,) of x, rising, with P(X <= x); sizes (m,) >= 0 of the additions to either side; mm or rad."""

    x: Array
    below: Array
    sizes: Array

    def reflect(self, about: float) -> WidenedLaw:
        """Return the law of about - y, mirrored."""
        return WidenedLaw(about - self.x[::-1], 1.0 - self.below[::-1], self.sizes)

    def cdf(self, y: float) -> float:
        """Return P(Y <= y)."""
        moved = np.concatenate([y - self.sizes, y + self.sizes])
        return float(np.interp(moved, self.x, self.below, left=0.0, right=1.0).mean())

    @cached_property
    def _bounds(self) -> tuple[float, float]:
        most = float(self.sizes.max())
        return float(self.x[0]) - most, float(self.x[-1]) + most

    def quantile(self, p: float) -> float:
        """Return the value not exceeded with probability p: halving, the law has no gaps that matter."""
        check_interval(p, "symmetric")
        low, high = self._bounds
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if self.cdf(middle) < p else (low, middle)
        return (low + high) / 2

    def interval(self, p: float = 0.95, kind: str = "symmetric") -> tuple[float, float]:
        """Return the coverage interval for probability p (JCGM 101, 7.7): symmetric, shortest, or upper = (-inf, y_p)."""
        check_interval(p, kind, STATEMENT_KINDS)
        if kind == "upper":
            return -math.inf, self.quantile(p)
        if kind == "symmetric":
            return self.quantile((1 - p) / 2), self.quantile((1 + p) / 2)
        outside = np.linspace(0.0, 1.0 - p, SPLITS + 2)[1:-1]
        ends = [(self.quantile(q), self.quantile(q + p)) for q in outside]
        return min(ends, key=lambda pair: pair[1] - pair[0])

    def probability(self, low: float = -math.inf, high: float = math.inf) -> float:
        """Return P(low <= Y <= high)."""
        ends = [self.cdf(v) if math.isfinite(v) else float(v > 0) for v in (low, high)]
        return min(max(ends[1] - ends[0], 0.0), 1.0)


def widen(law: Linear | Summary | WidenedLaw, sizes: Array) -> WidenedLaw:
    """Return the law with sizes (m,) added to either side."""
    if isinstance(law, WidenedLaw):
        return WidenedLaw(law.x, law.below, sum_with_random_signs([law.sizes, sizes]))
    if isinstance(law, Summary):
        return WidenedLaw(law.grid, law.below, np.asarray(sizes, float))
    if law.scale == 0.0:
        step = np.array([-1e-12, 1e-12])
        return WidenedLaw(law.mean + step, np.array([0.0, 1.0]), np.asarray(sizes, float))
    return WidenedLaw(*_table(law), np.asarray(sizes, float))


@lru_cache(maxsize=64)
def _table(law: Linear) -> tuple[Array, Array]:
    """Return places x (n,) and P(X <= x): one table for all parts that were measured by the same task."""
    place = np.sinh(np.linspace(-1.0, 1.0, TABLE_PLACES) * math.asinh(REACH_SCALES * 20.0)) / 20.0
    x = law.mean + law.scale * place
    return x, np.maximum.accumulate(law.cdf(x))


def sum_with_random_signs(sizes: list[Array], seed: int = 0) -> Array:
    """Return sizes (m,) of a sum of independent parts, each of either sign: every feature has its own draw."""
    rng = np.random.default_rng(seed)
    most = max(len(s) for s in sizes)
    total = np.resize(sizes[0], most).astype(float)
    for more in sizes[1:]:
        drawn = rng.permutation(np.resize(more, most))
        total = np.abs(total + drawn * rng.choice([-1.0, 1.0], most))
    return total
