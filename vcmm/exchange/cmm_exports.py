"""Values as other measuring software exports them: tables of CALYPSO (..._chr.txt) and text reports of PC-DMIS.

CALYPSO   tab-separated; heading planid partnb id type idsymbol actual nominal uppertol lowertol ... unit; perhaps a last line END.
          `id` is the characteristic, `actual` its value, `partnb` the part.
PC-DMIS   blocks  DIM LOC1= LOCATION OF CIRCLE CIR1 UNITS=MM  with a heading  AX NOMINAL +TOL -TOL MEAS DEV OUTTOL, in the order and
          with the columns that the FORMAT of the program chose, and a row per axis. Rows of a position leave cells empty: such a
          row is read by where its numbers stand. The characteristic is LOC1, or LOC1.D where the block has several rows.

Such files hold everything that was measured. What the scenario does not ask for, and what is not understood, is said.
Sources: help of PC-DMIS, "Dimension Command Format" and "Dimension Format" (Hexagon); an exported table of CALYPSO with all 45
columns, in the open zeiss converter. Nobody of us has either program.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.core.errors import DataError, did_you_mean
from vcmm.core.text import brief, lines_of
from vcmm.core.units import UNITS
from vcmm.exchange.foreign_text import foreign_number, foreign_text
from vcmm.inference.given import GivenValue

UNIT_WORDS = {
    "mm": "mm", "inch": "in", "in": "in", "um": "um", "µm": "um", "deg": "deg", "°": "deg", "rad": "rad",
}  # fmt: skip
CALYPSO = ("id", "actual", "nominal", "idsymbol")
BLOCK = re.compile(r"(?:DIM\s+)?([^\s=]+)\s*=\s*(.+?)(?:\s+UNITS\s*=\s*(\w+).*|\s*,\s*\$)$", re.IGNORECASE)
AXIS = re.compile(r"[A-Z]{1,3}", re.IGNORECASE)
NUMBER = re.compile(r"[-+]?[.,]?\d|-{2}")
TOLERANCE_COMMAND = re.compile(r"FCF[A-Z0-9_]+\b", re.IGNORECASE)
HEADINGS = {"NOM": "NOMINAL", "OUT-TOL": "OUTTOL", "AXIS": "AX"}
ANGLES = ("A", "PA")  # axes of a LOCATION that are angles: of a cone, polar
NO_FCF = "geometric tolerance commands (FCF...) are not read; write their values into values.csv"
SHOWN = 8  # names in a message


@dataclass(frozen=True)
class ExportRow:
    """One number of an export as it stands there. short: the name of its block, where the block has this row only."""

    part: str
    name: str
    cell: str
    unit: str
    column: str
    where: str
    short: str = ""
    broken: str = ""  # why its number cannot be told

    def value(self, name: str) -> GivenValue:
        """In mm or rad, under a name. DataError: no number, an unknown unit, a broken row."""
        if self.broken:
            raise DataError(f"{self.where}: {self.broken}")
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
        )


@dataclass(frozen=True)
class Export:
    """All rows of an export, and what of it is not understood."""

    kind: str
    rows: tuple[ExportRow, ...]
    notes: tuple[str, ...]


Reader = Callable[[Path, Sequence[str], list[str]], Iterator[ExportRow]]


def read_export(path: str | Path) -> Export | None:
    """An export of CALYPSO or PC-DMIS; None where the file is none. DataError, with the line: cut off, the wrong table."""
    text, assumed = foreign_text(path)
    lines = list(lines_of(text))
    kind = _kind(Path(path), lines)
    if kind is None:
        return None
    notes = list(assumed)
    rows = tuple(READERS[kind](Path(path), lines, notes))
    return Export(kind, rows, tuple(notes))


def exported_values(
    path: str | Path, wanted: Collection[str]
) -> tuple[tuple[tuple[GivenValue, ...], ...], str] | None:
    """(values per part, what was left out in words) of an export; None where the file is no such export.

    DataError, with the line: a cell that is no number, an unknown unit, a value given twice, none of the wanted ones there.
    """
    export = read_export(path)
    if export is None:
        return None
    asked = [(row, name) for row in export.rows if (name := _asked(row, wanted))]
    others = list(dict.fromkeys(row.short or row.name for row in export.rows if not _asked(row, wanted)))
    rows = [row.value(name) for row, name in asked]
    if not rows:
        hint = did_you_mean(others[0], list(wanted)) if others else ""
        raise DataError(
            f"{path}:1: it holds none of the characteristics of the part ({', '.join(wanted)}); it has {_some(others) or 'no value at all'}.{hint} Name "
            "the characteristics as the export does"
        )
    _check_once(rows)
    parts = tuple(tuple(v for v in rows if v.part == p) for p in dict.fromkeys(v.part for v in rows))
    said = (
        [f"{path}: {len(others)} characteristics are not asked for and left out: {_some(others)}"]
        if others
        else []
    )
    return parts, "; ".join([*said, *export.notes])


def _asked(row: ExportRow, wanted: Collection[str]) -> str:
    """The name under which a row is asked for, or ""."""
    return next((n for n in (row.short, row.name) if n and n in wanted), "")


def _some(names: Sequence[str]) -> str:
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")


def _kind(path: Path, lines: Sequence[str]) -> str | None:
    """Which reader a file wants, by its heading. DataError: another table of CALYPSO."""
    head = [c.strip() for c in next((line for line in lines if line.strip()), "").split("\t")]
    if set(CALYPSO) <= set(head):
        return "CALYPSO table"
    if head[0] == "planid" and len(head) > 2:
        raise DataError(
            f"{path}:1: this table of CALYPSO holds features or head data, no characteristics; name the one that ends in _chr.txt"
        )
    begun = any(BLOCK.match(line.strip()) and _is_dimension(lines, n) for n, line in enumerate(lines))
    return "PC-DMIS report" if begun else None


def _is_dimension(lines: Sequence[str], at: int) -> bool:
    """Whether a heading AX follows within a few lines."""
    return any(line.strip().upper().startswith(("AX ", "AX\t")) for line in lines[at + 1 : at + 5])


def _check_once(rows: Sequence[GivenValue]) -> None:
    seen: dict[tuple[str, str], str] = {}
    for v in rows:
        first = seen.setdefault((v.part, v.name), v.where)
        if first != v.where:
            of = f' of part "{v.part}"' if v.part else ""
            raise DataError(f'{v.where}: "{v.name}"{of} stands in {first} already; keep one')


def _calypso(path: Path, lines: Sequence[str], _notes: list[str]) -> Iterator[ExportRow]:
    header: list[str] = []
    for n, line in enumerate(lines, 1):
        cells = [c.strip() for c in line.split("\t")]
        if not line.strip() or cells[0] == "END":
            continue
        if not header:
            header = cells
            continue
        row = dict(zip(header, cells))
        if not row.get("id"):
            raise DataError(f"{path}:{n}: the row has no id; it was cut off, export the table again")
        given = {k: row.get(k, "") for k in ("partnb", "actual", "unit")}
        yield ExportRow(given["partnb"], row["id"], given["actual"], given["unit"], "actual", f"{path}:{n}")


@dataclass
class _Dimension:
    """A dimension of a PC-DMIS report while it is read."""

    name: str
    unit: str
    header: tuple[tuple[str, int], ...] = ()  # words and where they end
    rows: tuple[tuple[str, str, str, str], ...] = ()  # where, axis, measured cell, why it cannot be told


def _pcdmis(path: Path, lines: Sequence[str], notes: list[str]) -> Iterator[ExportRow]:
    block: _Dimension | None = None
    for n, line in enumerate(lines, 1):
        text, where = line.strip(), f"{path}:{n}"
        begins = BLOCK.match(text) if _is_dimension(lines, n - 1) else None
        if begins or text.upper().startswith("END OF DIMENSION"):
            yield from _rows(block)
            block = (
                _Dimension(begins[1], begins[3] or ("deg" if "ANGLE" in begins[2].upper() else ""))
                if begins
                else None
            )
        elif TOLERANCE_COMMAND.match(text):
            notes.append(f"{where}: {brief(text.split()[0])}: {NO_FCF}")
        elif block and text.upper().startswith(("AX ", "AX\t")):
            block.header = tuple(
                (HEADINGS.get(m[0], m[0]), m.end()) for m in re.finditer(r"\S+", line.upper())
            )
        elif block and block.header and _is_row(text):
            block.rows += (_row(block, line, where),)
    yield from _rows(block)


def _is_row(text: str) -> bool:
    """An axis (X, D, TP, ...) and something that stands for a number; not the head of a new page within a block."""
    axis, *others = text.split() or [""]
    return bool(AXIS.fullmatch(axis)) and any(NUMBER.match(cell) for cell in others)


def _row(block: _Dimension, line: str, where: str) -> tuple[str, str, str, str]:
    """(where, axis, measured cell, why it cannot be told). DataError: the heading has no MEAS."""
    words = [w for w, _ in block.header]
    if "MEAS" not in words:
        raise DataError(f"{where}: the heading of {block.name} has no column MEAS; add it to the report")
    cells = [(m[0], m.end()) for m in re.finditer(r"\S+", line)]
    axis = cells[0][0]
    if len(cells) >= len(words):
        measured = cells[words.index("MEAS")][0]
        return where, axis, measured, "" if measured.strip("-") else "no measured value stands in this row"
    placed = _by_place(cells, block.header)
    if placed is None or not _agrees(placed, words):
        why = f"{len(cells)} cells where the heading names {len(words)}, and not each under its heading; export the report again"
        return where, axis, "", why
    return (
        where,
        axis,
        placed.get("MEAS", ""),
        "" if "MEAS" in placed else "no measured value stands in this row",
    )


def _by_place(cells: Sequence[tuple[str, int]], header: Sequence[tuple[str, int]]) -> dict[str, str] | None:
    """Cells of a short row by the heading near whose end they end; None where two stand under one."""
    found = {min(header, key=lambda h: abs(h[1] - end))[0]: cell for cell, end in cells}
    return found if len(found) == len(cells) else None


def _agrees(placed: Mapping[str, str], words: Sequence[str]) -> bool:
    """Whether deviation = measured - nominal holds in a short row to its last digit: the proof that its cells stand rightly."""
    if "MEAS" not in placed:
        return True
    if "DEV" not in words:
        return False
    try:
        measured, deviation = foreign_number(placed["MEAS"]), foreign_number(placed["DEV"])
        digit = 10.0 ** -len(re.sub(r"^[^.,]*[.,]?", "", placed["MEAS"]))
    except (KeyError, ValueError):
        return False
    try:
        nominal = foreign_number(placed["NOMINAL"])
    except (KeyError, ValueError):
        nominal = 0.0  # none, or a word such as RFS or MMC
    return abs(measured - nominal - deviation) <= 1.5 * digit


def _rows(block: _Dimension | None) -> Iterator[ExportRow]:
    for where, axis, cell, broken in block.rows if block else ():
        assert block is not None
        unit = "deg" if axis.upper() in ANGLES else block.unit
        short = block.name if len(block.rows) == 1 else ""
        name = f"{block.name}.{axis}"
        yield ExportRow("", name, cell, unit, column="MEAS", where=where, short=short, broken=broken)


READERS: Mapping[str, Reader] = {"CALYPSO table": _calypso, "PC-DMIS report": _pcdmis}
