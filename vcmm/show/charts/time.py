"""A number that is followed over days: its band, checks, alarms and forecast."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vcmm.show.charts.canvas import add_legend, add_title
from vcmm.show.charts.curves import PlotSeries, curve
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import unit_word

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.core.run import Array
    from vcmm.show.charts.canvas import ChartSheet

BAND = 1.96  # of the standard uncertainty: 95 %


def over_time(
    days: Array, value: Array, u: Array, *, name: str, unit: str, start: str, alarms: Sequence[float], ahead: Array,
    what: str = "", ax: Axes | ChartSheet | None = None,
) -> Axes:  # fmt: skip
    """Plot value, u (n,) in `unit` over days (n,) since `start`; alarms: their days; ahead (k, 3): days after the last, value, u."""
    future = np.concatenate([[[0.0, value[-1], u[-1]]], np.reshape(ahead, (-1, 3))])
    later = days[-1] + future[:, 0]
    series = [
        PlotSeries(days, value, "checks, ± 1.96 u", value - BAND * u, value + BAND * u, marker=True),
        PlotSeries(
            later, future[:, 1], "forecast", future[:, 1] - BAND * future[:, 2], future[:, 1] + BAND * future[:, 2],
            dashed=True,
        ),
    ]  # fmt: skip
    title = f"{name}{f' ({what})' if what else ''}"
    drawn = curve(
        series, x_label=f"days since {start}", y_label=unit_word(unit), title=title, zero_line=False, ax=ax
    )
    for number, day in enumerate(alarms):
        label = None if number else "alarm"
        drawn.axvline(day, color=LIGHT["bad"], linewidth=1.0, linestyle=":", label=label)
    return add_title(add_legend(drawn), title) if len(alarms) else drawn
