"""Curves over an axis: errors with their bands (style of ISO 230-2 reports), drift, U against time, readings by the sense of motion,
a number that is followed over days with its checks, alarms and forecast, and the band chart of ISO 230-2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.show.charts.canvas import (
    TICK,
    ChartSheet,
    add_legend,
    add_title,
    as_data,
    canvas,
    carrying,
    plain_label,
    set_labels,
)
from vcmm.show.report.palette import LIGHT, SERIES
from vcmm.show.report.text import number, unit_word

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.core.run import Array

SENSES = ((1.0, "upwards", "o"), (-1.0, "downwards", "s"), (0.0, "at rest", "."))


@dataclass(frozen=True)
class PlotSeries:
    """One curve: x, y (n,); `low` and `high` (n,) bound its band (for example mean - 2 u, mean + 2 u).

    A NaN interrupts the line. `marker` draws a dot at every point (or the marker of matplotlib that it names);
    `line=False` leaves only the dots. `colour`: a role of the palette in place of that of its turn, so that one thing keeps it in
    all pictures.
    """

    x: npt.ArrayLike
    y: npt.ArrayLike
    name: str = ""
    low: npt.ArrayLike | None = None
    high: npt.ArrayLike | None = None
    marker: bool | str = False
    line: bool = True
    dashed: bool = False
    colour: str = ""


@dataclass(frozen=True)
class Band:
    """A limit band behind the curves: `low` and `high` are numbers, or arrays over `x` (an MPE funnel)."""

    low: npt.ArrayLike
    high: npt.ArrayLike
    name: str = ""
    x: npt.ArrayLike | None = None


def curve(
    series: Sequence[PlotSeries],
    *,
    x_label: str,
    y_label: str,
    title: str,
    bands: Sequence[Band] = (),
    zero_line: bool = True,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot curves with bands, each curve in a colour of its own. DataError: x, y, low, high of a series differ in length."""
    drawn = canvas(ax)
    for k, line in enumerate(series):
        _draw(drawn, _check_series(line), line, LIGHT[line.colour or SERIES[k % len(SERIES)]])
    for band_ in bands:
        x = np.asarray(drawn.get_xlim() if band_.x is None else band_.x, dtype=np.float64)
        low, high = (
            np.broadcast_to(np.asarray(v, dtype=np.float64), x.shape) for v in (band_.low, band_.high)
        )
        drawn.fill_between(
            x, low, high, facecolor=LIGHT["grid"], edgecolor=LIGHT["faint"], linestyle=":", alpha=0.7, zorder=0.5,
            label=plain_label(band_.name) or None,
        )  # fmt: skip
    if zero_line:
        drawn.axhline(0.0, color=LIGHT["rule"], linewidth=0.8, zorder=0.8)
    drawn.margins(x=0.01)
    drawn.ticklabel_format(useOffset=False)
    numbers = [
        {"name": line.name} | dict(zip(("x", "y", "low", "high"), map(as_data, _check_series(line))))
        for line in series
    ]
    drawn = carrying(drawn, chart="curve", x_label=x_label, y_label=y_label, series=numbers)
    return set_labels(add_legend(drawn), title, x_label, y_label)


def _draw(drawn: Axes, data: tuple[Array, ...], plot_series: PlotSeries, colour: str) -> None:
    name = plain_label(plot_series.name) or None
    if len(data) == 4:
        drawn.fill_between(data[0], data[2], data[3], color=colour, alpha=0.18, linewidth=0.0)
    dot = (
        plot_series.marker
        if isinstance(plot_series.marker, str)
        else "o"
        if plot_series.marker or not plot_series.line
        else ""
    )
    style = ("--" if plot_series.dashed else "-") if plot_series.line else "none"
    drawn.plot(
        data[0], data[1], linestyle=style, marker=dot, color=colour, linewidth=1.3, markersize=3.4, label=name
    )


def _check_series(plot_series: PlotSeries) -> tuple[Array, ...]:
    """Return (x, y) or (x, y, low, high), all of one length, infinities turned into gaps."""
    given = (
        (plot_series.x, plot_series.y)
        if plot_series.low is None or plot_series.high is None
        else (plot_series.x, plot_series.y, plot_series.low, plot_series.high)
    )
    parts = [np.atleast_1d(np.asarray(v, dtype=np.float64)) for v in given]
    if len({p.shape for p in parts}) != 1 or parts[0].ndim != 1:
        shapes = ", ".join(str(p.shape) for p in parts)
        raise DataError(
            f'Curve "{plot_series.name}" has x, y, low, high of shapes {shapes}: give arrays of one length.'
        )
    return tuple(np.where(np.isfinite(p), p, np.nan) for p in parts)


def band(
    nodes: Array, value: Array, u: Array, *, unit: str, title: str, label: str = "position / mm",
    ax: Axes | ChartSheet | None = None,
) -> Axes:  # fmt: skip
    """Plot value (n,) over nodes (n,) with the 95 % band value +- 1.96 u, all in `unit`."""
    plot_series = PlotSeries(nodes, value, "± 1.96 u", value - 1.96 * u, value + 1.96 * u)
    return curve([plot_series], x_label=label, y_label=unit, title=title, ax=ax)


def readings(
    position: Array,
    value: Array,
    sense: Array,
    *,
    unit: str,
    title: str,
    label: str,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot readings (n,) in `unit` over position (n,), those of each sense of motion (+1, -1, 0) in a colour of their own."""
    series = []
    for way, name, shape in SENSES:
        mine = sense == way
        if mine.any():
            words = f"{name} ({int(mine.sum())})"
            series.append(PlotSeries(position[mine], value[mine], words, marker=shape, line=False))
    if len(series) == 1:
        series = [PlotSeries(position, value, marker=True, line=False)]
    return curve(series, x_label=label, y_label=unit, title=title, ax=ax)


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
    for k, day in enumerate(alarms):
        label = None if k else "alarm"
        drawn.axvline(day, color=LIGHT["bad"], linewidth=1.0, linestyle=":", label=label)
    return add_title(add_legend(drawn), title) if len(alarms) else drawn


WAYS = (("approached in +", "c1", "o"), ("approached in −", "c2", "s"))


def positioning_band(
    targets: npt.ArrayLike,
    up: npt.ArrayLike,
    down: npt.ArrayLike,
    figures: Mapping[str, float],
    *,
    unit: str = "µm",
    label: str = "position / mm",
    title: str,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot deviations up and down (targets, runs) in `unit` at targets (n,); figures: name -> value in `unit`, as the table states them.

    Lines are the means, bands mean +- 2 s with s from n - 1 (ISO 230-2:2014, 3.13 to 3.16); A spans both bands, E both lines, drawn at
    the right. DataError: shapes that do not fit, fewer than two runs.
    """
    place, both = np.asarray(targets, float), [np.asarray(v, float) for v in (up, down)]
    if any(v.ndim != 2 or v.shape[0] != place.size or v.shape[1] < 2 for v in both):
        raise DataError(
            f"A band chart needs deviations (targets, runs) of two runs or more at {place.size} targets, got {[v.shape for v in both]}."
        )
    drawn: Any = canvas(ax, 360)
    mean, spread = [v.mean(axis=1) for v in both], [2.0 * v.std(axis=1, ddof=1) for v in both]
    for (name, colour, mark), y, s, raw in zip(WAYS, mean, spread, both):
        drawn.fill_between(place, y - s, y + s, color=LIGHT[colour], alpha=0.16, linewidth=0.0)
        drawn.plot(place, y, marker=mark, markersize=3.6, linewidth=1.3, color=LIGHT[colour], label=f"mean {name}, ± 2 s")  # fmt: skip
        drawn.plot(np.repeat(place, raw.shape[1]), raw.ravel(), ".", markersize=2.2, color=LIGHT[colour], alpha=0.55)  # fmt: skip
    drawn.axhline(0.0, color=LIGHT["rule"], linewidth=0.8, zorder=0.8)
    ends = {
        "A": (min((m - s).min() for m, s in zip(mean, spread)), max((m + s).max() for m, s in zip(mean, spread))),
        "E": (min(m.min() for m in mean), max(m.max() for m in mean)),
    }  # fmt: skip
    width = float(np.ptp(place)) or 1.0
    for i, (name, (low, high)) in enumerate(ends.items()):
        x = float(place.max()) + (0.05 + 0.07 * i) * width
        drawn.annotate("", (x, high), (x, low), arrowprops={"arrowstyle": "<->", "color": LIGHT["ink"], "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0})  # fmt: skip
        drawn.annotate(name, (x, high), (0, 3), textcoords="offset points", ha="center", fontsize=TICK, color=LIGHT["ink"])  # fmt: skip
    drawn.set_xlim(place.min() - 0.03 * width, place.max() + 0.17 * width)
    drawn.ticklabel_format(useOffset=False)
    figures_text = ", ".join(f"{name} {number(v, 3)}" for name, v in figures.items())
    set_labels(
        add_legend(drawn), f"{title}\n{figures_text} {unit} (ISO 230-2).", label, f"deviation / {unit}"
    )
    return carrying(
        drawn, chart="positioning", unit=unit, figures=dict(figures), targets=place, mean_up=mean[0], mean_down=mean[1],
        band_up=spread[0], band_down=spread[1], spans=ends,
    )  # fmt: skip
