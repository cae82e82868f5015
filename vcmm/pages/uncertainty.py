"""The report of an uncertainty evaluation: results, decisions, budgets, pictures, how it was computed."""

from __future__ import annotations

import math

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.evaluation.result import BudgetLine, CharacteristicResult, UncertaintyResult
from vcmm.measuring.scenario import Scenario
from vcmm.pages.view import part_items, touch_covariances, touch_items, volume_items

STATE = {"conforms": "good", "undecided": "warning", "does not conform": "bad"}
SMALL = {"mm": ("µm", 1e3), "rad": ("µrad", 1e6)}


def uncertainty_page(scenario: Scenario, found: UncertaintyResult) -> str:
    """One self-contained HTML file."""
    blocks = [r.heading("Results"), result_table(found), *(r.note(w, "warning") for w in found.warnings)]
    blocks += [r.heading("What was assumed"), assumptions(scenario, found)]
    blocks += [r.heading("Where it was measured"), *pictures(found)]
    for c in found.characteristics:
        blocks += [r.heading(f"{c.name} ({c.type})"), *characteristic_blocks(c)]
    blocks += [r.heading("How it was computed"), computed_table(found)]
    footer = f"vcmm {__version__}, seed {found.seed}. Error = indicated - true. Standard uncertainty u, coverage interval for p."
    return r.page(
        f"Measurement uncertainty: {scenario.name}", blocks, subtitle=scenario.machine.name, footer=footer
    )


def assumptions(scenario: Scenario, found: UncertaintyResult) -> str:
    """Machine, pose, styli, touches, temperatures, decision rule: what an assessor asks first."""
    task, machine = found.model.task, scenario.machine
    turns = ", ".join(f"{math.degrees(t):.4g}" for t in scenario.pose.turns())
    shift = ", ".join(f"{v:.6g}" for v in scenario.pose.shift)
    styli = "; ".join(
        f"{s.name}: tip Ø {2 * s.tip_radius:g} mm at ({', '.join(f'{v:g}' for v in s.offset)}) mm, "
        + ("qualified" if s.name in scenario.qualifications else "taken as perfectly qualified")
        for s in scenario.plan.styli.values()
    )
    warm = [
        f"{k[5:-2].replace('_', ' ')} {v:g} °C"
        for k, v in scenario.constants.items()
        if k.startswith("temp_") and k != "temp_gradient_C"
    ]
    counts = ", ".join(f"{name} {len(rows)}" for name, rows in task.touches.rows.items())
    rule = next((c.decision.rule for c in found.characteristics if c.decision), scenario.settings.rule)
    rows = [
        ["machine", f"{machine.name}, structure {machine.chain.structure}, error state {machine.state}"],
        ["part in the machine", f"shift ({shift}) mm, turned ({turns})° about fixed x, y, z"],
        ["touches", f"{task.touches.run.n}: {counts}"],
        ["styli", styli],
        ["temperatures", ", ".join(warm) or "20 °C throughout"],
        [
            "decision",
            f"{rule}, ISO 14253-1:2017; limits are compared with {'the corrected' if scenario.settings.known_bias == 'corrected' else 'the indicated'} value",
        ],
    ]
    return r.table(["", ""], rows)


def result_table(found: UncertaintyResult) -> str:
    """characteristic | nominal | y | bias | U | interval | tolerance | decision."""
    first = found.characteristics[0]
    columns = [
        "characteristic",
        "nominal",
        "y",
        "bias",
        "U",
        "interval from nominal",
        "tolerance",
        "decision",
    ]
    said = (
        "y: indicated value less its known bias."
        if first.corrected
        else "y: indicated value, its known bias not corrected."
    )
    caption = f"U: half the {first.interval_kind} coverage interval for p = {first.p:.0%}. {said} Lengths: mm and µm; angles: deg and µrad."
    return r.table(
        columns, [_row(c) for c in found.characteristics], numeric=(1, 2, 3, 4, 5, 6), caption=caption
    )


def _row(c: CharacteristicResult) -> list[object]:
    decision: object = "–"
    if c.decision is not None:
        decision = r.Cell(c.decision.text, kind=STATE[c.decision.text])  # type: ignore[arg-type]
    return [
        c.name, large(c.nominal, c.unit), large(c.value, c.unit), small(c.bias, c.unit), small(c.expanded, c.unit),
        span(c.interval, c), "–" if c.tolerance is None else span(c.tolerance, c), decision,
    ]  # fmt: skip


def span(ends: tuple[float, float], c: CharacteristicResult) -> str:
    """Two ends as departures from nominal, µm or µrad."""
    scale = SMALL[c.unit][1]
    return " … ".join(r.number(_clean((x - c.nominal) * scale), 3) for x in ends)


def _clean(value: float) -> float:
    """Rounding of the last bits is not a result: below 1e-6 µm (µrad) it is zero."""
    return 0.0 if abs(value) < 1e-6 else value


def large(value: float, unit: str) -> str:
    """A length in mm with 5 decimals, an angle in deg with 6."""
    return f"{value:.5f}" if unit == "mm" else f"{math.degrees(value):.6f}°"


def small(value: float, unit: str) -> str:
    """A small difference in µm (a plain number) or µrad; an en dash when it is not finite."""
    if not math.isfinite(value):
        return "–"
    word, scale = SMALL[unit]
    return r.number(_clean(value * scale), 3) + ("" if unit == "mm" else f" {word}")


def pictures(found: UncertaintyResult) -> list[str]:
    """The part in the machine, and the part with the ellipsoids of its touches."""
    task = found.model.task
    t = task.touches
    features = list(task.part.features.values())
    last = t.pose.apply(t.points[-1:] + t.tip_radius[-1] * t.normals[-1:])[0]
    stylus = task.plan.styli[task.plan.steps[-1].stylus]
    overview = [
        *volume_items(task.machine, stylus, last),
        *part_items(features, t.pose, task.part.mesh),
        *touch_items(t),
    ]
    close = [
        *part_items(features, t.pose, task.part.mesh),
        *touch_items(t, touch_covariances(task, found.model.influences)),
    ]
    return [
        r.scene(
            overview,
            title="Part in the machine",
            caption="Machine frame; the wire box is the reach of the tip.",
        ),
        r.scene(
            close,
            title="Touches and their standard uncertainty",
            caption="Ellipsoids: all Inputs together, k = 1.",
        ),
    ]


def characteristic_blocks(c: CharacteristicResult) -> list[str]:
    """Decision zones, distribution, budget bars and table."""
    word, scale = SMALL[c.unit]
    blocks = []
    charts = [_zones(c, word, scale), _histogram(c, word, scale)]
    bars = [(b.input, b.u * scale) for b in c.budget if b.u > 1e-3 * c.expanded][:8]
    if bars:
        charts.append(
            r.bars(
                bars,
                unit=word,
                title="Budget: contributions u_i",
                total=c.u * scale if math.isfinite(c.u) else None,
            )
        )
    shown = [x for x in charts if x]
    blocks += [r.columns(*shown)] if shown else []
    blocks.append(budget_table(c))
    return blocks


def _zones(c: CharacteristicResult, word: str, scale: float) -> str:
    if c.tolerance is None or c.decision is None or not math.isfinite(c.u):
        return ""
    low, high = ((t - c.nominal) * scale if math.isfinite(t) else None for t in c.tolerance)
    guard = c.decision.guard if c.decision.guard is not None else 1.645 * c.u
    lower = None if c.type not in ("size", "distance", "angle") else low
    title = f"Deviation from nominal, {c.decision.rule} (ISO 14253-1)"
    return r.zones(
        lower, high, (c.value - c.nominal) * scale, c.expanded * scale, guard * scale, unit=word, title=title
    )


def _histogram(c: CharacteristicResult, word: str, scale: float) -> str:
    if c.summary is None:
        return ""
    edges, counts = c.summary.histogram
    edges, counts = _coarse((edges - c.nominal) * scale, counts)
    interval = ((c.interval[0] - c.nominal) * scale, (c.interval[1] - c.nominal) * scale)
    marks = [("mean", (c.value - c.nominal) * scale)]
    title = f"Distribution of the measured value, {c.trials:,} trials"
    return r.histogram(
        edges, counts, x_label=f"deviation from nominal / {word}", title=title, interval=interval, marks=marks
    )


def _coarse(edges: np.ndarray, counts: np.ndarray, bars: int = 80) -> tuple[np.ndarray, np.ndarray]:
    """The filled part of a fine histogram in about 80 bars."""
    total = counts.cumsum()
    inside = np.flatnonzero((total > 5e-4 * total[-1]) & (total < (1 - 5e-4) * total[-1]))
    first, last = (inside[0], inside[-1] + 1) if len(inside) > 1 else (0, len(counts))
    width = max(1, (last - first) // bars)
    last = first + max(1, (last - first) // width) * width
    return edges[first : last + 1 : width], counts[first:last].reshape(-1, width).sum(axis=1)


def budget_table(c: CharacteristicResult) -> str:
    """EA-4/02 columns: quantity, estimate, u, law, degrees of freedom, redraw, sensitivity, contribution, share."""
    word, scale = SMALL[c.unit]
    columns = [
        "quantity",
        "estimate",
        "u(x)",
        "law",
        "ν",
        "drawn per",
        f"c / ({word}/unit)",
        f"u_i / {word}",
        "share",
    ]
    rows = [_budget_row(c, b, scale) for b in c.budget if b.u > 1e-4 * c.expanded or b is c.budget[0]]
    left = len(c.budget) - len(rows)
    if left:
        rows.append([f"{left} further, each under 10⁻⁴ U", *[""] * 8])
    if math.isfinite(c.interaction_share) and abs(c.interaction_share) > 5e-4:
        rows.append(["what inputs do only together", *[""] * 7, f"{c.interaction_share:.1%}"])
    total = f"u = {r.number(c.u * scale, 3)} {word}, k = {r.number(c.k, 3)}, U = {r.number(c.expanded * scale, 3)} {word} (p = {c.p:.0%})"
    return r.table(columns, rows, numeric=(1, 2, 4, 6, 7, 8), foot=[[total, *[""] * 8]])


def _budget_row(c: CharacteristicResult, b: BudgetLine, scale: float) -> list[object]:
    dof = r.number(b.dof, 3) if math.isfinite(b.dof) else "∞"
    sensitivity = "–" if b.sensitivity is None else r.number(b.sensitivity * scale, 3)
    share = f"{b.share:.1%}" if math.isfinite(b.share) else "–"
    text = f"<strong>{r.escape(b.what)}</strong><br><small>{r.escape(b.input)}{': ' if b.evidence else ''}{r.escape(b.evidence)}</small>"
    u_unit = "K" if b.unit == "degC" else b.unit
    return [
        r.Raw(text), _quantity(b.estimate, b.unit), _quantity(b.u_input, u_unit), b.distribution, dof, b.redraw,
        sensitivity, r.number(b.u * scale, 3), share,
    ]  # fmt: skip


def _quantity(value: float | None, unit: str) -> str:
    """A number in the unit of its parameter."""
    words = {"degC": "°C", "1": ""}
    return "–" if value is None else f"{r.number(value, 4)} {words.get(unit, unit)}".strip()


def computed_table(found: UncertaintyResult) -> str:
    """Which tier answered, how many trials, and the certified error of the linear model."""
    rows = [
        [
            c.name,
            c.tier,
            f"{c.trials:,}" if c.trials else "–",
            _certified(c),
            "yes" if c.coverage_shown else r.Cell("not shown", kind="warning"),
        ]
        for c in found.characteristics
    ]
    columns = ["characteristic", "tier", "trials", "largest |linear - exact|", "coverage shown"]
    caption = "The linear model is compared with multiplied transforms, contact and iterated fits on the same draws."
    return r.table(columns, rows, numeric=(2, 3), caption=caption)


def _certified(c: CharacteristicResult) -> str:
    if not math.isfinite(c.linear_error):
        return "not checked"
    return f"{r.number(c.linear_error * 1e6, 2)} {'nm' if c.unit == 'mm' else 'µrad'}"
