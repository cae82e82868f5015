"""Decide about conformity by the rules of ISO 14253-1, for a measured value with its uncertainty.

"probability 95 %"  conforms when the conformance probability is at least 95 %, does not conform when the true
                    value lies beyond one and the same limit with at least 95 %, else undecided. With a normal
                    law that is a guard band of 1.645 u outside the limit (ISO 14253-1:2017). Both limits
                    together are no proof: with U of many tolerances hardly any true value lies between them,
                    wherever the part was found.
"guard band U"      the limits are moved inwards by the expanded uncertainty U to accept, outwards to reject.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

from vcmm.core.errors import UsageError, choose_from

PROBABILITY, GUARD_BAND = "probability 95 %", "guard band U"
RULES = (PROBABILITY, GUARD_BAND)
CONFORMS, UNDECIDED, REJECTED = "conforms", "undecided", "does not conform"
ACCEPT, REJECT = 0.95, 0.05
WIDER_THAN_TOLERANCE = (
    "U is larger than the tolerance: the true value may lie beyond either limit; measure with a smaller U"
)


@dataclass(frozen=True)
class Decision:
    """`text`: one of the three outcomes. `p_conform` 0..1 or None when unknown. `guard`: width of the guard
    band in the unit of the value, None when it was not used or not known. `reason`: why nothing is decided, else empty.
    """

    text: str
    rule: str
    p_conform: float | None
    guard: float | None
    reason: str = ""


def no_decision(rule: str, reason: str) -> Decision:
    """Return the outcome without a decision, because the underlying interval is not shown to hold the true value."""
    return Decision(UNDECIDED, rule, None, None, reason)


def decide(
    value: float,
    limits: tuple[float, float],
    probability_of_conformance: float | None = None,
    u: float | None = None,
    U: float | None = None,  # the symbol of the GUM
    rule: str = PROBABILITY,
    one_sided: bool = False,
) -> Decision:
    """Decide about `value` against `limits` (lower, upper; -inf or inf where there is none), all in one
    unit.

    probability_of_conformance: from the whole distribution (the caller asks it whether a rejection is beyond one
    limit); without it a normal law with standard uncertainty u is taken. U: expanded uncertainty, 2 u when left out. one_sided: the lower limit is a bound
    of nature (the 0 of a tolerance zone) and cannot be violated. UsageError: unknown rule, what the rule
    needs is missing, bad numbers.
    """
    if rule not in RULES:
        raise UsageError(f'Unknown decision rule "{rule}".{choose_from(rule, RULES)}')
    lower, upper = (-math.inf if one_sided else limits[0]), limits[1]
    _check(value, lower, upper, probability_of_conformance, u, U)
    p = probability_of_conformance
    if p is None and u is not None:
        p = conformance_probability(value, (lower, upper), u)
    if rule == GUARD_BAND:
        return _by_guard_band(value, lower, upper, p, u, U)
    if p is None:
        raise UsageError(f'The rule "{rule}" needs u or the probability of conformance; give one of them.')
    guard = None if u is None else NormalDist().inv_cdf(ACCEPT) * u
    text = CONFORMS if p >= ACCEPT else REJECTED if p <= REJECT else UNDECIDED
    if text == REJECTED and probability_of_conformance is None and u is not None:
        sides = ((lower, math.inf), (-math.inf, upper))
        if min(conformance_probability(value, side, u) for side in sides) > REJECT:
            return Decision(UNDECIDED, rule, p, guard, WIDER_THAN_TOLERANCE)
    return Decision(text, rule, p, guard)


def conformance_probability(value: float, limits: tuple[float, float], u: float) -> float:
    """Return the share of a normal law (value, u) within the limits (JCGM 106:2012, 7.3); u = 0 gives 0 or 1."""
    lower, upper = limits
    if u == 0.0:
        return 1.0 if lower <= value <= upper else 0.0
    if value < 0.5 * (lower + upper):  # work on the side where the tails do not cancel
        lower, upper, value = -upper, -lower, -value
    return _below((upper - value) / u) - _below((lower - value) / u)


def _below(z: float) -> float:
    """Evaluate the standard normal distribution function, accurate in both tails."""
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


def _by_guard_band(
    value: float, lower: float, upper: float, p: float | None, u: float | None, expanded: float | None
) -> Decision:
    if expanded is None and u is None:
        raise UsageError(f'The rule "{GUARD_BAND}" needs U or u; give one of them.')
    guard = expanded if expanded is not None else 2.0 * (u or 0.0)
    if lower + guard <= value <= upper - guard:
        return Decision(CONFORMS, GUARD_BAND, p, guard)
    outside = value < lower - guard or value > upper + guard
    return Decision(REJECTED if outside else UNDECIDED, GUARD_BAND, p, guard)


def _check(
    value: float, lower: float, upper: float, p: float | None, u: float | None, expanded: float | None
) -> None:
    if not math.isfinite(value):
        raise UsageError(f"The value {value} is not finite; nothing can be decided about it.")
    if not lower < upper:
        raise UsageError(f"The lower limit {lower:g} is not below the upper limit {upper:g}; exchange them.")
    for name, number in (("u", u), ("U", expanded)):
        if number is not None and not (math.isfinite(number) and number >= 0.0):
            raise UsageError(f"{name} must be finite and not negative, not {number:g}.")
    if p is not None and not 0.0 <= p <= 1.0:
        raise UsageError(f"A probability of conformance lies between 0 and 1, not at {p:g}.")
