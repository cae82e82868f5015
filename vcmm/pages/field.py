"""The report of a volumetric error map: the deformed volume, maxima, diagonals."""

from __future__ import annotations

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.response.volumetric import ErrorField, linear_axes

LINES = 5  # grid lines per axis in the picture


def field_page(machine: Machine, found: ErrorField) -> str:
    """One self-contained HTML file."""
    size = found.size * 1e3
    engine = "exact transforms" if found.exact else "first order"
    rows = [
        ["largest tip error", f"{size.max():.3f} µm"],
        ["mean tip error", f"{size.mean():.3f} µm"],
        *(
            [f"largest in {c}", f"{v:.3f} µm"]
            for c, v in zip("xyz", np.abs(found.tip_error).max(axis=0) * 1e3)
        ),
        ["points", str(found.run.n)],
        ["engine", engine],
    ]
    blocks = [r.heading("Volumetric error"), r.table(["", "tip error, actual - nominal"], rows, numeric=(1,))]
    if found.diagonals:
        blocks += [r.heading("Body diagonals (ISO 230-6)"), diagonals_table(found)]
    blocks += [r.heading("The deformed volume"), picture(machine, found)]
    footer = f"vcmm {__version__}. Tip error = actual - nominal in workpiece axes; a CMM's indication has the opposite sign."
    return r.page(
        f"Error field of {machine.name}",
        blocks,
        subtitle=f"structure {machine.chain.structure}",
        footer=footer,
    )


def diagonals_table(found: ErrorField) -> str:
    rows = [[_place(d.start), _place(d.end), f"{d.length_error * 1e3:+.3f} µm"] for d in found.diagonals]
    return r.table(["from", "to", "length error"], rows, numeric=(2,))


def _place(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in values) + ") mm"


def picture(machine: Machine, found: ErrorField) -> str:
    """A grid of the travels, ideal and deformed; for given positions, arrows at them."""
    axes = linear_axes(machine)
    if len(axes) == 3 and not _is_grid(found):
        return _arrows(found)
    n = round(found.run.n ** (1 / 3))
    nominal = np.column_stack([found.run.q(a) for a in axes])
    factor = _magnification(nominal, found.tip_error)
    shape = (n,) * len(axes) + (3,)
    ideal = _pad(nominal).reshape(shape)
    bent = ideal + factor * found.tip_error.reshape(shape)
    items = [
        r.Lines(_segments(ideal), "muted", 0.6, name="nominal"),
        r.Lines(_segments(bent), "accent", 1.4, name=f"with errors x {factor:,.0f}"),
    ]
    return r.scene(
        items,
        title="Deformed volume",
        caption=f"Tip errors magnified {factor:,.0f} times; axis positions in mm.",
    )


def _is_grid(found: ErrorField) -> bool:
    n = round(found.run.n ** (1 / 3))
    return (
        n > 1
        and n**3 == found.run.n
        and all(len(np.unique(q)) == n for a, q in found.run.position.items() if a in "XYZ")
    )


def _arrows(found: ErrorField) -> str:
    points = (
        np.column_stack([found.run.position.get(a, np.zeros(found.run.n)) for a in "XYZ"]) + found.run.offset
    )
    factor = _magnification(points, found.tip_error)
    dots, arrows = r.Points(points, "muted", 1.5), r.Arrows(points, found.tip_error, factor, name="tip error")
    return r.scene([dots, arrows], title="Tip errors at the given positions")


def _pad(points: Array) -> Array:
    return np.column_stack([points, *[np.zeros(len(points))] * (3 - points.shape[1])])


def _magnification(points: Array, errors: Array) -> float:
    largest = float(np.linalg.norm(errors, axis=1).max(initial=0.0))
    size = float(np.ptp(points, axis=0).max(initial=1.0)) or 1.0
    if largest == 0:
        return 1.0
    exact = 0.12 * size / largest
    power = 10.0 ** np.floor(np.log10(exact))
    return float(power * max(m for m in (1, 2, 5) if m * power <= exact))


def _segments(grid: Array) -> Array:
    """All edges of a grid (n, n, n, 3) as segments (m, 2, 3)."""
    parts = []
    for axis in range(grid.ndim - 1):
        a = np.take(grid, range(grid.shape[axis] - 1), axis=axis)
        b = np.take(grid, range(1, grid.shape[axis]), axis=axis)
        parts.append(np.stack([a.reshape(-1, 3), b.reshape(-1, 3)], axis=1))
    return np.concatenate(parts)
