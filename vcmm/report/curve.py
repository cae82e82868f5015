"""Curves over one axis: error curves with their uncertainty band, drift, convergence (layout of ISO 230-2 reports)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.report import svg
from vcmm.report.axes import Area, Array, Scale, nice_ticks, room_left, span_of, x_axis, y_axis
from vcmm.report.palette import SERIES


@dataclass(frozen=True)
class PlotSeries:
    """One curve: x, y (n,); `low` and `high` (n,) bound its band (for example mean - 2 u, mean + 2 u).

    A NaN interrupts the line. `marker` draws a dot at every point; `line=False` leaves only the dots.
    """

    x: npt.ArrayLike
    y: npt.ArrayLike
    name: str = ""
    low: npt.ArrayLike | None = None
    high: npt.ArrayLike | None = None
    marker: bool = False
    line: bool = True
    dashed: bool = False


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
    width: int = svg.HALF,
    height: int = 300,
) -> str:
    """Curves with bands. DataError: x, y, low, high of a series differ in length."""
    data = [_checked(s) for s in series]
    limits = [(_array(b.low), _array(b.high)) for b in bands]
    xs = [d[0] for d in data] + [_array(b.x) for b in bands if b.x is not None]
    ys = [a for d in data for a in d[1:]] + [a for pair in limits for a in pair]
    low, high = span_of(np.concatenate(ys or [np.zeros(1)]), 0.08)
    if zero_line:
        low, high = min(low, 0.0), max(high, 0.0)
    x_low, x_high = span_of(np.concatenate(xs or [np.zeros(1)]), 0.0)
    ticks = nice_ticks(low, high, max(3, height // 45))
    entries = _legend_entries(series, bands)
    keys, used = svg.legend(entries, 0, 26, width)
    area = Area(room_left(ticks), 30 + used, width - 18, height - 46)
    x, y = Scale(x_low, x_high, area.left, area.right), Scale(low, high, area.bottom, area.top)
    body = [svg.text(0, 13, y_label, "muted"), keys, y_axis(area, y, ticks)]
    body += [_limit(b, lo, hi, x, y) for b, (lo, hi) in zip(bands, limits)]
    if zero_line and low < 0 < high:
        body.append(svg.line(area.left, y(0.0), area.right, y(0.0), svg.paint(stroke="faint")))
    body += [_band(d, i, x, y) for i, d in enumerate(data)]
    body += [_line(s, d, i, x, y) for i, (s, d) in enumerate(zip(series, data))]
    body.append(x_axis(area, x, x_label, width))
    return svg.figure(svg.document(width, height, "".join(body), title), title)


def _array(values: npt.ArrayLike | None) -> Array:
    return np.atleast_1d(np.asarray(values, dtype=np.float64))


def _checked(s: PlotSeries) -> tuple[Array, ...]:
    """(x, y) or (x, y, low, high), all of one length, infinities turned into gaps."""
    banded = s.low is not None and s.high is not None
    parts = [_array(v) for v in ((s.x, s.y, s.low, s.high) if banded else (s.x, s.y))]
    if len({p.shape for p in parts}) != 1 or parts[0].ndim != 1:
        shapes = ", ".join(str(p.shape) for p in parts)
        raise DataError(
            f'Curve "{s.name}" has x, y, low, high of shapes {shapes}: give arrays of one length.'
        )
    return tuple(np.where(np.isfinite(p), p, np.nan) for p in parts)


def runs(valid: npt.NDArray[np.bool_]) -> list[slice]:
    """Stretches of True in a boolean array (n,)."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], valid, [False]]).astype(np.int8)))
    return [slice(int(a), int(b)) for a, b in zip(edge[::2], edge[1::2])]


def thin(x: Array, y: Array, buckets: int = 1200) -> tuple[Array, Array]:
    """At most two points per bucket, its smallest and its largest y: a picture cannot show more."""
    if x.size <= 2 * buckets:
        return x, y
    starts = np.linspace(0, x.size, buckets + 1).astype(int)
    keep = [a + f(y[a:b]) for a, b in pairwise(starts) for f in (np.argmin, np.argmax)]
    index = np.unique(np.concatenate([[0], keep, [x.size - 1]]).astype(int))
    return x[index], y[index]


def _line(s: PlotSeries, data: tuple[Array, ...], i: int, x: Scale, y: Scale) -> str:
    colour, out = SERIES[i % len(SERIES)], []
    good = np.isfinite(data[0]) & np.isfinite(data[1])
    for run in runs(good) if s.line else []:
        px, py = thin(data[0][run], data[1][run])
        how = svg.paint(stroke=colour, width=1.7, dash="6 4" if s.dashed else "") + ' stroke-linejoin="round"'
        out.append(svg.path(svg.points(zip(x.many(px), y.many(py))), how, s.name))
    lonely = [r.start for r in runs(good) if r.stop - r.start == 1 and s.line]
    dots = np.flatnonzero(good) if s.marker or not s.line else np.array(lonely, dtype=int)
    how = svg.paint(colour, "surface", 1.0)
    out += [svg.circle(x(data[0][k]), y(data[1][k]), 3.2, how) for k in dots]
    return "".join(out)


def _band(data: tuple[Array, ...], i: int, x: Scale, y: Scale) -> str:
    if len(data) < 4:
        return ""
    out, good = [], np.isfinite(data[0] + data[2] + data[3])
    for run in runs(good):
        px, low, high = x.many(data[0][run]), y.many(data[2][run]), y.many(data[3][run])
        outline = [*zip(px, high), *zip(px[::-1], low[::-1])]
        out.append(
            svg.path(svg.points(outline, close=True), svg.paint(SERIES[i % len(SERIES)], opacity=0.17))
        )
    return "".join(out)


def _limit(band: Band, low: Array, high: Array, x: Scale, y: Scale) -> str:
    over = _array(band.x) if band.x is not None else np.array([x.low, x.high])
    px, low, high = np.broadcast_arrays(x.many(over), y.many(low), y.many(high))
    edge = svg.paint(stroke="faint", width=1.0, dash="2 3")
    fill = svg.path(
        svg.points([*zip(px, high), *zip(px[::-1], low[::-1])], close=True), svg.paint("grid", opacity=0.55)
    )
    return fill + "".join(svg.path(svg.points(zip(px, side)), edge, band.name) for side in (low, high))


def _legend_entries(series: Sequence[PlotSeries], bands: Sequence[Band]) -> list[tuple[str, str]]:
    out = []
    for i, s in enumerate(series):
        colour = SERIES[i % len(SERIES)]
        shade = svg.rect(0, 0, 16, 10, svg.paint(colour, opacity=0.17)) if s.low is not None else ""
        stroke = svg.line(0, 5, 16, 5, svg.paint(stroke=colour, width=1.7, dash="6 4" if s.dashed else ""))
        dot = svg.circle(8, 5, 3.2, svg.paint(colour)) if s.marker or not s.line else ""
        if s.name:
            out.append((shade + (stroke if s.line else "") + dot, s.name))
    box = svg.rect(0, 0, 16, 10, svg.paint("grid", "faint", 1.0, "2 3"))
    return out + [(box, b.name) for b in bands if b.name]
