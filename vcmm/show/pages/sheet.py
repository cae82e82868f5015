"""The sheet for an auditor: one page per characteristic in print, as a calibration laboratory signs it.

Result in words, who and when, serial numbers, files with their hashes, temperatures and what is done about them, and the budget
by EA-4/02 with the evidence of every line and its effective degrees of freedom (Welch-Satterthwaite, JCGM 100:2008, G.4).
What the scenario does not state is a blank to be filled in by hand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.core.run import T0_DEG_C
from vcmm.part.gps.decision import GUARD_BAND, PROBABILITY
from vcmm.physics.structure.expansion import PartExpansion, ScaleExpansion
from vcmm.show.pages.header import facts, hashes
from vcmm.show.pages.uncertainty import MEASURED
from vcmm.show.report import blocks as r
from vcmm.show.tables.quantities import SMALL_SCALE
from vcmm.show.tables.table import FINE_UNITS, ResultTable, html
from vcmm.show.tables.uncertainty import BUDGET, BudgetRow, budget_rows, not_added_up

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import BudgetLine, CharacteristicResult
    from vcmm.answer.inference.job import EvaluatedCharacteristic, EvaluatedPart
    from vcmm.task.measuring.scenario import Scenario

WORDS = {
    "by": "evaluated by", "date": "date", "laboratory": "laboratory", "machine_serial": "machine, serial number",
    "probe": "probe and styli", "part_serial": "part, serial number", "drawing": "drawing and revision", "order": "order", "remarks": "remarks",
}  # fmt: skip
TRACEABILITY = {  # ISO/IEC 17025:2017, 6.5: by what the result is traced to the SI, each with its certificate
    "machine_certificate": "certificate of the machine", "reference_sphere": "reference sphere, certificate",
    "standards": "standards, certificates", "thermometers": "thermometers, certificates",
}  # fmt: skip
RULES_IN_WORDS = {
    PROBABILITY: "ISO 14253-1:2017, its default: conformance and non-conformance are each stated with a probability of at least 95 %",
    GUARD_BAND: "ISO 14253-1:2017 with guard bands of U (stricter than its default, a conformance probability of 95 %)",
}
THERMAL = (
    "environment.",
    "channel.temp_",
    PartExpansion.name,
    ScaleExpansion.name,
    "room_",
)  # an assessor looks for these, however small
MOST_THERMAL = 3
ALWAYS = (
    "by",
    "date",
    "machine_serial",
    "part_serial",
    "drawing",
)  # a blank where not stated
BLANK = "_" * 16  # a line to write on
LINES = 6  # of a budget, so that a characteristic keeps to one page; the rest is one line


def effective_dof(lines: Iterable[BudgetLine], u: float) -> float:
    """Return nu_eff = u^4 / sum(u_i^4 / nu_i); infinite where all lines are."""
    rest = sum(line.u**4 / line.dof for line in lines if math.isfinite(line.dof) and line.dof > 0)
    return math.inf if rest == 0 or not math.isfinite(u) else u**4 / rest


# of U: drawn ends scatter by about 1 %; a normal law shifted by 5 % of U loses 0.1 % of coverage
LEAST_SHIFT = 0.05


def round_to_uncertainty(value: float, expanded: float) -> tuple[str, str]:
    """Return value and U in mm or rad, U with two significant digits, the value to the same place (JCGM 100, 7.2.6; EA-4/02, 6.3)."""
    if not math.isfinite(expanded) or expanded <= 0:
        return f"{value:.6f}", f"{expanded:.2g}"
    places = max(0, 1 - math.floor(math.log10(expanded)))
    return f"{value:.{places}f}", f"{expanded:.{places}f}"


def in_drawing(unit: str) -> tuple[float, str]:
    """Return the factor and the unit of a value as the drawing has it: mm, and angles in degrees."""
    return (math.degrees(1.0), "deg") if unit == "rad" else (1.0, "mm")


def in_words(e: EvaluatedCharacteristic) -> str:
    """Return the result in the words of a certificate."""
    c = e.result
    half = (c.interval[1] - c.interval[0]) / 2
    if c.true_value is not None:
        if not math.isfinite(c.interval[1]):
            return f"{c.name}: indicated {e.measured * 1e3:.2f} µm. These points do not bound the true value: {c.why_not_shown}."
        low, high = (f"{x * 1e3:.2f}" for x in c.interval)
        if c.true_value.counted_coverage is None:  # no inverse: what a mesh indicates, and nothing more
            return (
                f"{c.name}: indicated {e.measured * 1e3:.2f} µm. Measured again it lies between {low} µm and {high} µm with a probability "
                f"of {c.p:.0%}; nothing is claimed of the true value: {c.why_not_shown}."
            )
        stated = f" Stated with {c.filtered}." if c.filtered else ""
        claim = "" if c.true_value.is_claimed else " Its coverage was counted and is not claimed."
        return (
            f"{c.name}: indicated {e.measured * 1e3:.2f} µm. The true value lies between {low} µm and {high} µm with a coverage "
            f"probability of {c.p:.0%}.{claim}{stated}"
        )
    middle = sum(c.interval) / 2
    scale, unit = in_drawing(c.unit)
    shown_value = c.value if abs(middle - c.value) < LEAST_SHIFT * half else middle
    value, expanded = round_to_uncertainty(scale * shown_value, scale * half)
    k = "" if not math.isfinite(c.k) else f", coverage factor k = {c.k:.2f}"
    shown = "" if c.coverage_shown else f" The coverage is not demonstrated: {c.why_not_shown}."
    bias = " and holds the known bias, which is not corrected (U + |bias|)" if c.bias_in_U else ""
    return (
        f"{c.name} = {value} {unit} ± {expanded} {unit}{k}. The stated expanded uncertainty is half the {c.interval_kind} coverage interval "
        f"for a coverage probability of {c.p:.0%}{bias}.{shown}"
    )


def _decision_text(c: CharacteristicResult) -> str:
    if c.decision is None or c.tolerance is None:
        return "no requirement stated"
    p = "" if c.decision.p_conform is None else f", probability of conformance {c.decision.p_conform:.1%}"
    scale, unit = in_drawing(c.unit)
    low, high = (scale * end for end in c.tolerance)
    reason = f" ({c.decision.reason})" if c.decision.reason else ""
    rule = RULES_IN_WORDS.get(c.decision.rule, c.decision.rule)
    return f"{c.decision.text}{reason}; limits {low:.7g} to {high:.7g} {unit}{p}; rule: {rule}"


def sheet_page(scenario: Scenario, part: EvaluatedPart, files: Sequence[Path]) -> str:
    """Return the whole sheet as one HTML file: a page for every characteristic, then the files and a place to sign."""
    blocks = []
    for number, e in enumerate(part.characteristics, 1):
        blocks.append(f'<section class="sheet">{_section(scenario, part, e, number)}</section>')
    blocks += [r.heading("Files and their hashes (SHA-256)"), r.table(["file", "hash"], hashes(files))]
    blocks += r.notices(part.warnings)
    signed = [
        ["evaluated by", scenario.record.get("by", BLANK)],
        ["approved by", BLANK],
        ["date, signature", BLANK],
    ]
    blocks += [r.heading("Signed"), r.table(["", ""], signed)]
    footer = f"vcmm {__version__}, seed {part.uncertainty.seed}. The same files, version and seed give the same numbers."
    name = f", part {part.part}" if part.part else ""
    return r.page(
        f"{MEASURED}: {scenario.name}{name}",
        blocks,
        footer=footer,
        answers=[
            replace(r.answer_of(e.result), link=_title(part, e, n))
            for n, e in enumerate(part.characteristics, 1)
        ],
        facts=facts("", scenario.machine.name, scenario.record, part.uncertainty.seed),
    )


def _title(part: EvaluatedPart, e: EvaluatedCharacteristic, number: int) -> str:
    return f"{number} of {len(part.characteristics)}: {e.result.name} ({e.result.type})"


def _section(scenario: Scenario, part: EvaluatedPart, e: EvaluatedCharacteristic, number: int) -> str:
    c = e.result
    rows: list[list[object]] = [
        ["requirement", _decision_text(c)],
        ["not covered", "; ".join(c.not_covered) or "nothing named"],
        ["indicated value", _indication_text(e)],
        ["evaluated as", c.tier],
        ["temperatures", _temperatures(scenario)],
        ["compensation", _compensation_text(scenario)],
        ["machine", f"{scenario.machine.name}; errors {scenario.machine.state}, active: {', '.join(scenario.machine.compensation) or 'not stated'}"],
    ]  # fmt: skip
    heading = r.heading(_title(part, e, number))
    facts = r.columns(r.table(["", ""], rows), _records(scenario.record))
    return "\n".join([heading, r.note(in_words(e)), facts, _budget(c), *_without_evidence(c)])


def _indication_text(e: EvaluatedCharacteristic) -> str:
    c = e.result
    if c.true_value is not None:
        off = "not known" if math.isnan(c.bias) else f"{c.bias * 1e3:.3f} µm, which the interval takes off"
        return f"{e.measured:.6f} mm; bias {off}"
    if c.unit != "mm":
        scale, unit = in_drawing(c.unit)
        return f"{scale * e.measured:.6f} {unit}, known bias {scale * c.bias:+.2g} {unit}{' (corrected)' if c.corrected else ''}"
    return f"{e.measured:.6f} mm, known bias {c.bias * 1e3:+.3f} µm{' (corrected)' if c.corrected else ''}"


def _budget(c: CharacteristicResult) -> str:
    """Return the EA-4/02 budget: the largest lines, the rest together, and y, u, degrees of freedom, k and U."""
    first, rest = shown_lines(sorted(budget_rows(c), key=lambda row: -row.line.u))
    columns = tuple(column for column in BUDGET if column.head != "varies per")
    table = ResultTable("", columns, first)
    word, scale = FINE_UNITS[c.unit], SMALL_SCALE[c.unit]
    nu = effective_dof(c.budget, c.u)
    u_rest = r.number(math.hypot(*(row.line.u for row in rest)) * scale, 2)
    further = f"{len(rest)} further lines together {u_rest} {word} (all in budget.csv). " if rest else ""
    total = (
        f"{further}u(y) = {r.number(c.u * scale, 3)} {word}, ν_eff = {'∞' if math.isinf(nu) else f'{nu:.0f}'}, "
        f"coverage factor k = {r.number(c.stated[1], 3)}, U = {r.number(c.stated[0] * scale, 3)} {word}, p = {c.p:.0%}."
    )
    return "".join(
        [html(table), r.paragraph(total), *(r.paragraph(sentence) for sentence in not_added_up([c]))]
    )


def shown_lines(ranked: Sequence[BudgetRow]) -> tuple[list[BudgetRow], list[BudgetRow]]:
    """Return the LINES rows to show and the rest: the largest, among them the largest MOST_THERMAL of room, temperatures and expansions."""
    thermal = [row for row in ranked if row.line.u > 0 and row.line.input.startswith(THERMAL)][:MOST_THERMAL]
    others = [row for row in ranked if row not in thermal][: LINES - len(thermal)]
    shown = [row for row in ranked if row in thermal or row in others]
    return shown, [row for row in ranked if row not in shown]


def _without_evidence(c: CharacteristicResult) -> list[str]:
    """Return the lines without stated evidence in the scenario, which an auditor checks first."""
    names = [line.input for line in c.budget if not line.evidence and line.share > 1e-3]
    return [r.paragraph(f"No evidence is stated for: {', '.join(names)}.")] if names else []


def _records(record: Mapping[str, str]) -> str:
    """Return people and dates, and the traceability of the result."""
    traced: list[list[object]] = [[words, record.get(key, BLANK)] for key, words in TRACEABILITY.items()]
    return r.table(["", ""], _record_rows(record)) + r.table(["traceability", ""], traced)


def _record_rows(record: Mapping[str, str]) -> list[list[object]]:
    return [[words, record.get(key, BLANK)] for key, words in WORDS.items() if key in record or key in ALWAYS]


def _temperatures(scenario: Scenario) -> str:
    """Return the temperatures of part and scales, and the others where they are not at 20 degC."""
    temperatures = {
        k: v for k, v in scenario.constants.items() if k.startswith("temp_") and k != "temp_gradient_C"
    }
    shown = {k: v for k, v in temperatures.items() if "part" in k or "scale" in k or v != T0_DEG_C}
    return ", ".join(f"{k[5:-2].replace('_', ' ')} {v:g} °C" for k, v in shown.items()) or "20 °C throughout"


def _compensation_text(scenario: Scenario) -> str:
    """Return which expansions are corrected, with which coefficient."""
    out = []
    kinds: tuple[tuple[type[PartExpansion | ScaleExpansion], str], ...] = (
        (PartExpansion, "part"),
        (ScaleExpansion, "scales"),
    )
    for kind, what in kinds:
        with_ = {float(e.corrected) for e in scenario.machine.effects if isinstance(e, kind)}
        if not with_:
            out.append(f"{what}: no expansion stated")
        elif with_ == {0.0}:
            out.append(f"{what}: not corrected to 20 °C")
        else:
            coefficients = ", ".join(f"{v * 1e6:g}" for v in sorted(with_))
            out.append(f"{what}: corrected to 20 °C with {coefficients} µm/(m K)")
    return "; ".join(out)
