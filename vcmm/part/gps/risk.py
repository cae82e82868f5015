"""Decisions of ISO 14253-1 as zones, and their risks by JCGM 106:2012.

specific risk   of this one part: the probability that it is what the decision says it is not (JCGM 106, 9.3.2)
global risk     of a production: parts that are out and accepted (consumer's), in and rejected (producer's) (9.5), for a
                process of which mean and standard deviation are stated: no default, because the answer is mostly that
guard band      acceptance limits inside the tolerance limits (8.3): what the shop floor may read

wrong decisions the same for a rule with three answers, for many u at once, in closed form (placement)

All are for a normal measurement of standard uncertainty u; lengths in mm, angles in rad.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array
from vcmm.part.gps.decision import ACCEPT, GUARD_BAND

IN_ACCEPT, IN_UNCERTAIN, OUT_UNCERTAIN, OUT_REJECT = (
    "conformity zone", "uncertainty zone, inside the limits", "uncertainty zone, outside the limits", "non-conformity zone",
)  # fmt: skip
NODES = 48
_REACH = 6.0  # standard deviations of the process that are integrated


@dataclass(frozen=True)
class Production:
    """Process of production: normal, mean and standard deviation of the true values, in the unit of the limits."""

    mean: float
    u: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.mean) and math.isfinite(self.u) and self.u > 0):
            raise UsageError(
                f"production: mean = {self.mean:g} and u = {self.u:g} must be finite, u above zero; state what the process makes"
            )


@dataclass(frozen=True)
class GlobalRisk:
    """Shares of a production. consumer: out of tolerance and accepted; producer: in tolerance and rejected; out: all that is out."""

    consumer: float
    producer: float
    out: float
    acceptance: float


def zone(value: float, limits: tuple[float, float], half_width: float) -> str:
    """Return the zone of ISO 14253-1 in which a measured value lies; half_width: U. limits may be infinite on one side."""
    low, high = limits
    if low + half_width <= value <= high - half_width:
        return IN_ACCEPT
    if value < low - half_width or value > high + half_width:
        return OUT_REJECT
    return IN_UNCERTAIN if low <= value <= high else OUT_UNCERTAIN


def acceptance_limits(limits: tuple[float, float], guard: float) -> tuple[float, float] | None:
    """Return the limits for the reading, moved inwards by a guard band (JCGM 106, 8.3.2); None where they leave no interval."""
    low, high = limits[0] + guard, limits[1] - guard
    return (low, high) if low <= high else None


def specific_risk(p_conform: float, accepted: bool) -> float:
    """Return the probability that the decision about this part is wrong."""
    return 1 - p_conform if accepted else p_conform


def global_risk(limits: tuple[float, float], u: float, guard: float, production: Production) -> GlobalRisk:
    """Return the risks of accepting values that read within the limits moved inwards by `guard` and rejecting the rest.

    UsageError: u negative, limits exchanged.
    """
    low, high = limits
    if not low < high or u < 0:
        raise UsageError(f"limits {low:g} and {high:g} must rise, and u = {u:g} must not be negative")
    wrong = wrong_decisions(
        np.array([u]), np.zeros(1), limits, np.array([guard]), (production.mean, production.u)
    )
    made, read = (
        NormalDist(production.mean, production.u),
        NormalDist(production.mean, math.hypot(production.u, u)),
    )
    good = _share(made, limits)
    inside = acceptance_limits(limits, guard)
    accepted = 0.0 if inside is None else _share(read, inside)
    consumer = float(wrong.accept_bad[0])
    return GlobalRisk(consumer, producer=good - (accepted - consumer), out=1 - good, acceptance=accepted)


def _share(law: NormalDist, limits: tuple[float, float]) -> float:
    below = [law.cdf(x) if math.isfinite(x) else float(x > 0) for x in limits]
    return below[1] - below[0]


@dataclass(frozen=True)
class WrongDecisions:
    """Probabilities (m,): a bad part accepted, a good part rejected, a part left undecided."""

    accept_bad: Array
    reject_good: Array
    no_decision: Array

    @property
    def total(self) -> Array:
        """Probability of all wrong or missing decisions."""
        return self.accept_bad + self.reject_good + self.no_decision


def guard_band(rule: str, u: Array, expanded: Array) -> Array:
    """Return the width of the guard band: U, or 1.645 u for a conformance probability of 95 %."""
    return expanded if rule == GUARD_BAND else NormalDist().inv_cdf(ACCEPT) * u


def wrong_decisions(
    u: Array, bias: Array, limits: tuple[float, float], guard: Array, process: tuple[float, float]
) -> WrongDecisions:
    """Return the probabilities of wrong decisions for standard uncertainties u (m,), biases (m,), guard bands (m,). process: mean and
    standard deviation.

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
    """Return P(low <= Y <= high) for Y normal (centre, size); 0 where low > high."""
    from scipy.special import ndtr

    return np.maximum(np.asarray(ndtr((high - centre) / size) - ndtr((low - centre) / size)), 0.0)


def _panels(cuts: list[float], parts: int = 4) -> tuple[Array, Array]:
    """Return the nodes and weights between consecutive cuts."""
    node, weight = np.polynomial.legendre.leggauss(NODES)
    edges = np.unique(np.concatenate([np.linspace(a, b, parts + 1) for a, b in itertools.pairwise(cuts)]))
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()
