"""CSV files of points on a drawing: x_mm y_mm z_mm, with or without their normals nx ny nz."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError, choose_from
from vcmm.core.run import Array
from vcmm.files.columns import Sheet, read_csv
from vcmm.files.problems import misspelt

PLACES, NORMALS = ["x_mm", "y_mm", "z_mm"], ["nx", "ny", "nz"]


def read_points(path: Path, with_normals: bool = False) -> tuple[Sheet, Array, Array | None]:
    """The sheet, points (n, 3) mm and normals (n, 3) as they stand there, None without. with_normals: they must be there.

    DataError: columns that are missing or unknown, cells that are no numbers, normals that are no unit vectors.
    """
    sheet = read_csv(path)
    normals = with_normals or any(column in sheet.header for column in NORMALS)
    here = f"{sheet.path}:{sheet.header_line}"
    unknown = [column for column in sheet.header if column not in PLACES + NORMALS]
    needs = "x_mm,y_mm,z_mm,nx,ny,nz" if with_normals else "x_mm,y_mm,z_mm and may have nx,ny,nz"
    problems = [
        f"{here}: the column {column} is missing.{misspelt(column, unknown)} The file needs {needs}"
        for column in PLACES + (NORMALS if normals else [])
        if column not in sheet.header
    ]
    problems += [
        f'{here}: unknown column "{column}".{choose_from(column, PLACES + NORMALS)}' for column in unknown
    ]
    if problems:
        raise DataError(problems)
    return sheet, _columns(sheet, PLACES), _unit(sheet, _columns(sheet, NORMALS)) if normals else None


def _unit(sheet: Sheet, normals: Array) -> Array:
    """The normals (n, 3), after all were found to be as long as 1 within a hundredth, as in every other file."""
    size = np.linalg.norm(normals, axis=1)
    problems = [
        f"{sheet.at(int(i))}: nx ny nz has the length {size[i]:.4g}; give a unit vector"
        for i in np.flatnonzero(~(np.abs(size - 1.0) <= 0.01))
    ]
    if problems:
        raise DataError(problems)
    return normals


def row_of(sheet: Sheet, message: str) -> str:
    """File and line of the point that a message names."""
    match = re.search(r"\bpoint (\d+)\b", message)
    row = int(match[1]) - 1 if match else -1
    return sheet.at(row) if 0 <= row < len(sheet.lines) else f"{sheet.path}:{sheet.header_line}"


def _columns(sheet: Sheet, names: list[str]) -> Array:
    """Several columns (n, k); every bad cell is reported."""
    out: list[Array] = []
    problems: list[str] = []
    for name in names:
        try:
            out.append(sheet.numbers(name))
        except DataError as error:
            problems.extend(error.problems)
    if problems:
        raise DataError(problems)
    return np.stack(out, axis=1)
