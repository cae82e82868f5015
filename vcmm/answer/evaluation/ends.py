"""Estimate the uncertainty of the ends of an interval: belts come from a finite number of sampled parts, and differ with other parts.

Delete-a-group jackknife (P. S. Kott, J. Official Stat. 17 (2001) 521): each of G groups of the drawn parts is left out in turn,

    u^2 = (G - 1) / G  sum over groups of (end without the group - mean of these)^2

Parts are sampled independently, so that every G-th of them makes a group as good as any other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.answer.evaluation.belts import Reading, UnitedInverse, inverse_of
from vcmm.answer.evaluation.pairs import Pairs
from vcmm.core.run import Array
from vcmm.part.part import Characteristic

GROUPS = 10


def inverses_without(c: Characteristic, index: int, drawn: Sequence[Sequence[Pairs]]) -> tuple[Reading, ...]:
    """Return the inverse of characteristic number `index` from all sampled parts but a group, group after group.

    drawn: for each share of the limits that a machine may use, the sampled parts of each family.
    """
    out: list[Reading] = []
    for g in range(GROUPS):
        of_share = [
            inverse_of(c, 0, [_without(family, index, g) for family in families]) for families in drawn
        ]
        out.append(of_share[0] if len(of_share) == 1 else UnitedInverse(tuple(of_share)))
    return tuple(out)


def _without(drawn: Pairs, index: int, group: int) -> Pairs:
    return drawn.of(index, np.flatnonzero(np.arange(len(drawn.true)) % GROUPS != group))


def ends_u(
    groups: Sequence[Reading], p: float, indicated: Array, rest: Array | None
) -> tuple[float, float] | None:
    """Return the standard uncertainty of both ends at indicated (1,); None without groups."""
    if not groups:
        return None
    ends = np.array([[end[0] for end in inverse.interval(p, indicated, rest)] for inverse in groups])
    low, high = jackknife_u(ends)
    return float(low), float(high)


def jackknife_u(values: Array) -> Array:
    """Return the standard uncertainty (k,) of results that were computed without each of G groups, (G, k)."""
    count = len(values)
    return np.asarray(np.sqrt((count - 1) / count * ((values - values.mean(axis=0)) ** 2).sum(axis=0)))
