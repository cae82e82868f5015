"""Before and after in groups: a box per value of a covariate that has few, both in colours of their own and on one scale."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.show.charts.canvas import ChartSheet, add_legend, canvas, carrying, plain, plain_label
from vcmm.show.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
    plain(add_legend(drawn), title, label, y_label, grid="y")
    return carrying(drawn, chart="boxes", groups=groups, quantiles=numbers)
