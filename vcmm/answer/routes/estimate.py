"""The estimate of one route for one characteristic, and the agreement of two routes.

    estimate of a route = what is measured - what the route knows of the error; its uncertainty is a sum of named contributions
    E_n = (y_1 - y_2) / U(y_1 - y_2)                                  (ISO/IEC 17043:2010, B.3.1.3, for U of the difference)

Two routes about the same part share things: the reading itself, the expansion of the part. What carries the same name in both is
the same quantity with the same sensitivity, so it cancels in the difference, whatever either route thinks of its size; everything
else is independent. So u^2(y_1 - y_2) = sum of squares of what the two do not share, and the covariance is what is missing to
u_1^2 + u_2^2 (JCGM 100:2008, 5.2).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

READING = "scatter of the reading"
PART_EXPANSION = "expansion of the measured part"
P = 0.9545  # for which k = 2 of a normal law


@dataclass(frozen=True)
class Contribution:
    """One term of a route's uncertainty: u in mm or rad as it acts on the result, nu degrees of freedom."""

    name: str
    u: float
    dof: float = math.inf


@dataclass(frozen=True)
class RouteEstimate:
    """value: mm or rad; U = k u about it. remarks: warnings about this route. whole: U holds all errors that are in
    the value.
    """

    route: str
    value: float
    contributions: tuple[Contribution, ...]
    k: float
    remarks: tuple[str, ...] = ()
    whole: bool = True

    @property
    def u(self) -> float:
        return math.hypot(*(c.u for c in self.contributions))

    @property
    def expanded(self) -> float:
        return self.k * self.u

    @property
    def dof(self) -> float:
        return effective_dof(self.contributions)


@dataclass(frozen=True)
class RouteAgreement:
    """Two routes compared: difference first - second, its expanded uncertainty, covariance and names of their common contributions."""

    first: str
    second: str
    difference: float
    expanded: float
    covariance: float
    common_inputs: tuple[str, ...]

    @property
    def en(self) -> float:
        return self.difference / self.expanded if self.expanded > 0 else math.nan

    @property
    def agrees(self) -> bool:
        return abs(self.en) <= 1.0


def effective_dof(contributions: Iterable[Contribution]) -> float:
    """Return nu_eff = u^4 / sum(u_i^4 / nu_i) of Welch and Satterthwaite (JCGM 100:2008, G.2b); infinite where all are."""
    terms = list(contributions)
    rest = sum(c.u**4 / c.dof for c in terms if math.isfinite(c.dof) and c.dof > 0)
    whole = sum(c.u**2 for c in terms)
    return math.inf if rest == 0 or not math.isfinite(whole) else whole**2 / rest


def coverage_factor(dof: float) -> float:
    """Return k for p = 95.45 %: 2 for infinite degrees of freedom, Student's t below (JCGM 100:2008, G.3.2)."""
    if math.isinf(dof):
        return 2.0
    from scipy.special import stdtrit

    return float(stdtrit(dof, 0.5 + P / 2))


def agreements(estimates: Sequence[RouteEstimate]) -> tuple[RouteAgreement, ...]:
    """Compare every pair of routes whose U holds all errors that are in their values."""
    return tuple(agreement(a, b) for a, b in combinations([e for e in estimates if e.whole], 2))


def agreement(first: RouteEstimate, second: RouteEstimate) -> RouteAgreement:
    """Return E_n of two routes with the covariance of their common contributions."""
    names = {c.name for c in first.contributions} & {c.name for c in second.contributions}
    apart = [c for c in (*first.contributions, *second.contributions) if c.name not in names]
    u = math.hypot(*(c.u for c in apart))
    covariance = (first.u**2 + second.u**2 - u**2) / 2
    shared = tuple(c.name for c in first.contributions if c.name in names)
    k = coverage_factor(effective_dof(apart))
    return RouteAgreement(first.route, second.route, first.value - second.value, k * u, covariance, shared)
