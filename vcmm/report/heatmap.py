"""A map of one quantity over two others in discrete colour bands: U over the pose, error over a plane."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError
from vcmm.report import svg
from vcmm.report.axes import Area, Array, Scale, nice_ticks, room_left, tick_text, x_axis
from vcmm.report.colormap import Bands, bands, colour_legend, legend_width
from vcmm.report.text import text_width


def heat_map(
    values: npt.ArrayLike,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    *,
    x_label: str,
    y_label: str,
    unit: str,
    title: str,
    symmetric: bool = False,
    marks: Sequence[tuple[str, float, float]] = (),
    width: int = svg.HALF,
    height: int = 340,
) -> str:
    """`values` (ny, nx) at cell centres x (nx,) and y (ny,), both increasing. NaN cells are hatched "not evaluated".

    `symmetric`: blue-white-red about zero, for signed quantities. `marks`: (name, x, y), for example the best pose.
    DataError: shapes that do not fit, x or y not increasing.
    """
    data, xc, yc = _checked(values, x, y)
    scale = bands(data, symmetric=symmetric)
    xe, ye = cell_edges(xc), cell_edges(yc)
    ticks = nice_ticks(ye[0], ye[-1], max(3, height // 50))
    holes = not np.isfinite(data).all()
    right, bottom = width - legend_width(scale, unit) - 20, height - (64 if holes else 46)
    area = Area(room_left(ticks), 30, right, bottom)
    sx, sy = Scale(xe[0], xe[-1], area.left, right), Scale(ye[0], ye[-1], bottom, area.top)
    hatch = f"hatch-{zlib.crc32(data.tobytes() + title.encode()):08x}"
    body = [_hatch(hatch)] if holes else []
    body.append(_cells(data, scale, sx.many(xe), sy.many(ye), hatch))
    body += [svg.text(0, 13, y_label, "muted"), _y_labels(ticks, sy, area), x_axis(area, sx, x_label, width)]
    body += [_mark(name, sx(mx), sy(my), area) for name, mx, my in marks if np.isfinite([mx, my]).all()]
    body.append(colour_legend(scale, unit, right + 20, area.top, bottom))
    if holes:
        key = f'<rect width="16" height="10" fill="url(#{hatch})"/>'
        body.append(svg.legend([(key, "not evaluated")], area.left, height - 14, width)[0])
    return svg.figure(svg.document(width, height, "".join(body), title), title)


def cell_edges(centres: Array) -> Array:
    """Borders (n + 1,) half-way between the centres (n,); a single centre gets a cell of width 1."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def _checked(values: npt.ArrayLike, x: npt.ArrayLike, y: npt.ArrayLike) -> tuple[Array, Array, Array]:
    data, xc, yc = (np.asarray(a, dtype=np.float64) for a in (values, x, y))
    if xc.ndim != 1 or yc.ndim != 1 or data.shape != (yc.size, xc.size) or data.size == 0:
        raise DataError(
            f"A heat map needs values (ny, nx), x (nx,), y (ny,); got {data.shape}, {xc.shape}, {yc.shape}."
        )
    for name, axis in (("x", xc), ("y", yc)):
        if not (np.isfinite(axis).all() and (np.diff(axis) > 0).all()):
            raise DataError(
                f"The {name} positions of a heat map must be finite and increase: sort them with the values."
            )
    return data, xc, yc


def _cells(data: Array, scale: Bands, xe: Array, ye: Array, hatch: str) -> str:
    """One path per band; neighbours of one band in a row become one rectangle."""
    band = scale.index(data)
    paths: dict[int, list[str]] = {}
    for j in range(data.shape[0]):
        cuts = np.flatnonzero(np.diff(band[j])) + 1
        for a, b in zip([0, *cuts], [*cuts, data.shape[1]]):
            box = f"M{svg.px(xe[a])} {svg.px(ye[j])}H{svg.px(xe[b])}V{svg.px(ye[j + 1])}H{svg.px(xe[a])}Z"
            paths.setdefault(int(band[j, a]), []).append(box)
    out = []
    for k, parts in sorted(paths.items()):
        fill = svg.paint(scale.colours[k]) if k >= 0 else f'fill="url(#{hatch})"'
        out.append(
            svg.path(
                "".join(parts), f'{fill} shape-rendering="crispEdges"', "" if k >= 0 else "not evaluated"
            )
        )
    return "".join(out)


def _hatch(name: str) -> str:
    stroke = svg.path("M0 6L6 0", svg.paint(stroke="faint", width=1.0))
    back = svg.rect(0, 0, 6, 6, svg.paint("grid"))
    return f'<defs><pattern id="{name}" width="6" height="6" patternUnits="userSpaceOnUse">{back}{stroke}</pattern></defs>'


def _y_labels(ticks: Array, scale: Scale, area: Area) -> str:
    out = []
    for value, words in zip(ticks, tick_text(ticks)):
        y = scale(float(value))
        out.append(svg.line(area.left - 4, y, area.left, y, svg.paint(stroke="rule")))
        out.append(svg.text(area.left - 8, y + 4.3, words, "muted", "end"))
    return "".join(out)


def _mark(name: str, x: float, y: float, area: Area) -> str:
    """A ringed dot and its name on a small plate, which stays inside the map."""
    wide = text_width(name, svg.SIZE) + 10
    left = x + 9 if x + 9 + wide < area.right else x - 9 - wide
    dot = svg.circle(x, y, 4.5, svg.paint("#ffffff", "#1c2530", 1.8))
    if not name:
        return dot
    plate = svg.rect(left, y - 10, wide, 20, svg.paint("surface", opacity=0.88), radius=3)
    return dot + plate + svg.text(left + 5, y + 4.3, name, "ink")
