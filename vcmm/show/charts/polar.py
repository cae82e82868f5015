"""Roundness plot: radial deviations, magnified, on a reference circle (layout of ISO 12181-1 diagrams)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.show.charts.canvas import GRID, MUTED, TICK, ChartSheet, add_title, as_data, canvas, carrying
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CENTRE = 0.34  # radius of the innermost deviation over the outermost


def polar(
    angles_rad: npt.ArrayLike,
    radii_um: npt.ArrayLike,
    *,
    title: str,
    low_um: npt.ArrayLike | None = None,
    high_um: npt.ArrayLike | None = None,
    closed: bool = True,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot deviations radii_um (n,) from the reference circle at angles_rad (n,), counter-clockwise from +x.

    `low_um`, `high_um` (n,) bound an uncertainty band. The inscribed and circumscribed circle about the same centre
    are dashed; the title states their distance, the form deviation about this reference. Values that are not finite interrupt the line. `ax` must
    have polar axes. DataError: lengths differ, or no finite point.
    """
    angle, radius = np.asarray(angles_rad, dtype=np.float64), np.asarray(radii_um, dtype=np.float64)
    if angle.shape != radius.shape or angle.ndim != 1 or not np.isfinite(radius).any():
        raise DataError(
            f"A polar plot needs finite radii (n,) and angles (n,), got {radius.shape} and {angle.shape}."
        )
    radius = np.where(np.isfinite(radius), radius, np.nan)
    drawn = canvas(ax, 400, "polar")
    sides = [np.asarray(s, dtype=np.float64) for s in (low_um, high_um) if s is not None]
    sides = [np.where(np.isfinite(s), s, np.nan) for s in sides]
    every = np.concatenate([radius, *sides, [0.0]])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    span = high - low or 1.0
    if len(sides) == 2:
        drawn.fill_between(angle, *sides, color=LIGHT["c1"], alpha=0.18, linewidth=0.0)
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    ends = float(np.nanmin(radius)), float(np.nanmax(radius))
    for level, colour, style in ((0.0, "muted", "-"), *((e, "c2", "--") for e in ends)):
        drawn.plot(around, np.full(around.size, level), style, color=LIGHT[colour], linewidth=0.9)
    shut = closed and bool(np.isfinite(radius).all())
    line = [np.append(v, v[0]) if shut else v for v in (angle, radius)]
    drawn.plot(*line, color=LIGHT["c1"], linewidth=1.3)
    drawn.set_ylim(low, high + 0.04 * span)
    drawn.set_rorigin(low - CENTRE / (1.0 - CENTRE) * span)
    drawn.set_rlabel_position(67.5)
    drawn.tick_params(labelsize=TICK, labelcolor=MUTED)
    drawn.grid(color=GRID, linewidth=0.8)
    drawn.spines["polar"].set_edgecolor(GRID)
    drawn.spines["inner"].set_edgecolor(GRID)
    bounds = dict(zip(("low", "high"), map(as_data, sides))) if len(sides) == 2 else {}
    carrying(drawn, chart="polar", unit="µm", angle_rad=as_data(angle), radius=as_data(radius), **bounds)
    form = number(ends[1] - ends[0], 3)
    return add_title(drawn, f"{title}\nHighest to lowest point about this reference: {form} µm.")
