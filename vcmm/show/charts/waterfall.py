"""The waterfall of a budget: growth of u, contribution by contribution, from the largest to the total."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vcmm.show.charts.bars import ROW, in_two_lines
from vcmm.show.charts.canvas import MUTED, TICK, ChartSheet, canvas, carrying, plain_label, set_labels
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_BARS = 8
ROUNDED = 0.0005  # shares below it are printed as 0.0 %


def waterfall(
    items: Sequence[tuple[str, float]],
    total: float,
    *,
    unit: str,
    title: str,
    most: int = MOST_BARS,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot standard contributions (name, u_i) added in quadrature (GUM 5.1.2), largest first; the last bar is `total`, the u of the table.

    Bar i runs from sqrt(u_1^2 + .. + u_(i-1)^2) to sqrt(u_1^2 + .. + u_i^2), so the ends join. What lies past `most`, or has a
    share that tables print as 0.0 %, is one bar. Where
    the squares do not add up to total^2 a bar "interaction" closes the gap (up or down), as the table says it.
    """
    ranked = sorted(
        ((n, abs(float(u))) for n, u in items if math.isfinite(u) and u != 0.0), key=lambda p: -p[1]
    )
    most = max(1, min(most, sum(u * u >= ROUNDED * total**2 for _, u in ranked)))
    rest = math.sqrt(sum(u * u for _, u in ranked[most:]))
    shown = ranked[:most] + ([(f"{len(ranked) - most} others", rest)] if rest else [])
    steps, at = [], 0.0
    for name, u in shown:
        after = math.hypot(at, u)
        steps.append((name, at, after, u))
        at = after
    gap = total**2 - at**2
    if abs(gap) > 1e-3 * max(total**2, at**2):
        steps.append(("interaction", at, total, math.copysign(math.sqrt(abs(gap)), gap)))
    drawn: Any = canvas(ax, 56 + ROW * (len(steps) + 1))
    for i, (_, low, high, u) in enumerate(steps):
        colour = LIGHT["accent"] if high >= low else LIGHT["c2"]
        drawn.barh(i, high - low, left=low, height=0.55, color=colour)
        _beside(drawn, max(low, high), i, number(u, 3), color=MUTED)
        if i + 1 < len(steps):
            drawn.plot([high, high], [i - 0.28, i + 1.28], color=LIGHT["rule"], linewidth=0.8, zorder=0.5)
    drawn.barh(len(steps), total, height=0.55, color=LIGHT["ink"])
    _beside(drawn, total, len(steps), number(total, 3), color=LIGHT["ink"], fontweight="bold")
    names = [in_two_lines(name) for name, *_ in steps] + ["u"]
    drawn.set_yticks(range(len(names)), [plain_label(n) for n in names])
    drawn.set_ylim(len(names) - 0.4, -0.6)
    drawn.set_xlim(0.0, 1.22 * max([total, *(h for _, _, h, _ in steps)], default=1.0) or 1.0)
    set_labels(drawn, title, f"standard uncertainty, added in quadrature / {unit}", "", grid="x")
    return carrying(
        drawn, chart="waterfall", unit=unit, names=[n for n, *_ in steps], values=[u for *_, u in steps],
        ends=[h for _, _, h, _ in steps], total=total,
    )  # fmt: skip


def _beside(drawn: Any, x: float, y: float, words: str, **look: Any) -> None:
    drawn.annotate(words, (x, y), (5, 0), textcoords="offset points", va="center", fontsize=TICK, **look)
