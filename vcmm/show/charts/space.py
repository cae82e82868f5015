"""Pictures in space: tip errors as arrows, touches on a part, heights of a cut surface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.show.charts.canvas import ChartSheet, add_title, canvas, plain_label
from vcmm.show.charts.maps import add_colour_bar, colours_of
from vcmm.show.report.colormap import bands
from vcmm.show.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.core.run import Array

LONGEST = 0.12  # of the extent: the length of the largest arrow
FLAT = 0.2  # of the longest edge: the shortest that is drawn
TICKS = 6  # intervals of the longest edge
BOX_SHARE = 0.76  # size of the box within the picture, so that labels are not cut
NAME, NUMBER = 26.0, 9.0  # points from an edge to its name and its numbers, where the box is widest across
TO_NAME, TO_NUMBER = 21.0, 8.0  # what matplotlib adds by itself
LABELS = ("X / mm", "Y / mm", "Z / mm")


def motions(places: Array, vectors: Array, title: str, ax: Axes | ChartSheet | None = None) -> Axes:
    """Plot vectors (n, 3) mm at places (n, 3) mm; the title states the magnification, a round number."""
    drawn = canvas(ax, 420, "3d")
    size = float(np.linalg.norm(vectors, axis=1).max(initial=0.0))
    extent = _longest(places)
    times = round_down(LONGEST * extent / size) if size > 0 else 1.0
    drawn.quiver(*places.T, *(times * vectors).T, color=LIGHT["accent"], linewidth=1.0)
    drawn.scatter(*places.T, color=LIGHT["faint"], s=4)
    return _space(drawn, f"{title}, arrows {times:g} x", places)


def touches(
    places: Array,
    normals: Array,
    features: npt.NDArray[np.str_],
    title: str,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot touched points (n, 3) mm with their outward normals (n, 3), a colour per feature (n,) of names."""
    drawn = canvas(ax, 420, "3d")
    reach = 0.08 * _longest(places)
    for number, name in enumerate(dict.fromkeys(str(f) for f in features)):
        mine, colour = features == name, LIGHT[f"c{1 + number % 6}"]
        drawn.scatter(*places[mine].T, color=colour, s=10, label=plain_label(name))
        drawn.quiver(*places[mine].T, *(reach * normals[mine]).T, color=colour, linewidth=0.7, alpha=0.6)
    if len(places):
        drawn.legend(fontsize=8, frameon=False)
    return _space(drawn, title, places)


def heights(places: Array, height: Array, title: str, ax: Axes | ChartSheet | None = None) -> Axes:
    """Plot departures height (n,) um of a surface at places (n, 3) mm, symmetric colours; uncut places are left out."""
    drawn = canvas(ax, 420, "3d")
    cut = np.isfinite(height)
    scale = bands(height[cut], symmetric=True)
    colours, norm = colours_of(scale)
    made = drawn.scatter(*places[cut].T, c=height[cut], cmap=colours, norm=norm, s=5)
    add_colour_bar(drawn, made, scale, "material left over (+) / µm")
    return _space(drawn, title, places)


def round_down(value: float) -> float:
    """Return the next lower of 1, 2, 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(k for k in (1.0, 2.0, 5.0) if k * power <= value * (1 + 1e-12)))


def _longest(places: Array) -> float:
    """Return the longest edge of the box about places (n, 3), mm; 1 where it has none."""
    return (float(np.ptp(places, axis=0).max()) if len(places) else 0.0) or 1.0


def _space(drawn: Any, title: str, places: Array) -> Any:
    """Set up Axes true to scale, with edges shorter than FLAT of the longest drawn longer, and as many ticks as an edge has room for."""
    from matplotlib.ticker import MaxNLocator

    extent = np.ptp(places, axis=0) if len(places) else np.ones(3)
    shown = np.maximum(extent / _longest(places), FLAT) if len(places) else extent
    for i, (axis, name) in enumerate(zip("xyz", LABELS)):
        across = float(np.delete(shown, i).max())  # of which matplotlib takes a share for every point
        getattr(drawn, f"set_{axis}label")(name, fontsize=8, labelpad=NAME / across - TO_NAME)
        getattr(drawn, f"{axis}axis").set_major_locator(MaxNLocator(max(1, round(TICKS * shown[i]))))
        drawn.tick_params(axis, labelsize=7, pad=NUMBER / across - TO_NUMBER)
    drawn.set_box_aspect(shown, zoom=BOX_SHARE)
    return add_title(drawn, title)
