"""Where a picture goes: the Axes that the caller gives, or a figure of its own in the colours of the reports."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vcmm.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, MUTED, GRID = LIGHT["ink"], LIGHT["muted"], LIGHT["grid"]


def canvas(ax: Axes | None, width: float = 6.4, height: float = 3.6, space: bool = False) -> Any:
    """The Axes to draw on: `ax`, or those of a new figure of so many inches; space: with three dimensions."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    options: dict[str, Any] = {"projection": "3d"} if space else {}
    return plt.subplots(figsize=(width, height), layout="constrained", subplot_kw=options)[1]


def panels(count: int, width: float = 6.4, height: float = 2.2) -> list[Any]:
    """`count` Axes below one another in one figure."""
    import matplotlib.pyplot as plt

    made = plt.subplots(count, 1, figsize=(width, height * count), layout="constrained", squeeze=False)[1]
    return list(made[:, 0])


def plain(ax: Any, title: str, x: str, y: str, grid: str = "both") -> Any:
    """Title, labels with units, and a quiet frame; returns ax."""
    ax.set_title(title, fontsize=10, color=INK, loc="left")
    ax.set_xlabel(x, fontsize=9, color=MUTED)
    ax.set_ylabel(y, fontsize=9, color=MUTED)
    ax.tick_params(labelsize=8, colors=MUTED)
    ax.grid(True, axis=grid, color=GRID, linewidth=0.8)
    ax.set_axisbelow(True)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    return ax
