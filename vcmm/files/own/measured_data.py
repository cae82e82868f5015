"""Measured data of a part: points.csv (feature, x_mm, y_mm, z_mm) and values.csv (characteristic, value_mm).

Points   x y z with one length unit in their names (x_mm, x_in, x_um), optional nx ny nz, `feature` (left out: rows in the
         order of the plan), `stylus`, and `part` where one file holds several parts. The points.csv of `vcmm measure` too.
Values   `characteristic` with value_<unit>, or deviation_<unit> from nominal; lengths and angles may have a column each
         (empty cells where the other one holds the number). `part` as above.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.answer.inference.given_points import GivenPoints, GivenValue
from vcmm.core.digits import written_step
from vcmm.core.errors import DataError, choose_from
from vcmm.core.text import to_number
from vcmm.core.units import UNITS, dimension_of
from vcmm.files.sheets import Sheet, SheetColumn, instead, read_csv

LENGTHS = tuple(u for u in UNITS if dimension_of(u) == "length")
ANGLES = tuple(u for u in UNITS if dimension_of(u) == "angle")
WORDS = ("feature", "part", "stylus")
NORMALS = ("nx", "ny", "nz")
MEASURED_COLUMNS = tuple(f"measured_{c}_mm" for c in "xyz")  # as `vcmm measure` writes them
BESIDE = (*(f"nominal_{c}_mm" for c in "xyz"), "error_um")  # further columns beside them, not needed


@dataclass(frozen=True)
class ValueColumn:
    """A column of numbers in values.csv: its name, factor to mm or rad, and whether it counts from nominal."""

    name: str
    factor: float
    angle: bool
    deviation: bool


def read_measured_points(path: str | Path) -> tuple[GivenPoints, ...]:
    """Return the points of every part, in the order in which the parts appear. Raises DataError: columns, cells, normals."""
    sheet = read_csv(path)
    names, factor = _coordinates(sheet)
    has_normals = any(n in sheet.header for n in NORMALS)
    check_columns(
        sheet,
        (*names, *(NORMALS if has_normals else ())),
        (*WORDS, *names, *NORMALS, *(BESIDE if names == MEASURED_COLUMNS else ())),
    )
    points = factor * np.stack([sheet.numbers(n) for n in names], axis=1)
    normals = np.stack([sheet.numbers(n) for n in NORMALS], axis=1) if has_normals else None
    feature, stylus = (_words(sheet, name) for name in ("feature", "stylus"))
    step = factor * written_step([list(sheet.texts(n)) for n in names])
    parts = []
    for part, rows in _parts(sheet):
        parts.append(
            GivenPoints(
                part=part, points=points[rows], where=tuple(sheet.at(i) for i in rows),
                features=None if feature is None else tuple(feature[i] for i in rows),
                styli=None if stylus is None else tuple(stylus[i] for i in rows),
                normals=None if normals is None else normals[rows],
                step=step,
            )
        )  # fmt: skip
    return tuple(parts)


def read_measured_values(path: str | Path) -> tuple[tuple[GivenValue, ...], ...]:
    """Return the values of every part, in the order in which the parts appear. Raises DataError: columns, cells, a value given twice."""
    sheet = read_csv(path)
    columns = [c for c in (value_column(name) for name in sheet.header) if c is not None]
    allowed = ["characteristic", "part", "value_mm", "deviation_um", "value_deg"]
    named = ["characteristic", *(c.name for c in columns)]
    check_columns(sheet, ["characteristic"], ["part", *named], allowed)
    if not columns:
        at = sheet.head
        raise DataError(f"{at}: there is no column of values; add value_mm (deviation_um, value_deg ...)")
    return tuple(_values_of(sheet, columns, part, rows) for part, rows in _parts(sheet))


def _values_of(
    sheet: Sheet, columns: Sequence[ValueColumn], part: str, rows: Sequence[int]
) -> tuple[GivenValue, ...]:
    at, problems = sheet.header.index("characteristic"), []
    out: list[GivenValue] = []
    for i in rows:
        name = sheet.rows[i][at]
        filled = [c for c in columns if sheet.rows[i][sheet.header.index(c.name)]]
        if len(filled) != 1:
            problems.append(
                f'{sheet.at(i)}: "{name}" has {len(filled)} values; expected one number in its row'
            )
        elif any(v.name == name for v in out):
            problems.append(
                f'{sheet.at(i)}: "{name}" is given twice; one part has one value of it (column part tells parts apart)'
            )
        else:
            try:
                out.append(value_in(sheet, i, name, part, filled[0]))
            except ValueError:
                cell = sheet.rows[i][sheet.header.index(filled[0].name)]
                problems.append(
                    f'{sheet.at(i)}: "{cell}" in column {filled[0].name} is not a finite number{instead(cell, filled[0].name)}'
                )
    if problems:
        raise DataError(problems)
    return tuple(out)


def value_in(sheet: Sheet, row: int, name: str, part: str, column: ValueColumn) -> GivenValue:
    """Return the number of a row in one column. ValueError: it is no finite number."""
    number = to_number(sheet.rows[row][sheet.header.index(column.name)])
    if not np.isfinite(number):
        raise ValueError
    return GivenValue(
        part,
        name,
        number * column.factor,
        angle=column.angle,
        deviation=column.deviation,
        where=sheet.at(row),
    )


def value_column(name: str) -> ValueColumn | None:
    """Parse a heading such as value_mm or deviation_um; None for another one."""
    head, _, unit = name.partition("_")
    if head not in ("value", "deviation") or unit not in (*LENGTHS, *ANGLES):
        return None
    return ValueColumn(name, UNITS[unit][0], unit in ANGLES, head == "deviation")


def _coordinates(sheet: Sheet) -> tuple[tuple[str, ...], float]:
    """Return the names of the three coordinate columns and the factor to mm."""
    for unit in LENGTHS:
        names = tuple(f"{c}_{unit}" for c in "xyz")
        if set(names) & set(sheet.header):
            return names, UNITS[unit][0]
    if set(MEASURED_COLUMNS) <= set(sheet.header):
        return MEASURED_COLUMNS, 1.0
    at = sheet.head
    bare = [c for c in "xyzXYZ" if c in sheet.header]
    hint = f' "{bare[0]}" states no unit.' if bare else ""
    raise DataError(
        f"{at}: the columns x_mm, y_mm, z_mm are missing.{hint} The header is feature,x_mm,y_mm,z_mm"
    )


def check_columns(
    sheet: Sheet, needed: Sequence[str], allowed: Sequence[str], shown: Sequence[str] | None = None
) -> None:
    """Raise DataError for a missing column that is needed, and for an unknown one."""
    columns = shown or allowed
    problems = sheet.missing(map(SheetColumn, needed))
    problems += sheet.unknown(allowed, lambda name: f".{_no_unit(name)}{choose_from(name, columns)}")
    if problems:
        raise DataError(problems)


def _no_unit(name: str) -> str:
    return f' "{name}" states no known unit.' if name.startswith(("value", "deviation")) else ""


def _words(sheet: Sheet, name: str) -> list[str] | None:
    return sheet.words(name) if name in sheet.header else None


def _parts(sheet: Sheet) -> list[tuple[str, list[int]]]:
    """Name of every part and its rows; one nameless part without such a column."""
    names = _words(sheet, "part")
    if names is None:
        return [("", list(range(len(sheet.rows))))]
    return [(part, [i for i, n in enumerate(names) if n == part]) for part in dict.fromkeys(names)]
