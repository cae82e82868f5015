"""The decision picture of ISO 14253-1: conformance, uncertainty and non-conformance zones, result with its U bar;
and tolerance zones: points between two planes (flatness), an axis in its circle, with the bonus of the size (position).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.show.charts.canvas import (
    INK,
    MUTED,
    WORD,
    ChartSheet,
    add_legend,
    canvas,
    carrying,
    plain_label,
    set_labels,
)
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import as_written as as_given
from vcmm.show.report.text import number, with_uncertainty

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAMES = {"good": "conformance zone", "warning": "uncertainty zone", "bad": "non-conformance zone"}
MARGIN_SHARE = 0.14  # of what is shown, on both sides


@dataclass(frozen=True)
class Zone:
    """An interval of the value axis and its kind: good, warning or bad."""

    low: float
    high: float
    kind: str


def zone_list(lower: float | None, upper: float | None, guard: float) -> list[Zone]:
    """Return the zones from left to right over the whole axis (ends are infinite).

    Conformance [lower + guard, upper - guard], non-conformance outside [lower - guard, upper + guard], uncertainty
    zone between. A guard band above half of the tolerance leaves no conformance zone.
    UsageError: no limit, lower >= upper, negative guard band.
    """
    if lower is None and upper is None:
        raise UsageError("A decision needs a lower or an upper limit: give at least one of them.")
    if lower is not None and upper is not None and lower >= upper:
        raise UsageError(f"The lower limit {lower:g} is not below the upper limit {upper:g}: exchange them.")
    if not guard >= 0:
        raise UsageError(f"The guard band must be zero or positive, got {guard:g}.")
    low = -math.inf if lower is None else lower
    high = math.inf if upper is None else upper
    cuts = [-math.inf, low - guard, low + guard, high - guard, high + guard, math.inf]
    if cuts[2] > cuts[3]:
        cuts[2] = cuts[3] = (cuts[2] + cuts[3]) / 2
    kinds = ("bad", "warning", "good", "warning", "bad")
    return [Zone(a, b, kind) for a, b, kind in zip(cuts, cuts[1:], kinds) if b > a]


def zone_of(value: float, zones: list[Zone]) -> Zone:
    """Return the zone that holds the value; on a boundary, the better one."""
    order = {"good": 0, "warning": 1, "bad": 2}
    return min((z for z in zones if z.low <= value <= z.high), key=lambda z: order[z.kind])


def zones(
    lower: float | None,
    upper: float | None,
    value: float,
    expanded: float,
    guard: float,
    *,
    unit: str,
    title: str,
    decision: str = "",
    span: tuple[float, float] | None = None,
    of: str = "true value",
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot tolerance limits (either may be None), result `value` with expanded uncertainty, guard band width; one unit.

    decision: the decision, written beside the zone (a bias that is known and not corrected leaves a result in the
    conformance zone undecided). span: the interval of the true value, drawn in place of value +- expanded where the indicated value
    is not in its middle, and the quantity `of` the interval. Where value or uncertainty is not finite, the zones are drawn alone with a note.
    """
    bar = span or (value - expanded, value + expanded)
    parts, drawn = zone_list(lower, upper, guard), canvas(ax, 190)
    limits = [v for v in (lower, upper) if v is not None]
    is_finite = math.isfinite(value) and math.isfinite(expanded)
    reach = [e for v in limits for e in (v - guard, v + guard)]
    reach += [value, *bar] if is_finite else [value] if math.isfinite(value) else []
    room = MARGIN_SHARE * (max(reach) - min(reach)) or max(abs(reach[0]), 1.0) * 0.1
    ends = min(reach) - room, max(reach) + room
    drawn.set_xlim(*ends)
    drawn.set_ylim(0.0, 1.0)
    _stripes(drawn, parts, ends, limits)
    verdict = "The result is not available."
    if is_finite:
        words = f"{of} {span[0]:.3g} to {span[1]:.3g}" if span else with_uncertainty(value, expanded)
        _result(drawn, value, bar, f"{words} {unit}".strip())
        decision_text = f"Decision: {decision}. " if decision else ""
        verdict = f"{decision_text}{_where(span, limits, of) if span else _in_zone(value, parts)}"
    _ticks(drawn, limits, ends)
    drawn.set_yticks([])
    set_labels(
        add_legend(drawn),
        f"{title}\n{verdict}",
        f"{'limits' if len(limits) == 2 else 'limit'} / {unit}",
        "",
        grid="",
    )
    drawn.spines[["left", "bottom"]].set_visible(False)
    return carrying(
        drawn,
        chart="decision",
        unit=unit,
        value=value,
        U=expanded,
        interval=bar,
        limits=[lower, upper],
        decision=decision,
    )


def _ticks(drawn: Any, limits: list[float], ends: tuple[float, float]) -> None:
    """Draw a tick at every limit; both in one where they are near."""
    near = len(limits) == 2 and limits[1] - limits[0] < 0.25 * (ends[1] - ends[0])
    drawn.set_xticks(
        [sum(limits) / 2] if near else limits,
        [" to ".join(map(as_given, limits))] if near else [*map(as_given, limits)],
    )


def _in_zone(value: float, parts: list[Zone]) -> str:
    return f"The result lies in the {NAMES[zone_of(value, parts).kind]}."


def _where(span: tuple[float, float], limits: list[float], of: str) -> str:
    """Return the place of the interval in words. Several limits: the lower first; one alone is the upper."""
    low, high = limits[0] if len(limits) == 2 else -math.inf, limits[-1]
    where = "beyond the limit" if span[0] > high or span[1] < low else "on both sides of a limit"
    if low <= span[0] and span[1] <= high:
        where = "within the limits"
    return f"The interval of the {of} lies {where}."


def _stripes(drawn: Any, parts: list[Zone], ends: tuple[float, float], limits: list[float]) -> None:
    """Draw zones in their colours, each kind named once; a line at every limit, a thin one where a guard band begins."""
    labels: set[str] = set()
    for zone in parts:
        name = None if zone.kind in labels else NAMES[zone.kind].removesuffix(" zone")
        labels.add(zone.kind)
        low, high = max(zone.low, ends[0]), min(zone.high, ends[1])
        drawn.axvspan(low, high, 0.0, 0.6, facecolor=LIGHT[f"{zone.kind}-soft"], linewidth=0.0, label=name)
    for a, b in pairwise(parts):
        if a.kind != b.kind and b.low not in limits:
            drawn.axvline(b.low, 0.0, 0.6, color=LIGHT["warning"], linewidth=0.8, linestyle=":")
    for limit in limits:
        drawn.axvline(limit, 0.0, 0.66, color=INK, linewidth=1.2)


def _result(drawn: Any, value: float, bar: tuple[float, float], text: str) -> None:
    """Draw a diamond at the value, and a bar over its interval, which need not hold the value in the middle, or at all."""
    middle, half = sum(bar) / 2, (bar[1] - bar[0]) / 2
    drawn.plot([value], [0.3], "D", color=INK, markersize=6)
    drawn.errorbar([middle], [0.3], xerr=[half], fmt="none", ecolor=INK, capsize=4, elinewidth=1.3)
    words = plain_label(text)
    low, high = drawn.get_xlim()
    share = (value - low) / (high - low)
    side = "left" if share < 0.2 else "right" if share > 0.8 else "center"
    drawn.annotate(words, (value, 0.36), (0, 30), textcoords="offset points", ha=side, va="bottom", fontsize=WORD, fontweight="bold", color=INK, arrowprops={"arrowstyle": "-", "color": MUTED, "linewidth": 0.7})  # fmt: skip


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
