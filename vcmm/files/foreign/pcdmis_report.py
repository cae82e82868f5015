"""Tables of a PC-DMIS text report: dimensions (DIM LOC1= ...) with a heading AX, geometric tolerances (FCFLOC1 Position ...) with a heading FEATURE.

    FCFLOC1 Position   MM   dia 0.2 (M) A B C
    FEATURE  NOMINAL  +TOL  -TOL  BONUS  MEAS  DEV  OUTTOL
    CIR1     0.0000  0.2000 0.0000 0.0104 0.0065 0.0065 0.0000

A row with fewer cells than the heading has words is read by the columns of its numbers, and checked by DEV = MEAS - NOMINAL. A row of a
geometric tolerance is FCFLOC1.Position.CIR1, or FCFLOC1.Position where the table has one; FCFFLAT1.PLN1 or FCFFLAT1 without a segment; a
Summary with axes gives FCFLOC1.CIR1.X. BONUS is what the size pays for at maximum or least material; MEAS still holds it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from vcmm.core.errors import DataError
from vcmm.files.foreign.foreign_text import foreign_number

AXIS = re.compile(r"[A-Z]{1,3}", re.IGNORECASE)
NUMBER = re.compile(r"[-+]?[.,]?\d|-{2}")
FRAME = re.compile(r"(?P<name>FCF[A-Z0-9_]+)\b\s*=?\s*(?P<segment>[A-Z]{4,})?", re.IGNORECASE)
UNIT = re.compile(r"\b(?P<unit>MM|IN|INCH)\b")
HEADINGS = {"NOM": "NOMINAL", "OUT-TOL": "OUTTOL", "AXIS": "AX"}
ANGLES = ("A", "PA")  # axes of a LOCATION that are angles: of a cone, polar
NO_TABLE = "no table with FEATURE and MEAS follows this geometric tolerance; write its value into values.csv"
MOST_LINES_TO_HEADING = 4  # lines from the name to the heading


@dataclass(frozen=True)
class TableRow:
    """One row: its name within the table (an axis, or a feature), cells of MEAS and BONUS (None: no such column), why it cannot be read;
    cells of NOMINAL and DEV, "" where there are none."""

    where: str
    name: str
    axis: str
    measured: str
    defect: str
    bonus: str | None
    nominal: str = ""
    deviation: str = ""


@dataclass
class ReportTable:
    """A dimension or geometric tolerance while it is read. header: words and where they end."""

    name: str
    unit: str
    segment: str = ""
    is_frame: bool = False
    header: tuple[tuple[str, int], ...] = ()
    rows: list[TableRow] = field(default_factory=list)

    def named_rows(self) -> Iterator[tuple[str, str, str, TableRow]]:
        """Yield (name, the short one or "", unit, row)."""
        parts = [self.name, *([self.segment] if self.segment and self.segment != "Summary" else [])]
        base = ".".join(parts)
        for row in self.rows:
            axis = f".{row.axis}" if row.axis and self.is_frame else ""
            short = base if len(self.rows) == 1 and not axis else ""
            yield (
                f"{base}.{row.name}{axis}",
                short,
                "deg" if row.name.upper() in ANGLES and not self.is_frame else self.unit,
                row,
            )


def frame_begins(lines: Sequence[str], at: int) -> bool:
    """Return whether a geometric tolerance with a table begins in this line."""
    if not FRAME.match(lines[at].strip()):
        return False
    for line in lines[at + 1 : at + 1 + MOST_LINES_TO_HEADING]:
        if is_frame_heading(line):
            return True
        if FRAME.match(line.strip()):
            return False
    return False


def is_frame_heading(line: str) -> bool:
    """Return whether a line is the heading of the values of a geometric tolerance."""
    words = line.upper().split()
    return bool(words) and words[0] == "FEATURE" and "MEAS" in words


def frame_of(line: str) -> ReportTable:
    """Return the table that a line such as `FCFLOC1 Position  MM` begins."""
    match = FRAME.match(line.strip())
    assert match is not None
    unit = UNIT.search(line[match.end("name") :])
    segment = (match["segment"] or "").capitalize()
    return ReportTable(match["name"], unit["unit"] if unit else "", segment, is_frame=True)


def heading_of(line: str) -> tuple[tuple[str, int], ...]:
    """Return the words of a heading and where they end."""
    return tuple((HEADINGS.get(m[0], m[0]), m.end()) for m in re.finditer(r"\S+", line.upper()))


def is_row(table: ReportTable, text: str) -> bool:
    """Return whether a line is a row: a name (an axis X, D, TP ... of a dimension) and something that replaces a number; not the head of
    a new page within a table."""
    first, *others = text.split() or [""]
    named = table.is_frame or bool(AXIS.fullmatch(first))
    return bool(first) and named and any(NUMBER.match(cell) for cell in others)


def row_of(table: ReportTable, line: str, where: str) -> TableRow:
    """Parse a row by its heading. DataError: the heading has no MEAS."""
    words = [w for w, _ in table.header]
    if "MEAS" not in words:
        raise DataError(f"{where}: the heading of {table.name} has no column MEAS; add it to the report")
    cells = [(m[0], m.end()) for m in re.finditer(r"\S+", line)]
    complete = len(cells) == len(words) or (len(cells) > len(words) and not table.is_frame)
    placed = dict(zip(words, (c for c, _ in cells))) if complete else _by_place(cells, table.header)
    name, axis = cells[0][0], (placed or {}).get("AX", "")
    bonus = None if "BONUS" not in words else (placed or {}).get("BONUS", "")
    if placed is None or not (complete or _agrees(placed, words)):
        why = f"{len(cells)} cells where the heading names {len(words)}, and not each under its heading; export the report again"
        return TableRow(where, name, axis, "", why, bonus)
    measured = placed.get("MEAS", "")
    missing = "" if measured.strip("-") else "this row has no measured value"
    nominal, deviation = (placed.get(word, "") for word in ("NOMINAL", "DEV"))
    return TableRow(
        where,
        name,
        axis if table.is_frame else "",
        measured,
        missing,
        bonus=bonus,
        nominal=nominal,
        deviation=deviation,
    )


def _by_place(cells: Sequence[tuple[str, int]], header: Sequence[tuple[str, int]]) -> dict[str, str] | None:
    """Return the cells of a short row by the heading near whose end they end; None where two are under one."""
    by_heading = {min(header, key=lambda h: abs(h[1] - end))[0]: cell for cell, end in cells}
    return by_heading if len(by_heading) == len(cells) else None


def _agrees(placed: Mapping[str, str], words: Sequence[str]) -> bool:
    """Return whether deviation = measured - nominal holds in a short row to its last digit, which proves that its cells are assigned correctly."""
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
