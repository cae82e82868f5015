"""What trials gave: histogram, coverage interval, limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from vcmm.charts.canvas import canvas, plain
from vcmm.core.run import Array
from vcmm.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def distribution(
    edges: Array,
    counts: Array,
    *,
    interval: tuple[float, float] | None = None,
    limits: tuple[float, float] | None = None,
    marks: Mapping[str, float] | None = None,
    unit: str = "mm",
    title: str = "",
    ax: Axes | None = None,
) -> Axes:
    """Bars of area proportional to the counts (edges (n + 1,), counts (n,)); interval shaded, limits and marks as lines.

    A limit that is infinite is none; without counts no bars are drawn, and that is said.
    """
    drawn = canvas(ax)
    wide = np.diff(edges)
    height = np.asarray(counts, dtype=float) / wide / max(float(np.sum(counts)), 1.0)
    drawn.bar(edges[:-1], height, wide, align="edge", color=LIGHT["accent-soft"], edgecolor="none")
    if not len(counts):
        drawn.text(
            0.01,
            0.96,
            "closed form, no trials",
            transform=drawn.transAxes,
            va="top",
            fontsize=8,
            color=LIGHT["muted"],
        )
    if not len(counts):
        drawn.text(
            0.01,
            0.96,
            "closed form, no trials",
            transform=drawn.transAxes,
            va="top",
            fontsize=8,
            color=LIGHT["muted"],
        )
    if interval:
        drawn.axvspan(*interval, color=LIGHT["accent"], alpha=0.18, label="coverage interval")
    for limit, name in zip(limits or (), ("lower limit", "upper limit")):
        if np.isfinite(limit):
            drawn.axvline(limit, color=LIGHT["bad"], linewidth=1.4, label=name)
    for number, (name, value) in enumerate((marks or {}).items()):
        drawn.axvline(value, color=LIGHT[f"c{2 + number % 5}"], linewidth=1.2, linestyle="--", label=name)
    if drawn.get_legend_handles_labels()[0]:
        drawn.legend(fontsize=8, frameon=False)
    drawn.ticklabel_format(axis="x", useOffset=False)
    return plain(drawn, title, unit, f"density / (1/{unit})")
