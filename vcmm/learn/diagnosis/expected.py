"""What an add-on measurement is expected to decide between two names."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from vcmm.learn.diagnosis.constants import SUREST, UNSEEN

ROWS = 80  # of the recording repeated in an add-on, and draws of what it decides


def log_odds(one: float, other: float) -> float:
    return float(np.log(max(one, UNSEEN) / max(other, UNSEEN)))


def expected_probability(odds: float, more: float) -> float:
    """Probability of whichever of two names is right, expected after an add-on that adds `more` of squared distance between them.

    The added ln BF is normal about +more/2 where the first is right and about -more/2 where the other is, with variance `more`
    (Lindley, Ann. Math. Stat. 27 (1956) 986); it is drawn at ROWS even quantiles.
    """
    z = np.array([NormalDist().inv_cdf((k + 0.5) / ROWS) for k in range(ROWS)])
    added = 0.5 * more + np.sqrt(max(more, 0.0)) * z
    first = 1.0 / (1.0 + np.exp(-odds))
    right = np.mean(1.0 / (1.0 + np.exp(np.clip(-odds - added, -SUREST, SUREST))))
    other = np.mean(1.0 / (1.0 + np.exp(np.clip(odds - added, -SUREST, SUREST))))
    return float(first * right + (1.0 - first) * other)
