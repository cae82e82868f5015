"""Decisions of ISO 14253-1 as zones, and the risks of JCGM 106:2012 that go with them.

specific risk   of this one part: the probability that it is what the decision says it is not (JCGM 106, 9.3.2)
global risk     of a production: parts that are out and accepted (consumer's), in and rejected (producer's) (9.5), for a
                process of which mean and standard deviation are stated: no default, because the answer is mostly that
guard band      acceptance limits inside the tolerance limits (8.3): what the shop floor may read

All are for a normal measurement of standard uncertainty u; lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError

IN_ACCEPT, IN_UNCERTAIN, OUT_UNCERTAIN, OUT_REJECT = (
    "conformity zone", "uncertainty zone, inside the limits", "uncertainty zone, outside the limits", "non-conformity zone",
)  # fmt: skip
NODES = 64  # Gauss-Legendre nodes per panel
REACH = 9.0  # standard deviations of the process that are integrated


@dataclass(frozen=True)
class Production:
    """What the process makes: normal, mean and standard deviation of the true values, in the unit of the limits."""

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
    accepted: float


def zone(value: float, limits: tuple[float, float], half_width: float) -> str:
    """In which zone of ISO 14253-1 a measured value lies; half_width: U. limits may be infinite on one side."""
    low, high = limits
    if low + half_width <= value <= high - half_width:
        return IN_ACCEPT
    if value < low - half_width or value > high + half_width:
        return OUT_REJECT
    return IN_UNCERTAIN if low <= value <= high else OUT_UNCERTAIN


def acceptance_limits(limits: tuple[float, float], guard: float) -> tuple[float, float] | None:
    """Limits for the reading, moved inwards by a guard band (JCGM 106, 8.3.2); None where nothing is left between them."""
    low, high = limits[0] + guard, limits[1] - guard
    return (low, high) if low <= high else None


def specific_risk(p_conform: float, accepted: bool) -> float:
    """Probability that the decision about this part is wrong."""
    return 1 - p_conform if accepted else p_conform


def global_risk(limits: tuple[float, float], u: float, guard: float, production: Production) -> GlobalRisk:
    """Risks of accepting what reads within the limits moved inwards by `guard`.

    By quadrature over the process; readings are normal about the true value with u. UsageError: u negative, limits exchanged.
    """
    low, high = limits
    if not low < high or u < 0:
        raise UsageError(f"limits {low:g} and {high:g} must rise, and u = {u:g} must not be negative")
    inside = acceptance_limits(limits, guard)
    true, weight = _nodes(limits, u, production)
    density = weight * _density(true, production)
    accepts = np.zeros(len(true)) if inside is None else _between(inside, true, u)
    good = (true >= low) & (true <= high)
    return GlobalRisk(
        consumer=float(density[~good] @ accepts[~good]), producer=float(density[good] @ (1 - accepts[good])),
        out=float(density[~good].sum()), accepted=float(density @ accepts),
    )  # fmt: skip


def _nodes(limits: tuple[float, float], u: float, production: Production) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights over the process, panels broken at the limits and fine about them."""
    ends = production.mean + REACH * production.u * np.linspace(-1, 1, 19)
    fine = [x + k * u for x in limits if math.isfinite(x) for k in np.linspace(-9, 9, 19)]
    edges = np.unique(np.concatenate([ends, [e for e in fine if ends[0] < e < ends[-1]]]))
    node, weight = np.polynomial.legendre.leggauss(NODES)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()


def _density(x: np.ndarray, production: Production) -> np.ndarray:
    z = (x - production.mean) / production.u
    return np.asarray(np.exp(-z * z / 2) / (production.u * math.sqrt(2 * math.pi)))


def _between(limits: tuple[float, float], true: np.ndarray, u: float) -> np.ndarray:
    """P(reading within limits) for each true value."""
    if u == 0:
        return ((true >= limits[0]) & (true <= limits[1])).astype(float)
    from scipy.special import ndtr

    return np.asarray(ndtr((limits[1] - true) / u) - ndtr((limits[0] - true) / u))
