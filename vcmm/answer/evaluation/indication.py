"""Results of a characteristic for any indicated value: interval of the true value, and the decision about it."""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist

from vcmm.answer.evaluation.result import BIAS_IN_REACH, CharacteristicResult, TrueValue
from vcmm.answer.evaluation.summary import Summary
from vcmm.answer.evaluation.truth import Additive, PredictedPart, Statement
from vcmm.part.gps.decision import (
    ACCEPT,
    CONFORMS,
    GUARD_BAND,
    REJECT,
    REJECTED,
    UNDECIDED,
    WIDER_THAN_TOLERANCE,
    Decision,
    decide,
    no_decision,
)


def at_indication(result: CharacteristicResult, y: float, rule: str) -> CharacteristicResult:
    """Return the result for an indicated value y, mm or rad: value, interval, k and decision by a rule of vcmm.part.gps.decision."""
    assert result.truth is not None
    limits = None
    if result.tolerance is not None:
        limits = (-math.inf if result.one_sided else result.tolerance[0], result.tolerance[1])
    statement = result.truth.state(y, result.p, result.interval_kind, limits)
    if statement.counted_coverage is not None or statement.short:
        result = replace(result, coverage_shown=not statement.short, why_not_shown=statement.short)
    if result.extreme and not isinstance(
        result.truth, PredictedPart
    ):  # nothing is smaller than perfect, no length below zero
        low, high = (max(end, 0.0) for end in statement.interval)
        if isinstance(result.truth, Additive) and result.one_sided and result.summary is not None:
            # no inverse is known: the spread of what the machine indicates, which claims nothing
            low, high = (max(end, 0.0) for end in result.summary.interval(result.p, result.interval_kind))
        statement = replace(statement, estimate=max(statement.estimate, 0.0), interval=(low, high))
    half = (statement.interval[1] - statement.interval[0]) / 2
    is_finite = math.isfinite(result.u) and result.u > 0
    half = result.half_width or half
    true, bias = None, result.bias
    if result.extreme and not isinstance(result.truth, PredictedPart):
        true = TrueValue(
            statement.estimate,
            statement.interval,
            result.coverage_shown,
            statement.counted_coverage,
            statement.interval_u,
        )
        bias = bias if isinstance(result.truth, Additive) else y - statement.estimate
    summed = isinstance(result.truth, PredictedPart) or not result.extreme  # a part to come indicates nothing
    law = result.truth.of(y) if isinstance(result.truth, Additive) else result.summary
    return replace(
        result, summary=law if isinstance(law, Summary) else None, value=statement.estimate if summed else y, bias=bias,
        interval=statement.interval, k=half / result.u if is_finite else math.nan,
        decision=_beyond_one_limit(result, y, _decision(result, statement, rule)), true_value=true,
    )  # fmt: skip


def _decision(result: CharacteristicResult, statement: Statement, rule: str) -> Decision | None:
    if result.tolerance is None:
        return None
    if not result.coverage_shown:
        return no_decision(rule, result.why_not_shown)
    if statement.p_reach is not None and rule != GUARD_BAND:
        return _with_bias(result, statement, rule)
    low, high = statement.interval
    where = (
        (low + high) / 2 if rule == GUARD_BAND else statement.estimate
    )  # the guard band is that of the interval
    return decide(
        where, result.tolerance, statement.p_conform, u=result.u if math.isfinite(result.u) else None, U=(high - low) / 2,
        rule=rule, one_sided=result.one_sided,
    )  # fmt: skip


def _beyond_one_limit(result: CharacteristicResult, y: float, decision: Decision | None) -> Decision | None:
    """A rejection stands where the true value lies beyond one and the same limit (ISO 14253-1:2017); both together prove nothing."""
    if decision is None or decision.text != REJECTED or decision.rule == GUARD_BAND or result.one_sided:
        return decision
    assert result.truth is not None
    assert result.tolerance is not None
    low, high = result.tolerance
    for side in ((low, math.inf), (-math.inf, high)):
        statement = result.truth.state(y, result.p, result.interval_kind, side)
        within = statement.p_conform if statement.p_reach is None else statement.p_reach[1]
        if within is not None and within <= REJECT:
            return decision
    return replace(decision, text=UNDECIDED, reason=WIDER_THAN_TOLERANCE)


def _with_bias(result: CharacteristicResult, statement: Statement, rule: str) -> Decision:
    """Decide with U + |bias|, where a known bias is not corrected: no decision that a value shifted by the bias, either way, would change."""
    assert statement.p_reach is not None
    least, most = statement.p_reach
    u = result.u if math.isfinite(result.u) else None
    text = CONFORMS if least >= ACCEPT else REJECTED if most <= REJECT else UNDECIDED
    guard = None if u is None else NormalDist().inv_cdf(ACCEPT) * u + abs(result.bias)
    why = BIAS_IN_REACH if text == UNDECIDED else ""
    return Decision(text, rule, statement.p_conform, guard, why)
