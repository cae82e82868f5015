"""Traces of a controller (scope): time, commanded and actual position of one or more axes, densely sampled.

Columns are time_s, X_commanded_mm, X_actual_mm ..., or named in [scope]: time = "Name", X = ["SetPos", "ActPos"].
Rows of remarks above the numbers, as exports have them, are skipped; the names stand in the row that begins with
"Name" or in the last one above the numbers. Actual is what the axis's own encoder says: a trace shows the drive, not the
geometry. Values are actual - commanded at the same time, so they hold the whole following error v / Kv.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.axes import AXIS_NAMES, is_axis, is_rotary
from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.core.history import path_history
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.core.text import LARGEST, brief, lines_of, read_text, to_number
from vcmm.files.observations import axis_direction
from vcmm.files.own.recording_tables import ScopeTable
from vcmm.files.sheets import Layout
from vcmm.task.response.recording import Recording

LENGTH = {"mm": 1.0, "um": 1e-3, "m": 1e3, "in": 25.4}
ANGLE = {"deg": np.pi / 180.0, "rad": 1.0}
FILETIME = 1e18  # above every time in steps of 100 ns since 1601, and not infinite
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "filetime": 1e-7}  # filetime: steps of 100 ns


@dataclass(frozen=True, eq=False)
class Scope:
    """time (n,) s from the first row; commanded, actual: axis -> (n,) mm or rad."""

    time: Array
    command: Mapping[str, Array]
    actual: Mapping[str, Array]


def read_scope(path: str | Path, table: ScopeTable) -> Scope:
    """Read a trace. Raises DataError: a column that is missing, a cell that is no number, time that does not increase."""
    path = Path(path)
    header, numbers, lines = _numbers(path)
    axes = table.axes or _default_axes(header)
    if not axes:
        raise DataError(
            f"{path}:{lines[0]}: no axis found; name the columns X_commanded_mm, X_actual_mm, or write for example "
            f'[scope] axes = {{ X = ["SetPos", "ActPos"] }}. Columns: {", ".join(header)}'
        )
    _check_axes(path, axes)

    def column(name: str) -> Array:
        if name not in header:
            raise DataError(f'{path}:{lines[0]}: there is no column "{name}".{choose_from(name, header)}')
        return numbers[:, header.index(name)]

    time = column(table.time)
    time = (time - time[0]) * TIME[table.time_unit or _ending(table.time, TIME, "s")]
    back = np.flatnonzero(np.diff(time) <= 0)
    if len(back):
        raise DataError(f"{path}:{lines[int(back[0]) + 1]}: the time does not increase")
    both = {a: [column(n) * _factor(path, a, n, table.unit) for n in names] for a, names in axes.items()}
    far = np.flatnonzero(np.max([np.abs(p) for pair in both.values() for p in pair], axis=0) > LARGEST)
    if len(far):
        raise DataError(f"{path}:{lines[int(far[0])]}: a position is beyond {LARGEST:g} mm; repair the row")
    return Scope(time, {a: pair[0] for a, pair in both.items()}, {a: pair[1] for a, pair in both.items()})


def _check_axes(path: Path, axes: Mapping[str, list[str]]) -> None:
    for axis, names in axes.items():
        if not is_axis(axis):
            raise DataError(f'{path}: unknown axis "{axis}" in [scope]; allowed are {AXIS_NAMES}')
        if len(names) != 2:
            raise DataError(
                f'{path}: {axis} takes two columns, as in {axis} = ["SetPos", "ActPos"]: commanded, actual'
            )
    if len({is_rotary(a) for a in axes}) > 1:
        raise DataError(
            f"{path}: linear and rotary axes give recordings of two kinds; read them one after the other"
        )


def _factor(path: Path, axis: str, name: str, unit: str) -> float:
    units = ANGLE if is_rotary(axis) else LENGTH
    unit = unit or _ending(name, units, "")
    if unit not in units:
        raise DataError(
            f'{path}: the unit of "{name}" is not stated; write [scope] unit = "{next(iter(units))}"'
        )
    return units[unit]


def _ending(name: str, units: Mapping[str, float], otherwise: str) -> str:
    """Return the unit at the end of a column name: Pos_mm, Pos [mm], Pos (mm)."""
    for unit in units:
        if name.endswith((f"_{unit}", f"[{unit}]", f"({unit})")):
            return unit
    return otherwise


def _default_axes(header: list[str]) -> dict[str, list[str]]:
    out = {}
    for axis in "XYZABC":
        for unit in (*LENGTH, *ANGLE):
            names = [f"{axis}_commanded_{unit}", f"{axis}_actual_{unit}"]
            if all(name in header for name in names):
                out[axis] = names
    return out


def _numbers(path: Path) -> tuple[list[str], Array, list[int]]:
    """Return the column names, numbers (n, columns) and the line of every row. Raises DataError for a later row that is none."""
    text = lines_of(read_text(path))
    delimiter = max(",;\t", key="\n".join(text[:200]).count)
    lines = list(Layout(delimiter).rows(text))
    first = next(
        (i for i, row in enumerate(lines) if len(row.cells) > 1 and all(map(_is_number, row.cells))), None
    )
    if first is None:
        raise DataError(f"{path}:1: there is no row of numbers; a trace has columns of time and positions")
    count = len(lines[first].cells)
    above = [row.cells for row in lines[:first] if len(row.cells) == count]
    if not above:
        raise DataError(f"{path}:{lines[first].line}: no row above the numbers names the {count} columns")
    header = next((cells for cells in above if cells[0] == "Name"), above[-1])
    rows = [row for row in lines[first:] if row.text != "EOF"]  # TwinCAT ends its exports with the word
    problems = [
        f"{path}:{row.line}: expected {len(header)} finite numbers: {brief(row.text)}"
        for row in rows
        if len(row.cells) != len(header) or not all(map(_is_number, row.cells))
    ]
    if problems:
        raise DataError(problems)
    return header, np.array([[to_number(c) for c in row.cells] for row in rows]), [row.line for row in rows]


def _is_number(cell: str) -> bool:
    try:
        return abs(to_number(cell)) <= FILETIME
    except ValueError:
        return False


def recording_of_scope(
    scope: Scope,
    machine: Machine,
    at: Mapping[str, float],
    offset: Array,
    measuring: bool = False,
) -> Recording:
    """Return a trace as a recording: actual - commanded of each axis along its direction; kind path, for rotary axes angle.

    at: positions of the other axes, mm or rad; offset (3,) mm of the tool. Memory columns come from the commanded path.
    """
    for axis in scope.command:
        if axis not in machine.chain.letters:
            raise UsageError(
                f"the machine {machine.chain.structure} has no axis {axis}; correct [scope] or the machine"
            )
    n, axes = len(scope.time), list(scope.command)
    position = {a: np.full(n, q) for a, q in at.items()} | dict(scope.command)
    columns = {"time_s": scope.time, **path_history(scope.command, scope.time)}
    run = Run(position, np.tile(np.asarray(offset, dtype=float), (n, 1)), columns)
    direction = np.stack([axis_direction(machine, run, a) for a in axes], axis=1).reshape(-1, 3)
    error = np.stack([scope.actual[a] - scope.command[a] for a in axes], axis=1).ravel()
    value = -error if measuring else error
    kind = "angle" if is_rotary(axes[0]) else "path"
    none = np.full(len(value), -1, dtype=np.intp)
    return Recording(
        "",
        kind,
        run,
        value=value,
        measuring=measuring,
        row=np.repeat(np.arange(n), len(axes)),
        direction=direction,
        other=none,
    )
