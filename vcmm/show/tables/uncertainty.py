"""An uncertainty evaluation as tables: results, budget, method; the characteristics of JSON and budget.csv."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from vcmm.answer.evaluation.judgement import decision_risk, production_risk, reading_limits, zone_of
from vcmm.answer.evaluation.result import (
    ROUNDING,
    BudgetLine,
    CharacteristicResult,
    UncertaintyResult,
    budget_interaction,
    common_causes,
)
from vcmm.part.gps.decision import ACCEPT, GUARD_BAND, REJECT, UNDECIDED
from vcmm.show.tables.quantities import (
    DASH,
    DEVIATION,
    FINE,
    LENGTH,
    SHARE,
    SIZE,
    SMALL_SCALE,
    SPAN,
    fixed,
    small_in_file,
)
from vcmm.show.tables.stated import kind_of_interval, meaning_of_U
from vcmm.show.tables.table import (
    COUNT,
    WORDS,
    Column,
    ResultTable,
    Unit,
    Writing,
    csv_text,
    entry,
    records,
)

STATE = {"conforms": "good", "undecided": "warning", "does not conform": "bad"}


def _decision_badge(text: str | None, unit: Unit) -> object:
    from vcmm.show.report.table import Cell

    return DASH if text is None else Cell(text, kind=STATE[text])  # type: ignore[arg-type]


def _coverage_badge(shown: bool, unit: Unit) -> object:
    from vcmm.show.report.table import Cell

    return "yes" if shown else Cell("not demonstrated", kind="warning")


DECISION = Writing(lambda text, unit: text or DASH, _decision_badge, words=True)
COVERAGE = Writing(lambda shown, unit: "yes" if shown else "not demonstrated", _coverage_badge, words=True)


def decision_text(c: CharacteristicResult) -> str | None:
    return None if c.decision is None else c.decision.text


def stated_with(results: Iterable[CharacteristicResult]) -> list[str]:
    """Return the filter, cut-off and tip of every form that is stated with them."""
    return [f"{c.name} is stated with {c.filtered}" for c in results if c.filtered]


def undecided_because(results: Iterable[CharacteristicResult]) -> list[str]:
    """Return why nothing is decided, one sentence per characteristic that is undecided."""
    out = []
    for c in results:
        if c.decision is not None and c.decision.text == UNDECIDED:
            p = c.decision.p_conform
            why = "" if p is None else f"probability of conformity {p:.1%}"
            if p is not None and c.decision.rule == GUARD_BAND:
                why += ", and a limit lies within the coverage interval"
            elif p is not None:
                why += f", neither at least {ACCEPT:.0%} nor at most {REJECT:.0%}"
            out.append(f"{c.name} is undecided: {c.decision.reason or why}")
    return out


def not_added_up(results: Iterable[CharacteristicResult]) -> list[str]:
    """Return one sentence where shares of budgets do not add to 100 %: which characteristics, their sum, and why."""
    names = [f"{c.name} {1.0 - rest:.1%}" for c in results if (rest := budget_interaction(c))]
    if not names:
        return []
    return [
        f"shares of u² that do not add to 100%: {', '.join(names)}; each line is the variance with that input alone, the others held "
        "still (JCGM 101, Annex B), and these add only where the output is linear; the rest to 100% is interaction"
    ]


def p_conform(c: CharacteristicResult) -> float | None:
    return None if c.decision is None else c.decision.p_conform


def from_nominal(ends: tuple[float, float] | None, c: CharacteristicResult) -> list[float] | None:
    """Return two ends as departures from nominal, mm or rad."""
    return None if ends is None else [x - c.nominal for x in ends]


def _causes(c: CharacteristicResult) -> list[dict[str, Any]]:
    """Return the physical causes that several lines of the budget have in common, with their share together."""
    causes = common_causes(c.budget)
    return [{"cause": k, "share": share, "inputs": list(names)} for k, (share, names) in causes.items()]


def _ends(limits: tuple[float, float] | None) -> list[float | None] | None:
    return None if limits is None else [x if math.isfinite(x) else None for x in limits]


def _global_risk(c: CharacteristicResult) -> dict[str, float] | None:
    """Return the shares of the stated production: out and accepted, in and rejected."""
    risk = production_risk(c)
    if risk is None:
        return None
    return {
        "consumer": risk.consumer, "producer": risk.producer, "out_of_tolerance": risk.out, "accepted": risk.acceptance,
    }  # fmt: skip


def _true_value(c: CharacteristicResult) -> dict[str, Any] | None:
    """Return the true value beside the indicated one, of form, orientation and location."""
    t = c.true_value
    if t is None:
        return None
    counted = (
        {"coverage_counted": {"family": t.counted_coverage[0], "other": t.counted_coverage[1]}}
        if t.counted_coverage
        else {}
    )
    return {
        f"estimate_{c.unit}": t.estimate,
        f"interval_{c.unit}": list(t.interval),
        f"interval_u_{c.unit}": None if t.interval_u is None else _ends(t.interval_u),
        "coverage_claimed": t.is_claimed,
        "reason": None if t.is_claimed else c.why_not_shown,
        "not_covered": list(c.not_covered),
        **counted,
    }


def true_value_by_points(c: CharacteristicResult) -> dict[str, Any] | None:
    """Return the true value of any characteristic of measured points; of a size, distance or angle that of its interval."""
    if c.true_value is not None:
        return _true_value(c)
    return {
        f"estimate_{c.unit}": c.value - (c.bias if c.bias_in_U else 0.0),
        f"interval_{c.unit}": list(c.interval),
        f"interval_u_{c.unit}": None,  # no parts are drawn for it
        "coverage_claimed": c.coverage_shown,
        "reason": c.why_not_shown or None,
        "not_covered": list(c.not_covered),
    }


def not_covered(results: Iterable[CharacteristicResult]) -> list[str]:
    """Return limits of the claims, one sentence per characteristic of which coverage is claimed."""
    return [
        f"{c.name}: not covered: {'; '.join(c.not_covered)}"
        for c in results
        if c.coverage_shown and c.not_covered
    ]


RESULTS: tuple[Column[CharacteristicResult], ...] = (
    Column("characteristic", lambda c: c.name, key="name"),
    entry("type", lambda c: c.type),
    Column("nominal", lambda c: c.nominal, LENGTH, key="nominal_{unit}"),
    Column("y", lambda c: c.value, LENGTH, key="value_{unit}"),
    entry("mean_{unit}", lambda c: c.mean),
    Column("bias", lambda c: c.bias, DEVIATION, key="bias_{unit}"),
    entry("bias_corrected", lambda c: c.corrected),
    entry("bias_in_U_{unit}", lambda c: c.bias_in_U),
    entry("u_{unit}", lambda c: c.u),
    Column("U", lambda c: c.stated[0], SIZE, key="U_{unit}"),
    Column("k", lambda c: c.stated[1], fixed(2), key="k", on="terminal"),
    entry("p", lambda c: c.p),
    entry("interval_{unit}", lambda c: list(c.interval)),
    Column("interval from nominal", lambda c: from_nominal(c.interval, c), SPAN),
    entry("interval_kind", kind_of_interval),
    entry("true_value", lambda c: _true_value(c)),
    entry("filter", lambda c: c.filtered or None),
    entry("why_not_shown", lambda c: c.why_not_shown or None),
    entry("coverage_shown", lambda c: c.coverage_shown),
    entry("tolerance_{unit}", lambda c: None if c.tolerance is None else list(c.tolerance)),
    Column("tolerance", lambda c: from_nominal(c.tolerance, c), SPAN, on="page"),
    Column("decision", decision_text, DECISION, key="decision"),
    entry("decision_rule", lambda c: None if c.decision is None else c.decision.rule),
    entry("p_conform", p_conform),
    entry("zone", zone_of),
    entry("acceptance_limits_{unit}", lambda c: _ends(reading_limits(c))),
    entry("specific_risk", decision_risk),
    entry("global_risk", lambda c: _global_risk(c)),
    entry("budget", lambda c: records(BUDGET, budget_rows(c))),
    entry("common_causes", lambda c: _causes(c)),
    entry("interaction_share", lambda c: c.interaction_share),
    entry("tier", lambda c: c.tier),
    entry("trials", lambda c: c.trials),
    entry("linear_error_{unit}", lambda c: c.linear_error),
)


def results(result: UncertaintyResult) -> ResultTable[CharacteristicResult]:
    """Return the table characteristic | nominal | y | bias | U | k | interval | tolerance | decision."""
    first = result.characteristics[0]
    corrected = " (bias corrected)" if first.corrected else ""
    title = f"measured value y{corrected}, U and coverage interval for p = {first.p:.0%}"
    bias_text = "less its known bias" if first.corrected else "its known bias not corrected"
    caption = (
        f"{meaning_of_U(result.characteristics)}. y: indicated value"
        f"{' ' if first.corrected else ', '}{bias_text}. Lengths: mm and µm; angles: deg and µrad."
    )
    return ResultTable(
        title, RESULTS, result.characteristics, f"{meaning_of_U(result.characteristics)}.", caption
    )


@dataclass(frozen=True)
class BudgetRow:
    """A line of the budget with the characteristic that it belongs to; first: of this characteristic."""

    of: CharacteristicResult
    line: BudgetLine
    first: bool = False

    @property
    def unit(self) -> Unit:
        return self.of.unit


def _dof(row: BudgetRow) -> float | None:
    return row.line.dof if row.line.dof != math.inf else None


def _dof_on_page(dof: float | None, unit: Unit) -> str:
    from vcmm.show.report.text import number

    return "∞" if dof is None or not math.isfinite(dof) else number(dof, 3)


def _number_on_page(value: float | None, unit: Unit) -> str:
    from vcmm.show.report.text import number

    return DASH if value is None else number(value * SMALL_SCALE[unit], 3)


def _quantity_in_words(row: BudgetRow) -> object:
    """Return the quantity that varies, in words over its name and evidence."""
    from vcmm.show.report.table import Raw
    from vcmm.show.report.text import escape

    b = row.line
    evidence = f"{': ' if b.evidence else ''}{escape(b.evidence)}"
    return Raw(f"<strong>{escape(b.what)}</strong><br><small>{escape(b.input)}{evidence}</small>")


def _in_its_unit(value: float | None, unit: str) -> str:
    """Return a number in the unit of its parameter."""
    from vcmm.show.report.text import number

    words = {"degC": "°C", "1": ""}
    return DASH if value is None else f"{number(value, 4)} {words.get(unit, unit)}".strip()


AS_IT_IS = Writing(lambda value, unit: str(value), lambda value, unit: value, words=True)
DOF = Writing(_dof_on_page)
SENSITIVITY = Writing(_number_on_page)
CONTRIBUTION = Writing(SIZE.terminal, _number_on_page)
QUANTITY = Writing(lambda text, unit: text)
U_UNIT = {"degC": "K"}  # of a standard uncertainty, where it is another than that of the estimate

BUDGET: tuple[Column[BudgetRow], ...] = (
    Column("characteristic", lambda b: b.of.name if b.first else "", on="terminal"),
    Column(None, lambda b: b.of.name, csv="characteristic"),
    Column("input", lambda b: b.line.input, key="input", csv="input", on="terminal"),
    Column("quantity", _quantity_in_words, AS_IT_IS, on="page"),
    Column(None, lambda b: b.line.what, key="what", csv="what"),
    Column(None, lambda b: b.line.estimate, key="estimate", csv="estimate"),
    Column("estimate", lambda b: _in_its_unit(b.line.estimate, b.line.unit), QUANTITY, on="page"),
    Column(None, lambda b: b.line.u_input, key="u_input", csv="u_input"),
    Column(
        "u(x)",
        lambda b: _in_its_unit(b.line.u_input, U_UNIT.get(b.line.unit, b.line.unit)),
        QUANTITY,
        on="page",
    ),
    Column(None, lambda b: b.line.unit, key="unit", csv="unit"),
    Column("law", lambda b: b.line.distribution, WORDS, key="distribution", csv="distribution"),
    Column("ν", _dof, DOF, key="dof", csv="dof", on="page"),
    Column("varies per", lambda b: b.line.redraw, key="redraw", csv="redraw"),
    entry("sensitivity_{unit}_per_unit", lambda b: b.line.sensitivity),
    Column(
        "c / ({small}/unit)",
        lambda b: b.line.sensitivity,
        SENSITIVITY,
        csv="sensitivity_um_or_urad_per_unit",
        file=small_in_file,
        on="page",
    ),
    Column(
        "u_i",
        lambda b: b.line.u,
        CONTRIBUTION,
        key="u_{unit}",
        csv="u_i_um_or_urad",
        page_head="u_i / {small}",
        file=small_in_file,
    ),
    Column("share", lambda b: b.line.share, SHARE, key="share", csv="share"),
    Column(None, lambda b: b.line.evidence, key="evidence", csv="evidence"),
)


def budget_rows(c: CharacteristicResult) -> list[BudgetRow]:
    """Return the lines, the largest first."""
    lines = sorted(c.budget, key=lambda line: -line.u)
    return [BudgetRow(c, line, i == 0) for i, line in enumerate(lines)]


def more_than_rounding(row: BudgetRow) -> bool:
    """Return whether a line is the first, or has a share that is not printed as 0.0 %."""
    return row.first or row.line.share >= ROUNDING


def budget_table(characteristics: Iterable[CharacteristicResult], most: int = 5) -> ResultTable[BudgetRow]:
    """Return the largest lines of every characteristic that are more than rounding."""
    rows = [b for c in characteristics for b in budget_rows(c)[:most] if more_than_rounding(b)]
    words = {5: "five"}.get(most, str(most))
    return ResultTable(f"budget (up to {words} largest lines each)", BUDGET, rows)


def budget_total(c: CharacteristicResult) -> BudgetLine:
    """Return the closing line of a budget: k, U, p, y and bias in words, u in numbers."""
    scale = SMALL_SCALE[c.unit]
    expanded, k = c.stated
    text = (
        f"k = {k:.3g}; U = {expanded * scale:.4g}; "
        if math.isfinite(expanded)
        else "no U: the true value is not bounded; "
    )
    text += f"p = {c.p:g}; y = {c.value:.9g} {c.unit}"
    text += f"; bias = {c.bias * scale:.4g}" if math.isfinite(c.bias) else ""
    rest = budget_interaction(c)
    text += f"; inputs together {rest:+.4g} of u^2, beyond the lines" if rest else ""
    return BudgetLine(
        input="combined", what=text, distribution="", dof=math.inf, redraw="", estimate=None, u_input=None, unit="",
        sensitivity=None, u=c.u, share=1.0, evidence=c.tier,
    )  # fmt: skip


def budget_csv(result: UncertaintyResult) -> str:
    """Return the budget as an assessor reads it, one row per input, then the combined row of each characteristic."""
    rows = [b for c in result.characteristics for b in (*budget_rows(c), BudgetRow(c, budget_total(c)))]
    return csv_text(ResultTable("", BUDGET, rows))


COMPUTATION_COLUMNS: tuple[Column[CharacteristicResult], ...] = (
    Column("characteristic", lambda c: c.name),
    Column("method", lambda c: c.tier),
    Column("trials", lambda c: c.trials, COUNT),
    Column(
        "largest error of the linear model",
        lambda c: c.linear_error,
        FINE,
        page_head="largest |linear - exact|",
    ),
    Column("coverage shown", lambda c: c.coverage_shown, COVERAGE, on="page"),
)


def computation_table(result: UncertaintyResult) -> ResultTable[CharacteristicResult]:
    """Return the method, the number of trials, and the certified error of the linear model."""
    caption = "The linear model is compared with multiplied transforms, contact and iterated fits on the same draws."
    return ResultTable(
        "how it was computed", COMPUTATION_COLUMNS, result.characteristics, page_caption=caption
    )


def uncertainty_json(result: UncertaintyResult) -> dict[str, Any]:
    """Return the body of the JSON document; angles use _rad keys."""
    return {"trials": result.trials, "characteristics": records(RESULTS, result.characteristics)}


def characteristic_json(c: CharacteristicResult) -> dict[str, Any]:
    """Return one characteristic; estimate, u_input and sensitivity of a budget line refer to its `unit`."""
    return records(RESULTS, [c])[0]
