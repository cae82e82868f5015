"""A number over time, and a check beside its forecast: polar of a circle, over its axis of a line (layout of ISO 230-2 diagrams), else reading by reading."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vcmm.show import charts
from vcmm.show.charts import ChartSheet, PlotSeries, PolarTrace

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.files.learned.last_checks import CheckPart
    from vcmm.files.learned.track_result import NumberOverTime, Track

WAYS = ((1.0, "forwards", "o"), (-1.0, "backwards", "s"), (0.0, "read", "o"))


def number_over_time(track: Track, course: NumberOverTime, ax: Axes | ChartSheet | None = None) -> Axes:
    """Plot a number over the days with its band, checks, alarms and forecast."""
    return charts.over_time(
        course.when - course.when[0], course.value, course.u, name=course.name, unit=course.unit, start=track.checks[0].date,
        alarms=[c.when - course.when[0] for c in track.alarms], ahead=np.array(course.ahead), what=course.what, ax=ax,
    )  # fmt: skip


def beside_forecast(part: CheckPart, ax: Axes | ChartSheet | None = None) -> Axes:
    """Plot the readings, and their forecast with the 95 % band of one reading."""
    title = f"{part.name} of {part.date}\n{part.inside:.0%} of {len(part.readings)} readings within the 95 % band of their forecast"
    if part.circle:
        lines = [
            PolarTrace("forecast, ± 1.96 u", part.place, part.forecast, "c2", half_um=1.96 * part.u),
            PolarTrace("read", part.place, part.readings, "c1"),
        ]
        return charts.traces(lines, title=title, ax=ax)
    order = np.argsort(part.place, kind="stable")
    place, middle, half = part.place[order], part.forecast[order], 1.96 * part.u[order]
    series = [PlotSeries(place, middle, "forecast, ± 1.96 u", middle - half, middle + half, colour="c2")]
    for way, name, marker in WAYS:
        rows = part.up == way
        if rows.any():
            series.append(
                PlotSeries(part.place[rows], part.readings[rows], name, marker=marker, line=False, colour="c1" if way >= 0 else "c3")
            )  # fmt: skip
    label = f"{part.axis} / mm" if part.axis else "number of the reading"
    return charts.curve(series, x_label=label, y_label=part.unit, title=title, ax=ax)
