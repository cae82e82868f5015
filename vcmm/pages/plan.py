"""The report of a chosen plan: U against measuring time, the chosen touches on the part, who measures what."""

from __future__ import annotations

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.core.pose import Pose
from vcmm.gps import characteristics as gps
from vcmm.measuring.scenario import Scenario
from vcmm.pages.view import part_items
from vcmm.placing.planning import PlanPoint, PlanResult
from vcmm.tables.planned import curve
from vcmm.tables.quantities import SMALL_SCALE
from vcmm.tables.table import SMALL, html


def plan_page(scenario: Scenario, found: PlanResult) -> str:
    """One self-contained HTML file."""
    blocks = [r.heading("U against measuring time"), *_curves(scenario, found), _table(scenario, found)]
    blocks += [r.heading("The chosen touches"), _picture(scenario, found)]
    footer = f"vcmm {__version__}. U in closed form, form of the part included; time as planned, with {found.budget_s:g} s allowed."
    return r.page(f"Measuring plan: {scenario.name}", blocks, subtitle=scenario.machine.name, footer=footer)


def _units(scenario: Scenario) -> dict[str, str]:
    return {c.name: gps.unit(c) for c in scenario.part.characteristics}


def _curves(scenario: Scenario, found: PlanResult) -> list[str]:
    """One curve per characteristic, with the present and the chosen plan as dots; two side by side."""
    charts = []
    for name, unit in _units(scenario).items():
        if name not in found.chosen.expanded:
            continue
        word, scale = SMALL[unit], SMALL_SCALE[unit]

        def dots(
            points: list[PlanPoint], title: str, line: bool, name: str = name, scale: float = scale
        ) -> r.PlotSeries:
            x, y = [p.minutes for p in points], [p.expanded[name] * scale for p in points]
            return r.PlotSeries(x, y, title, marker=not line, line=line)

        series = [
            dots(list(found.pareto), "best plans", True),
            dots([found.chosen], "chosen", False),
            dots([found.present], "present", False),
        ]
        charts.append(r.curve(series, x_label="measuring time / min", y_label=f"U / {word}", title=name))
    return [r.columns(*charts[i : i + 2]) for i in range(0, len(charts), 2)]


def _table(scenario: Scenario, found: PlanResult) -> str:
    """The present plan, then ten of the curve, the chosen one among them."""
    some = {int(i) for i in np.linspace(0, len(found.pareto) - 1, 10)}
    shown = [p for i, p in enumerate(found.pareto) if i in some or p is found.chosen]
    return html(curve(scenario, found, shown))


def _picture(scenario: Scenario, found: PlanResult) -> str:
    points = np.concatenate([step.points for step in found.plan.steps])
    items = [
        *part_items(list(scenario.part.features.values()), Pose.identity(), scenario.part.mesh),
        r.Points(points, "accent", 2.4),
    ]
    return r.scene(
        items,
        title="Touches",
        caption=f"{len(points)} touches in {found.chosen.minutes:.2f} min; drawing frame.",
    )
