"""Probabilities of wrong decisions, in closed form (JCGM 106:2012, 9.5; ISO 14253-1).

The parts to come have true values normal about the process mean; the machine indicates the true value plus its bias
plus an error of standard uncertainty u. Accepted is what lies within the limits moved inwards by the guard band,
rejected what lies beyond the limits moved outwards, the rest is undecided.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from vcmm.core.run import Array
from vcmm.gps.decision import ACCEPT, GUARD_BAND

NODES = 48
_REACH = 6.0  # standard deviations of the process that are integrated


@dataclass(frozen=True)
class WrongDecisions:
    """Probabilities (m,): a bad part accepted, a good part rejected, a part left undecided."""

    accept_bad: Array
    reject_good: Array
    undecided: Array

    @property
    def total(self) -> Array:
        """Not judged rightly."""
        return self.accept_bad + self.reject_good + self.undecided


def guard_band(rule: str, u: Array, expanded: Array) -> Array:
    """Width of the guard band: U, or 1.645 u for a conformance probability of 95 %."""
    return expanded if rule == GUARD_BAND else NormalDist().inv_cdf(ACCEPT) * u


def wrong_decisions(
    u: Array, bias: Array, limits: tuple[float, float], guard: Array, process: tuple[float, float]
) -> WrongDecisions:
    """For standard uncertainties u (m,), biases (m,), guard bands (m,). process: mean and standard deviation.

    The product of two normal laws is integrated over the true value by Gauss-Legendre panels that end at the limits,
    where the integrand jumps. Limits may be infinite.
    """
    mean, spread = process
    low, high = mean - _REACH * spread, mean + _REACH * spread
    cuts = sorted({low, high, *(min(max(v, low), high) for v in limits)})
    true, weight = _panels(cuts)
    weight = weight * np.exp(-(((true - mean) / spread) ** 2) / 2) / (spread * np.sqrt(2 * np.pi))
    good = (true >= limits[0]) & (true <= limits[1])
    indicated = true[None, :] + bias[:, None]
    size = np.maximum(u, 1e-15)[:, None]
    accepted = _between(limits[0] + guard[:, None], limits[1] - guard[:, None], indicated, size)
    kept = _between(limits[0] - guard[:, None], limits[1] + guard[:, None], indicated, size)
    rejected = 1 - kept
    undecided = kept - accepted
    return WrongDecisions(
        accepted[:, ~good] @ weight[~good], rejected[:, good] @ weight[good], undecided @ weight
    )


def _between(low: Array, high: Array, centre: Array, size: Array) -> Array:
    """P(low <= Y <= high) for Y normal (centre, size); 0 where low > high."""
    from scipy.special import ndtr

    return np.maximum(np.asarray(ndtr((high - centre) / size) - ndtr((low - centre) / size)), 0.0)


def _panels(cuts: list[float], parts: int = 4) -> tuple[Array, Array]:
    """Nodes and weights between consecutive cuts."""
    node, weight = np.polynomial.legendre.leggauss(NODES)
    edges = np.unique(np.concatenate([np.linspace(a, b, parts + 1) for a, b in itertools.pairwise(cuts)]))
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()
