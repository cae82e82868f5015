"""A map of one quantity over two others in discrete colour bands: U over the pose, an error over a plane, the surface of a cut."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.show.charts.canvas import (
    INK,
    MUTED,
    RULE,
    TICK,
    WORD,
    ChartSheet,
    as_data,
    canvas,
    carrying,
    plain_label,
    set_labels,
)
from vcmm.show.report.colormap import Bands, bands
from vcmm.show.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.core.run import Array


def heat_map(
    values: npt.ArrayLike,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    *,
    x_label: str,
    y_label: str,
    unit: str,
    title: str,
    symmetric: bool = False,
    marks: Sequence[tuple[str, float, float]] = (),
    over: npt.ArrayLike | None = None,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot `values` (ny, nx) at cell centres x (nx,) and y (ny,), both increasing. Cells without a value are hatched.

    `symmetric`: blue-white-red about zero, for signed quantities. `marks`: (name, x, y), for example the best pose.
    `over`: values whose colours these are, of all maps that are compared. DataError: shapes that do not fit, x or y not increasing.
    """
    data, xc, yc = _check_grid(values, x, y)
    drawn = canvas(ax, 340)
    scale = bands(data if over is None else np.asarray(over, dtype=np.float64), symmetric=symmetric)
    colours, norm = colours_of(scale)
    if not np.isfinite(data).all():
        drawn.patch.set(hatch="////", edgecolor=LIGHT["faint"])
        drawn.plot(
            [],
            [],
            "s",
            markersize=7,
            markerfacecolor="none",
            color=LIGHT["faint"],
            label="hatched: not evaluated",
        )
        drawn.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=TICK, frameon=False, labelcolor=MUTED
        )
    made = drawn.pcolormesh(
        cell_edges(xc), cell_edges(yc), np.ma.masked_invalid(data), cmap=colours, norm=norm, rasterized=True
    )
    for name, mx, my in marks:
        if np.isfinite([mx, my]).all():
            _mark(drawn, name, mx, my, mx > (xc[0] + xc[-1]) / 2)
    add_colour_bar(drawn, made, scale, unit)
    set_labels(drawn, title, x_label, y_label, grid="")
    finite = data[np.isfinite(data)]
    least, most = (float(finite.min()), float(finite.max())) if finite.size else (np.nan, np.nan)
    ends = {
        "x": as_data(xc), "y": as_data(yc), "values": as_data(data), "marks": [[name, mx, my] for name, mx, my in marks],
        "least": least, "most": most, "levels": scale.levels,
    }  # fmt: skip
    return carrying(drawn, chart="map", unit=unit, **ends)


def is_of_one_colour(
    values: npt.ArrayLike, over: npt.ArrayLike | None = None, symmetric: bool = False
) -> bool:
    """Return whether a map would have one colour only, so that a sentence is clearer."""
    data = np.asarray(values, dtype=np.float64)
    scale = bands(data if over is None else np.asarray(over, dtype=np.float64), symmetric=symmetric)
    inner = np.asarray(scale.levels[1:-1], dtype=np.float64)
    return len(np.unique(np.digitize(data[np.isfinite(data)], inner))) < 2


def colours_of(scale: Bands) -> tuple[Any, Any]:
    """Return (colour map, norm) of matplotlib for bands."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    return ListedColormap(list(scale.colours)), BoundaryNorm(scale.levels, len(scale.colours))


def add_colour_bar(drawn: Any, made: Any, scale: Bands, unit: str) -> None:
    """Add the bar of colours beside a picture, with every boundary labelled where there is room."""
    bar = drawn.figure.colorbar(
        made, ax=drawn, aspect=24, pad=0.02, ticks=scale.levels[:: 1 + (len(scale.levels) - 1) // 12]
    )
    bar.set_label(plain_label(unit), fontsize=WORD, color=MUTED)
    bar.ax.tick_params(labelsize=TICK, color=RULE, labelcolor=MUTED, length=2)
    bar.outline.set_edgecolor(RULE)


def cell_edges(centres: Array) -> Array:
    """Return the borders (n + 1,) half-way between the centres (n,); a single centre gets a cell of width 1."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def _check_grid(values: npt.ArrayLike, x: npt.ArrayLike, y: npt.ArrayLike) -> tuple[Array, Array, Array]:
    data, xc, yc = (np.asarray(a, dtype=np.float64) for a in (values, x, y))
    if xc.ndim != 1 or yc.ndim != 1 or data.shape != (yc.size, xc.size) or data.size == 0:
        raise DataError(
            f"A heat map needs values (ny, nx), x (nx,), y (ny,); got {data.shape}, {xc.shape}, {yc.shape}."
        )
    for name, axis in (("x", xc), ("y", yc)):
        if not (np.isfinite(axis).all() and (np.diff(axis) > 0).all()):
            raise DataError(
                f"The {name} positions of a heat map must be finite and increase: sort them with the values."
            )
    return data, xc, yc


def _mark(drawn: Any, name: str, x: float, y: float, left: bool) -> None:
    """Draw a ringed dot and its name on a small plate on the side where there is room."""
    drawn.plot(
        [x],
        [y],
        "o",
        markersize=6,
        markerfacecolor=LIGHT["surface"],
        markeredgecolor=INK,
        markeredgewidth=1.3,
    )
    if name:
        drawn.annotate(
            plain_label(name), (x, y), (-9 if left else 9, 0), textcoords="offset points", ha="right" if left else "left", va="center",
            fontsize=TICK, color=INK, bbox={"boxstyle": "round,pad=0.2", "facecolor": LIGHT["surface"], "edgecolor": "none", "alpha": 0.88},
        )  # fmt: skip
