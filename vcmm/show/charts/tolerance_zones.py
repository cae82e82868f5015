"""Pictures of tolerance zones: points between two planes (flatness), an axis in its circle, with the bonus of the size (position)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.show.charts.canvas import ChartSheet, add_legend, canvas, carrying, set_labels
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def flatness_zone(
    along_mm: npt.ArrayLike,
    residual_um: npt.ArrayLike,
    zone_um: float | None,
    *,
    title: str,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot points seen from the side: residuals (n,) um over places (n,) mm, the two planes that hold them, and the zone of the drawing
    about them."""
    x, y = np.asarray(along_mm, float), np.asarray(residual_um, float)
    low, high = float(y.min()), float(y.max())
    middle = (low + high) / 2
    drawn: Any = canvas(ax, 240)
    if zone_um is not None:
        ends = middle - zone_um / 2, middle + zone_um / 2
        drawn.axhspan(*ends, facecolor=LIGHT["good-soft"], linewidth=0.0, label=f"zone of the drawing, {number(zone_um, 3)} µm")  # fmt: skip
    for level, name in ((low, None), (high, "planes that hold all points")):
        drawn.axhline(level, color=LIGHT["c2"], linewidth=1.0, linestyle="--", label=name)
    drawn.plot(x, y, "o", color=LIGHT["c1"], markersize=4, label="points")
    drawn.margins(x=0.04, y=0.12)
    set_labels(
        add_legend(drawn),
        f"{title}\nThe points take {number(high - low, 3)} µm.",
        "along the longer side / mm",
        "from the plane / µm",
    )
    return carrying(drawn, chart="flatness", unit="µm", value=high - low, zone=zone_um, planes=[low, high])


def position_zone(
    off_um: npt.ArrayLike,
    zone_um: float | None,
    paid_um: float = 0.0,
    *,
    title: str,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot an axis (both ends) or centre (k, 2) um about its nominal place in the circle of the zone; dashed: that circle with the bonus of the size.

    The value is the diameter of the circle through the worst end, less the bonus of the size, not below 0 (ISO 1101, ISO 2692).
    """
    off = np.atleast_2d(np.asarray(off_um, float))
    whole = 2.0 * float(np.hypot(off[:, 0], off[:, 1]).max())
    value = max(whole - paid_um, 0.0)
    drawn: Any = canvas(ax, 380)
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    ring = np.column_stack([np.cos(around), np.sin(around)])
    radii = [whole / 2]
    if zone_um is not None:
        radii.append(zone_um / 2)
        drawn.fill(*(zone_um / 2 * ring).T, facecolor=LIGHT["good-soft"], label=f"zone of the drawing, ⌀ {number(zone_um, 3)} µm")  # fmt: skip
        if paid_um > 0:
            radii.append((zone_um + paid_um) / 2)
            drawn.plot(*((zone_um + paid_um) / 2 * ring).T, "--", color=LIGHT["good"], linewidth=1.1, label=f"with {number(paid_um, 3)} µm that the size pays for")  # fmt: skip
    drawn.plot(*(whole / 2 * ring).T, color=LIGHT["c2"], linewidth=1.0, label="circle through the worst end")
    drawn.plot(*off.T, "o-", color=LIGHT["c1"], markersize=5, linewidth=1.2, label="axis" if len(off) > 1 else "centre")  # fmt: skip
    drawn.plot([0.0], [0.0], "+", color=LIGHT["ink"], markersize=9)
    reach = 1.12 * max(*radii, 1e-9)
    drawn.set_xlim(-reach, reach)
    drawn.set_ylim(-reach, reach)
    drawn.set_aspect("equal")
    paid = f" less {number(paid_um, 3)} µm paid by the size" if paid_um > 0 else ""
    set_labels(add_legend(drawn), f"{title}\n⌀ {number(whole, 3)} µm{paid}: {number(value, 3)} µm.", "off / µm", "off / µm")  # fmt: skip
    return carrying(
        drawn, chart="position", unit="µm", value=value, circle=whole, zone=zone_um, paid=paid_um, off=off
    )
