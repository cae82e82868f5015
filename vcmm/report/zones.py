"""The decision picture of ISO 14253-1: conformance, uncertainty and non-conformance zones, result with its U bar."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from vcmm.core.errors import UsageError
from vcmm.report import svg
from vcmm.report.axes import Scale
from vcmm.report.text import plain, text_width, with_uncertainty

NAMES = {"good": "conformance zone", "warning": "uncertainty zone", "bad": "non-conformance zone"}
_TOP, _TALL = 46.0, 30.0


@dataclass(frozen=True)
class Zone:
    """An interval of the value axis and its kind: good, warning or bad."""

    low: float
    high: float
    kind: str


def zone_list(lower: float | None, upper: float | None, guard: float) -> list[Zone]:
    """The zones from left to right over the whole axis (ends are infinite).

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
    """The zone that holds the value; on a boundary, the better one."""
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
    width: int = svg.HALF,
) -> str:
    """Tolerance limits (either may be None), result `value` with expanded uncertainty, guard band width; one unit.

    A value or an uncertainty that is not finite draws the zones alone and says so.
    """
    parts = zone_list(lower, upper, guard)
    known = math.isfinite(value) and math.isfinite(expanded)
    scale = _scale(
        [v for v in (lower, upper) if v is not None], guard, value, expanded if known else 0.0, width
    )
    body = [_stripe(zone, scale) for zone in parts]
    body += [_limits(lower, upper, unit, scale), _guards(parts, lower, upper, scale)]
    verdict = "The result is not available."
    if known:
        body.append(_marker(value, expanded, unit, scale, width))
        verdict = f"The result lies in the {NAMES[zone_of(value, parts).kind]}."
    shown = [k for k in NAMES if any(z.kind == k for z in parts)]
    keys = [
        (svg.rect(0, 0, 16, 10, svg.paint(f"{k}-soft", k, 0.8)), NAMES[k].removesuffix(" zone"))
        for k in shown
    ]
    legend, used = svg.legend(keys, 0, _TOP + _TALL + 42, width)
    return svg.figure(
        svg.document(width, _TOP + _TALL + 44 + used, "".join(body) + legend, title), title, verdict
    )


def _scale(limits: list[float], guard: float, value: float, expanded: float, width: float) -> Scale:
    reach = [e for x in limits for e in (x - guard, x + guard)]
    reach += [value - expanded, value + expanded] if math.isfinite(value) else []
    low, high = min(reach), max(reach)
    pad = 0.14 * (high - low) if high > low else max(abs(low), 1.0) * 0.1
    return Scale(low - pad, high + pad, 0, width)


def _stripe(zone: Zone, scale: Scale) -> str:
    a, b = (scale(min(max(v, scale.low), scale.high)) for v in (zone.low, zone.high))
    return svg.rect(a, _TOP, b - a, _TALL, svg.paint(f"{zone.kind}-soft"), NAMES[zone.kind])


def _limits(lower: float | None, upper: float | None, unit: str, scale: Scale) -> str:
    """Lines and labels of the limits; one common label where two would touch."""
    known = [(name, x) for name, x in (("lower", lower), ("upper", upper)) if x is not None]
    named = [(f"{name} limit {plain(x)} {unit}".strip(), scale(x)) for name, x in known]
    if len(named) == 2:
        reach = sum(text_width(words, svg.SIZE) for words, _ in named) / 2 + 12
        if named[1][1] - named[0][1] < reach:
            both = f"limits {plain(lower)} to {plain(upper)} {unit}".strip()
            named = [(both, (named[0][1] + named[1][1]) / 2)]
    bottom, how = _TOP + _TALL, svg.paint(stroke="ink", width=1.4)
    out = [svg.line(scale(x), _TOP - 5, scale(x), bottom + 8, how) for _, x in known]
    for words, at in named:
        half = text_width(words, svg.SIZE) / 2
        out.append(svg.text(min(max(at, half), scale.end - half), bottom + 23, words, "ink", "middle"))
    return "".join(out)


def _guards(parts: list[Zone], lower: float | None, upper: float | None, scale: Scale) -> str:
    """Thin lines where zones of different kind meet, besides the limits."""
    cuts = {b.low for a, b in pairwise(parts) if a.kind != b.kind} - {lower, upper}
    how = svg.paint(stroke="warning", width=1.0, dash="2 2")
    return "".join(svg.line(scale(x), _TOP, scale(x), _TOP + _TALL, how) for x in sorted(cuts))


def _marker(value: float, expanded: float, unit: str, scale: Scale, width: float) -> str:
    x, a, b, y = scale(value), scale(value - expanded), scale(value + expanded), _TOP + _TALL / 2
    how = svg.paint(stroke="ink", width=1.6)
    bar = svg.line(a, y, b, y, how) + svg.line(a, y - 6, a, y + 6, how) + svg.line(b, y - 6, b, y + 6, how)
    diamond = svg.path(
        svg.points([(x, y - 6), (x + 6, y), (x, y + 6), (x - 6, y)], close=True), svg.paint("ink")
    )
    words = f"{with_uncertainty(value, expanded)} {unit}".strip()
    half = 1.1 * text_width(words, svg.SIZE + 1) / 2  # bold is wider
    centre = min(max(x, half), width - half)
    leader = svg.line(x, _TOP - 18, x, y - 6, svg.paint(stroke="faint", width=0.8))
    return (
        leader
        + bar
        + diamond
        + svg.text(centre, _TOP - 24, words, role="ink", anchor="middle", size=svg.SIZE + 1, bold=True)
    )
