"""Noise with memory, e_t = rho e_(t-1) + a_t, against noise without: the restricted likelihood ratio of residuals.

With R the correlation matrix of the noise and W its whitening (W' W = R^-1), y = W d, X = W Q:

    -2 ln L(rho) = (n - k) ln S + ln |R| + ln |X' X| + const,    S = |y|^2 - y' X (X' X)^-1 X' y

(D. A. Harville, Biometrika 61 (1974) 383). W d is e_1 and (e_t - rho e_(t-1)) / sqrt(1 - rho^2), and |W| = |R|^(-1/2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array

RHOS = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.98)  # rho that are tried


@dataclass(frozen=True, eq=False)
class Whitening:
    """A base in the order of the scan as rho sees it: orthonormal base (n, k) of X, and ln |R| + ln |X' X|."""

    rho: float
    base: Array
    penalty: float

    def rest(self, d: Array) -> Array:
        """Return S (m,) of departures d (m, n)."""
        y = through(d, self.rho)
        return np.asarray((y**2).sum(axis=1) - ((y @ self.base) ** 2).sum(axis=1))


def through(d: Array, rho: float) -> Array:
    """Return W d of rows (m, n)."""
    y = d.copy()
    y[:, 1:] = (d[:, 1:] - rho * d[:, :-1]) / np.sqrt(1.0 - rho**2)
    return y


def whitening(base: Array, rho: float) -> Whitening:
    """Return the whitening. base (n, k): orthonormal, rows in the order of the scan."""
    q, r = np.linalg.qr(through(base.T, rho).T)
    inside = (len(base) - 1) * np.log(1.0 - rho**2)  # ln |R|
    return Whitening(rho, q, float(inside + 2.0 * np.log(np.abs(np.diag(r))).sum()))


def likelihood_ratio(
    bases: Mapping[str, Sequence[Whitening]], departures: Mapping[str, Array]
) -> tuple[Array, Array]:
    """Return 2 ln of the largest likelihood over that of no memory (m,), and the rho of it (m,); one rho for all features.

    bases: per feature one for each rho, that of 0 first. departures: per feature (m, n) in the order of the scan.
    """
    minus = []
    for number in range(len(RHOS)):
        total = np.zeros(len(next(iter(departures.values()))))
        for name, d in departures.items():
            basis = bases[name][number]
            total += (d.shape[1] - basis.base.shape[1]) * np.log(
                np.maximum(basis.rest(d), 1e-300)
            ) + basis.penalty
        minus.append(total)
    table = np.array(minus)
    best = table.argmin(axis=0)
    return table[0] - table.min(axis=0), np.array(RHOS)[best]
