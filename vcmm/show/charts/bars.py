"""Bars of contributions to an uncertainty, of probabilities of names, and the waterfall of a budget: growth of u from the largest contribution to the total."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, Protocol

from vcmm.core.errors import UsageError, choose_from
from vcmm.show.charts.canvas import MUTED, TICK, ChartSheet, canvas, carrying, plain_label, set_labels
from vcmm.show.charts.inline import HINT
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import DASH, align_decimals, number, shorten, text_width

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Share = Literal["square", "linear", "none"]
MOST_BARS = 12
ROUNDING = 5e-4  # of u^2: smaller shares are printed as 0.0 %
NAME, ROW = 200.0, 30  # px: of a name at most, of a bar
FREE, BEFORE = 0.36, 0.16  # of the width, for figures behind the longest bar, and before the lowest


class _Contribution(Protocol):
    @property
    def what(self) -> str: ...
    @property
    def u(self) -> float: ...
    @property
    def share(self) -> float: ...


def contributions(
    lines: Sequence[_Contribution], title: str = "budget", ax: Axes | ChartSheet | None = None
) -> Axes:
    """Return one bar per line (share of u^2 in percent), the largest on top; past the twelfth they are summed up.

    What would be printed as 0.0 % is left out.
    """
    ranked = sorted((line for line in lines if line.share >= ROUNDING), key=lambda line: -line.share)
    items = [(line.what, 100.0 * line.share) for line in ranked]
    if len(ranked) > MOST_BARS:
        rest = items[MOST_BARS - 1 :]
        items = [*items[: MOST_BARS - 1], (f"{len(rest)} others", sum(share for _, share in rest))]
    return bars(items, unit="%", title=title, share="none", label="share of u² / %", ax=ax)


def probabilities(
    names: Sequence[str], values: Sequence[float], title: str, ax: Axes | ChartSheet | None = None
) -> Axes:
    """Return one bar per name, probability in percent, in the order given."""
    items = [(name, 100.0 * v) for name, v in zip(names, values)]
    return bars(items, unit="%", title=title, share="none", label="probability / %", longest=100.0, ax=ax)


def shares(values: Sequence[float], total: float | None = None, share: Share = "square") -> list[float]:
    """Return the share of each value, 1 = all of it.

    "square": (u_i / u)^2, the index of EA-4/02 and of the law of propagation (GUM 5.1.2); u = root sum of squares
    of the values unless `total` gives it (then the shares may add to less than 1: interaction). "linear":
    |v_i| / total, total = sum of |v_i| unless given. A total of zero gives NaN shares.
    """
    if share not in ("square", "linear", "none"):
        raise UsageError(f'Unknown share "{share}".{choose_from(share, ("square", "linear", "none"))}')
    power = 2 if share == "square" else 1
    sizes = [abs(v) ** power if math.isfinite(v) else math.nan for v in values]
    whole = sum(s for s in sizes if math.isfinite(s)) if total is None else abs(total) ** power
    return [s / whole if whole > 0 else math.nan for s in sizes]


def percent(value: float) -> str:
    """Return "38 %", "<1 %", or an en dash."""
    if not math.isfinite(value):
        return DASH
    if 0 < value < 0.005:
        return "<1 %"
    return f"{100 * value:.0f} %"


def bars(
    items: Sequence[tuple[str, float]],
    *,
    unit: str,
    title: str,
    total: float | None = None,
    share: Share = "square",
    longest: float = 0.0,
    label: str = "",
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Return one bar per (name, value) in the order given, with the value and its share in percent (see `shares`).

    Negative values go to the left of zero in a colour of their own (tornado); what is not finite has no bar.
    longest: a value that must fit too, so that charts side by side have one scale.
    """
    names, values = [name for name, _ in items], [float(v) for _, v in items]
    parts, figures = shares(values, total, share), align_decimals(values)
    drawn = canvas(ax, 46 + ROW * max(len(items), 1))
    wide = [v if math.isfinite(v) else 0.0 for v in values]
    colours = [LIGHT["accent"] if v >= 0 else LIGHT["c2"] for v in wide]
    made = drawn.barh(range(len(items)), wide, color=colours, height=0.55)
    words = figures if share == "none" else [f"{f} · {percent(p)}" for f, p in zip(figures, parts)]
    drawn.bar_label(made, labels=words, padding=4, fontsize=TICK, color=MUTED)
    for bar, name, value in zip(made, names, values):
        bar.set_gid(f"{HINT}{name}: {number(value, 3)}")
    drawn.set_yticks(range(len(items)), [plain_label(in_two_lines(name)) for name in names])
    drawn.set_ylim(len(items) - 0.4, -0.6)
    low, high = min([0.0, *wide]), max([0.0, longest, *wide])
    before = BEFORE if low < 0 else 0.0
    reach = (high - low or 1.0) / (1.0 - FREE - before)
    drawn.set_xlim(low - before * reach, low + (1.0 - before) * reach)
    kind = {"square": ", share of u²", "linear": ", share", "none": ""}[share]
    drawn.axvline(0.0, color=LIGHT["rule"], linewidth=0.8)
    set_labels(drawn, title, label or f"{unit}{kind}", "", grid="x")
    return carrying(drawn, chart="bars", unit=unit, names=names, values=values, total=total)


def in_two_lines(name: str) -> str:
    """Return a name in one line or two, broken between words; a text too long for both loses words in its middle."""
    if text_width(name, 12.0) <= NAME:
        return name
    words = name.split()
    for first in range(len(words) - 1, 0, -1):
        above, below = " ".join(words[:first]), " ".join(words[first:])
        if text_width(above, 12.0) <= NAME:
            return f"{above}\n{shorten(below, 12.0, NAME)}"
    return shorten(name, 12.0, NAME)


MOST_STEPS = 8


def waterfall(
    items: Sequence[tuple[str, float]],
    total: float,
    *,
    unit: str,
    title: str,
    most: int = MOST_STEPS,
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
    most = max(1, min(most, sum(u * u >= ROUNDING * total**2 for _, u in ranked)))
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
