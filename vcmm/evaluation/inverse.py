"""The true value of form, orientation and location from the indicated one.

An extreme value grows with noise: what is indicated is no sum of a true value and an error. So the question is turned round:
for every true value T there is a distribution of what the machine would indicate, over parts of that true value (a family of
forms, directions of tilt, ways to be off place) and over all that is known of the machine. The coverage interval holds every T
for which y lies in the middle p of that distribution (J. Neyman, Phil. Trans. R. Soc. A 236 (1937) 333): whatever the true
value is, it holds it in the share p of measurements, and no share of the noise is counted as form. It begins at zero where the
indicated value could come from a perfect part. The probability of conformance is that of indicating more than y at the limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.evaluation.truth import Limits, Statement

LEVELS = np.concatenate(
    [np.linspace(0.0, 0.05, 41), np.linspace(0.055, 0.945, 90), np.linspace(0.95, 1.0, 41)]
)
BLIND = 0.1  # of the true value: what is indicated at least of a part that is far off
CLIP = 0.25  # an indicated value that falls below this quantile of a perfect part says no more than that quantile


@dataclass(frozen=True, eq=False)
class Inverted:
    """true (t,): rising from 0; indicated (t, k): quantiles of what is indicated at LEVELS; mm."""

    true: Array
    indicated: Array

    def given(self, y: float, p: float, kind: str, limits: Limits | None = None) -> Statement:
        low, estimate, high = (self._at(y, level) for level in ((1 + p) / 2, 0.5, (1 - p) / 2))
        most = None if limits is None else self.exceeds(limits[1], y)
        high = max(high, self._at(float(self._column(CLIP)[0]), (1 - p) / 2))
        if self.sight(p) < BLIND:  # parts of any true value may indicate as little: there is no upper end
            high = np.inf
        return Statement(estimate, (low, high), most)

    def _column(self, level: float) -> Array:
        """Indicated value (t,) not exceeded with this probability, made to rise with the true value."""
        at = np.array([np.interp(level, LEVELS, row) for row in self.indicated])
        return np.maximum.accumulate(at)

    def _at(self, y: float, level: float) -> float:
        """The true value of which y is this quantile; 0 where even a perfect part indicates more."""
        column = self._column(level)
        if y <= column[0]:
            return 0.0
        if y >= column[-1]:  # far out the indicated value grows in proportion
            slope = (self.true[-1] - self.true[-2]) / max(column[-1] - column[-2], 1e-15)
            return float(self.true[-1] + slope * (y - column[-1]))
        return float(np.interp(y, column, self.true))

    def exceeds(self, true: float, y: float) -> float:
        """P(more than y is indicated of a part of this true value)."""
        k = int(np.clip(np.searchsorted(self.true, true), 1, len(self.true) - 1))
        share = (true - self.true[k - 1]) / (self.true[k] - self.true[k - 1])
        row = (1 - share) * self.indicated[k - 1] + share * self.indicated[k]
        return float(1 - np.interp(y, np.maximum.accumulate(row), LEVELS, left=0.0, right=1.0))

    def ends(self, true: float, p: float) -> tuple[float, float]:
        """Between which values the machine indicates a part of this true value in the share p of measurements."""
        low, high = (
            float(np.interp(true, self.true, self._column(level))) for level in ((1 - p) / 2, (1 + p) / 2)
        )
        return low, high

    def sight(self, p: float) -> float:
        """What a part that is far off indicates at least, as a share of its true value."""
        return float(self._column((1 - p) / 2)[-1] / max(self.true[-1], 1e-15))

    def attained(self, true: float, indicated: Array, p: float) -> float:
        """Share of indicated values (m,) of parts of this true value whose interval for p holds it."""
        low, high = self.ends(true, p)
        return float(((indicated <= high) & ((indicated >= low) | (true == 0))).mean())


def inverted(true: Array, families: Sequence[Array]) -> Inverted:
    """From indicated values (t, m) of m parts of each true value (t,), one array per family of parts.

    Low quantiles are the lowest, high ones the highest of the families: the interval holds the parts of every one of them.
    """
    by_family = np.stack([np.quantile(values, LEVELS, axis=1).T for values in families])
    hull = np.where(LEVELS < 0.5, by_family.min(axis=0), by_family.max(axis=0))
    return Inverted(true, hull)
