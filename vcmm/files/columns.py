"""CSV files of positions and recordings: header names with units to canonical columns of a Run."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from vcmm.errors import DataError, did_you_mean
from vcmm.run import Array, Run

LABELS = (
    "pose",
    "part",
    "stylus",
    "tool",
    "feature",
    "setup",
    "run",
    "event",
    "instrument",
    "clamp",
    "repeat",
    "mode",
)
DEG = np.pi / 180.0


def read_csv(path: str | Path) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a CSV file (comma or semicolon). Raises DataError with the line of a ragged row."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror}") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise DataError(f"{path} is empty; its first line names the columns, for example X_mm,Y_mm,Z_mm")
    delimiter = ";" if lines[0].count(";") > lines[0].count(",") else ","
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(rows[0]):
            raise DataError(f"{path}:{number}: {len(row)} cells where the header names {len(rows[0])}")
    return rows[0], rows[1:]


def read_positions(path: str | Path, axes: tuple[str, ...]) -> Run:
    """Positions (X_mm ... C_deg) and tip offsets (offset_x_mm ...) to a Run; every axis must have its column.

    Other numeric columns and labels are kept. Raises DataError naming column, line and fix.
    """
    header, rows = read_csv(path)
    numbers, labels = _typed(Path(path), header, rows)
    position = {}
    for axis in axes:
        name = f"{axis}_deg" if axis in "ABC" else f"{axis}_mm"
        if name not in numbers:
            raise DataError(
                f"{path}:1: the column {name} is missing.{did_you_mean(name, header)} The machine has the axes {' '.join(axes)}"
            )
        position[axis] = numbers.pop(name) * (DEG if axis in "ABC" else 1.0)
    offset = np.stack([numbers.pop(f"offset_{c}_mm", np.zeros(len(rows))) for c in "xyz"], axis=1)
    return Run(position, offset, canonical_columns(numbers), labels)


def canonical_columns(numbers: dict[str, Array]) -> dict[str, Array]:
    """Angles to rad: probe_angle_deg -> probe_angle_rad; everything else is canonical already."""
    out = {}
    for name, values in numbers.items():
        out[f"{name[:-4]}_rad" if name.endswith("_deg") else name] = (
            values * DEG if name.endswith("_deg") else values
        )
    return out


def _typed(
    path: Path, header: list[str], rows: list[list[str]]
) -> tuple[dict[str, Array], dict[str, np.ndarray]]:
    numbers: dict[str, Array] = {}
    labels: dict[str, np.ndarray] = {}
    for i, name in enumerate(header):
        cells = [row[i] for row in rows]
        if name in LABELS:
            labels[name] = np.array(cells, dtype=np.str_)
            continue
        values = np.empty(len(cells))
        for j, cell in enumerate(cells):
            try:
                values[j] = float(cell)
            except ValueError:
                raise DataError(f'{path}:{j + 2}: "{cell}" in column {name} is not a number') from None
            if not np.isfinite(values[j]):
                raise DataError(
                    f'{path}:{j + 2}: "{cell}" in column {name} is not finite; remove or repair the row'
                )
        numbers[name] = values
    return numbers, labels
