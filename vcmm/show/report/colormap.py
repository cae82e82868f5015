"""Discrete colour bands for maps, safe for colour-blind readers, with their legend.

Sequential: the viridis scale (dark is small). Diverging: blue, white, red, zero always a boundary between bands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vcmm.show.report.text import as_written, escape

if TYPE_CHECKING:
    from vcmm.core.run import Array

SEQUENTIAL = (
    "#440154",
    "#472d7b",
    "#3b528b",
    "#2c728e",
    "#21918c",
    "#28ae80",
    "#5ec962",
    "#addc30",
    "#fde725",
)
DIVERGING = ("#16406f", "#2f6fae", "#8ab6d9", "#e4ecf2", "#f6e7e1", "#eba387", "#c24a3a", "#7d1a20")
NO_VALUE = "#b4bac2"  # a face without a value


@dataclass(frozen=True)
class Bands:
    """Boundaries (n + 1,), increasing, and the n colours between them."""

    levels: Array
    colours: tuple[str, ...]

    def index(self, values: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Return the band of each value, -1 where it is not finite; the last boundary belongs to the last band."""
        data = np.asarray(values, dtype=np.float64)
        band = np.searchsorted(self.levels, data, side="right") - 1
        return np.where(np.isfinite(data), np.clip(band, 0, len(self.colours) - 1), -1).astype(np.int64)


def bands(values: npt.ArrayLike, *, symmetric: bool = False, count: int = 8) -> Bands:
    """Return about `count` bands with round boundaries that hold all finite values; symmetric about zero if asked.

    Values that are not finite are ignored; without any finite value there is one band from 0 to 1.
    """
    data = np.asarray(values, dtype=np.float64).ravel()
    data = data[np.isfinite(data)]
    if data.size == 0:
        return Bands(np.array([0.0, 1.0]), ramp(1, symmetric))
    low, high = float(data.min()), float(data.max())
    if symmetric:
        high = max(abs(low), abs(high))
        low = -high
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        half = abs(high) / 2 or 0.5
        low, high = low - half, high + half
    step = nice_step(high - low, count)
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    levels = np.arange(first, last + 1) * step
    return Bands(levels, ramp(len(levels) - 1, symmetric))


def ramp(count: int, diverging: bool = False) -> tuple[str, ...]:
    """Return `count` colours spread evenly over the whole scale."""
    anchors = DIVERGING if diverging else SEQUENTIAL
    rgb = np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in anchors], dtype=np.float64)
    at = np.linspace(0, len(anchors) - 1, count) if count > 1 else np.array([(len(anchors) - 1) / 2])
    mixed = np.stack([np.interp(at, np.arange(len(anchors)), rgb[:, k]) for k in range(3)], axis=1)
    return tuple("#" + "".join(f"{round(v):02x}" for v in row) for row in mixed)


def legend(scale: Bands, unit: str, tall: float, missing: bool = False) -> str:
    """Return the bar of the bands `tall` pixels high with its labelled boundaries as HTML, the unit above, below what has no value."""
    every = max(1, int(np.ceil(16 * len(scale.colours) / tall)))
    n = len(scale.colours)
    rows = [
        f'<li style="background:{colour}">{_label(scale.levels[i]) if (i % every == 0 and i + every <= n) or i == 0 else ""}</li>'
        for i, colour in enumerate(scale.colours)
    ]
    none = f'<p><i style="background:{NO_VALUE}"></i>none</p>' if missing else ""
    bar = (
        f'<ol style="height:{tall:.0f}px">{"".join(rows)}<li class="end">{_label(scale.levels[n])}</li></ol>'
    )
    return f'<div class="bands"><p>{escape(unit)}</p>{bar}{none}</div>'


def _label(value: float) -> str:
    return f"<span>{as_written(value)}</span>"


def nice_step(span: float, count: int) -> float:
    """Return the step of the series 1, 2, 5, 10 ... that comes closest to `count` intervals in `span` (> 0)."""
    raw = span / max(count, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    factor = raw / power  # borders are the geometric means of neighbours
    return power * (1 if factor < 2**0.5 else 2 if factor < 10**0.5 else 5 if factor < 50**0.5 else 10)
