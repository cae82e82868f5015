"""Curves over an axis: an error with its band (ISO 230-2 style), and readings by the sense of motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vcmm.charts.canvas import canvas, plain
from vcmm.core.run import Array
from vcmm.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SENSES = ((1.0, "upwards", "c1", "o"), (-1.0, "downwards", "c2", "s"), (0.0, "at rest", "c6", "."))


def band(
    nodes: Array, value: Array, u: Array, *, unit: str, title: str, label: str = "position / mm", ax: Axes | None = None
) -> Axes:  # fmt: skip
    """value (n,) over nodes (n,) with the band value +- 2 u, all in `unit`."""
    drawn = canvas(ax)
    drawn.fill_between(nodes, value - 2 * u, value + 2 * u, color=LIGHT["accent-soft"], label="± 2 u")
    drawn.plot(nodes, value, color=LIGHT["accent"], linewidth=1.5)
    drawn.axhline(0.0, color=LIGHT["rule"], linewidth=0.8)
    drawn.legend(fontsize=8, frameon=False)
    return plain(drawn, title, label, unit)


def readings(
    position: Array, value: Array, sense: Array, *, unit: str, title: str, label: str, ax: Axes | None = None
) -> Axes:
    """Readings (n,) in `unit` over position (n,), those of each sense of motion (+1, -1, 0) in a colour of their own."""
    drawn = canvas(ax)
    there = [one for one in SENSES if (sense == one[0]).any()]
    for number, name, colour, shape in there:
        mine = sense == number
        drawn.plot(
            position[mine], value[mine], shape, color=LIGHT[colour], markersize=3.5, alpha=0.8,
            label=f"{name} ({int(np.count_nonzero(mine))})", linestyle="none",
        )  # fmt: skip
    if len(there) > 1:
        drawn.legend(fontsize=8, frameon=False)
    return plain(drawn, title, label, unit)
