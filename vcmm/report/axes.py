"""Axes of a chart: linear scales, ticks at 1-2-5 steps, thin grid, labels that say quantity and unit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vcmm.report import svg
from vcmm.report.text import MINUS, text_width, widest

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Scale:
    """Linear map from data [low, high] to pixels [start, end]."""

    low: float
    high: float
    start: float
    end: float

    def __call__(self, value: float) -> float:
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def many(self, values: npt.ArrayLike) -> Array:
        """The same for an array of any shape."""
        data = np.asarray(values, dtype=np.float64)
        return self.start + (data - self.low) / (self.high - self.low) * (self.end - self.start)


@dataclass(frozen=True)
class Area:
    """The rectangle of a chart in which data is drawn, pixels."""

    left: float
    top: float
    right: float
    bottom: float


def nice_step(span: float, count: int) -> float:
    """The step of the series 1, 2, 5, 10 ... that comes closest to `count` intervals in `span` (> 0)."""
    raw = span / max(count, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    factor = raw / power  # borders are the geometric means of neighbours
    return power * (1 if factor < 2**0.5 else 2 if factor < 10**0.5 else 5 if factor < 50**0.5 else 10)


def nice_ticks(low: float, high: float, count: int = 6) -> Array:
    """Ticks at multiples of a nice step inside [low, high] (high > low)."""
    step = nice_step(high - low, count)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.arange(first, last + 1, dtype=np.float64) * step


def tick_text(ticks: npt.ArrayLike) -> list[str]:
    """Labels with just enough decimals to tell neighbours apart and to be exact."""
    values = [float(t) for t in np.atleast_1d(np.asarray(ticks, dtype=np.float64))]
    step = min((abs(b - a) for a, b in pairwise(values)), default=abs(values[0]) if values else 1.0)
    decimals = 0
    while decimals < 12 and any(abs(round(v, decimals) - v) > 1e-6 * (step or 1.0) for v in values):
        decimals += 1
    return [f"{v + 0.0:.{decimals}f}".replace("-", MINUS) if abs(v) > 1e-12 * step else "0" for v in values]


def span_of(values: npt.ArrayLike, margin: float = 0.05) -> tuple[float, float]:
    """(low, high) of the finite values, widened by `margin` of the range; never empty."""
    data = np.asarray(values, dtype=np.float64).ravel()
    data = data[np.isfinite(data)]
    if data.size == 0:
        return 0.0, 1.0
    low, high = float(data.min()), float(data.max())
    pad = margin * (high - low) if high > low else max(abs(low), 1.0) * 0.05
    return low - pad, high + pad


def room_left(ticks: Array, least: float = 34.0) -> float:
    """Width that the labels of the y axis need."""
    return max(least, widest(tick_text(ticks), svg.SIZE) + 14)


def fitting_ticks(scale: Scale, count: int = 8) -> Array:
    """Ticks of a horizontal axis, as many as fit without their labels touching."""
    length = abs(scale.end - scale.start)
    for n in range(count, 1, -1):
        ticks = nice_ticks(scale.low, scale.high, n)
        if len(ticks) * (widest(tick_text(ticks), svg.SIZE) + 14) <= length:
            return ticks
    return nice_ticks(scale.low, scale.high, 2)


def x_axis(area: Area, scale: Scale, label: str, width: float) -> str:
    """Baseline, tick labels and the centred axis label (needs 40 px below the area) in a picture of `width`."""
    ticks = fitting_ticks(scale)
    out = [svg.line(area.left, area.bottom, area.right, area.bottom, svg.paint(stroke="rule"))]
    for value, words in zip(ticks, tick_text(ticks)):
        x = scale(float(value))
        out.append(svg.line(x, area.bottom, x, area.bottom + 4, svg.paint(stroke="rule")))
        half = text_width(words, svg.SIZE) / 2
        out.append(svg.text(min(max(x, half), width - half), area.bottom + 18, words, "muted", "middle"))
    out.append(svg.text((area.left + area.right) / 2, area.bottom + 36, label, "muted", "middle"))
    return "".join(out)


def y_axis(area: Area, scale: Scale, ticks: Array) -> str:
    """Horizontal grid lines and tick labels."""
    out = []
    for value, words in zip(ticks, tick_text(ticks)):
        y = scale(float(value))
        out.append(svg.line(area.left, y, area.right, y, svg.paint(stroke="grid")))
        out.append(svg.text(area.left - 8, y + 4.3, words, "muted", "end"))
    return "".join(out)
