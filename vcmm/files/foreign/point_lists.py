"""Read measured points of measuring software: bare lists of numbers, without the heading of a points.csv.

PC-DMIS   the first line begins with XYZIJK, and with METRIC from its 11th column on (inches without); then x,y,z or x,y,z,i,j,k
          per line.
others    three or six numbers per line (x y z, perhaps i j k), perhaps a word before them, which is the feature; separated by
          blanks, tabs, semicolons or commas. No unit is stated: millimetres are assumed, with a note.

Without a word the rows are in the order of the plan. A column of numbers before the coordinates is no name: such a list is refused.
Source: help of PC-DMIS, "Notes on XYZ Files", "Importing an XYZ File as CAD Data" (Hexagon).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.core.digits import written_step
from vcmm.core.errors import DataError
from vcmm.core.text import brief, is_usual, lines_of
from vcmm.files.foreign.foreign_text import foreign_number, foreign_text
from vcmm.files.sheets import Layout, Row

INCH = 25.4
COMMENTS = ("#", "//", "!", "%")


@dataclass(frozen=True)
class PointList:
    """Points of one part, and the assumptions made."""

    points: GivenPoints
    notes: tuple[str, ...]


def read_point_list(path: str | Path) -> PointList | None:
    """Read the points of a list; None where the first line is neither XYZIJK nor numbers (a points.csv has a heading).

    DataError, with the line: a row with another number of cells than the first, no number, a vector without length.
    """
    text, assumed = foreign_text(path)
    lines = lines_of(text)
    rows = list(Layout(comments=COMMENTS).rows(lines))
    if not rows:
        return None
    n, first = rows[0].line, lines[rows[0].line - 1]
    notes, factor = list(assumed), 1.0
    if first.startswith("XYZIJK"):
        metric = first[10:16] == "METRIC"
        factor, rows = (1.0 if metric else INCH), rows[1:]
        if not metric:
            notes.append(f"{path}:{n}: METRIC does not stand in columns 11 to 16, so these are inches")
    elif len(_numbers(_cells(first))) not in (3, 6):
        return None
    else:
        notes.append(f"{path}: a bare list of points states no unit; millimetres are taken")
    if not rows:
        raise DataError(f"{path}:{n}: there is no point after the heading")
    return PointList(_parse_points(Path(path), rows, factor), tuple(notes))


def _cells(line: str) -> list[str]:
    """Split a line into cells; a comma separates only where nothing else does, else it is a decimal comma."""
    text = line.strip()
    if ";" in text or "\t" in text:
        return Layout(r"[;\t]").cells(text.rstrip(";"))
    return (
        Layout().cells(text) if re.search(r"[^,\s]\s+[^,\s]", text) else Layout(",").cells(text.rstrip(","))
    )


def _numbers(cells: Sequence[str]) -> list[float]:
    """Return the numbers after a word, or from the first cell on; none where one of them is no number."""
    try:
        return [foreign_number(c) for c in cells[0 if _is_number(cells[0]) else 1 :]]
    except ValueError:
        return []


def _is_number(cell: str) -> bool:
    try:
        foreign_number(cell)
    except ValueError:
        return False
    return True


def _parse_points(path: Path, rows: Sequence[Row], factor: float) -> GivenPoints:
    cells = [_cells(row.text) for row in rows]
    width, named = len(cells[0]), not _is_number(cells[0][0])
    if width - named not in (3, 6):
        raise DataError(
            f"{path}:{rows[0].line}: {width - named} numbers in a row; points have three, or six with their vector"
        )
    table = []
    for line, row in zip(rows, cells):
        numbers = _numbers(row)
        if (
            len(row) != width
            or len(numbers) != width - named
            or _is_number(row[0]) == named
            or not all(map(is_usual, numbers))
        ):
            raise DataError(
                f'{path}:{line.line}: "{brief(line.text)}" is no row like the first, {"a name and " if named else ""}{width - named} numbers'
            )
        table.append(numbers)
    values = np.array(table)
    normals = values[:, 3:6] if values.shape[1] >= 6 else None
    if normals is not None and (bare := np.flatnonzero(np.linalg.norm(normals, axis=1) == 0.0)).size:
        raise DataError(
            f"{path}:{rows[bare[0]].line}: the vector i, j, k has no length; export the points without vectors"
        )
    return GivenPoints(
        part="", points=factor * values[:, :3], where=tuple(f"{path}:{row.line}" for row in rows),
        features=tuple(row[0] for row in cells) if named else None,
        normals=None if normals is None else normals,
        step=factor * written_step([[row[named + i] for row in cells] for i in range(3)]),
    )  # fmt: skip
