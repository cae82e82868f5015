"""vcmm uncertainty: value, U, decision and budget of every characteristic."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter


def uncertainty_command(
    scenario: Path,
    *,
    trials: int | None = None,
    seed: int | None = None,
    engine: Literal["auto", "montecarlo", "exact"] = "auto",
    digits: int | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Task-specific uncertainty: value, U, coverage interval, decision and budget of every characteristic.

    Exit code 1 when a characteristic does not conform.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    trials
        Monte Carlo trials (default: the scenario's, else 10^6).
    seed
        Seed of the random streams (default: the scenario's, else 0).
    engine
        auto: closed form where the output is smooth, else Monte Carlo; montecarlo: sample all; exact: every trial
        with multiplied transforms, contact and iterated fits.
    digits
        Adaptive Monte Carlo to this many significant digits of u (JCGM 101, 7.9) instead of fixed trials.
    json
        Print one JSON document.
    out
        Folder for report.html, uncertainty.json, budget.csv.
    """
    from vcmm.api import uncertainty
    from vcmm.console.common import about, document, output_folder, print_json, progress, sources
    from vcmm.files.scenario import load_scenario

    folder = output_folder(out) if out else None
    loaded = load_scenario(scenario)
    with progress() as report, about(scenario):
        found = uncertainty(loaded, seed=seed, trials=trials, engine=engine, digits=digits, progress=report)
    content = document(
        "vcmm.uncertainty/1",
        uncertainty_json(found),
        seed=found.seed,
        files=sources(scenario),
        warnings=found.warnings,
    )
    if folder:
        _write(folder, loaded, found, content)
    if json:
        print_json(content)
    else:
        show(found)
    return (
        1 if any(c.decision and c.decision.text == "does not conform" for c in found.characteristics) else 0
    )


def uncertainty_json(found: Any) -> dict[str, Any]:
    """The body of the JSON document; angles use _rad keys."""
    return {
        "trials": found.trials,
        "characteristics": [characteristic_json(c) for c in found.characteristics],
    }


def characteristic_json(c: Any) -> dict[str, Any]:
    """One characteristic; estimate, u_input and sensitivity of a budget line refer to its `unit`."""
    unit = c.unit
    budget = [
        {
            "input": b.input, "what": b.what, "distribution": b.distribution, "dof": b.dof if b.dof != float("inf") else None,
            "redraw": b.redraw, "estimate": b.estimate, "u_input": b.u_input, "unit": b.unit,
            f"sensitivity_{unit}_per_unit": b.sensitivity, f"u_{unit}": b.u, "share": b.share, "evidence": b.evidence,
        }
        for b in c.budget
    ]  # fmt: skip
    decision = c.decision
    return {
        "name": c.name, "type": c.type,
        f"nominal_{unit}": c.nominal, f"value_{unit}": c.value, f"mean_{unit}": c.mean, f"bias_{unit}": c.bias,
        "bias_corrected": c.corrected, f"u_{unit}": c.u,
        f"U_{unit}": c.expanded, "k": c.k, "p": c.p, f"interval_{unit}": list(c.interval), "interval_kind": c.interval_kind,
        "coverage_shown": c.coverage_shown, f"tolerance_{unit}": None if c.tolerance is None else list(c.tolerance),
        "decision": None if decision is None else decision.text,
        "decision_rule": None if decision is None else decision.rule,
        "p_conform": None if decision is None else decision.p_conform,
        "budget": budget, "interaction_share": c.interaction_share,
        "tier": c.tier, "trials": c.trials, f"linear_error_{unit}": c.linear_error,
    }  # fmt: skip


def show(found: Any) -> None:
    """The result table, the largest budget lines, and how it was computed."""
    from vcmm.console.common import say, show_table
    from vcmm.console.quantities import deviation_text, fine_text, length_text, percent_text, span_text

    rows = [
        [
            c.name, length_text(c.nominal, c.unit), length_text(c.value, c.unit), deviation_text(c.bias, c.unit),
            deviation_text(c.expanded, c.unit, signed=False), f"{c.k:.2f}" if c.k == c.k else "–",
            span_text([x - c.nominal for x in c.interval], c.unit),
            "–" if c.decision is None else c.decision.text,
        ]
        for c in found.characteristics
    ]  # fmt: skip
    first = found.characteristics[0]
    show_table(
        f"measured value y{' (bias corrected)' if first.corrected else ''}, U and {first.interval_kind} coverage interval for p = {first.p:.0%}",
        ["characteristic", "nominal", "y", "bias", "U", "k", "interval from nominal", "decision"], rows, left=(0, 7),
    )  # fmt: skip
    budget = [
        [
            c.name if i == 0 else "",
            b.input,
            b.distribution,
            b.redraw,
            deviation_text(b.u, c.unit, signed=False),
            percent_text(b.share),
        ]
        for c in found.characteristics
        for i, b in enumerate(b for b in c.budget[:5] if i_matters(b, c))
    ]
    columns = ["characteristic", "input", "law", "redraw", "u_i", "share"]
    show_table("budget (up to five largest lines each)", columns, budget, left=(0, 1, 2, 3))
    tiers = [
        [c.name, c.tier, f"{c.trials:,}" if c.trials else "–", fine_text(c.linear_error, c.unit)]
        for c in found.characteristics
    ]
    show_table(
        "how it was computed",
        ["characteristic", "tier", "trials", "largest error of the linear model"],
        tiers,
        left=(0, 1),
    )
    for warning in found.warnings:
        say(f"note: {warning}")


def i_matters(line: Any, c: Any) -> bool:
    """Whether a budget line is more than rounding."""
    return bool(line.u > 1e-4 * c.expanded or line is c.budget[0])


def _write(folder: Path, scenario: Any, found: Any, content: dict[str, Any]) -> None:
    import json as _json

    from vcmm.console.common import say, write_files
    from vcmm.pages.uncertainty import uncertainty_page

    texts = {
        "uncertainty.json": _json.dumps(content, indent=1, allow_nan=False),
        "budget.csv": _csv(found),
        "report.html": uncertainty_page(scenario, found),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/report.html, uncertainty.json, budget.csv")


def _csv(found: Any) -> str:
    """The budget as an assessor reads it, one row per input, then the combined row of each characteristic."""
    head = "characteristic,input,what,estimate,u_input,unit,distribution,dof,redraw,sensitivity_um_or_urad_per_unit,u_i_um_or_urad,share,evidence"
    rows = [head]
    for c in found.characteristics:
        scale = 1e3 if c.unit == "mm" else 1e6
        for b in c.budget:
            numbers = [b.estimate, b.u_input]
            sensitivity = None if b.sensitivity is None else b.sensitivity * scale
            rows.append(
                _row(
                    c.name,
                    b.input,
                    b.what,
                    *numbers,
                    b.unit,
                    b.distribution,
                    b.dof,
                    b.redraw,
                    sensitivity,
                    b.u * scale,
                    b.share,
                    b.evidence,
                )
            )
        summary = f"k = {c.k:.3g}; U = {c.expanded * scale:.4g}; p = {c.p:g}; y = {c.value:.9g} {c.unit}; bias = {c.bias * scale:.4g}"
        rows.append(
            _row(c.name, "combined", summary, None, None, "", "", None, "", None, c.u * scale, 1.0, c.tier)
        )
    return "\n".join(rows) + "\n"


def _row(*cells: Any) -> str:
    def text(cell: Any) -> str:
        if cell is None or cell == float("inf"):
            return ""
        if isinstance(cell, float):
            return f"{cell:.6g}"
        return '"' + str(cell).replace('"', '""') + '"'

    return ",".join(text(c) for c in cells)
