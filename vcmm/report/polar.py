"""Roundness plot: radial deviations, magnified, drawn on a reference circle (layout of ISO 12181-1 diagrams)."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.report import svg
from vcmm.report.axes import Array, nice_step, tick_text
from vcmm.report.curve import runs
from vcmm.report.text import number

_CENTRE = 0.34  # radius of the innermost ring over the outermost


def polar(
    angles_rad: npt.ArrayLike,
    radii_um: npt.ArrayLike,
    *,
    title: str,
    low_um: npt.ArrayLike | None = None,
    high_um: npt.ArrayLike | None = None,
    closed: bool = True,
    width: int = svg.HALF,
    height: int = 400,
) -> str:
    """Deviations radii_um (n,) from the reference circle at angles_rad (n,), counter-clockwise from +x.

    `low_um`, `high_um` (n,) bound an uncertainty band. The inscribed and circumscribed circle about the same centre
    are dashed; their distance, the form deviation about this reference, is in the caption. A NaN interrupts the
    line. DataError: lengths differ, or no finite point.
    """
    angle, radius = np.asarray(angles_rad, dtype=np.float64), np.asarray(radii_um, dtype=np.float64)
    if angle.shape != radius.shape or angle.ndim != 1 or not np.isfinite(radius).any():
        raise DataError(
            f"A polar plot needs finite radii (n,) and angles (n,), got {radius.shape} and {angle.shape}."
        )
    sides = [np.asarray(s, dtype=np.float64) for s in (low_um, high_um) if s is not None]
    rings, step = _ring_levels([radius, *sides])
    middle, outer = (width / 2, height / 2), height / 2 - 26
    unit = outer * (1 - _CENTRE) / float(rings[-1] - rings[0])  # px per um
    base = outer - unit * float(rings[-1])  # radius of the reference circle
    body = [_rings(middle, base, unit, rings), _spokes(middle, outer)]
    if len(sides) == 2:
        body.append(_band(angle, sides, middle, base, unit))
    body += [_envelope(radius, middle, base, unit), _profile(angle, radius, middle, base, unit, closed)]
    body.append(_ring_labels(middle, base, unit, rings))
    form = float(np.nanmax(radius) - np.nanmin(radius))
    caption = f"One ring is {number(step, 1)}\u00a0µm. Highest to lowest point about this reference: {number(form, 3)}\u00a0µm."
    return svg.figure(svg.document(width, height, "".join(body), title), title, caption)


def _ring_levels(values: list[Array]) -> tuple[Array, float]:
    """Deviations, um, at which rings are drawn (zero among them), and their step."""
    data = np.concatenate(values)
    data = data[np.isfinite(data)]
    low, high = min(float(data.min()), 0.0), max(float(data.max()), 0.0)
    step = nice_step(high - low if high > low else 1.0, 5)
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return np.arange(min(first, -1), max(last, 1) + 1, dtype=np.float64) * step, step


Centre = tuple[float, float]


def _xy(angle: Array, radius: Array, middle: Centre, base: float, unit: float) -> list[tuple[float, float]]:
    r = base + unit * radius
    return list(zip(middle[0] + r * np.cos(angle), middle[1] - r * np.sin(angle)))


def _rings(middle: Centre, base: float, unit: float, rings: Array) -> str:
    out = []
    for level in rings:
        zero = abs(level) < 1e-12
        how = svg.paint(stroke="muted" if zero else "grid", width=1.2 if zero else 1.0)
        out.append(svg.circle(*middle, base + unit * float(level), how))
    return "".join(out)


def _spokes(middle: Centre, outer: float) -> str:
    out = []
    for degree in range(0, 360, 45):
        c, s = math.cos(math.radians(degree)), -math.sin(math.radians(degree))
        a, b = 0.5 * _CENTRE * outer, outer
        ends = (middle[0] + a * c, middle[1] + a * s, middle[0] + b * c, middle[1] + b * s)
        out.append(svg.line(*ends, svg.paint(stroke="grid")))
        anchor = "middle" if abs(c) < 0.1 else "start" if c > 0 else "end"
        x, y = middle[0] + (outer + 7) * c, middle[1] + (outer + 13 if abs(c) < 0.1 else outer + 7) * s
        out.append(svg.text(x, y + 4.3, f"{degree}°", "muted", anchor))
    return "".join(out)


def _ring_labels(middle: Centre, base: float, unit: float, rings: Array) -> str:
    """Deviation of each ring, written between two spokes."""
    c, s = math.cos(math.radians(67.5)), math.sin(math.radians(67.5))
    out = []
    for level, words in zip(rings, tick_text(rings)):
        r = base + unit * float(level)
        out.append(
            svg.text(middle[0] + r * c, middle[1] - r * s + 4, words, "muted", "middle", 10.5, halo=True)
        )
    return "".join(out)


def _envelope(radius: Array, middle: Centre, base: float, unit: float) -> str:
    how = svg.paint(stroke="c2", width=1.1, dash="5 3")
    ends = (("lowest point", float(np.nanmin(radius))), ("highest point", float(np.nanmax(radius))))
    return "".join(svg.circle(*middle, base + unit * r, how, f"{name} {number(r, 3)} µm") for name, r in ends)


def _band(angle: Array, sides: list[Array], middle: Centre, base: float, unit: float) -> str:
    low, high = (_xy(angle, s, middle, base, unit) for s in sides)
    ring = svg.points(high, close=True) + svg.points(low[::-1], close=True)
    return svg.path(ring, svg.paint("c1", opacity=0.17) + ' fill-rule="evenodd"')


def _profile(angle: Array, radius: Array, middle: Centre, base: float, unit: float, closed: bool) -> str:
    good = np.isfinite(radius) & np.isfinite(angle)
    how = svg.paint(stroke="c1", width=1.6) + ' stroke-linejoin="round"'
    out = []
    for run in runs(good):
        xy = _xy(angle[run], radius[run], middle, base, unit)
        out.append(svg.path(svg.points(xy, close=closed and bool(good.all())), how))
    return "".join(out)
