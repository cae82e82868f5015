"""The report of a placement on a machine tool: the map, what each characteristic gains, how sure."""

from __future__ import annotations

from vcmm import __version__
from vcmm import report as r
from vcmm.gps.characteristics import unit
from vcmm.machining.placement import PlacedCut
from vcmm.machining.scenario import CutScenario
from vcmm.pages.uncertainty import small
from vcmm.placing.tables import poses, region_text


def place_cut_page(scenario: CutScenario, found: PlacedCut) -> str:
    """One self-contained HTML file."""
    blocks = [r.heading("Poses"), _poses(found), r.heading("What each characteristic gains"), _gains(found)]
    blocks += [r.heading("Map over the table"), _map(found)]
    sure = [["certificate", found.certificate.text], ["flatness", region_text(found)]]  # type: ignore[arg-type]
    blocks += [r.heading("How sure, how flat"), r.table(["", ""], sure)]
    footer = f"vcmm {__version__}, seed {found.seed}. Part and work offset move together; the program stays as it is."
    return r.page(
        f"Place of the part: {scenario.name}", blocks, subtitle=scenario.machine.name, footer=footer
    )


def _poses(found: PlacedCut) -> str:
    rows = [
        [name, poses(at.pose)[0], r.number(at.value, 4)]
        for name, at in (
            ("found", found.best),
            ("present", found.present),
            ("median", found.median),
            ("worst", found.worst),
        )
    ]
    caption = "Objective: weighted |deviation| as a share of half the tolerance; the smaller the better."
    return r.table(["pose", "shift / mm", "objective"], rows, numeric=(2,), caption=caption)


def _gains(found: PlacedCut) -> str:
    rows = [
        [c.name, small(float(before), unit(c)), small(float(after), unit(c))]
        for c, before, after in zip(found.characteristics, found.present.deviations, found.best.deviations)
    ]
    caption = "Deviation by the known errors, µm (angles µrad)."
    return r.table(["characteristic", "present", "found"], rows, numeric=(1, 2), caption=caption)


def _map(found: PlacedCut) -> str:
    chart = found.map
    if len(chart.names) < 2:
        return r.paragraph("One degree of freedom or none: no map.")
    return r.heat_map(
        chart.values, chart.x, chart.y, x_label=f"{chart.names[0]} / mm", y_label=f"{chart.names[1]} / mm", unit="",
        title="objective", marks=[("found", found.best.pose[0], found.best.pose[1]), ("present", found.present.pose[0], found.present.pose[1])],
        width=900, height=480,
    )  # fmt: skip
