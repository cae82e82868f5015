"""Deviations written on the part: the outline of a part seen at an angle, and a label with a leader line for every characteristic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.show.charts.canvas import INK, MUTED, TICK, ChartSheet, add_title, canvas, carrying, plain_label
from vcmm.show.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]
VIEW = (-60.0, 28.0)  # azimuth of the eye from +x towards +y and its elevation, degrees
WIDTH, ROW = 780, 50  # pixels of the picture; of a label
LONGEST_NAME = 36  # characters of a label beside the part
COLUMN = 0.66  # where labels begin, in widths of the part from its middle
EDGE = 1.3  # half of the picture in the same unit


@dataclass(frozen=True)
class Callout:
    """One label. spots (k, 3) mm: places it points at; two of them are joined, as by a dimension. colour: a role; numbers: the values
    shown, as data."""

    name: str
    text: str
    spots: npt.ArrayLike
    verdict: str = ""
    colour: str = "muted"
    value: float = math.nan
    expanded: float = math.nan
    unit: str = "µm"


def callouts(
    outlines: npt.ArrayLike, labels: Sequence[Callout], *, title: str, ax: Axes | ChartSheet | None = None
) -> Axes:
    """Draw labels left and right of a part whose lines (n, 2, 3) are seen from `VIEW`; every leader ends at the place of its label.

    Labels are on the side of their spots, in the order of their heights, so that leaders cross little. The lengths are no scale.
    """
    lines = project(np.asarray(outlines, float).reshape(-1, 3)).reshape(-1, 2, 2)
    spots = [project(np.asarray(callout.spots, float).reshape(-1, 3)) for callout in labels]
    flat = np.vstack([lines.reshape(-1, 2), *spots])
    low, high = flat.min(axis=0), flat.max(axis=0)
    middle, size = (low + high) / 2, float((high - low).max()) or 1.0
    sides = left_and_right([float(s[:, 0].mean() - middle[0]) for s in spots])
    tall = max(300, ROW * (max(map(len, sides), default=0) + 1))
    if isinstance(ax, ChartSheet):
        ax = ChartSheet(WIDTH, ax.height)
    drawn: Any = canvas(ax, tall)
    half = EDGE * tall / WIDTH
    scale = min(1.0, 1.8 * half) / size
    from matplotlib.collections import LineCollection

    drawn.add_collection(
        LineCollection(list(scale * (lines - middle)), colors=LIGHT["faint"], linewidths=0.8)
    )
    for side, of_side in zip((-1, 1), sides):
        heights = [float(spots[i][:, 1].mean()) for i in of_side]
        order = [of_side[k] for k in np.argsort(heights)[::-1]]
        step = 2 * half / (len(order) + 1)
        for row, i in enumerate(order, 1):
            _label(drawn, labels[i], scale * (spots[i] - middle), (side * COLUMN, half - step * row))
    drawn.set_xlim(-EDGE, EDGE)
    drawn.set_ylim(-half, half)
    drawn.set_aspect("equal")
    drawn.axis("off")
    add_title(drawn, title)
    return carrying(
        drawn, chart="callouts", names=[c.name for c in labels], values=[c.value for c in labels], U=[c.expanded for c in labels],
        units=" ".join(c.unit for c in labels), texts=" | ".join(c.text for c in labels), verdicts=" | ".join(c.verdict for c in labels),
    )  # fmt: skip


def project(points: Array) -> Array:
    """Return points (n, 2), to the right and upwards, as the eye of `VIEW` sees points (n, 3), orthographic."""
    a, e = np.radians(VIEW)
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    up = np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])
    return np.asarray(points @ np.stack([right, up], axis=1))


def left_and_right(across: Sequence[float]) -> tuple[list[int], list[int]]:
    """Return the numbers of the labels on either side: half of them on each, by the places of their spots."""
    order = sorted(range(len(across)), key=lambda i: across[i])
    half = len(order) // 2
    return sorted(order[:half]), sorted(order[half:])


def short_name(name: str) -> str:
    """Return a name shortened to the room of a label."""
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def _label(drawn: Any, callout: Callout, spots: Array, at: tuple[float, float]) -> None:
    """Draw the leader from the middle of the spots, a line between two spots, and the words."""
    colour = LIGHT[callout.colour]
    middle = spots.mean(axis=0)
    if len(spots) > 1:
        drawn.plot(spots[:, 0], spots[:, 1], color=colour, linewidth=1.2, marker="o", markersize=3)
    side = math.copysign(1.0, at[0])
    drawn.plot([middle[0], at[0] - 0.05 * side, at[0] - 0.015 * side], [middle[1], at[1], at[1]], color=colour, linewidth=0.9)  # fmt: skip
    drawn.plot(*middle, marker="o", markersize=4, color=colour)
    where = "left" if side > 0 else "right"
    verdict = f": {callout.verdict}" if callout.verdict else ""
    drawn.text(*at, plain_label(short_name(callout.name)), ha=where, va="bottom", fontsize=TICK, color=MUTED)
    drawn.text(*at, plain_label(callout.text + verdict), ha=where, va="top", fontsize=TICK, color=INK if callout.colour == "muted" else colour)  # fmt: skip
