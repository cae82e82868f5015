"""Read values that other measuring software exports: tables of CALYPSO (..._chr.txt) and text reports of PC-DMIS.

CALYPSO   tab-separated; heading planid partnb id type idsymbol actual nominal uppertol lowertol ... unit; perhaps a last line END.
          `id` is the characteristic, `actual` its value, `partnb` the part.
PC-DMIS   blocks  DIM LOC1= LOCATION OF CIRCLE CIR1 UNITS=MM  with a heading  AX NOMINAL +TOL -TOL MEAS DEV OUTTOL, in the order and
          with the columns that the FORMAT of the program chose, and a row per axis. Rows of a position leave cells empty: such a
          row is read by the columns of its numbers. The characteristic is LOC1, or LOC1.D where the block has several rows; tables of
          geometric tolerances (FCF...) are those of vcmm.files.foreign.pcdmis_report.

Such files hold everything that was measured. Notes name values that the scenario does not need, and rows that are not understood.
Sources: help of PC-DMIS, "Dimension Command Format" and "Dimension Format" (Hexagon); an exported table of CALYPSO with all 45
columns, in the open zeiss converter. Not tested with either program.

An export is also checked against itself and against the scenario: deviation = actual - nominal, and one nominal in both.

A row measured against another nominal than that of the scenario is a row of another drawing, or the scenario is: its value is right,
its decision may not be. Numbers are compared as far as they are written: deviation within 1.5 last digits of the coarsest of the
three (each is rounded on its own), nominal within half a last digit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.answer.inference.given_points import GivenValue
from vcmm.core.errors import DataError, did_you_mean
from vcmm.core.text import brief, lines_of
from vcmm.core.units import UNITS
from vcmm.files.foreign.foreign_text import foreign_number, foreign_text
from vcmm.files.foreign.pcdmis_report import (
    FRAME,
    NO_TABLE,
    ReportTable,
    frame_begins,
    frame_of,
    heading_of,
    is_frame_heading,
    is_row,
    row_of,
)
from vcmm.files.sheets import Layout

ROUNDING = 1e-6  # of a last digit: binary numbers


@dataclass(frozen=True)
class StatedCells:
    """Cells of one row as written ("" where there is none), and the words of their columns."""

    actual: str
    nominal: str = ""
    deviation: str = ""
    words: tuple[str, str, str] = ("actual", "nominal", "deviation")


def contradictions(cells: StatedCells, unit: str, drawing: float | None) -> list[str]:
    """Return contradictions in words, without the place. unit: of the cells; drawing: nominal of the scenario, mm or rad."""
    actual, nominal, deviation = (_number(c) for c in (cells.actual, cells.nominal, cells.deviation))
    a, n, d = cells.words
    out = []
    if nominal is not None and drawing is not None:
        due = drawing / UNITS[unit][0]
        if abs(nominal - due) > (0.5 + ROUNDING) * _digit(cells.nominal) + ROUNDING * 1e-3:
            out.append(
                f"{n} {cells.nominal.strip()} {unit} is not that of the scenario, {due:.9g} {unit}: the value is judged against the "
                "scenario; correct the one that is not on the drawing"
            )
    if actual is not None and nominal is not None and deviation is not None:
        difference = actual - nominal
        allowed = (1.5 + ROUNDING) * max(_digit(c) for c in (cells.actual, cells.nominal, cells.deviation))
        if (
            min(abs(difference - deviation), abs(difference + deviation)) > allowed
        ):  # either sign: of a place below zero some count outwards
            places = max(_places(c) for c in (cells.actual, cells.nominal))
            out.append(
                f"{d} {cells.deviation.strip()} is not {a} - {n} = {cells.actual.strip()} - {cells.nominal.strip()} = "
                f"{difference:.{places}f} {unit}; {a} is taken"
            )
    return out


def _number(cell: str) -> float | None:
    """Return the number of a cell; None for an empty cell, or a word such as MMC."""
    try:
        return foreign_number(cell)
    except ValueError:
        return None


def _places(cell: str) -> int:
    """Return the digits behind the point or comma: 50,0021 -> 4."""
    return len(re.sub(r"^[^.,]*[.,]?", "", cell.strip().lower().split("e")[0]))


def _digit(cell: str) -> float:
    """Return the value of the last digit: 50,0021 -> 1e-4, 1.5e-3 -> 1e-4."""
    power = cell.strip().lower().partition("e")[2]
    return float(10.0 ** ((int(power) if power else 0) - _places(cell)))


UNIT_WORDS = {
    "mm": "mm", "inch": "in", "in": "in", "um": "um", "µm": "um", "deg": "deg", "°": "deg", "rad": "rad",
}  # fmt: skip
TABS = Layout("\t")
CALYPSO = ("id", "actual", "nominal", "idsymbol")
BLOCK = re.compile(r"(?:DIM\s+)?([^\s=]+)\s*=\s*(.+?)(?:\s+UNITS\s*=\s*(\w+).*|\s*,\s*\$)$", re.IGNORECASE)
MOST_SHOWN = 8  # names in a message


@dataclass(frozen=True)
class ExportRow:
    """One number of an export as written in the file. short: the name of its block, where the block has this row only."""

    part: str
    name: str
    cell: str
    unit: str
    column: str
    where: str
    short: str = ""
    defect: str = ""  # why its number cannot be told
    bonus: str | None = "0"  # cell of what the size of the feature pays for; None: no such column
    nominal: str = ""
    deviation: str = ""

    def value(self, name: str) -> GivenValue:
        """Return the value in mm or rad, under a name. DataError: no number, an unknown unit, a broken row."""
        if self.defect:
            raise DataError(f"{self.where}: {self.defect}")
        unit = UNIT_WORDS.get(self.unit.strip().lower())
        if unit is None:
            stated = (
                f'the unit "{self.unit.strip()}" is not known' if self.unit.strip() else "no unit is stated"
            )
            raise DataError(f"{self.where}: {stated}; allowed are {', '.join(UNIT_WORDS)}")
        try:
            number = foreign_number(self.cell)
        except ValueError:
            what = (
                f'"{self.cell.strip()}" in column {self.column}'
                if self.cell.strip()
                else f"an empty cell in column {self.column}"
            )
            raise DataError(f"{self.where}: {what} is not a number") from None
        return GivenValue(
            self.part,
            name,
            number * UNITS[unit][0],
            angle=unit in ("deg", "rad"),
            deviation=False,
            where=self.where,
            bonus=None if self.bonus is None else foreign_number(self.bonus or "0") * UNITS[unit][0],
        )

    def remarks(self, name: str, drawing: float | None) -> list[str]:
        """Return remarks where nominal and deviation contradict the value or the scenario, with the line, for rows whose `value` can be
        read."""
        words = ("MEAS", "NOMINAL", "DEV") if self.column == "MEAS" else ("actual", "nominal", "deviation")
        cells = StatedCells(self.cell, self.nominal, self.deviation, words)
        remarks = contradictions(cells, UNIT_WORDS[self.unit.strip().lower()], drawing)
        return [f"{self.where}: {name}: {text}" for text in remarks]


@dataclass(frozen=True)
class Export:
    """All rows of an export, and notes on rows that are not understood."""

    kind: str
    rows: tuple[ExportRow, ...]
    notes: tuple[str, ...]


Reader = Callable[[Path, Sequence[str], list[str]], Iterator[ExportRow]]


def read_export(path: str | Path) -> Export | None:
    """Read an export of CALYPSO or PC-DMIS; None where the file is none. DataError, with the line: cut off, the wrong table."""
    text, assumed = foreign_text(path)
    lines = list(lines_of(text))
    kind = _kind(Path(path), lines)
    if kind is None:
        return None
    notes = list(assumed)
    rows = tuple(READERS[kind](Path(path), lines, notes))
    return Export(kind, rows, tuple(notes))


def exported_values(
    path: str | Path, wanted: Collection[str], nominals: Mapping[str, float] | None = None
) -> tuple[tuple[tuple[GivenValue, ...], ...], str] | None:
    """Return (values per part, a note on values left out) of an export; None where the file is no such export.

    nominals: of the scenario, mm or rad; notes report a row with another one, and a deviation that is not actual - nominal.
    DataError, with the line: a cell that is no number, an unknown unit, a value given twice, none of the wanted ones there.
    """
    export = read_export(path)
    if export is None:
        return None
    requested = [(row, name) for row in export.rows if (name := _requested_name(row, wanted))]
    others = list(
        dict.fromkeys(row.short or row.name for row in export.rows if not _requested_name(row, wanted))
    )
    rows = [row.value(name) for row, name in requested]
    if not rows:
        hint = did_you_mean(others[0], list(wanted)) if others else ""
        raise DataError(
            f"{path}:1: it holds none of the characteristics of the part ({', '.join(wanted)}); it has {_some(others) or 'no value at all'}.{hint} Name "
            "the characteristics as the export does"
        )
    _check_once(rows)
    parts = tuple(tuple(v for v in rows if v.part == p) for p in dict.fromkeys(v.part for v in rows))
    note = (
        [f"{path}: {len(others)} characteristics are not asked for and left out: {_some(others)}"]
        if others
        else []
    )
    remarks = [text for row, name in requested for text in row.remarks(name, (nominals or {}).get(name))]
    return parts, "; ".join([*remarks, *note, *export.notes])


def _requested_name(row: ExportRow, wanted: Collection[str]) -> str:
    """Return the name under which a row is requested, or ""."""
    return next((n for n in (row.short, row.name) if n and n in wanted), "")


def _some(names: Sequence[str]) -> str:
    more = len(names) - MOST_SHOWN
    return ", ".join(names[:MOST_SHOWN]) + (f" and {more} more" if more > 0 else "")


def _kind(path: Path, lines: Sequence[str]) -> str | None:
    """Return the reader for a file, by its heading. DataError: another table of CALYPSO."""
    head = TABS.cells(next((line for line in lines if line.strip()), ""))
    if set(CALYPSO) <= set(head):
        return "CALYPSO table"
    if head[0] == "planid" and len(head) > 2:
        raise DataError(
            f"{path}:1: this table of CALYPSO holds features or head data, no characteristics; name the one that ends in _chr.txt"
        )
    begun = any(
        (BLOCK.match(line.strip()) and _is_dimension(lines, n)) or frame_begins(lines, n)
        for n, line in enumerate(lines)
    )
    return "PC-DMIS report" if begun else None


def _is_dimension(lines: Sequence[str], at: int) -> bool:
    """Return whether a heading AX follows within a few lines."""
    return any(line.strip().upper().startswith(("AX ", "AX\t")) for line in lines[at + 1 : at + 5])


def _check_once(rows: Sequence[GivenValue]) -> None:
    lines_of: dict[tuple[str, str], str] = {}
    for v in rows:
        first = lines_of.setdefault((v.part, v.name), v.where)
        if first != v.where:
            of = f' of part "{v.part}"' if v.part else ""
            raise DataError(f'{v.where}: "{v.name}"{of} is already in {first}; keep one')


def _calypso(path: Path, lines: Sequence[str], _notes: list[str]) -> Iterator[ExportRow]:
    header: list[str] = []
    for line in TABS.rows(lines):
        n = line.line
        if line.cells[0] == "END":
            continue
        if not header:
            header = line.cells
            continue
        row = dict(zip(header, line.cells))
        if not row.get("id"):
            raise DataError(f"{path}:{n}: the row has no id; it was cut off, export the table again")
        given = {k: row.get(k, "") for k in ("partnb", "actual", "unit", "nominal", "deviation")}
        yield ExportRow(
            given["partnb"], row["id"], given["actual"], given["unit"], "actual", f"{path}:{n}",
            nominal=given["nominal"], deviation=given["deviation"],
        )  # fmt: skip


def _pcdmis(path: Path, lines: Sequence[str], notes: list[str]) -> Iterator[ExportRow]:
    table: ReportTable | None = None
    units: dict[str, str] = {}  # of a geometric tolerance: its summary states none
    for n, line in enumerate(lines, 1):
        text, where = line.strip(), f"{path}:{n}"
        begins = BLOCK.match(text) if _is_dimension(lines, n - 1) else None
        frame = FRAME.match(text) if not begins else None
        if begins or frame or text.upper().startswith("END OF DIMENSION"):
            yield from _rows(table)
            table = None
        if begins:
            table = ReportTable(begins[1], begins[3] or ("deg" if "ANGLE" in begins[2].upper() else ""))
        elif frame and frame_begins(lines, n - 1):
            table = frame_of(line)
            table.unit = units.setdefault(table.name, table.unit) if not table.unit else table.unit
            units[table.name] = table.unit
        elif frame and not any(word in text.upper() for word in ("SHIFT", "SUMMARY")):
            notes.append(f"{where}: {brief(frame['name'])}: {NO_TABLE}")
        elif table and (
            is_frame_heading(text) if table.is_frame else text.upper().startswith(("AX ", "AX\t"))
        ):
            table.header = heading_of(line)
        elif table and table.header and is_row(table, text):
            table.rows.append(row_of(table, line, where))
    yield from _rows(table)


def _rows(table: ReportTable | None) -> Iterator[ExportRow]:
    for name, short, unit, row in table.named_rows() if table else ():
        yield ExportRow(
            "", name, row.measured, unit, column="MEAS", where=row.where, short=short, defect=row.defect, bonus=row.bonus,
            nominal=row.nominal, deviation=row.deviation,
        )  # fmt: skip


READERS: Mapping[str, Reader] = {"CALYPSO table": _calypso, "PC-DMIS report": _pcdmis}
