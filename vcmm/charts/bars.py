"""Bars: what contributes how much to an uncertainty, and how probable names are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from vcmm.charts.canvas import canvas, plain
from vcmm.report.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHOWN = 12
ROUNDING = 5e-4  # of u^2: printed as 0.0 %
ROUNDING = 5e-4  # of u^2: printed as 0.0 %


class _Contribution(Protocol):
    @property
    def what(self) -> str: ...
    @property
    def u(self) -> float: ...
    @property
    def share(self) -> float: ...


class PlottedBudget(tuple[Any, ...]):
    """The lines of a budget, a tuple of BudgetLine with a picture."""

    def plot(self, ax: Axes | None = None, title: str = "budget") -> Axes:
        """Shares of u^2, the largest first."""
        return contributions(self, title, ax)


def contributions(lines: Sequence[_Contribution], title: str = "budget", ax: Axes | None = None) -> Axes:
    """One bar per line (share of u^2 in percent), the largest on top; past the twelfth they are summed up.

    What would be printed as 0.0 % is left out.
    """
    ranked = sorted((line for line in lines if line.share >= ROUNDING), key=lambda line: -line.share)
    names, shares = [line.what for line in ranked], [100.0 * line.share for line in ranked]
    if len(ranked) > SHOWN:
        rest = len(ranked) - SHOWN + 1
        names, shares = (
            [*names[: SHOWN - 1], f"{rest} others"],
            [*shares[: SHOWN - 1], sum(shares[SHOWN - 1 :])],
        )
    return _bars(names, shares, title, "share of u² / %", ax)


def probabilities(names: Sequence[str], values: Sequence[float], title: str, ax: Axes | None = None) -> Axes:
    """One bar per name, probability in percent, in the order given."""
    made = _bars(names, [100.0 * v for v in values], title, "probability / %", ax)
    made.set_xlim(0.0, 112.0)
    return made


def _bars(names: Sequence[str], values: Sequence[float], title: str, label: str, ax: Axes | None) -> Any:
    drawn = canvas(ax, height=0.9 + 0.28 * max(len(names), 1))
    at = range(len(names))
    made = drawn.barh(at, values, color=LIGHT["accent"], height=0.7)
    drawn.bar_label(made, labels=[f"{v:.1f}" for v in values], padding=3, fontsize=8, color=LIGHT["muted"])
    drawn.set_yticks(at, names)
    drawn.invert_yaxis()
    return plain(drawn, title, label, "", grid="x")
