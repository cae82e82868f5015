"""CSV files of points on a drawing: x_mm y_mm z_mm, with or without their normals nx ny nz."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError, choose_from
from vcmm.core.run import Array
from vcmm.files.problems import misspelt
from vcmm.files.sheets import Sheet, SheetColumn, read_csv

PLACES, NORMALS = ("x_mm", "y_mm", "z_mm"), ("nx", "ny", "nz")


def read_points(path: Path, with_normals: bool = False) -> tuple[Sheet, Array, Array | None]:
    """Return the sheet, points (n, 3) mm and normals (n, 3) as written, None without. with_normals: normals are required.

    DataError: columns that are missing or unknown, cells that are no numbers, normals that are no unit vectors.
    """
    sheet = read_csv(path)
    normals = with_normals or any(column in sheet.header for column in NORMALS)
    unknown = [column for column in sheet.header if column not in PLACES + NORMALS]
    needs = "x_mm,y_mm,z_mm,nx,ny,nz" if with_normals else "x_mm,y_mm,z_mm and may have nx,ny,nz"
    columns = [
        SheetColumn(
            name,
            optional=name in NORMALS and not normals,
            advice=f".{misspelt(name, unknown)} The file needs {needs}",
        )
        for name in PLACES + NORMALS
    ]
    problems = sheet.missing(columns)
    problems += sheet.unknown(PLACES + NORMALS, lambda name: f".{choose_from(name, PLACES + NORMALS)}")
    if problems:
        raise DataError(problems)
    return sheet, sheet.stack(PLACES), _unit(sheet, sheet.stack(NORMALS)) if normals else None


def _unit(sheet: Sheet, normals: Array) -> Array:
    """Return the normals (n, 3), after checking that their length is 1 within a hundredth, as in every other file."""
    size = np.linalg.norm(normals, axis=1)
    problems = [
        f"{sheet.at(int(i))}: nx ny nz has the length {size[i]:.4g}; give a unit vector"
        for i in np.flatnonzero(~(np.abs(size - 1.0) <= 0.01))
    ]
    if problems:
        raise DataError(problems)
    return normals


def row_of(sheet: Sheet, message: str) -> str:
    """Return the file and line of the point that a message names."""
    match = re.search(r"\bpoint (\d+)\b", message)
    row = int(match[1]) - 1 if match else -1
    return sheet.at(row) if 0 <= row < len(sheet.lines) else sheet.head
