"""A volumetric error map as tables: maxima, body diagonals, and field.csv."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.show.tables.quantities import fixed
from vcmm.show.tables.table import Column, ResultTable, csv_text, entry, listing, records

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.core.run import Array
    from vcmm.task.response.volumetric import Diagonal, ErrorField


def _ends(values: tuple[float, ...], between: str = ", ") -> str:
    return "(" + between.join(f"{v:g}" for v in values) + ")"


DIAGONALS: tuple[Column[Diagonal], ...] = (
    Column("from", lambda d: f"{_ends(d.start)} mm"),
    Column("to", lambda d: f"{_ends(d.end)} mm"),
    Column("length error", lambda d: d.length_error, fixed(3, "um", 1e3, signed=True)),
    entry("from", lambda d: list(d.start)),
    entry("to", lambda d: list(d.end)),
    entry("length_error", lambda d: d.length_error),
)


def diagonals(error_map: ErrorField) -> ResultTable[Diagonal]:
    return ResultTable("body diagonals (ISO 230-6)", DIAGONALS, error_map.diagonals)


def engine_text(error_map: ErrorField) -> str:
    return "exact transforms" if error_map.exact else "first order"


def maxima(machine: Machine, error_map: ErrorField) -> ResultTable[Any]:
    """Return the largest and mean tip error with the place of the largest, and the body diagonals: all on one screen."""
    size, worst = error_map.size, int(error_map.size.argmax())
    place = ", ".join(
        f"{a} {_display_position(a, error_map.run.q(a)[worst]):.4g} {_unit(a)}" for a in machine.chain.letters
    )
    rows = [
        ["largest tip error", f"{size.max() * 1e3:.3f} µm", f"at {place}"],
        ["mean tip error", f"{size.mean() * 1e3:.3f} µm", f"{error_map.run.n} points"],
        ["largest in x, y, z", " ".join(f"{v:.3f}" for v in _largest(error_map)) + " µm", ""],
    ]
    if error_map.u is not None:
        three = " ".join(f"{v:.3f}" for v in 2e3 * error_map.u.max(axis=0))
        rows.append(["largest U in x, y, z", f"{three} µm", "k = 2, of one positioning"])
    for d in error_map.diagonals:
        ends = f"{_ends(d.start, ' ')} to {_ends(d.end, ' ')}"
        rows.append(["body diagonal", f"{d.length_error * 1e3:+.3f} µm", ends])
    title = f"{machine.name}: tip error, actual - nominal ({engine_text(error_map)})"
    return listing(title, ["", "value", "where"], rows, words=(0, 2))


def summary(error_map: ErrorField) -> ResultTable[Any]:
    """Return the same for the page, which has the diagonals apart."""
    size = error_map.size * 1e3
    rows = [
        ["largest tip error", f"{size.max():.3f} µm"],
        ["mean tip error", f"{size.mean():.3f} µm"],
        *([f"largest in {c}", f"{v:.3f} µm"] for c, v in zip("xyz", _largest(error_map))),
        *_spread_rows(error_map),
        ["points", str(error_map.run.n)],
        ["engine", engine_text(error_map)],
    ]
    return listing("Volumetric error", ["", "tip error, actual - nominal"], rows)


def _spread_rows(error_map: ErrorField) -> list[list[str]]:
    if error_map.u is None:
        return []
    return [
        [f"largest U in {c} (k = 2)", f"{v:.3f} µm"] for c, v in zip("xyz", 2e3 * error_map.u.max(axis=0))
    ]


def _largest(error_map: ErrorField) -> Array:
    """Return the largest tip error (3,) um."""
    return np.asarray(np.abs(error_map.tip_error).max(axis=0) * 1e3)


def _unit(axis: str) -> str:
    return "deg" if is_rotary(axis) else "mm"


def _display_position(axis: str, position: float) -> float:
    """Return axis positions in mm and deg for display."""
    return math.degrees(position) if is_rotary(axis) else float(position)


def field_json(error_map: ErrorField) -> dict[str, Any]:
    """Return the body of the JSON document."""
    size = error_map.size
    return {
        "engine": "exact" if error_map.exact else "first-order",
        "points": int(error_map.run.n),
        "tip_error_mm": error_map.tip_error.tolist(),
        "u_mm": None if error_map.u is None else error_map.u.tolist(),
        "U_mm": None if error_map.u is None else (2 * error_map.u).tolist(),
        "not_in_U": list(error_map.left_out),
        "within_mm": {a: [low, high] for a, low, high in error_map.within},
        "summary": {
            "max_mm": float(size.max(initial=0.0)),
            "mean_mm": float(size.mean()) if len(size) else 0.0,
            "max_xyz_mm": np.abs(error_map.tip_error).max(axis=0, initial=0.0).tolist(),
            "body_diagonals_mm": records(DIAGONALS, error_map.diagonals),
        },
    }


def field_csv(machine: Machine, error_map: ErrorField) -> str:
    """Return the axis positions in mm and deg, tip errors in um, nine significant digits."""

    def position(axis: str, row: int) -> float:
        return _display_position(axis, error_map.run.q(axis)[row])

    def error(component: int, row: int) -> float:
        return float(error_map.tip_error[row, component] * 1e3)

    columns: list[Column[int]] = [
        Column(None, partial(position, a), csv=f"{a}_{_unit(a)}", file=_nine_digits)
        for a in machine.chain.letters
    ]
    columns += [
        Column(None, partial(error, i), csv=f"error_{c}_um", file=_nine_digits) for i, c in enumerate("xyz")
    ]
    u = error_map.u
    if u is not None:
        spread = [partial(_um_of, u, i) for i in range(3)]
        columns += [Column(None, f, csv=f"U_{c}_um", file=_nine_digits) for f, c in zip(spread, "xyz")]
    return csv_text(ResultTable("", columns, range(error_map.run.n)))


def _um_of(u: Array, component: int, row: int) -> float:
    """Return U of k = 2."""
    return float(2e3 * u[row, component])


def _nine_digits(value: float, unit: str) -> str:
    return f"{value:.9g}"
