"""Infer the true value from an indicated value: interval and probability of conformance.

    indicated y = true value + error            so the true value given y follows  y - error

A law of the error that leans to one side leans to the other in the true value (JCGM 101:2008, 5.3; JCGM 106:2012, 6).
A part that is still to be cut is no indication: there the law of the trials is that of the part itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

from vcmm.answer.evaluation.interval import Linear
from vcmm.answer.evaluation.summary import Summary
from vcmm.answer.evaluation.widened_law import WidenedLaw

MORE_MISSES = 0.1  # an interval for p may miss this share more often than 1 - p says: 5.5 % for 95 %
Limits = tuple[float, float]


@dataclass(frozen=True)
class Statement:
    """About the true value: estimate, coverage interval, probability that it lies within the limits (None without).

    Belts (vcmm.answer.evaluation.inversion) also state the share of sampled parts in which the interval held the true value.
    """

    estimate: float
    interval: tuple[float, float]
    p_conform: float | None
    short: str = ""  # why its coverage may not be claimed, where that was counted
    counted_coverage: tuple[float, float] | None = None  # of drawn parts, and of parts of another kind
    interval_u: tuple[float, float] | None = None  # of the ends, from the number of draws
    p_reach: tuple[float, float] | None = (
        None  # least and most probability to conform of indications off by a bias that is left in, either way
    )


class Truth(Protocol):
    """The true value as a function of the indicated one."""

    def state(self, y: float, p: float, kind: str, limits: Limits | None = None) -> Statement:
        """Return the statement about the true value, mm or rad, when y is indicated. limits: of the true value, infinite where none."""
        ...


@dataclass(frozen=True, eq=False)
class Additive:
    """y = true value + error, whatever the true value: law is that of the indicated value for a part that reads `at`.

    error: mean of the law beyond `at`, which laws of samples may have; shift: the known bias that is taken off. bias: one that is
    left in the value and enlarges U to U + |bias| in its place (JCGM 100:2008, F.2.4.5; ISO 15530-3:2011, 9).
    """

    law: Linear | Summary | WidenedLaw
    at: float
    error: float = 0.0
    shift: float = 0.0
    bias: float = 0.0

    def state(self, y: float, p: float, kind: str, limits: Limits | None = None) -> Statement:
        statement = _statement(self.of(y), y - self.shift - self.error, p, kind, limits)
        return self._with_bias_outside(statement, y, limits) if self.bias else statement

    def _with_bias_outside(self, statement: Statement, y: float, limits: Limits | None) -> Statement:
        """Extend the interval by |bias| on both sides; the probability to conform is that of the true value, y - bias."""
        low, high = statement.interval
        interval = (low - abs(self.bias), high + abs(self.bias))
        if limits is None:
            return replace(statement, interval=interval)
        lower, true, upper = (self.of(y + d).probability(*limits) for d in self.ways())
        reach = (min(lower, upper), max(lower, statement.p_conform or 0.0, upper))
        return replace(statement, interval=interval, p_conform=true, p_reach=reach)

    def ways(self) -> tuple[float, float, float]:
        """Return the amounts added to y where a bias is left in: least, for the true value, most."""
        return -abs(self.bias), -self.bias, abs(self.bias)

    def of(self, y: float) -> Linear | Summary | WidenedLaw:
        """Return the law of the true value."""
        return self.law.reflect(y - self.shift + self.at)

    def coverage(self, p: float, kind: str, bias: float) -> float:
        """Return the probability that the interval for p holds the true value when all indications are off by `bias`, mm or rad."""
        law = self.law.reflect(2 * self.at)
        low, high = law.interval(p, kind)
        return law.probability(low + bias, high + bias)


@dataclass(frozen=True, eq=False)
class PredictedPart:
    """No indication: the law of the trials is that of the part to come, and the estimate is its expected value."""

    law: Linear | Summary
    estimate: float

    def state(self, y: float, p: float, kind: str, limits: Limits | None = None) -> Statement:
        return _statement(self.law, self.estimate, p, kind, limits)


def _statement(
    law: Linear | Summary | WidenedLaw, estimate: float, p: float, kind: str, limits: Limits | None
) -> Statement:
    within = None if limits is None else law.probability(*limits)
    u = law.ends_u(p) if isinstance(law, Summary) else (0.0, 0.0)  # an inversion draws nothing
    return Statement(estimate, law.interval(p, kind), within, interval_u=u)


def holds(attained: float, p: float) -> bool:
    """Return whether an interval for the share p of cases holds in nearly as many: |bias| = U / 10 of a normal law."""
    return 1 - attained <= (1 + MORE_MISSES) * (1 - p) + 1e-9
