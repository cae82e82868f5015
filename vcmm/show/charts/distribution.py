"""Results of trials: histogram, coverage interval (GUM Supplement 1, clause 7.7), limits, marked values;
and boxes of groups, a box per value of a covariate that has few.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.show.charts.canvas import (
    MUTED,
    TICK,
    ChartSheet,
    add_legend,
    canvas,
    carrying,
    plain_label,
    set_labels,
)
from vcmm.show.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.core.run import Array


def distribution(
    edges: npt.ArrayLike,
    counts: npt.ArrayLike,
    *,
    interval: tuple[float, float] | None = None,
    limits: tuple[float, float] | None = None,
    marks: Mapping[str, float] | None = None,
    unit: str = "mm",
    label: str = "",
    title: str = "",
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot bars of area proportional to the counts (edges (n + 1,), counts (n,)), darker inside the interval; lines for limits and marks.

    A limit or mark that is not finite is left out; without counts a text replaces the bars.
    DataError: shapes that do not fit, edges that do not increase, counts negative or not finite.
    """
    edge, count = _check_histogram(edges, counts)
    drawn = canvas(ax)
    if count.size:
        _bars(drawn, edge, count / np.diff(edge) / max(float(count.sum()), 1.0), interval)
    else:
        drawn.text(
            0.01,
            0.96,
            "closed form, no trials",
            transform=drawn.transAxes,
            va="top",
            fontsize=TICK,
            color=MUTED,
        )
    if interval and np.isfinite(interval).all():
        drawn.axvspan(*interval, color=LIGHT["accent"], alpha=0.14, label="coverage interval", linewidth=0.0)
    for limit, name in zip(limits or (), ("lower limit", "upper limit")):
        if np.isfinite(limit):
            drawn.axvline(limit, color=LIGHT["bad"], linewidth=1.4, label=name)
    for number, (name, value) in enumerate((marks or {}).items()):
        if np.isfinite(value):
            drawn.axvline(
                value,
                color=LIGHT[f"c{2 + number % 5}"],
                linewidth=1.2,
                linestyle="--",
                label=plain_label(name),
            )
    drawn.ticklabel_format(axis="x", useOffset=False)
    set_labels(add_legend(drawn), title, label or unit, f"density / (1/{unit})")
    return carrying(
        drawn, chart="distribution", unit=unit, interval=interval, limits=limits, marks=dict(marks or {})
    )


def _check_histogram(edges: npt.ArrayLike, counts: npt.ArrayLike) -> tuple[Array, Array]:
    edge, count = np.asarray(edges, dtype=np.float64), np.asarray(counts, dtype=np.float64)
    if edge.ndim != 1 or count.shape != (edge.size - 1,):
        raise DataError(f"A histogram needs n + 1 edges for n counts, got {edge.shape} and {count.shape}.")
    if not (np.isfinite(edge).all() and (np.diff(edge) > 0).all()):
        raise DataError(
            "The edges of a histogram must be finite and increase: sort them and remove repeated ones."
        )
    if not (np.isfinite(count).all() and (count >= 0).all()):
        raise DataError("The counts of a histogram must be finite and not negative.")
    return edge, count


def _bars(drawn: Axes, edge: Array, density: Array, interval: tuple[float, float] | None) -> None:
    """Draw all bars, and over them those inside the interval, cut at its ends: their area is the coverage probability."""
    low, high = interval or (edge[0], edge[-1])
    if interval:
        drawn.stairs(density, edge, fill=True, color=LIGHT["accent-soft"])
    inner = np.unique(np.clip(edge, low, high))
    if inner.size > 1:
        row = np.clip(
            np.searchsorted(edge, (inner[1:] + inner[:-1]) / 2, side="right") - 1, 0, density.size - 1
        )
        drawn.stairs(density[row], inner, fill=True, color=LIGHT["accent"])


def coarsen(edges: Array, counts: Array, bars: int = 80) -> tuple[Array, Array]:
    """Return the filled part of a fine histogram in about 80 bars."""
    total = counts.cumsum()
    inside = np.flatnonzero((total > 5e-4 * total[-1]) & (total < (1 - 5e-4) * total[-1]))
    first, last = (inside[0], inside[-1] + 1) if len(inside) > 1 else (0, len(counts))
    width = max(1, (last - first) // bars)
    last = first + max(1, (last - first) // width) * width
    return edges[first : last + 1 : width], counts[first:last].reshape(-1, width).sum(axis=1)


MOST_GROUPS = 4


def is_grouped(x: npt.ArrayLike) -> bool:
    """Return whether a covariate has so few values that a box for each shows more than dots."""
    return len(np.unique(np.asarray(x, float))) <= MOST_GROUPS


def boxes(
    x: npt.ArrayLike,
    series: Sequence[tuple[str, npt.ArrayLike, str]],
    *,
    label: str,
    y_label: str,
    title: str,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Return the boxes (quartiles, whiskers to 5 % and 95 %, median) of each (name, values (n,), colour) at every value of x (n,)."""
    place = np.asarray(x, float)
    groups = np.unique(place)
    drawn: Any = canvas(ax)
    numbers: dict[str, list[list[float]]] = {}
    width = 0.7 / max(len(series), 1)
    for k, (name, values, colour) in enumerate(series):
        y = np.asarray(values, float)
        if y.shape != place.shape:
            raise DataError(f'"{name}" has {y.shape} values at {place.shape} places: give one each.')
        at = np.arange(len(groups)) + (k - (len(series) - 1) / 2) * width
        mine = [y[place == g] for g in groups]
        numbers[name] = [[float(q) for q in np.quantile(v, (0.05, 0.25, 0.5, 0.75, 0.95))] for v in mine]
        ink = {"color": LIGHT[colour], "linewidth": 1.3}
        drawn.bxp(
            [dict(zip(("whislo", "q1", "med", "q3", "whishi"), q), fliers=[]) for q in numbers[name]],
            positions=at, widths=0.8 * width, showfliers=False, patch_artist=True, manage_ticks=False,
            boxprops={"facecolor": "none", "edgecolor": LIGHT[colour], "linewidth": 1.3}, medianprops=ink, whiskerprops=ink, capprops=ink,
        )  # fmt: skip
        drawn.plot([], [], color=LIGHT[colour], linewidth=4, label=plain_label(name))
    drawn.axhline(0.0, color=LIGHT["rule"], linewidth=0.8, zorder=0.8)
    drawn.set_xticks(range(len(groups)), [f"{g:g}\n(n = {int((place == g).sum())})" for g in groups])
    drawn.set_xlim(-0.6, len(groups) - 0.4)
    set_labels(add_legend(drawn), title, label, y_label, grid="y")
    return carrying(drawn, chart="boxes", groups=groups, quantiles=numbers)
