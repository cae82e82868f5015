"""Histogram of a Monte Carlo result with its coverage interval (GUM Supplement 1, clause 7.7) and marked values."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.report import svg
from vcmm.report.axes import Area, Array, Scale, x_axis
from vcmm.report.text import text_width

_ROW = 17.0


def histogram(
    edges: npt.ArrayLike,
    counts: npt.ArrayLike,
    *,
    x_label: str,
    title: str,
    interval: tuple[float, float] | None = None,
    interval_label: str = "coverage interval",
    marks: Sequence[tuple[str, float]] = (),
    width: int = svg.HALF,
    height: int = 300,
) -> str:
    """Bars of area proportional to the counts (edges (n + 1,), counts (n,)), darker inside `interval`.

    `marks` are (name, x) drawn as lines, for example the nominal value and the limits; a mark that is not finite is
    left out. DataError: shapes that do not fit, edges that do not increase, counts negative or not finite.
    """
    edge, count = _checked(edges, counts)
    marks = [(name, float(x)) for name, x in marks if np.isfinite(x)]
    values = [edge[0], edge[-1], *(x for _, x in marks), *(interval or ())]
    pad = 0.02 * (max(values) - min(values))
    scale = Scale(min(values) - pad, max(values) + pad, 22, width - 22)
    levels, head = _levels(marks, scale, width), 30.0 if interval else 0.0
    area = Area(22, head + 12 + _ROW * (max(levels, default=-1) + 1), width - 22, height - 46)
    body = [_bars(edge, count, interval, scale, area)]
    body += [_mark(x, head + 12 + _ROW * level, scale, area) for (_, x), level in zip(marks, levels)]
    body += [
        _name(name, scale(x), head + 12 + _ROW * level, width) for (name, x), level in zip(marks, levels)
    ]
    body += [_bracket(interval, interval_label, scale, width)] if interval else []
    body.append(x_axis(area, scale, x_label, width))
    return svg.figure(svg.document(width, height, "".join(body), title), title)


def _checked(edges: npt.ArrayLike, counts: npt.ArrayLike) -> tuple[Array, Array]:
    edge, count = np.asarray(edges, dtype=np.float64), np.asarray(counts, dtype=np.float64)
    if edge.ndim != 1 or edge.size < 2 or count.shape != (edge.size - 1,):
        raise DataError(f"A histogram needs n + 1 edges for n counts, got {edge.shape} and {count.shape}.")
    if not (np.isfinite(edge).all() and (np.diff(edge) > 0).all()):
        raise DataError(
            "The edges of a histogram must be finite and increase: sort them and remove repeated ones."
        )
    if not (np.isfinite(count).all() and (count >= 0).all()):
        raise DataError("The counts of a histogram must be finite and not negative.")
    return edge, count


def _bars(edge: Array, count: Array, interval: tuple[float, float] | None, scale: Scale, area: Area) -> str:
    """Bars split where the interval begins and ends, so that the dark area is the coverage probability."""
    density = count / np.diff(edge)
    tallest = float(density.max()) or 1.0
    inner = [v for v in (interval or ()) if edge[0] < v < edge[-1]]
    cuts = np.unique(np.concatenate([edge, inner]))
    out = []
    for a, b in pairwise(cuts):
        middle = (a + b) / 2
        k = min(int(np.searchsorted(edge, middle, side="right")) - 1, count.size - 1)
        tall = float(density[k]) / tallest * (area.bottom - area.top)
        inside = interval is None or interval[0] <= middle <= interval[1]
        how = svg.paint("accent" if inside else "accent-soft") + ' shape-rendering="crispEdges"'
        if tall > 0:
            out.append(svg.rect(scale(a), area.bottom - tall, scale(b) - scale(a), tall, how))
    return "".join(out)


def _levels(marks: Sequence[tuple[str, float]], scale: Scale, width: float) -> list[int]:
    """Row of each mark's label, so that no two labels in a row touch."""
    ends: list[list[tuple[float, float]]] = []
    out = []
    for name, x in marks:
        a, b = _extent(name, scale(x), width)
        row = next((i for i, taken in enumerate(ends) if all(b < c or a > d for c, d in taken)), len(ends))
        if row == len(ends):
            ends.append([])
        ends[row].append((a - 8, b + 8))
        out.append(row)
    return out


def _extent(name: str, x: float, width: float) -> tuple[float, float]:
    """Left and right end of a label centred on x but kept inside the picture."""
    half = text_width(name, svg.SIZE) / 2
    x = min(max(x, half), width - half)
    return x - half, x + half


def _mark(x: float, y: float, scale: Scale, area: Area) -> str:
    how = svg.paint(stroke="c2", width=1.2, dash="4 3")
    return svg.line(scale(x), y + 5, scale(x), area.bottom, how)


def _name(name: str, x: float, y: float, width: float) -> str:
    a, b = _extent(name, x, width)
    return svg.text((a + b) / 2, y, name, "c2", "middle", halo=True)


def _bracket(interval: tuple[float, float], label: str, scale: Scale, width: float) -> str:
    """The interval as a line with end ticks and its name, on top of everything."""
    a, b, y = scale(interval[0]), scale(interval[1]), 21.0
    how = svg.paint(stroke="accent", width=1.3)
    ends = svg.line(a, y, b, y, how) + svg.line(a, y - 4, a, y + 4, how) + svg.line(b, y - 4, b, y + 4, how)
    left, right = _extent(label, (a + b) / 2, width)
    return ends + svg.text((left + right) / 2, y - 8, label, "accent", "middle")


def filled(edges: Array, counts: Array, bars: int = 80) -> tuple[Array, Array]:
    """The filled part of a fine histogram in about 80 bars."""
    total = counts.cumsum()
    inside = np.flatnonzero((total > 5e-4 * total[-1]) & (total < (1 - 5e-4) * total[-1]))
    first, last = (inside[0], inside[-1] + 1) if len(inside) > 1 else (0, len(counts))
    width = max(1, (last - first) // bars)
    last = first + max(1, (last - first) // width) * width
    return edges[first : last + 1 : width], counts[first:last].reshape(-1, width).sum(axis=1)
