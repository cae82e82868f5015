"""The page of `vcmm calibrate thermal`: temperatures over time, the readings of the tip, and their residuals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.learn.calibration.thermal_search import ThermalFit
from vcmm.show import charts
from vcmm.show.charts import PlotSeries
from vcmm.show.pages.header import OF_MACHINES, facts
from vcmm.show.report import blocks as r
from vcmm.show.tables.answers_runs import thermal_answers
from vcmm.show.tables.table import html
from vcmm.show.tables.thermal import TermRow, terms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.core.machine import Machine
    from vcmm.learn.calibration.thermal import ThermalModel
    from vcmm.learn.calibration.thermal_terms import WarmReadings

MINUTE = 60.0  # s
DIRECTIONS = "XYZ"


def thermal_page(model: ThermalModel, machine: Machine, rows: Sequence[TermRow]) -> str:
    """Return one self-contained HTML file."""
    blocks = [r.heading("What was found"), html(terms(rows))]
    plain = ThermalFit(model.fit.parts, (), np.zeros(0))
    before = plain.solve(plain.lags, plain.weights())[1]
    after = model.fit.solve(model.lags, model.fit.weights())[1]
    for part, was, left in zip(model.fit.parts, before, after):
        blocks.append(r.heading(part.recording.name))
        blocks.append(charts.on_page(temperatures, part, sorted(model.trained)))
        sides = _sides(part)
        for name, mine in sides.items():
            blocks.append(charts.on_page(drift, part, was, left, mine, name if len(sides) > 1 else ""))
    blocks.append(
        r.note(
            "Before: readings less what the machine file says and less what set-up and zero may be. After: less the terms found too. "
            f"{model.outliers} single readings stand out from their neighbours; they are drawn and were not fitted."
        )
    )
    unused = [f"{sensor}: {why}" for sensor, why in model.unused_sensors.items()]
    blocks += [r.note(f"Not used: {'; '.join(unused)}.")] if unused else []
    return r.page(
        f"Thermal report: {machine.name}",
        blocks,
        footer=f"vcmm {__version__}",
        answers=thermal_answers(model, len(rows)),
        facts=facts("", machine.name, machine.record, expected_names=OF_MACHINES),
    )


def temperatures(part: WarmReadings, sensors: Sequence[str], ax: charts.ChartSheet | None = None) -> Axes:
    """Plot the readings of every sensor over the time of a recording, degC over minutes."""
    run = part.observer.run
    series = [
        PlotSeries(_minutes(run.columns["time_s"]), run.columns[f"temp_{name}_C"], name)
        for name in sensors
        if f"temp_{name}_C" in run.columns
    ]
    return charts.curve(
        series, x_label="time / min", y_label="°C", title="Temperatures", zero_line=False, ax=ax
    )


def drift(
    part: WarmReadings, was: np.ndarray, left: np.ndarray, mine: np.ndarray, side: str, ax: charts.ChartSheet | None = None
) -> Axes:  # fmt: skip
    """Plot the readings of one direction over time before and after the terms, um over minutes; each keeps the colour that it has in a diagnosis."""
    at = _minutes(part.observer.run.columns["time_s"])[part.recording.row][mine]
    series = [
        PlotSeries(at, 1e3 * was[mine], "before", marker=True, line=False, colour="c2"),
        PlotSeries(at, 1e3 * left[mine], "after", marker="s", line=False, colour="c1"),
    ]
    title = f"Drift{f' along {side}' if side else ''}"
    return charts.curve(series, x_label="time / min", y_label="µm", title=title, ax=ax)


def _minutes(time: np.ndarray) -> np.ndarray:
    return np.asarray((time - time[0]) / MINUTE)


def _sides(part: WarmReadings) -> dict[str, np.ndarray]:
    """Return rows by the axis that their observation lies nearest to; all under one name where the recording states no direction."""
    given = [part.observer.run.columns.get(f"n{letter}") for letter in "xyz"]
    if any(direction is None for direction in given):
        return {"": np.ones(len(part.value), dtype=bool)}
    towards = np.abs(
        np.stack([np.asarray(direction) for direction in given], axis=1)[part.recording.row]
    ).argmax(axis=1)
    return {name: towards == i for i, name in enumerate(DIRECTIONS) if (towards == i).any()}
