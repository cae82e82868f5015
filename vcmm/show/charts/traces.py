"""Polar traces: ball bar (both senses, before and after) and roundness (unfiltered, filtered, with its reference circles).

Radial deviations are magnified and drawn on a circle (layout of ISO 12181-1 and ISO 230-4). A reference circle whose centre lies off
the origin by (x, y) is drawn as radius + x cos t + y sin t, which is exact to deviation^2 / diameter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.show.charts.canvas import (
    GRID,
    MUTED,
    TICK,
    ChartSheet,
    add_legend,
    add_title,
    as_data,
    canvas,
    carrying,
    plain_label,
)
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class PolarTrace:
    """Deviations radius_um (n,) at angle_rad (n,), counter-clockwise from +x; colour: a role of the palette.

    width_um: the width that is stated of it where that is not about the drawn centre (G+ and G- of ISO 230-4 are about their own).
    half_um: half of the band (n,) about it; None: it has none.
    """

    name: str
    angle_rad: npt.ArrayLike
    radius_um: npt.ArrayLike
    colour: str = "c1"
    thin: bool = False
    closed: bool = True
    width_um: float | None = None
    half_um: npt.ArrayLike | None = None


@dataclass(frozen=True)
class ReferenceCircle:
    """Radius and centre of a reference circle, as deviations (um) from the nominal one; `width_um`: the roundness about it."""

    name: str
    radius_um: float
    x_um: float
    y_um: float
    width_um: float
    zone: bool = False  # drawn as the two circles of the minimum zone

    def at(self, angle: npt.ArrayLike) -> npt.NDArray[np.float64]:
        t = np.asarray(angle, dtype=np.float64)
        return np.asarray(self.radius_um + self.x_um * np.cos(t) + self.y_um * np.sin(t))


def traces(
    lines: Sequence[PolarTrace],
    *,
    title: str,
    circles: Sequence[ReferenceCircle] = (),
    low_um: float | None = None,
    high_um: float | None = None,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot traces about one reference circle (the thin one at 0), on one scale. low_um, high_um: ends of the scale, where pictures are compared.

    The width of every trace, highest less lowest point about the drawn centre unless it states its own, is a number of the picture. DataError: lengths differ,
    nothing finite.
    """
    kept = [_check(line) for line in lines]
    if not kept:
        raise DataError("A polar trace needs one trace at least.")
    drawn: Any = canvas(ax, 440, "polar")
    bands = [_band(line, r) for line, (_, r) in zip(lines, kept)]
    ends = np.concatenate(
        [
            *(r for _, r in kept),
            *(side for b in bands for side in b),
            *([v] for v in (low_um, high_um) if v is not None),
            [0.0],
        ]
    )
    low, high = float(np.nanmin(ends)), float(np.nanmax(ends))
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    drawn.plot(around, np.zeros(around.size), color=LIGHT["faint"], linewidth=0.9)
    for line, band, (angle, radius) in zip(lines, bands, kept):
        if band:
            around_it = [np.append(v, v[0]) for v in (angle, *band)] if line.closed else [angle, *band]
            drawn.fill_between(*around_it, color=LIGHT[line.colour], alpha=0.18, linewidth=0.0)
        shut = line.closed and bool(np.isfinite(radius).all())
        both = [np.append(v, v[0]) if shut else v for v in (angle, radius)]
        drawn.plot(
            *both,
            color=LIGHT[line.colour],
            linewidth=0.8 if line.thin else 1.4,
            alpha=0.75 if line.thin else 1.0,
            label=plain_label(line.name),
        )
    for circle in circles:
        half = circle.width_um / 2 if circle.zone else 0.0
        for shift in {-half, half}:
            name = plain_label(circle.name) if shift == half else None
            colour, style = ("c4", "--") if circle.zone else ("c3", "-.")
            drawn.plot(around, circle.at(around) + shift, style, color=LIGHT[colour], linewidth=1.0, label=name)  # fmt: skip
    _frame(drawn, low, high)
    drawn.set_xticks(np.radians([0, 45, 135, 180, 225, 270, 315]))  # the keys stand above 90 degrees
    widths = {
        line.name: float(np.nanmax(r) - np.nanmin(r)) if line.width_um is None else line.width_um
        for line, (_, r) in zip(lines, kept)
    }
    widths_text = ", ".join([f"{name}: {number(w, 3)} µm" for name, w in widths.items()] + [f"{c.name}: {number(c.width_um, 3)} µm" for c in circles])  # fmt: skip
    add_title(add_legend(drawn), f"{title}\nHighest less lowest point; {widths_text}.")
    about = {c.name: {"radius": c.radius_um, "x": c.x_um, "y": c.y_um, "width": c.width_um} for c in circles}
    return carrying(drawn, chart="trace", unit="µm", width=widths, circles=about, scale=[low, high])


def _band(line: PolarTrace, radius: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], ...]:
    """Return both sides (n,) of the band of a trace; none where it has none."""
    if line.half_um is None:
        return ()
    half = np.broadcast_to(np.asarray(line.half_um, dtype=np.float64), radius.shape)
    return radius - half, radius + half


def _check(line: PolarTrace) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    angle, radius = (np.asarray(v, dtype=np.float64) for v in (line.angle_rad, line.radius_um))
    if angle.shape != radius.shape or angle.ndim != 1 or not np.isfinite(radius).any():
        raise DataError(
            f'The trace "{line.name}" needs finite radii (n,) and angles (n,), got {radius.shape} and {angle.shape}.'
        )
    return angle, np.where(np.isfinite(radius), radius, np.nan)


def _frame(drawn: Any, low: float, high: float) -> None:
    span = high - low or 1.0
    drawn.set_ylim(low, high + 0.04 * span)
    drawn.set_rorigin(low - CENTRE / (1.0 - CENTRE) * span)
    drawn.set_rlabel_position(67.5)
    drawn.tick_params(labelsize=TICK, labelcolor=MUTED)
    drawn.grid(color=GRID, linewidth=0.8)
    for name in ("polar", "inner"):
        drawn.spines[name].set_edgecolor(GRID)


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
