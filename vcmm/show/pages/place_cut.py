"""The report of a placement on a machine tool: the map, the gain of each characteristic, its certainty."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.answer.placing.words import region_text
from vcmm.show import charts as draw
from vcmm.show.pages.header import facts
from vcmm.show.report import blocks as r
from vcmm.show.tables.answers import placed_cut_answers
from vcmm.show.tables.placement import compared_cut_poses, gains
from vcmm.show.tables.table import html, listing

if TYPE_CHECKING:
    from vcmm.shop.machining.placement import PlacedCut
    from vcmm.shop.machining.scenario import CutScenario


def place_cut_page(scenario: CutScenario, placed: PlacedCut) -> str:
    """Return one self-contained HTML file."""
    blocks = [
        r.heading("Poses"),
        html(compared_cut_poses(placed)),
        r.heading("What each characteristic gains"),
        html(gains(placed)),
    ]
    blocks += [r.heading("Map over the table"), _map(placed)]
    sure = [["certificate", placed.certificate.text], ["flatness", region_text(placed)]]
    blocks += [r.heading("How sure, how flat"), html(listing("", ["", ""], sure, words=(0, 1)))]
    footer = f"vcmm {__version__}, seed {placed.seed}. Part and work offset move together; the program stays as it is."
    return r.page(
        f"Placement report: {scenario.name}",
        blocks,
        footer=footer,
        answers=placed_cut_answers(placed),
        facts=facts(
            "", scenario.machine.name, scenario.record, placed.seed, [("program", scenario.program.name)]
        ),
    )


def _map(placed: PlacedCut) -> str:
    chart = placed.map
    if len(chart.names) < 2:
        return r.paragraph("One degree of freedom or none: no map.")
    return draw.on_page(draw.heat_map,
        chart.values, chart.x, chart.y, x_label=f"{chart.names[0]} / mm", y_label=f"{chart.names[1]} / mm", unit="",
        title="objective", marks=[("found", placed.best.pose[0], placed.best.pose[1]), ("present", placed.present.pose[0], placed.present.pose[1])],
        ax=draw.ChartSheet(900, 480))  # fmt: skip
