"""The sheet for an auditor: one page per characteristic in print, as a calibration laboratory signs it.

Result in words, who and when, serial numbers, files with their hashes, temperatures, and the budget by EA-4/02 with
its effective degrees of freedom (Welch-Satterthwaite, JCGM 100:2008, G.4).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from vcmm import __version__
from vcmm import report as r
from vcmm.evaluation.result import BudgetLine, CharacteristicResult
from vcmm.inference.job import Evaluated, EvaluatedPart
from vcmm.measuring.scenario import Scenario
from vcmm.pages.uncertainty import budget_table
from vcmm.report.table import Raw

WORDS = {
    "by": "evaluated by", "date": "date", "laboratory": "laboratory", "machine_serial": "machine, serial number",
    "machine_certificate": "certificate of the machine", "probe": "probe and styli", "part_serial": "part, serial number",
    "drawing": "drawing and revision", "order": "order", "remarks": "remarks",
}  # fmt: skip


def effective_dof(lines: Iterable[BudgetLine], u: float) -> float:
    """nu_eff = u^4 / sum(u_i^4 / nu_i); infinite where all lines are."""
    rest = sum(line.u**4 / line.dof for line in lines if math.isfinite(line.dof) and line.dof > 0)
    return math.inf if rest == 0 or not math.isfinite(u) else u**4 / rest


def rounded(value: float, expanded: float) -> tuple[str, str]:
    """Value and U in mm or rad, U with two significant digits, the value to the same place (JCGM 100, 7.2.6; EA-4/02, 6.3)."""
    if not math.isfinite(expanded) or expanded <= 0:
        return f"{value:.6f}", f"{expanded:.2g}"
    places = max(0, 1 - math.floor(math.log10(expanded)))
    return f"{value:.{places}f}", f"{expanded:.{places}f}"


def in_words(e: Evaluated) -> str:
    """The result as it stands in a certificate."""
    c, unit = e.result, e.unit
    half = (c.interval[1] - c.interval[0]) / 2
    if c.true_value is not None:
        low, high = (f"{x * 1e3:.2f}" for x in c.interval)
        stated = f" Stated with {c.filtered}." if c.filtered else ""
        claim = "" if c.true_value.claimed else " Its coverage was counted and is not claimed."
        return (
            f"{c.name}: indicated {e.measured * 1e3:.2f} µm. The true value lies between {low} µm and {high} µm with a coverage "
            f"probability of {c.p:.0%}.{claim}{stated}"
        )
    value, expanded = rounded(sum(c.interval) / 2, half)
    k = "" if not math.isfinite(c.k) else f", k = {c.k:.2f}"
    shown = "" if c.coverage_shown else f" The coverage is not shown: {c.why_not_shown}."
    return (
        f"{c.name} = {value} {unit} ± {expanded} {unit}{k}. The stated expanded uncertainty is half the {c.interval_kind} coverage interval "
        f"for a coverage probability of {c.p:.0%}.{shown}"
    )


def _decided(c: CharacteristicResult) -> str:
    if c.decision is None or c.tolerance is None:
        return "no requirement stated"
    p = "" if c.decision.p_conform is None else f", probability of conformance {c.decision.p_conform:.1%}"
    low, high = c.tolerance
    reason = f" ({c.decision.reason})" if c.decision.reason else ""
    return f"{c.decision.text}{reason}; limits {low:.6g} to {high:.6g} {c.unit}, rule: {c.decision.rule} (ISO 14253-1){p}"


def hashes(files: Sequence[Path]) -> list[list[object]]:
    """File and the SHA-256 of its bytes."""
    return [[str(f), Raw(f"<code>{hashlib.sha256(f.read_bytes()).hexdigest()}</code>")] for f in files]


def sheet_page(scenario: Scenario, part: EvaluatedPart, files: Sequence[Path]) -> str:
    """The whole sheet as one HTML file: a page for every characteristic, then the files."""
    blocks = []
    for number, e in enumerate(part.characteristics, 1):
        blocks.append(f'<section style="break-after: page">{_section(scenario, part, e, number)}</section>')
    blocks += [r.heading("Files and their hashes (SHA-256)"), r.table(["file", "hash"], hashes(files))]
    blocks += [r.note(w, "warning") for w in part.warnings]
    footer = f"vcmm {__version__}, seed {part.uncertainty.seed}. The same files, version and seed give the same numbers."
    name = f", part {part.part}" if part.part else ""
    return r.page(
        f"Measurement result: {scenario.name}{name}", blocks, subtitle=scenario.machine.name, footer=footer
    )


def _section(scenario: Scenario, part: EvaluatedPart, e: Evaluated, number: int) -> str:
    c = e.result
    nu = effective_dof(c.budget, c.u)
    rows: list[list[object]] = [
        ["result", in_words(e)],
        ["requirement", _decided(c)],
        ["indicated value", f"{e.measured:.6f} {c.unit}, known bias {c.bias * 1e3:+.3f} µm{' (corrected)' if c.corrected else ''}" if c.unit == "mm" else f"{e.measured:.8f} rad"],
        ["effective degrees of freedom", "infinite" if math.isinf(nu) else f"{nu:.0f}"],
        ["evaluated as", c.tier],
        *_stated(scenario.record),
        ["temperatures", _temperatures(scenario)],
        ["state of the machine", f"errors {scenario.machine.state}, compensation {', '.join(scenario.machine.compensation) or 'not stated'}"],
    ]  # fmt: skip
    heading = r.heading(f"{number} of {len(part.characteristics)}: {c.name} ({c.type})")
    return "\n".join([heading, r.table(["", ""], rows), budget_table(c)])


def _stated(record: Mapping[str, str]) -> list[list[object]]:
    return [
        [words, record.get(key, "not stated")]
        for key, words in WORDS.items()
        if key in record or key in ("by", "date")
    ]


def _temperatures(scenario: Scenario) -> str:
    held = {k: v for k, v in scenario.constants.items() if k.startswith("temp_") and k != "temp_gradient_C"}
    return ", ".join(f"{k[5:-2].replace('_', ' ')} {v:g} °C" for k, v in held.items()) or "20 °C throughout"
