"""The demo's report: Gaska 2014, five places, beside the paper's figures."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.core.pose import Pose
from vcmm.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.measuring.scenario import Scenario
from vcmm.pages.uncertainty import pictures
from vcmm.pages.view import machine_items, part_items, reach
from vcmm.papers.gaska2014.twin import CAPTION, NODES, PAPER_DISTANCE_U, PAPER_FORM_U, Row, field_scales
from vcmm.tables.quantities import fixed
from vcmm.tables.table import NUMBER_TEXT, Column, ResultTable, html

WHAT = (
    "Residual kinematic errors of a Leitz PMM 12106 after Gąska et al., Int. J. Adv. Manuf. Technol. 73 (2014) 497–507. "
    "Published and typed in: the 52 reference nodes, the standard deviations of 8 of them, ν = 13, the maxima and means, "
    "the interpolation, the results. Drawn, because unpublished: the other 44 nodes, the part, its five places, the plan, "
    "the probe and the tolerances."
)
CAUTION = (
    "No agreement is claimed: the paper does not say that its U is an output of its model (the part was measured by "
    "another procedure with a step gauge and a ring). The range shows what 200 machines give that all agree with the "
    "published maxima and means. Redrawing the field at each touch or once per run decides most of U; the paper's "
    "text allows both readings. Form: by the paper's recipe, coverage not shown."
)


def demo_page(
    scenario: Scenario, rows: Sequence[Row], draws: int, shown: UncertaintyResult, first: Sequence[str]
) -> str:
    """One self-contained HTML file. first: blocks of one plain part, which stand before the published one."""
    blocks = [
        r.heading("First: one part on one machine"),
        *first,
        r.heading("A published part at five places"),
        r.paragraph(WHAT),
        r.note(CAUTION, "warning"),
        r.heading("Results"),
        html(table(rows, draws)),
    ]
    blocks += [r.heading("Machine, part and places"), overview(scenario)]
    blocks += [r.heading("One place in detail"), *pictures(shown), *charts(rows)]
    footer = f"vcmm {__version__}, seed {scenario.settings.seed}. Error = indicated - true."
    return r.page("Measured virtually: how well", blocks, footer=footer)


def table(rows: Sequence[Row], draws: int) -> ResultTable[Row]:
    """Form and distance at every place beside the paper; the same in the terminal, the CSV and the report."""
    other = f"U, {draws} draws"
    columns: list[Column[Row]] = [
        Column("place", lambda row: row.place, csv="place"),
        Column("field per", lambda row: row.redraw, csv="redraw"),
        *_measured("form", "um", lambda row: row.form, PAPER_FORM_U, other),
        *_measured("distance", "mm", lambda row: row.distance, PAPER_DISTANCE_U, other),
        Column("form, distance", lambda row: f"{_text(row.form)}, {_text(row.distance)}", csv="decision"),
        Column(
            "main contributors",
            lambda row: f"{_main(row.form)}, {_main(row.distance)}",
            csv="main_contributor",
        ),
    ]
    title = "Gaska 2014 twin: compressor body at five places of a Leitz PMM 12106"
    on_page = f"{draws} draws: smallest and largest U over machines that agree with the published figures; paper: U of Table 3, µm."
    return ResultTable(title, columns, rows, CAPTION, on_page)


def _measured(
    what: str, unit: str, of: Callable[[Row], CharacteristicResult], paper: Mapping[str, float], other: str
) -> list[Column[Row]]:
    """Value, U, range of U over the draws, and U of the paper, of one characteristic."""
    value = fixed(2, scale=1e3) if unit == "um" else fixed(4)
    words = unit.replace("u", "µ")
    columns: list[Column[Row]] = [
        Column(
            f"{what} {unit}",
            lambda row: of(row).value,
            value,
            csv=f"{what}_{unit}",
            page_head=f"{what} / {words}",
        ),
        Column("U um", lambda row: of(row).expanded, UM, csv=f"{what}_U_um", page_head="U / µm"),
        Column(other, lambda row: span(getattr(row, f"{what}_range")), NUMBER_TEXT, csv=f"{what}_U_range_um"),
        Column("paper", lambda row: paper[row.place], fixed(1), csv=f"paper_{what}_U_um"),
    ]
    return [replace(c, file=c.writing.terminal) for c in columns]


UM = fixed(2, scale=1e3)


def _main(c: CharacteristicResult) -> str:
    """The largest line of a budget in short: field 98%."""
    line = c.budget[0]
    effect = re.split(r"[\[.]", line.input)[0]
    name = {"residual_field": "field", "probe_lobing": "lobing"}.get(effect, effect)
    return f"{name} {line.share:.0%}"


def _text(c: CharacteristicResult) -> str:
    return "–" if c.decision is None else c.decision.text


def span(ends: tuple[float, float]) -> str:
    return f"{ends[0] * 1e3:.2f} … {ends[1] * 1e3:.2f}"


def overview(scenario: Scenario) -> str:
    """The machine's reach, the 52 nodes with their standard deviations, the part at its five places."""
    stylus = next(iter(scenario.plan.styli.values()))
    features = list(scenario.part.features.values())
    low, high = reach(scenario.machine, stylus.offset)
    items = machine_items(low, high, scenario.pose.shift + [0, 0, 120], stylus)
    for name, pose in scenario.places.items():
        items += [body(pose), *part_items(features, pose)]
        items.append(r.Label(pose.shift + [0, 0, 150], name))
    scales = field_scales(scenario)
    covariances = np.einsum("ni,ij->nij", scales**2, np.eye(3))
    items += [
        r.Points(NODES, "muted", 1.5, name="reference nodes"),
        r.Ellipsoids(NODES, covariances, 2e4, "c4", name="d(X), d(Y), d(Z) of the nodes"),
    ]
    return r.scene(items, title="Places of the part among the reference nodes", view=(-74.0, 36.0))


def body(pose: Pose) -> r.SceneMesh:
    """The drawn body around the bore and between the faces."""
    vertices, faces = r.box_mesh([-94.0, -40.0, 10.0], [94.0, 40.0, 99.0])
    return r.SceneMesh(pose.apply(vertices), faces, "#b9c3cf", 0.55)


def charts(rows: Sequence[Row]) -> list[str]:
    """U by place for both redraw rules."""
    out = []
    for redraw in dict.fromkeys(row.redraw for row in rows):
        chosen = [row for row in rows if row.redraw == redraw]
        items = [(f"place {row.place}: distance", row.distance.expanded * 1e3) for row in chosen]
        out.append(
            r.bars(items, unit="µm", title=f"U of the distance, field redrawn per {redraw}", share="none")
        )
    return [r.columns(*out)]
