"""The report of a chosen plan: U against measuring time, the chosen touches on the part, the stylus of each feature."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.core.pose import Pose
from vcmm.part.gps import characteristics as gps
from vcmm.show import charts as draw
from vcmm.show.pages.header import facts
from vcmm.show.pages.view import part_items
from vcmm.show.report import blocks as r
from vcmm.show.tables.answers import plan_answers
from vcmm.show.tables.placement import curve
from vcmm.show.tables.quantities import SMALL_SCALE
from vcmm.show.tables.table import FINE_UNITS, html

if TYPE_CHECKING:
    from vcmm.answer.placing.planning import PlanPoint, PlanResult
    from vcmm.task.measuring.scenario import Scenario


def plan_page(scenario: Scenario, result: PlanResult) -> str:
    """Return one self-contained HTML file."""
    blocks = [r.heading("U against measuring time"), *_curves(scenario, result), _table(scenario, result)]
    blocks += [r.heading("The chosen touches"), _picture(scenario, result)]
    footer = f"vcmm {__version__}. U in closed form, form of the part included; time as planned, with {result.budget_s:g} s allowed."
    return r.page(
        f"Measuring plan: {scenario.name}",
        blocks,
        footer=footer,
        answers=plan_answers(result, _units(scenario)),
        facts=facts("", scenario.machine.name, scenario.record),
    )


def _units(scenario: Scenario) -> dict[str, str]:
    return {c.name: gps.unit(c) for c in scenario.part.characteristics}


def _curves(scenario: Scenario, result: PlanResult) -> list[str]:
    """Return one curve per characteristic, with the present and the chosen plan as dots; two side by side."""
    charts = []
    for name, unit in _units(scenario).items():
        if name not in result.choice.expanded:
            continue
        word, scale = FINE_UNITS[unit], SMALL_SCALE[unit]

        def dots(
            points: list[PlanPoint], title: str, line: bool, name: str = name, scale: float = scale
        ) -> draw.PlotSeries:
            x, y = [p.minutes for p in points], [p.expanded[name] * scale for p in points]
            return draw.PlotSeries(x, y, title, marker=not line, line=line)

        series = [
            dots(list(result.pareto), "best plans", True),
            dots([result.choice], "chosen", False),
            dots([result.present], "present", False),
        ]
        charts.append(
            draw.on_page(
                draw.curve, series, x_label="measuring time / min", y_label=f"U / {word}", title=name
            )
        )
    return [r.columns(*charts[i : i + 2]) for i in range(0, len(charts), 2)]


def _table(scenario: Scenario, result: PlanResult) -> str:
    """Return the present plan, then ten of the curve, the chosen one among them."""
    some = {int(i) for i in np.linspace(0, len(result.pareto) - 1, 10)}
    shown = [p for i, p in enumerate(result.pareto) if i in some or p is result.choice]
    return html(curve(scenario, result, shown))


def _picture(scenario: Scenario, result: PlanResult) -> str:
    points = np.concatenate([step.points for step in result.plan.steps])
    items = [
        *part_items(list(scenario.part.features.values()), Pose.identity(), scenario.part.mesh),
        r.Points(points, "accent", 2.4),
    ]
    return r.scene(
        items,
        title="Touches",
        caption=f"{len(points)} touches in {result.choice.minutes:.2f} min; drawing frame.",
    )
