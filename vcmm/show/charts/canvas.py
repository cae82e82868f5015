"""Target of a picture: the Axes that the caller gives, a figure of its own, or a sheet for a page, in the colours of the reports."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import text_width

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, MUTED, GRID, RULE = LIGHT["ink"], LIGHT["muted"], LIGHT["grid"], LIGHT["rule"]
WORD, TICK = 9, 8.5  # sizes of letters, points
INCH = 100.0  # pixels of a page


@dataclass(frozen=True)
class ChartSheet:
    """Axes for a page, so many pixels large (height None: the default of the chart); made without pyplot, so in any thread."""

    width: int = 500
    height: int | None = None


def canvas(where: Axes | ChartSheet | None, height: int = 300, projection: str | None = None) -> Any:
    """Return the Axes to draw on: those given, those of a sheet, or those of a new figure of pyplot `height` pixels high."""
    options: dict[str, Any] = {"subplot_kw": {"projection": projection}}
    if where is None:
        import matplotlib.pyplot as plt

        size = (6.4, max(3.6, 1.2 * height / INCH))
        return plt.subplots(figsize=size, layout="constrained", **options)[1]
    if not isinstance(where, ChartSheet):
        return where
    from matplotlib.figure import Figure

    figure = Figure(figsize=(where.width / INCH, (where.height or height) / INCH), layout="constrained")
    return figure.subplots(**options)


def carrying(ax: Any, **numbers: Any) -> Any:
    """Return the Axes with the numbers that it shows: `on_page` writes them as data, so that a script (and a test) can read a picture."""
    ax.vcmm_numbers = numbers
    return ax


MOST_NUMBERS = 2000  # of one curve or map in the data of a page; of more its number and ends


def as_data(values: Any) -> Any:
    """Return numbers (n,) or (m, n) to six significant digits, where they are few; else their count and their ends."""
    import numpy as np

    given = np.asarray(values, dtype=float)
    if given.size <= MOST_NUMBERS:
        return [as_data(row) for row in given] if given.ndim > 1 else [float(f"{v:.6g}") for v in given]
    finite = given[np.isfinite(given)]
    return {"numbers": given.size, "ends": [float(finite.min()), float(finite.max())] if finite.size else []}


def panels(count: int, width: float = 6.4, height: float = 2.2, rows: Sequence[int] = ()) -> list[Any]:
    """Return `count` Axes below one another in one figure; rows: number of bars in each, where they are bars."""
    import matplotlib.pyplot as plt

    tall = [0.75 + 0.32 * n for n in rows] or [height] * count
    made = plt.subplots(
        count, 1, figsize=(width, sum(tall)), layout="constrained", squeeze=False, height_ratios=tall
    )[1]
    return list(made[:, 0])


def plain_label(words: str) -> str:
    """Return words as plain text: no mathematics between dollars, and never hidden from a legend by a leading underscore."""
    words = words.replace("$", r"\$")
    return f"\u200a{words}" if words.startswith("_") else words


def add_title(ax: Any, title: str) -> Any:
    """Write the title on the left, above the keys of `keyed`; a second line is smaller on a page."""
    key = ax.get_legend()
    rows = 0 if key is None else math.ceil(len(key.get_texts()) / key._ncols)
    ax.set_title(plain_label(title), fontsize=10, color=INK, loc="left", pad=6.0 + 1.65 * TICK * rows)
    return ax


def set_labels(ax: Any, title: str, x: str, y: str, grid: str = "both") -> Any:
    """Set title, labels with units, and a quiet frame; return ax."""
    ax.set_xlabel(plain_label(x), fontsize=WORD, color=MUTED)
    ax.set_ylabel(plain_label(y), fontsize=WORD, color=MUTED)
    ax.tick_params(labelsize=TICK, colors=RULE, labelcolor=MUTED, length=3)
    if grid:
        ax.grid(True, axis=grid, color=GRID, linewidth=0.8)
    ax.set_axisbelow(True)
    for side, spine in ax.spines.items():
        spine.set_visible(side not in ("top", "right"))
        spine.set_edgecolor(RULE)
    return add_title(ax, title)


def add_legend(ax: Any) -> Any:
    """Add the legend above the picture, as many keys in a row as fit; none where nothing has a name."""
    handles, names = ax.get_legend_handles_labels()
    if names:
        wide = 500.0 if ax.figure is None else INCH * ax.figure.get_figwidth()
        most = max(text_width(name, TICK / 0.72) for name in names) + 50.0
        ax.legend(
            handles, names, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=max(1, int(wide / most)), fontsize=TICK,
            frameon=False, labelcolor=MUTED, borderaxespad=0.2, handlelength=1.6, columnspacing=1.2,
        )  # fmt: skip
    return ax
