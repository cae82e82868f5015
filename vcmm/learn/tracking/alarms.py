"""Test whether a recording agrees with its prediction: the innovation test, with one false-alarm rate for all recordings that will ever come.

The innovation is tested as a whole (chi-square) and along every jump by itself; the smallest chance times the number of tests
(Bonferroni) is the chance of the recording. Recording k may spend

    alpha_k = alpha / (2.1097 (k + 1) ln^2 (k + 1)),   sum over all k = alpha

so that a machine that does not change is alarmed at most with probability alpha, however long it is followed (alpha spending: K. Lan
& D. DeMets, Biometrika 70 (1983) 659; 2.1097 is the sum of 1 / (n ln^2 n) from n = 2 on).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.changes import Jump
from vcmm.learn.tracking.kalman import GaussianState, chance_beyond, innovation, solve_lower

ALPHA = 0.05
SUM = 2.109742801  # of 1 / (n ln^2 n), n = 2, 3 ...


def level(number: int, alpha: float) -> float:
    """Return the chance below which recording `number` (from 1) is an alarm."""
    return alpha / (SUM * (number + 1) * math.log(number + 1) ** 2)


def chance_of(
    state: GaussianState, columns: Array, value: Array, jumps: Sequence[Jump]
) -> tuple[float, float]:
    """Return (chance, rms of the innovation in units of its standard uncertainty) of readings with unit noise."""
    if not len(value):
        return 1.0, 0.0
    forecast = innovation(state, columns, value)
    white = forecast.white
    chances = [float(chance_beyond(len(white), float(white @ white)))]
    for jump in jumps:
        moved = solve_lower(forecast.lower, columns @ jump.columns)
        left, size, _ = np.linalg.svd(moved, full_matrices=False)
        kept = size > 1e-6 * max(float(size[0]), 1e-300)
        if size[0] > 1e-9 and kept.sum() < len(white):
            chances.append(
                float(chance_beyond(int(kept.sum()), float(((left[:, kept].T @ white) ** 2).sum())))
            )
    return min(1.0, min(chances) * len(chances)), float(np.sqrt((white**2).mean()))
