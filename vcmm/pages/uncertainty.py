"""The report of an uncertainty evaluation: results, decisions, budgets, pictures, how it was computed."""

from __future__ import annotations

import math
import re

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.pages.view import part_items, touch_covariances, touch_items, volume_items
from vcmm.result import CharacteristicResult, UncertaintyResult
from vcmm.scenario import Scenario

STATE = {"conforms": "good", "undecided": "warning", "does not conform": "bad"}
SMALL = {"mm": ("µm", 1e3), "rad": ("µrad", 1e6)}


def uncertainty_page(scenario: Scenario, found: UncertaintyResult) -> str:
    """One self-contained HTML file."""
    blocks = [r.heading("Results"), result_table(found), *(r.note(w, "warning") for w in found.warnings)]
    blocks += [r.heading("Where it was measured"), *pictures(found)]
    for c in found.characteristics:
        blocks += [r.heading(f"{c.name} ({c.type})"), *characteristic_blocks(c)]
    blocks += [r.heading("How it was computed"), computed_table(found)]
    footer = f"vcmm {__version__}, seed {found.seed}. Error = indicated - true. Standard uncertainty u, coverage interval for p."
    return r.page(
        f"Measurement uncertainty: {scenario.name}", blocks, subtitle=scenario.machine.name, footer=footer
    )


def result_table(found: UncertaintyResult) -> str:
    """characteristic | nominal | tolerance | y | bias | U | U/T | decision | main contributor."""
    columns = [
        "characteristic",
        "nominal",
        "tolerance",
        "y",
        "bias",
        "U",
        "U/T",
        "decision",
        "main contributor",
    ]
    p = found.characteristics[0].p
    caption = f"U: half the {p:.0%} coverage interval. U/T: U over the width of the tolerance."
    return r.table(
        columns, [_row(c) for c in found.characteristics], numeric=(1, 2, 3, 4, 5, 6), caption=caption
    )


def _row(c: CharacteristicResult) -> list[object]:
    decision: object = "–"
    if c.decision is not None:
        decision = r.Cell(c.decision.text, kind=STATE[c.decision.text])  # type: ignore[arg-type]
    ratio = "–"
    if c.tolerance is not None and all(map(math.isfinite, c.tolerance)):
        ratio = f"{c.expanded / (c.tolerance[1] - c.tolerance[0]):.1%}"
    return [
        c.name, large(c.nominal, c.unit), _tolerance(c), large(c.value, c.unit), small(c.bias, c.unit),
        small(c.expanded, c.unit), ratio, decision, main_contributor(c),
    ]  # fmt: skip


def main_contributor(c: CharacteristicResult) -> str:
    """The effect behind the largest line of the budget, with its share."""
    if not c.budget or not math.isfinite(c.budget[0].share):
        return "–"
    effect = re.split(r"[\[.]", c.budget[0].input.removeprefix("channel."))[0]
    return f"{effect.replace('_', ' ')} {c.budget[0].share:.0%}"


def large(value: float, unit: str) -> str:
    """A length in mm with 5 decimals, an angle in deg with 6."""
    return f"{value:.5f} mm" if unit == "mm" else f"{math.degrees(value):.6f}°"


def small(value: float, unit: str) -> str:
    """A small difference in µm or µrad; an en dash when it is not finite."""
    word, scale = SMALL[unit]
    return f"{r.number(value * scale, 3)} {word}" if math.isfinite(value) else "–"


def _tolerance(c: CharacteristicResult) -> str:
    if c.tolerance is None:
        return "–"
    word, scale = SMALL[c.unit]
    low, high = (r.number((t - c.nominal) * scale, 4) for t in c.tolerance)
    return f"{low} … {high} {word}"


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
    bars = [(b.input, b.u * scale) for b in c.budget if b.u > 0][:8]
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
    blocks.append(r.details("Budget table", budget_table(c)))
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
    """EA-4/02 columns: quantity, estimate, u, law, redraw, sensitivity, contribution, share."""
    word, scale = SMALL[c.unit]
    columns = [
        "input",
        "estimate",
        "u(x)",
        "law",
        "redraw",
        "sensitivity",
        f"u_i / {word}",
        "share",
        "evidence",
    ]
    rows = [
        [
            b.input, _estimate(b.estimate, b.unit), _estimate(b.u_input, b.unit), b.distribution, b.redraw,
            r.number(b.sensitivity, 3), r.number(b.u * scale, 3), f"{b.share:.1%}" if math.isfinite(b.share) else "–", b.evidence,
        ]
        for b in c.budget
    ]  # fmt: skip
    foot = [
        [
            "interaction",
            "",
            "",
            "",
            "",
            "",
            "",
            f"{c.interaction_share:.1%}" if math.isfinite(c.interaction_share) else "–",
            "what Inputs do only together",
        ]
    ]
    foot.append(
        [
            "together",
            "",
            "",
            "",
            "",
            "",
            r.number(c.u * scale, 3),
            "",
            f"U = {small(c.expanded, c.unit)}, k = {r.number(c.k, 3)}",
        ]
    )
    return r.table(columns, rows, numeric=(1, 2, 5, 6, 7), foot=foot)


def _estimate(value: float | None, unit: str) -> str:
    """A canonical number in the unit of its parameter."""
    from vcmm.units import in_unit

    if value is None:
        return "–"
    return f"{r.number(in_unit(value, unit), 4)} {unit}" if unit not in ("", "1") else r.number(value, 4)


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
