"""The report of a virtual cut: decisions, colour maps of the surface, main contributors, method."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.shop.cutting.solid import picture as stock_mesh
from vcmm.shop.machining.turned_blank import TurnedBlank, mesh
from vcmm.shop.motion.toolpath import clock
from vcmm.show import charts as draw
from vcmm.show import report as r
from vcmm.show.pages.callouts import callout_picture
from vcmm.show.pages.header import facts, files_block
from vcmm.show.pages.path import cut_path
from vcmm.show.pages.uncertainty import characteristic_blocks
from vcmm.show.tables.cut import finished_part, owners, surface
from vcmm.show.tables.table import html
from vcmm.show.tables.uncertainty import computation_table

if TYPE_CHECKING:
    from vcmm.shop.machining.result import CutResult, Patch
    from vcmm.task.measuring.cut_scenario import CutScenario


def cut_page(scenario: CutScenario, result: CutResult, files: Sequence[Path] = ()) -> str:
    """Return one self-contained HTML file. files: all files read."""
    blocks = [r.heading("The finished part"), html(finished_part(result)), html(owners(result))]
    places = {p.net.feature: p.net.points for p in result.patches}
    blocks += callout_picture(scenario.part, result.characteristics, places)
    blocks += r.notices(result.warnings)
    blocks += [
        r.heading("The cut surface"),
        html(surface(result)),
        picture(result),
        *stock_picture(result),
        *maps(result),
        r.heading("Along the program"),
        cut_path(scenario),
    ]
    for c in result.characteristics:
        blocks += [r.heading(f"{c.name} ({c.type})"), *characteristic_blocks(c)]
    blocks += [
        r.heading("How it was computed"),
        html(computation_table(result.uncertainty)),
        *files_block(files),
    ]
    footer = (
        f"vcmm {__version__}, seed {result.uncertainty.seed}. Machining error = actual - commanded; departure of the "
        "surface along the outward normal, plus is material left."
    )
    return r.page(
        f"Virtual machining report: {scenario.name}",
        blocks,
        footer=footer,
        answers=[r.answer_of(c) for c in result.characteristics],
        facts=facts(
            scenario.part.name if hasattr(scenario.part, "name") else "",
            scenario.machine.name,
            scenario.record,
            result.uncertainty.seed,
            [("program", scenario.program.name), ("cycle time", clock(result.seconds))],
        ),
    )


def picture(result: CutResult) -> str:
    """Return all patches in their colours, drawing frame."""
    items = []
    for patch in result.patches:
        height = patch.height * 1e3
        items.append(
            r.SceneMesh(
                patch.net.points,
                patch.net.faces,
                values=height,
                unit="µm",
                symmetric=True,
                edges=False,
                cull=False,
            )
        )
    if not items:
        return ""
    return r.scene(
        items,
        title="Departure of the surface",
        caption="Drawing frame; along the outward normal, red is material left.",
    )


MOST_FACES = 24_000  # of the picture of the stock: the scene refuses more than 30 000


def stock_picture(result: CutResult) -> list[str]:
    """Return the remaining blank; of a map of heights every few nodes."""
    if result.blank is None:
        return []
    if isinstance(result.blank, TurnedBlank):
        return [_turned_picture(result.blank)]
    vertices, faces = stock_mesh(result.blank.after, MOST_FACES)
    removed = f"{result.blank.removed_volume / 1e3:.1f} cm³ removed; kept as {result.blank.kept_as}, workpiece axes of the machine."
    return [
        r.scene(
            [r.SceneMesh(vertices, faces, edges=False)], title="What is left of the stock", caption=removed
        )
    ]


def _turned_picture(blank: TurnedBlank) -> str:
    vertices, faces = mesh(blank.after, max(1, len(blank.after.z) // 300))
    removed = f"{blank.removed_volume / 1e3:.1f} cm³ removed; machine axes."
    return r.scene(
        [r.SceneMesh(vertices, faces, edges=False)], title="What is left of the bar", caption=removed
    )


def maps(result: CutResult) -> list[str]:
    """Return a flat map of each feature, two side by side."""
    charts = [_map(p) for p in result.patches if np.isfinite(p.height).any()]
    return [r.columns(*charts[i : i + 2]) for i in range(0, len(charts), 2)]


def _map(patch: Patch) -> str:
    net = patch.net
    first, second = (
        np.degrees(v) if "deg" in label else v for v, label in zip((net.first, net.second), net.labels)
    )
    values = (patch.height * 1e3).reshape(len(second), len(first))
    return draw.on_page(draw.heat_map,
        values, first, second, x_label=net.labels[0], y_label=net.labels[1], unit="µm",
        title=f"{net.feature}: departure along the normal", symmetric=True)  # fmt: skip
