"""The report of a volumetric error map: the deformed volume, maxima, diagonals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__, charts
from vcmm.show import report as r
from vcmm.show.pages.header import facts
from vcmm.show.tables.answers import field_answers
from vcmm.show.tables.error_field import diagonals, summary
from vcmm.show.tables.table import html
from vcmm.task.response.volumetric import ErrorField, field, linear_axes

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.core.run import Array


def field_page(machine: Machine, error_map: ErrorField) -> str:
    """Return one self-contained HTML file."""
    blocks = [r.heading("Volumetric error"), html(summary(error_map))]
    if error_map.diagonals:
        blocks += [r.heading("Body diagonals (ISO 230-6)"), html(diagonals(error_map))]
    blocks += [r.heading("The deformed volume"), picture(machine, error_map)]
    blocks += _layers(error_map, linear_axes(machine))
    footer = f"vcmm {__version__}. Tip error = actual - nominal in workpiece axes; a CMM's indication has the opposite sign."
    return r.page(
        f"Volumetric error report: {machine.name}",
        blocks,
        footer=footer,
        answers=field_answers(machine, error_map),
        facts=facts("", f"{machine.name}, structure {machine.chain.structure}"),
    )


def picture(machine: Machine, error_map: ErrorField) -> str:
    """Return a grid of the travels, ideal and deformed; for given positions, arrows at them."""
    axes = linear_axes(machine)
    n = round(error_map.run.n ** (1 / max(1, len(axes))))
    if not _is_grid(error_map, axes, n):
        return _arrows(error_map)
    items, factor = _deformed_lines(error_map, axes, n)
    return r.scene(
        items,
        title="Deformed volume",
        caption=f"Tip errors magnified {factor:,.0f} times; axis positions in mm.",
    )


def volume_scene(machine: Machine) -> list[r.Lines]:
    """Return a grid of the travels, ideal and deformed, as items of a scene."""
    error_map, axes = field(machine), linear_axes(machine)
    if not _is_grid(error_map, axes, round(error_map.run.n ** (1 / max(1, len(axes))))):
        return []
    return _deformed_lines(error_map, axes, round(error_map.run.n ** (1 / max(1, len(axes)))))[0]


def _deformed_lines(error_map: ErrorField, axes: list[str], n: int) -> tuple[list[r.Lines], float]:
    """Return the lines of both grids, and the magnification of the errors."""
    nominal = _points(error_map)
    factor = magnification_of(nominal, error_map.tip_error)
    shape = (n,) * len(axes) + (3,)
    ideal = nominal.reshape(shape)
    bent = ideal + factor * error_map.tip_error.reshape(shape)
    items = [
        r.Lines(_segments(ideal), "muted", 0.6, name="nominal"),
        r.Lines(_segments(bent), "accent", 1.4, name=f"with errors, magnified {factor:,.0f} ×"),
    ]
    return items, factor


def _layers(error_map: ErrorField, axes: list[str]) -> list[str]:
    """Return maps of the tip error and of its U over x and y, at the middle height of the points; none without Inputs or without three axes."""
    points = _points(error_map)
    if error_map.u is None or len(axes) < 3:
        return []
    heights = np.unique(points[:, 2])
    here = points[:, 2] == heights[len(heights) // 2]
    x, y = (np.unique(points[here, i]) for i in (0, 1))
    if min(len(x), len(y)) < 2:
        return []
    out = [r.heading(f"Tip error and its U at Z {heights[len(heights) // 2]:g} mm")]
    for i, name in enumerate("xyz"):
        for values, what, signed in (
            (error_map.tip_error, "tip error", True),
            (2 * error_map.u, "U (k = 2)", False),
        ):
            sheet = np.full((len(y), len(x)), np.nan)
            at = np.searchsorted(y, points[here, 1]), np.searchsorted(x, points[here, 0])
            sheet[at] = 1e3 * values[here, i]
            words = {"x_label": "X / mm", "y_label": "Y / mm", "unit": "µm", "title": f"{what} in {name}"}
            out.append(charts.on_page(charts.heat_map, sheet, x, y, symmetric=signed, **words))
    return out


def _is_grid(error_map: ErrorField, axes: list[str], n: int) -> bool:
    """Return whether the positions are n values of each linear axis, as `volumetric.grid` places them."""
    values = (np.unique(error_map.run.position[a]) for a in axes if a in error_map.run.position)
    return n > 1 and error_map.run.n == n ** len(axes) and all(len(q) == n for q in values)


def _points(error_map: ErrorField) -> Array:
    """Return positions of the linear axes (n, 3) mm; an axis that the machine lacks stays at zero."""
    zero = np.zeros(error_map.run.n)
    return np.column_stack([error_map.run.position.get(a, zero) for a in "XYZ"])


def _arrows(error_map: ErrorField) -> str:
    points = _points(error_map) + error_map.run.offset
    factor = magnification_of(points, error_map.tip_error)
    dots, arrows = (
        r.Points(points, "muted", 1.5),
        r.Arrows(points, error_map.tip_error, factor, name="tip error"),
    )
    return r.scene([dots, arrows], title="Tip errors at the given positions")


def magnification_of(points: Array, errors: Array) -> float:
    largest = float(np.linalg.norm(errors, axis=1).max(initial=0.0))
    size = float(np.ptp(points, axis=0).max(initial=1.0)) or 1.0
    if largest == 0:
        return 1.0
    exact = 0.12 * size / largest
    power = 10.0 ** np.floor(np.log10(exact))
    return float(power * max(m for m in (1, 2, 5) if m * power <= exact))


def _segments(grid: Array) -> Array:
    """Return all edges of a grid (n, n, n, 3) as segments (m, 2, 3)."""
    parts = []
    for axis in range(grid.ndim - 1):
        a = np.take(grid, range(grid.shape[axis] - 1), axis=axis)
        b = np.take(grid, range(1, grid.shape[axis]), axis=axis)
        parts.append(np.stack([a.reshape(-1, 3), b.reshape(-1, 3)], axis=1))
    return np.concatenate(parts)
