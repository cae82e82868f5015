"""The report of an uncertainty evaluation: results, decisions, budgets, pictures, method.

Pictures of the tolerance zones of measured parts: flatness, roundness and position, with the measured points in them.

The picture of deviations: departure of the surface of a part from its nominal one, at every point that was touched.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.answer.evaluation.result import (
    CharacteristicResult,
    UncertaintyResult,
    budget_interaction,
    common_causes,
)
from vcmm.answer.evaluation.truth import PredictedPart
from vcmm.core.pose import Pose
from vcmm.part.alignment import align
from vcmm.part.gps.zone_points import (
    FlatPoints,
    PlacedAxis,
    RoundPoints,
    least_squares_circle,
    minimum_zone_circles,
    zone_points,
)
from vcmm.show import charts as draw
from vcmm.show.charts.distribution import coarsen
from vcmm.show.pages.callouts import callout_picture
from vcmm.show.pages.header import facts, files_block
from vcmm.show.pages.view import Item, part_items, rounded_down, task_in_machine, touch_names, touches_of
from vcmm.show.report import blocks as r
from vcmm.show.report.blocks import Lines, Points
from vcmm.show.tables.quantities import SMALL_SCALE
from vcmm.show.tables.stated import how_well_known
from vcmm.show.tables.table import FINE_UNITS, ResultTable, html, on_page
from vcmm.show.tables.uncertainty import (
    BUDGET,
    budget_rows,
    computation_table,
    more_than_rounding,
    not_covered,
    results,
    stated_with,
    undecided_because,
)

if TYPE_CHECKING:
    from vcmm.answer.evaluation.linear import LinearModel
    from vcmm.core.run import Array
    from vcmm.part.characteristic import Characteristic
    from vcmm.task.measuring.scenario import Scenario
    from vcmm.task.measuring.task import Task

SHARE = 12.0  # the longest needle is at most so small a part of the size of the part
MATERIAL_KINDS = (("bad", "material left over", 1.0), ("accent", "material missing", -1.0))


def deviations_block(task: Task) -> list[str]:
    """Return the scene, or nothing where no touch has a deviation (n,) mm along its outward normal (`task.form`)."""
    if not task.form.any():
        return []
    factor = magnification(task.touches.points, task.form)
    return [
        r.scene(
            deviation_items(task, factor),
            title="Deviations of the points",
            caption=f"From the nominal surface along its normal, less the known error of the machine, drawn {factor:,.0f} times too long; "
            f"from {1e3 * task.form.min():+.2f} to {1e3 * task.form.max():+.2f} µm. Point at a dot to read it.",
        )
    ]


def magnification(points: Array, deviations: Array) -> float:
    """Return a round factor by which the longest needle is about a twelfth of the part, or less."""
    return rounded_down(float(np.ptp(points, axis=0).max()) / SHARE / float(np.abs(deviations).max()))


def deviation_items(task: Task, factor: float) -> list[Item]:
    """Return the part, and a needle from every touched place to the surface, `factor` times too long; by sign in two colours."""
    t, form = task.touches, task.form
    names = touch_names(t)
    items: list[Item] = [*part_items(list(task.part.features.values()), t.pose, task.part.mesh)]
    for colour, name, sign in MATERIAL_KINDS:
        rows = np.flatnonzero(sign * form > 0)
        if len(rows):
            labels = [f"{names[i]}\ndeviation {1e3 * form[i]:+.2f} µm" for i in rows]
            feet = t.pose.apply(t.points[rows])
            tips = feet + factor * form[rows, None] * t.pose.turn(t.normals[rows])
            items += [
                Lines(np.stack([feet, tips], axis=1), colour, 2.0, name=name),
                Points(tips, colour, 1.8, hover=labels),
            ]
    return items


def zone_picture(model: LinearModel, c: Characteristic) -> list[str]:
    """Return the zone of one characteristic with the measured points; nothing for other types, and without points."""
    task = model.task
    if not task.form.any():
        return []
    features, scheme = task.part.features, task.plan.alignment
    pose = None if scheme is None else align(scheme, features, model.base, Pose.identity())
    places = {name: task.touches.points[rows] for name, rows in task.touches.rows.items()}
    shown = zone_points(c, features, model.base, places, pose)
    zone = None if c.zone is None else 1e3 * c.zone
    if isinstance(shown, FlatPoints):
        title = f"{c.name}: points as indicated, in the zone"
        return [draw.on_page(draw.flatness_zone, shown.along, 1e3 * shown.residual, zone, title=title)]
    if isinstance(shown, PlacedAxis):
        title = f"{c.name}: as indicated, in the zone"
        return [draw.on_page(draw.position_zone, 1e3 * shown.off, zone, 1e3 * shown.size_bonus, title=title)]
    return [] if shown is None else [_round(c, shown)]


def _round(c: Characteristic, shown: RoundPoints) -> str:
    order = np.argsort(shown.angle, kind="stable")
    angle, raw = shown.angle[order], 1e3 * shown.residual[order]
    lines = [draw.PolarTrace("unfiltered", angle, raw, "c1" if shown.filtered is None else "c6", thin=True)]
    kept = raw
    if shown.filtered is not None:
        kept = 1e3 * shown.filtered[order]
        lines.append(draw.PolarTrace("filtered", angle, kept, "c1"))
    circles = []
    for name, element, zone in (
        ("LSC", least_squares_circle, False), ("MZC", minimum_zone_circles, True),
    ):  # fmt: skip
        (radius, x, y), width = element(angle, kept)
        circles.append(draw.ReferenceCircle(name, float(radius), float(x), float(y), width, zone=zone))
    return draw.on_page(draw.traces, lines, title=f"{c.name}: profile as indicated", circles=circles)


PREDICTED, MEASURED = "Virtual measurement report", "Measurement result"


def uncertainty_page(
    scenario: Scenario, result: UncertaintyResult, files: Sequence[Path] = (), title: str = PREDICTED
) -> str:
    """Return one self-contained HTML file. files: all files read; title: of a prediction, or of a measurement (`MEASURED`)."""
    characteristics = result.characteristics
    why = [
        *stated_with(characteristics),
        *undecided_because(characteristics),
        *not_covered(characteristics),
        *how_well_known(characteristics),
    ]
    leaves = [
        [
            r.heading("Results"),
            html(results(result)),
            *_on_the_part(result),
            *(r.note(w) for w in why),
            *r.notices(result.warnings),
            r.heading("What was assumed"),
            assumptions(scenario, result),
        ],
        [
            r.heading("Where it was measured"),
            *pictures(result),
            *deviations_block(result.model.task),
            r.heading("How it was computed"),
            html(computation_table(result)),
        ],
    ]
    part = "a part with this form" if result.model.task.form.any() else "the nominal part"
    leaves += [
        [
            r.heading(f"{c.name} ({c.type})"),
            *zone_picture(result.model, characteristic),
            *characteristic_blocks(c, part),
        ]
        for c, characteristic in zip(result.characteristics, result.model.characteristics)
    ]
    blocks = [r.leaf(*leaf) for leaf in leaves] + files_block(files)
    footer = f"vcmm {__version__}, seed {result.seed}. Error = indicated - true. Standard uncertainty u, coverage interval for p."
    return r.page(
        f"{title}: {scenario.name}",
        blocks,
        footer=footer,
        answers=[r.answer_of(c) for c in result.characteristics],
        facts=facts("", scenario.machine.name, scenario.record, result.seed),
    )


def assumptions(scenario: Scenario, result: UncertaintyResult) -> str:
    """Return machine, pose, styli, touches, temperatures, decision rule, which an assessor checks first."""
    task, machine = result.model.task, scenario.machine
    turns = ", ".join(f"{math.degrees(t):.4g}" for t in scenario.pose.turns())
    shift = ", ".join(f"{v:.6g}" for v in scenario.pose.shift)
    styli = "; ".join(
        f"{s.name}: tip Ø {2 * s.tip_radius:g} mm at ({', '.join(f'{v:g}' for v in s.offset)}) mm, "
        + ("qualified" if s.name in scenario.qualifications else "assumed perfectly qualified")
        for s in scenario.plan.styli.values()
    )
    warm = [
        f"{k[5:-2].replace('_', ' ')} {v:g} °C"
        for k, v in scenario.constants.items()
        if k.startswith("temp_") and k != "temp_gradient_C"
    ]
    counts = ", ".join(f"{name} {len(rows)}" for name, rows in task.touches.rows.items())
    rule = next((c.decision.rule for c in result.characteristics if c.decision), scenario.settings.rule)
    rows = [
        ["machine", f"{machine.name}, structure {machine.chain.structure}, error state {machine.state}"],
        ["part in the machine", f"shift ({shift}) mm, turned ({turns})° about fixed x, y, z"],
        ["touches", f"{task.touches.run.n}: {counts}"],
        ["styli", styli],
        ["temperatures", ", ".join(warm) or "20 °C throughout"],
        [
            "decision",
            f"{rule}, ISO 14253-1:2017; limits are compared with {_comparison_text(scenario, result)}",
        ],
    ]
    return r.table(["", ""], rows)


def _comparison_text(scenario: Scenario, result: UncertaintyResult) -> str:
    """Return the value that is compared with limits: extreme values use the interval of the true value, for any treatment of a bias."""
    by_belts = [
        c.true_value is not None and c.true_value.counted_coverage is not None for c in result.characteristics
    ]
    other = f"the {'corrected' if scenario.settings.known_bias == 'corrected' else 'indicated'} value"
    if not any(by_belts):
        return other
    true = "the interval of the true value"
    return true if all(by_belts) else f"{other} of sizes, distances and angles, with {true} of all else"


def _on_the_part(result: UncertaintyResult) -> list[str]:
    """Return the results with leader lines to their features."""
    task = result.model.task
    places = {name: task.touches.points[rows] for name, rows in task.touches.rows.items()}
    return callout_picture(task.part, result.characteristics, places)


def pictures(result: UncertaintyResult) -> list[str]:
    """Return the part in the machine, and the part with the ellipsoids of its touches."""
    overview, close = scenes(result)
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


def scenes(result: UncertaintyResult) -> tuple[list[Item], list[Item]]:
    """Return the items of both pictures."""
    task = result.model.task
    return task_in_machine(task), touches_of(task, result.model.influences)


def characteristic_blocks(c: CharacteristicResult, part: str = "the nominal part") -> list[str]:
    """Return the decision zones, distribution, budget bars and table. part: whose indicated values the trials are."""
    return [*characteristic_charts(c, part), *_waterfall(c), budget_table(c)]


def _waterfall(c: CharacteristicResult) -> list[str]:
    """Return the waterfall of u from its contributions; nothing where one alone makes it, or u has no value."""
    word, scale = FINE_UNITS[c.unit], SMALL_SCALE[c.unit]
    items = [(b.what or b.input, b.u * scale) for b in c.budget if b.u > 0 and math.isfinite(b.u)]
    if len(items) < 2 or not math.isfinite(c.u):
        return []
    figure = draw.on_page(
        draw.waterfall, items, c.u * scale, unit=word, title="How u grows: contributions added in quadrature"
    )
    return [
        f'<div class="on-screen">{figure}</div>'
    ]  # in print the bars and the table say the same on one page


def characteristic_charts(c: CharacteristicResult, part: str = "the nominal part") -> list[str]:
    """Return the decision zones, distribution and budget bars side by side; nothing where there is none of them."""
    word, scale = FINE_UNITS[c.unit], SMALL_SCALE[c.unit]
    charts = [decision_chart(c), _histogram(c, part)]
    bars = [(b.input, b.u * scale) for b in c.budget if b.u > 1e-3 * c.expanded][:8]
    if bars:
        charts.append(
            draw.on_page(
                draw.bars,
                bars,
                unit=word,
                title="Budget: contributions u_i",
                total=c.u * scale if math.isfinite(c.u) else None,
            )
        )
    shown = [x for x in charts if x]
    return [r.columns(*shown)] if shown else []


def decision_chart(c: CharacteristicResult) -> str:
    """Return the zones of ISO 14253-1 with the result; nothing where nothing is decided."""
    word, scale = FINE_UNITS[c.unit], SMALL_SCALE[c.unit]
    if c.tolerance is None or c.decision is None or not math.isfinite(c.u):
        return ""
    low, high = ((t - c.nominal) * scale if math.isfinite(t) else None for t in c.tolerance)
    guard = c.decision.guard if c.decision.guard is not None else 1.645 * c.u
    lower = None if c.type not in ("size", "distance", "angle") else low
    span = None
    counted = c.true_value is not None and c.true_value.counted_coverage
    if (counted or not _about_its_middle(c)) and all(map(math.isfinite, c.interval)):
        # what is decided by, about which what is indicated or expected may lie anywhere
        span, guard = (
            ((c.interval[0] - c.nominal) * scale, (c.interval[1] - c.nominal) * scale),
            c.decision.guard or 0.0,
        )
    title = f"Deviation from nominal, {c.decision.rule} (ISO 14253-1)"
    title += f"; undecided: {c.decision.reason}" if c.decision.reason else ""
    return draw.on_page(
        draw.zones,
        lower,
        high,
        (c.value - c.nominal) * scale,
        c.stated[0] * scale,
        guard * scale,
        unit=word,
        title=title,
        decision=c.decision.text,
        span=span,
        of="finished part" if isinstance(c.truth, PredictedPart) else "true value",
    )


def _about_its_middle(c: CharacteristicResult) -> bool:
    """Return whether the interval is value +- U to within a hundredth of U, so that both may replace it."""
    return abs(sum(c.interval) / 2 - c.value) <= 0.01 * c.expanded


def _histogram(c: CharacteristicResult, part: str) -> str:
    if c.summary is None:
        return ""
    word, scale = FINE_UNITS[c.unit], SMALL_SCALE[c.unit]
    edges, counts = c.summary.histogram
    edges, counts = coarsen((edges - c.nominal) * scale, counts)
    interval: tuple[float, float] | None = (
        (c.interval[0] - c.nominal) * scale,
        (c.interval[1] - c.nominal) * scale,
    )
    marks = {"y": (c.value - c.nominal) * scale, "mean": (c.summary.mean - c.nominal) * scale}
    y = "expected value" if isinstance(c.truth, PredictedPart) else "indicated value"
    title = f"Distribution of the {_quantity_text(c, part)}, {c.trials:,} trials; y: {y}"
    if c.true_value is not None:
        interval = None
    return draw.on_page(
        draw.distribution, edges, counts, unit=word, label=f"deviation from nominal / {word}", title=title, interval=interval,
        marks=marks)  # fmt: skip


def _quantity_text(c: CharacteristicResult, part: str) -> str:
    if isinstance(c.truth, PredictedPart):
        return "finished part"
    return "true value when y is indicated" if c.true_value is None else f"indicated value of {part}"


def budget_table(c: CharacteristicResult) -> str:
    """Return EA-4/02 columns: quantity, estimate, u, law, degrees of freedom, redraw, sensitivity, contribution, share."""
    word, scale = FINE_UNITS[c.unit], SMALL_SCALE[c.unit]
    rows = [row for row in budget_rows(c) if more_than_rounding(row)]
    table = ResultTable("", BUDGET, rows)
    blank = [""] * (len(on_page(table).heads) - 2)
    more: list[list[object]] = []
    left = len(c.budget) - len(rows)
    if left:
        rest = sum(b.share for b in c.budget) - sum(row.line.share for row in rows)
        more.append([f"{left} further, each below 0.05 %", *blank, f"{rest:.1%}"])
    for cause, (share, names) in common_causes(c.budget).items():
        more.append([f"by {cause}: {', '.join(names)}", *blank, f"{share:.1%}"])
    if rest := budget_interaction(c):
        more.append(["100 % less the shares above: interaction", *blank, f"{rest:.1%}"])
    total = f"u = {r.number(c.u * scale, 3)} {word}, k = {r.number(c.stated[1], 3)}, U = {r.number(c.stated[0] * scale, 3)} {word} (p = {c.p:.0%})"
    return html(table, more=more, foot=[[total, *blank, ""]])
