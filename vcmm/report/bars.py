"""Horizontal bars: an uncertainty budget (share of the variance), a tornado (signed effects), a stacked share bar."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from vcmm.core.errors import UsageError, choose_from
from vcmm.report import svg
from vcmm.report.axes import Scale
from vcmm.report.palette import SERIES
from vcmm.report.text import DASH, aligned, number, shorten, text_width, widest

Share = Literal["square", "linear", "none"]
_ROW, _BAR = 27.0, 13.0


def shares(values: Sequence[float], total: float | None = None, share: Share = "square") -> list[float]:
    """Share of each value, 1 = all of it.

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
    """ "38 %", "<1 %", or an en dash."""
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
    width: int = svg.HALF,
    longest: float = 0.0,
) -> str:
    """One bar per (name, value), with the value and its share in per cent (see `shares`).

    Lengths are proportional to the value; negative values grow to the left of a zero line (tornado). Order is kept.
    longest: a value that must fit too, so that charts side by side have one scale.
    """
    values = [float(v) for _, v in items]
    parts = shares(values, total, share)
    numbers, percents = aligned(values), [percent(p) for p in parts]
    shown = share != "none"
    right = width - (max(widest(percents, svg.SIZE), 62.0) + 14 if shown else 0)
    left = min(widest([name for name, _ in items], svg.SIZE) + 14, 0.46 * width)
    end = right - widest([*numbers, unit], svg.SIZE) - 14
    scale = _scale([*values, longest], left, end)
    out = [svg.text(right, 12, unit, "muted", "end", 11.5)]
    if shown:
        out.append(svg.text(width, 12, "share of u²" if share == "square" else "share", "muted", "end", 11.5))
    for i, (name, value) in enumerate(items):
        y = 22 + i * _ROW
        out.append(_bar(name, value, scale, y, left))
        out.append(svg.text(right, y + 13, numbers[i], "ink", "end"))
        if shown:
            out.append(svg.text(width, y + 13, percents[i], "muted", "end"))
    height = 24 + _ROW * len(items)
    zero = scale(0.0)
    out.append(svg.line(zero, 20, zero, height - 4, svg.paint(stroke="rule")))
    return svg.figure(svg.document(width, height, "".join(out), title), title)


def _scale(values: Sequence[float], left: float, end: float) -> Scale:
    finite = [v for v in values if math.isfinite(v)]
    low, high = min([0.0, *finite]), max([0.0, *finite])
    return Scale(low, high if high > low else low + 1.0, left, end)


def _bar(name: str, value: float, scale: Scale, y: float, left: float) -> str:
    label = shorten(name, svg.SIZE, left - 12)
    words = svg.text(0, y + 13, label, "ink").replace(
        "</text>", f"{svg.tooltip(name)}</text>" if label != name else "</text>"
    )
    if not math.isfinite(value):
        return words
    a, b = sorted((scale(0.0), scale(value)))
    role = "accent" if value >= 0 else "c2"
    return words + svg.rect(a, y + 2.5, b - a, _BAR, svg.paint(role), f"{name}: {number(value, 3)}")


def stacked(
    items: Sequence[tuple[str, float]], *, title: str, share: Share = "square", width: int = svg.HALF
) -> str:
    """One bar divided by share, largest part keeps its place; names and per cent in the legend below."""
    parts = shares([float(v) for _, v in items], None, share)
    out, entries, x = [], [], 0.0
    for i, ((name, _), part) in enumerate(zip(items, parts)):
        colour, fade = SERIES[i % len(SERIES)], 1.0 if i < len(SERIES) else 0.5
        wide = width * (part if math.isfinite(part) else 0.0)
        how = svg.paint(colour, opacity=fade)
        out.append(svg.rect(x, 2, max(wide - 1.0, 0.0), 24, how, f"{name}: {percent(part)}"))
        if wide > text_width(percent(part), 11.5) + 10:
            out.append(svg.text(x + wide / 2, 18.5, percent(part), "surface", "middle", 11.5))
        entries.append((svg.rect(0, 0, 16, 10, how), f"{name} · {percent(part)}"))
        x += wide
    keys, height = svg.legend(entries, 0, 40, width)
    return svg.figure(svg.document(width, 46 + height, "".join(out) + keys, title), title)
