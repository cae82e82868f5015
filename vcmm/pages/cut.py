"""The report of a virtual cut: decisions, colour maps of the surface, who owns the deviation, how it was computed."""

from __future__ import annotations

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.cutting.solid import picture as stock_mesh
from vcmm.evaluation.result import CharacteristicResult
from vcmm.machining.result import CutResult, Patch, expected
from vcmm.machining.scenario import CutScenario
from vcmm.machining.turned_blank import TurnedBlank, mesh
from vcmm.pages.uncertainty import STATE, characteristic_blocks, computed_table, large, small, span

GROUP_WORDS = {
    "machine": "machine tool", "tool": "tool", "setup": "set-up", "part": "part",
    "measurement": "measurement",
}  # fmt: skip


def cut_page(scenario: CutScenario, found: CutResult) -> str:
    """One self-contained HTML file."""
    blocks = [r.heading("The finished part"), parts_table(found), owners(found)]
    blocks += [r.note(w, "warning") for w in found.warnings]
    blocks += [
        r.heading("The cut surface"),
        surface_table(found),
        picture(found),
        *stock_picture(found),
        *maps(found),
    ]
    for c in found.characteristics:
        blocks += [r.heading(f"{c.name} ({c.type})"), *characteristic_blocks(c)]
    blocks += [r.heading("How it was computed"), computed_table(found.uncertainty)]
    footer = (
        f"vcmm {__version__}, seed {found.uncertainty.seed}. Machining error = actual - commanded; departure of the "
        "surface along the outward normal, plus is material left."
    )
    return r.page(
        f"Virtual machining: {scenario.name}",
        blocks,
        subtitle=f"{scenario.program.name} on {scenario.machine.name}",
        footer=footer,
    )


def parts_table(found: CutResult) -> str:
    """What to expect of each characteristic, and whether it will conform."""
    rows = [
        [
            c.name, large(c.nominal, c.unit), small(expected(c), c.unit), small(c.bias, c.unit), small(c.expanded, c.unit),
            span(c.interval, c), "–" if c.tolerance is None else span(c.tolerance, c), _decided(c),
            "–" if c.decision is None or c.decision.p_conform is None else f"{c.decision.p_conform:.1%}",
        ]
        for c in found.characteristics
    ]  # fmt: skip
    columns = [
        "characteristic",
        "nominal",
        "deviation",
        "known errors",
        "U",
        "interval",
        "tolerance",
        "decision",
        "conforms with",
    ]
    first = found.characteristics[0]
    caption = (
        f"Deviation to expect, of it by the known errors of the machine, and coverage interval for p = {first.p:.0%}; lengths "
        "in mm and µm, angles in deg and µrad."
    )
    return r.table(columns, rows, numeric=(1, 2, 3, 4, 5, 6, 8), caption=caption)


def _decided(c: CharacteristicResult) -> object:
    return "–" if c.decision is None else r.Cell(c.decision.text, kind=STATE[c.decision.text])  # type: ignore[arg-type]


def owners(found: CutResult) -> str:
    """Whose uncertainty it is, and what of it a batch shares."""
    names = list(GROUP_WORDS)
    rows = [
        [
            c.name, small(c.u, c.unit), *[f"{found.shares[c.name][n]:.0%}" for n in names],
            small(found.repeats[c.name], c.unit), small(found.scatters[c.name], c.unit),
        ]
        for c in found.characteristics
    ]  # fmt: skip
    columns = ["characteristic", "u", *GROUP_WORDS.values(), "u repeats", "u scatters"]
    caption = (
        "Shares of u² by owner. What repeats is common to all parts cut with this set-up; what scatters differs from part to "
        "part."
    )
    return r.table(columns, rows, numeric=tuple(range(1, len(columns))), caption=caption)


def surface_table(found: CutResult) -> str:
    s = found.surface
    minutes, seconds = divmod(found.seconds, 60)
    rows = [
        ["largest departure", f"{s.max_um:.2f} µm"],
        ["rms departure", f"{s.rms_um:.2f} µm"],
        ["points looked at, on nets over all features", f"{s.points:,}"],
        ["of these left uncut", f"{s.uncut:,}"],
        [f"of these gouged by the program itself, deeper than {s.deep_um:g} µm", f"{s.gouges:,}"],
        ["contacts against displaced tools", f"{found.recut.largest * 1e3:.3f} µm" if found.recut else "–"],
        ["cycle time", f"{minutes:.0f} min {seconds:.1f} s"],
    ]
    return r.table(["", ""], rows, numeric=(1,))


def picture(found: CutResult) -> str:
    """All patches in their colours, drawing frame."""
    items = []
    for patch in found.patches:
        height = patch.height * 1e3
        items.append(
            r.Mesh(
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


def stock_picture(found: CutResult) -> list[str]:
    """What is left of the blank; of a map of heights every few nodes."""
    if found.blank is None:
        return []
    if isinstance(found.blank, TurnedBlank):
        return [_turned_picture(found.blank)]
    vertices, faces = stock_mesh(found.blank.after, MOST_FACES)
    removed = f"{found.blank.removed / 1e3:.1f} cm³ removed; kept as {found.blank.kept_as}, workpiece axes of the machine."
    return [
        r.scene([r.Mesh(vertices, faces, edges=False)], title="What is left of the stock", caption=removed)
    ]


def _turned_picture(blank: TurnedBlank) -> str:
    vertices, faces = mesh(blank.after, max(1, len(blank.after.z) // 300))
    removed = f"{blank.removed / 1e3:.1f} cm³ removed; machine axes."
    return r.scene([r.Mesh(vertices, faces, edges=False)], title="What is left of the bar", caption=removed)


def maps(found: CutResult) -> list[str]:
    """A flat map of each feature, two side by side."""
    charts = [_map(p) for p in found.patches if np.isfinite(p.height).any()]
    return [r.columns(*charts[i : i + 2]) for i in range(0, len(charts), 2)]


def _map(patch: Patch) -> str:
    net = patch.net
    first, second = (
        np.degrees(v) if "deg" in label else v for v, label in zip((net.first, net.second), net.labels)
    )
    values = (patch.height * 1e3).reshape(len(second), len(first))
    return r.heat_map(
        values, first, second, x_label=net.labels[0], y_label=net.labels[1], unit="µm",
        title=f"{net.feature}: departure along the normal", symmetric=True,
    )  # fmt: skip
