"""The Kalman filter in square-root form: mean and a factor of the covariance, so that no covariance is ever below zero.

    advance      S S' -> S S' + diag(q)        by a triangular factor (QR)
    condition    A. Andrews, AIAA J. 6 (1968) 1165: with F = H S, F F' + I = L L' (L lower triangular)
                 S -> S - S F' L^-T (L + I)^-1 F
                 m -> m + S F' (F F' + I)^-1 (y - H m)

Readings come with unit noise. R. E. Kalman, J. Basic Eng. 82 (1960) 35; G. Bierman, Factorization Methods (1977), ch. 5 and 7.

An innovation is tested by chi-square: the chance that a sum of squares of independent standard normal numbers is larger, for whole degrees of
freedom in closed form.

    even k:  e^(-h) sum_(j < k/2) h^j / j!                                            h = x / 2
    odd k:   erfc(sqrt h) + e^(-h) sum_(j < (k-1)/2) h^(j + 1/2) / Gamma(j + 3/2)

(M. Abramowitz & I. Stegun, Handbook of Mathematical Functions (1964), 26.4.4 and 26.4.5.) So that a new recording does not wait for scipy.special.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from vcmm.core.run import Array


def chance_beyond(count: int, square: float) -> float:
    """Return P(chi-square of `count` degrees of freedom > square)."""
    half, odd = square / 2.0, count % 2
    if half <= 0.0:
        return 1.0
    shift = 0.5 if odd else 0.0
    terms = ((j + shift) * math.log(half) - math.lgamma(j + shift + 1.0) - half for j in range(count // 2))
    whole = math.fsum(math.exp(t) for t in terms)
    return min(1.0, whole + (math.erfc(math.sqrt(half)) if odd else 0.0))


@lru_cache(maxsize=256)
def square_at(count: int, chance: float) -> float:
    """Return the square that is exceeded with this chance: the smallest number of floating point with chance_beyond(count, square) <= chance."""
    low, high = 0.0, 1.0
    while chance_beyond(count, high) > chance:
        low, high = high, 2.0 * high
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if chance_beyond(count, middle) > chance else (low, middle)
    return high


@dataclass(frozen=True, eq=False)
class GaussianState:
    """mean (n,); factor (n, c): covariance = factor @ factor.T."""

    mean: Array
    factor: Array

    @property
    def covariance(self) -> Array:
        return self.factor @ self.factor.T


@dataclass(frozen=True, eq=False)
class Innovation:
    """Difference of readings from their prediction: value (r,), spread (r, c) = H S, lower (r, r): Cholesky factor of its covariance."""

    value: Array
    spread: Array
    lower: Array

    @cached_property
    def white(self) -> Array:
        """The innovation (r,) in units of its own standard uncertainties, independent."""
        return solve_lower(self.lower, self.value)

    @property
    def log_likelihood(self) -> float:
        white = self.white
        logs = np.log(np.diag(self.lower)).sum()
        return float(-0.5 * white @ white - logs - 0.5 * len(white) * np.log(2 * np.pi))


def solve_lower(lower: Array, columns: Array) -> Array:
    """Solve lower^-1 columns, lower (r, r) triangular. The general solver: LAPACK's triangular one wakes its threads for matrices of ten rows."""
    if not len(lower):
        return columns
    return np.asarray(np.linalg.solve(lower, columns), dtype=np.float64)


def triangular(factor: Array) -> Array:
    """Return a factor of the same covariance with as many columns as rows that are not zero, at most."""
    rows = np.flatnonzero(factor.any(axis=1))
    if factor.shape[1] <= len(rows):
        return factor
    out = np.zeros((factor.shape[0], len(rows)))
    out[rows] = np.asarray(np.linalg.qr(factor[rows].T, mode="r")).T
    return out


def advance(state: GaussianState, variance: Array) -> GaussianState:
    """Advance the state. variance (n,): variance added."""
    grown = np.flatnonzero(variance > 0)
    if not len(grown):
        return state
    fresh = np.zeros((len(variance), len(grown)))
    fresh[grown, np.arange(len(grown))] = np.sqrt(variance[grown])
    return GaussianState(state.mean, triangular(np.concatenate([state.factor, fresh], axis=1)))


def innovation(state: GaussianState, columns: Array, value: Array) -> Innovation:
    """Return the innovation of columns (r, n), value (r,) with unit noise."""
    spread = columns @ state.factor
    lower = np.asarray(np.linalg.cholesky(spread @ spread.T + np.eye(len(value))), dtype=np.float64)
    return Innovation(value - columns @ state.mean, spread, lower)


def condition(state: GaussianState, innovation: Innovation) -> GaussianState:
    """Condition the state on the readings."""
    gain = state.factor @ innovation.spread.T
    half = solve_lower(innovation.lower, gain.T)  # L^-1 (S F')'
    mean = state.mean + half.T @ innovation.white
    inner = solve_lower(innovation.lower + np.eye(len(innovation.value)), innovation.spread)
    return GaussianState(mean, state.factor - half.T @ inner)
