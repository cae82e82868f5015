"""The band chart of ISO 230-2: mean of every target in both directions, mean +- 2 s about it, and A, R, E, B, M in the margin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.show.charts.canvas import TICK, ChartSheet, add_legend, canvas, carrying, set_labels
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
