"""Details of a decision: its zone, the limits for readings, its own risk and that of the production."""

from __future__ import annotations

import math

from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.part.gps.decision import CONFORMS, REJECTED
from vcmm.part.gps.risk import GlobalRisk, Production, acceptance_limits, global_risk, specific_risk, zone

Limits = tuple[float, float]


def limits_of(c: CharacteristicResult) -> Limits | None:
    """Return the limits of the true value; the 0 of a zone is none."""
    if c.tolerance is None:
        return None
    return (-math.inf if c.one_sided else c.tolerance[0], c.tolerance[1])


def zone_of(c: CharacteristicResult) -> str | None:
    """Return the zone of ISO 14253-1 by the ends of the coverage interval; None where its coverage is not demonstrated."""
    limits = limits_of(c)
    if limits is None or not c.coverage_shown:
        return None
    low, high = c.interval
    return zone((low + high) / 2, limits, (high - low) / 2)


def reading_limits(c: CharacteristicResult) -> Limits | None:
    """Return the limits for readings on the shop floor, moved inwards by the guard band of the rule. None where there is none."""
    limits = limits_of(c)
    if limits is None or c.decision is None or c.decision.guard is None or c.extreme:
        return None
    return acceptance_limits(limits, c.decision.guard)


def decision_risk(c: CharacteristicResult) -> float | None:
    """Return the probability that this decision is wrong (specific risk, JCGM 106, 9.3.2); None where nothing was decided."""
    d = c.decision
    if d is None or d.p_conform is None or d.text not in (CONFORMS, REJECTED):
        return None
    return specific_risk(d.p_conform, d.text == CONFORMS)


def production_risk(c: CharacteristicResult) -> GlobalRisk | None:
    """Return the risks over the production that the job states; None where none is stated, or a value is no sum of truth and error."""
    limits = limits_of(c)
    if c.production is None or limits is None or c.extreme or not c.coverage_shown:
        return None
    if c.decision is None or c.decision.guard is None or not math.isfinite(c.u):
        return None
    middle = sum(c.tolerance) / 2 if c.tolerance else 0.0
    return global_risk(limits, c.u, c.decision.guard, Production(middle + c.production[0], c.production[1]))
