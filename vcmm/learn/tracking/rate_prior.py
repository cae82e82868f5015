"""One prior for all rates of a kind: numbers of the same kind wander alike, more or less, and how much alike is learnt from them.

    log2 rate_k = m + d_k,   m ~ N(CENTRE, r SPREAD^2),   d_k ~ N(0, (1 - r) SPREAD^2),   r ~ uniform on 0 ... 1
    P(which of n rates are above zero) = k! (n - k)! / (n + 1)!      k of them; of trend and season

Each rate alone has the prior of vcmm.learn.tracking.rates whatever r is: log2 of it N(CENTRE, SPREAD^2), half of it at zero. What the
hierarchy adds is that rates of one kind tell of each other: r is the correlation of two of them, and its uniform prior is the uniform
shrinkage prior (W. Strawderman, Ann. Math. Stat. 42 (1971) 385; M. Daniels, Canadian J. Stat. 27 (1999) 567), which needs no number
to be chosen. The second line is the chance that a share of them, uniform on 0 ... 1, moves at all (T. Bayes, Phil. Trans. 53 (1763) 370).
m stands on the steps of the grid; r on the middles of SHARES equal parts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.rates import CENTRE, GRIDS, SPREAD, steps_of

SHARES = 10  # parts of the correlation between rates of a kind


def kind_of(group: str) -> str:
    """squareness[C0Y].angle -> squareness.angle: groups of one kind have one prior."""
    head, _, rest = group.partition("[")
    return head + rest.partition("]")[2]


@dataclass(frozen=True)
class KindPrior:
    """The joint prior of rates of one name (walk, trend, season) within a kind; levels are numbers on GRIDS[name]."""

    name: str

    @cached_property
    def steps(self) -> Array:
        """log2 of the levels that have a size; of the walk none stands as 2^-7."""
        return steps_of(self.name)

    @property
    def first(self) -> int:
        """The first level that has a size: 1 where zero is apart."""
        return len(GRIDS[self.name]) - len(self.steps)

    @cached_property
    def _about(self) -> tuple[Array, Array]:
        """P(m | r) (SHARES, s) and P(level | m, r) (SHARES, s, s), s steps."""
        shares = (np.arange(SHARES) + 0.5) / SHARES
        mean = -0.5 * (self.steps - CENTRE) ** 2 / (shares[:, None] * SPREAD**2)
        gap = self.steps[None, :] - self.steps[:, None]
        own = -0.5 * gap**2 / ((1.0 - shares[:, None, None]) * SPREAD**2)
        return _normal(mean), _normal(own)

    def of_one_more(self, others: Sequence[int]) -> Array:
        """ln of the probability of every level of one rate, given the levels of all others of its kind."""
        middle, own = self._about
        sized = [k - self.first for k in others if k >= self.first]
        weight = middle * np.prod(own[:, :, sized], axis=2)
        sizes = np.einsum("rm,rml->l", weight, own) / weight.sum()
        if not self.first:
            return np.asarray(np.log(sizes))
        moving = (len(sized) + 1) / (len(others) + 2)
        return np.log(np.concatenate([[1.0 - moving], moving * sizes]))

    def of_all(self, levels: Sequence[int]) -> float:
        """ln of the probability of the levels of all rates of a kind together."""
        middle, own = self._about
        sized, n = [k - self.first for k in levels if k >= self.first], len(levels)
        out = math.log((middle * np.prod(own[:, :, sized], axis=2)).sum() / SHARES)
        if self.first:
            out += math.lgamma(len(sized) + 1) + math.lgamma(n - len(sized) + 1) - math.lgamma(n + 2)
        return out


def _normal(logs: Array) -> Array:
    """Probabilities along the last axis."""
    out = np.exp(logs - logs.max(axis=-1, keepdims=True))
    return np.asarray(out / out.sum(axis=-1, keepdims=True))


@lru_cache(maxsize=8)
def prior_of(name: str) -> KindPrior:
    """Of walk, trend or season."""
    return KindPrior(name)
