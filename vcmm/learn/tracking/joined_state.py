"""The state when rates are not known: a filter for each draw of the rates, all joined.

    p(state | readings) = mean over draws of p(state | readings, rates),   rates ~ p(rates | readings)

(D. Magill, IEEE Trans. Automatic Control 10 (1965) 434; the draws come from vcmm.learn.tracking.learn_rates.) What is handed on is the Gaussian of
the mean and covariance of the mixture:

    m = mean of m_i,   P = mean of P_i + (m_i - m)(m_i - m)'

A forecast is a linear function of this state and of what comes in anew, whose variance is proportional to the square of a rate: with P and the mean
squares of the rates its variance is that of the mixture at every age (law of total variance; to the dependence of walk and state).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.changes import Jump
from vcmm.learn.tracking.compress import SeenRecording
from vcmm.learn.tracking.evidence import filter_all
from vcmm.learn.tracking.kalman import GaussianState
from vcmm.learn.tracking.quantities import TrackedMachine
from vcmm.learn.tracking.rates import GroupRates, motion_of

ROUNDING = 1e-13  # of the largest variance: what is below is rounding


def state_by_draws(
    tracked: TrackedMachine,
    draws: Sequence[tuple[GroupRates, ...]],
    recordings: Sequence[SeenRecording],
    jumps: Sequence[Jump],
) -> GaussianState:
    """The state on the day of the last recording, over all draws of the rates."""
    motions = [motion_of(tracked.group_of_mode, tracked.stated, draw) for draw in draws]
    return join_equal_parts(*filter_all(recordings, motions, jumps).states())


def join_equal_parts(means: Array, covariances: Array) -> GaussianState:
    """One Gaussian of the mean and covariance of a mixture of equal parts: means (m, n), covariances (m, n, n)."""
    mean = means.mean(axis=0)
    away = means - mean
    size, ways = np.linalg.eigh(covariances.mean(axis=0) + away.T @ away / len(means))
    kept = size > ROUNDING * max(float(size[-1]), 1e-300)
    return GaussianState(mean, ways[:, kept] * np.sqrt(size[kept]))
