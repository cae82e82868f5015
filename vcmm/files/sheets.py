"""Read tables as text: lines to cells, a header and its rows, and the columns that a reader declares.

    COLUMNS = (SheetColumn("target", units=("mm", "deg")), SheetColumn("run", word=True), SheetColumn("direction", word=True))
    sheet = read_csv(path)
    problems = sheet.missing(COLUMNS)

A column that states units is headed by its name and one of them (target_mm, target_deg); its numbers come in mm and rad.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import LARGEST, brief, is_usual, lines_of, read_text, to_number, unescape_cell
from vcmm.core.units import ABSOLUTE_ZERO, UNITS

BLANK = ("", "nan", "na", "n/a")
POINT = "; decimals take a point"
FEW = 5  # cells that are named one by one
DEAD = 0.5  # share of cells without a number from which it is the column that is wrong, and not the rows


@dataclass(frozen=True)
class SheetColumn:
    """A column that a table of some kind may have.

    units: of its numbers, as they end its heading; none where the numbers are not converted.   aliases: other headings of the
    same meaning.   others: other names, each with its units.   optional: the table may do without.   advice: the text of a message
    after "is missing".
    """

    name: str
    units: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    others: tuple[tuple[str, tuple[str, ...]], ...] = ()
    optional: bool = False
    advice: str = ""

    @property
    def headings(self) -> dict[str, float]:
        """Every heading of the column, the usual one first, and the factor from its unit to mm, rad, s ..."""
        named = [(self.name, self.units), *self.others]
        factors = {f"{name}_{unit}": UNITS[unit][0] for name, units in named for unit in units}
        return (factors or {self.name: 1.0}) | dict.fromkeys(self.aliases, 1.0)


@dataclass(frozen=True)
class Sheet:
    """A CSV file: header, rows of cells, and the line of the header and of every row."""

    path: Path
    header: list[str]
    rows: list[list[str]]
    header_line: int
    lines: list[int]

    def at(self, row: int) -> str:
        """Return 'front.csv:12', the place of a row (0 = first)."""
        return f"{self.path}:{self.lines[row]}"

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.rows)

    @property
    def head(self) -> str:
        """Place of the header, 'front.csv:1'."""
        return f"{self.path}:{self.header_line}"

    def heading(self, column: SheetColumn) -> str:
        """Return the heading under which a column is here; "" where it is absent."""
        return next((name for name in column.headings if name in self.header), "")

    def missing(self, columns: Iterable[SheetColumn]) -> list[str]:
        """Return problems with the presence of columns: one that is absent, one under two headings."""
        problems = []
        for column in columns:
            here = [name for name in column.headings if name in self.header]
            if len(here) == 1 or (not here and column.optional):
                continue
            first = next(iter(column.headings))
            what = (
                f"{' and '.join(here)} are both there; keep one"
                if here
                else f"the column {first} is missing{column.advice}"
            )
            several = f". Allowed: {', '.join(column.headings)}" if len(column.headings) > 1 else ""
            problems.append(f"{self.head}: {what}{several}")
        return problems

    def unknown(self, allowed: Collection[str], advice: Callable[[str], str]) -> list[str]:
        """Return one problem for every heading that is not allowed. advice: the text of the message after the name."""
        return [
            f'{self.head}: unknown column "{name}"{advice(name)}'
            for name in self.header
            if name not in allowed
        ]

    def quantities(self, column: SheetColumn) -> Array:
        """Return the numbers (n,) of a column that is here, in mm, rad, s ... DataError as `numbers` raises it."""
        name = self.heading(column)
        factor = column.headings[name]
        return self.numbers(name) if factor == 1.0 else self.numbers(name) * factor

    def quantities_or(self, column: SheetColumn, problems: list[str]) -> Array | None:
        """Return the same numbers; None where the column is not here once, or, with its problems noted, a cell is no number."""
        if sum(name in self.header for name in column.headings) != 1:
            return None
        try:
            return self.quantities(column)
        except DataError as error:
            problems.extend(error.problems)
        return None

    def stack(self, columns: Sequence[str]) -> Array:
        """Return several columns (n, k). Raises DataError naming every cell of all of them that is no number."""
        out: list[Array] = []
        problems: list[str] = []
        for name in columns:
            try:
                out.append(self.numbers(name))
            except DataError as error:
                problems.extend(error.problems)
        if problems:
            raise DataError(problems)
        return np.stack(out, axis=1)

    def words(self, name: str) -> list[str]:
        """Return the cells of one column."""
        i = self.header.index(name)
        return [row[i] for row in self.rows]

    def texts(self, name: str) -> np.ndarray:
        """Return one column (n,) as text."""
        return np.array(self.words(name), dtype=np.str_)

    def blanks(self, name: str) -> np.ndarray:
        """Return which cells of one column are empty (n,) bool."""
        return np.array([is_blank(cell) for cell in self.words(name)], dtype=bool)

    def take(self, rows: np.ndarray) -> Sheet:
        """Return the sheet with some of the rows, by number."""
        return replace(self, rows=[self.rows[k] for k in rows], lines=[self.lines[k] for k in rows])

    def without(self, name: str) -> Sheet:
        """Return the sheet without one column."""
        i = self.header.index(name)
        rows = [row[:i] + row[i + 1 :] for row in self.rows]
        return replace(self, header=[n for n in self.header if n != name], rows=rows)

    def with_numbers(self, name: str, rows: np.ndarray, new: Array) -> Sheet:
        """Return the sheet with other numbers (n,) in some of the rows (n,) of one column."""
        i = self.header.index(name)
        cells = [
            [*row[:i], repr(float(new[k])), *row[i + 1 :]] if rows[k] else row
            for k, row in enumerate(self.rows)
        ]
        return replace(self, rows=cells)

    def numbers(self, name: str) -> Array:
        """Return one column (n,). Raises DataError naming every cell that is no finite number."""
        i = self.header.index(name)
        out, problems = np.zeros(len(self.rows)), []
        for j, row in enumerate(self.rows):
            try:
                out[j] = to_number(row[i])
            except ValueError:
                problems.append(
                    f'{self.at(j)}: "{brief(row[i])}" in column {name} is not a number{instead(row[i], name)}'
                )
                continue
            if not is_usual(out[j]):
                what = f"beyond {LARGEST:g}" if np.isfinite(out[j]) else "not finite"
                problems.append(
                    f'{self.at(j)}: "{brief(row[i])}" in column {name} is {what}; remove or repair the row'
                )
            elif out[j] < ABSOLUTE_ZERO and is_temperature(name):
                problems.append(
                    f"{self.at(j)}: {row[i]} degC in column {name} is below absolute zero; repair the row"
                )
        if len(problems) > max(DEAD * len(self.rows), FEW):
            problems = [self._many(name, problems)]
        if problems:
            raise DataError(problems)
        return out

    def _many(self, name: str, problems: list[str]) -> str:
        """Return one sentence about a column of which many cells are wrong; it mentions a decimal comma."""
        share = f"{len(problems)} of {len(self.rows)} rows"
        if problems[0].endswith(POINT):
            return f"{problems[0]} ({share} of this column are so)"
        return (
            f"{self.head}: {name} is no finite number in {share}: repair the column, or remove it "
            "(what depends on it is then not testable), not the rows"
        )


@dataclass(frozen=True)
class Row:
    """One line of a table without quotation marks: its number in the file, its text and its cells."""

    line: int
    text: str
    cells: list[str]


@dataclass(frozen=True)
class Layout:
    """Layout of the rows of a table of other programs.

    separator: between cells, a regular expression; "" blanks.   comments: beginnings of lines that are no rows.   remark: text that
    ends the cells of a line.
    """

    separator: str = ""
    comments: tuple[str, ...] = ()
    remark: str = ""

    def cells(self, text: str) -> list[str]:
        """Return the cells of one line, without the blanks around them."""
        if not self.separator:
            return text.split()
        parts = text.split(self.separator) if len(self.separator) == 1 else re.split(self.separator, text)
        return [part.strip() for part in parts]

    def rows(self, lines: Iterable[str], first: int = 1) -> Iterator[Row]:
        """Yield every line with content. first: number of the first line in the file."""
        for number, raw in enumerate(lines, first):
            content = raw.split(self.remark)[0] if self.remark else raw
            text = content.strip()
            if text and not text.startswith(self.comments):
                yield Row(number, text, self.cells(content))


NO_NUMBER = '"{}" is not a number; decimals are written with a point'
UNUSUAL = "{} is not finite or far too large; remove the row or measure it again"


def numbers_of(
    cells: Sequence[str], at: str, no_number: str = NO_NUMBER, unusual: str = UNUSUAL
) -> list[float]:
    """Return the numbers of cells. Raises DataError with the place and one of the two sentences, {} the cells."""
    shown = brief(" ".join(cells))
    try:
        values = [to_number(cell) for cell in cells]
    except ValueError:
        raise DataError(f"{at}: {no_number.format(shown)}") from None
    if not all(map(is_usual, values)):
        raise DataError(f"{at}: {unusual.format(shown)}")
    return values


def is_blank(cell: str) -> bool:
    """Return whether a cell holds nothing: empty, or one of the words that programs write for it."""
    return cell.strip().lower() in BLANK


def is_temperature(name: str) -> bool:
    """Return whether a column holds temperatures, not differences of them."""
    return name.startswith(("temp_", "reading_")) and name.endswith("_C") and "gradient" not in name


def instead(cell: str, name: str) -> str:
    """Return what to write instead, where that is known."""
    if name.startswith("sense_"):
        return "; write 1 where the axis last moved up, -1 where it moved down, 0 where that is not known"
    return POINT if re.fullmatch(r"[-+]?\d+,\d+", cell) else ""


def read_csv(path: str | Path, numbered: bool = False) -> Sheet:
    """Read header and rows of a CSV file (comma, semicolon or tab). Raises DataError with the line of a ragged row.

    numbered: where the first line holds numbers alone there is no header, and the columns are "1", "2" ...
    """
    path = Path(path)
    lines = _lines_with_text(path)
    if numbered and lines and _holds_numbers(path, lines[0]):
        delimiter = _delimiter(lines[0][1])
        count = len(cells_of(path, lines[:1], delimiter)[0][0])
        lines = [(lines[0][0], delimiter.join(str(k + 1) for k in range(count))), *lines]
    if not lines:
        raise DataError(
            f"{path}:1: the file is empty; its first line names the columns, for example X_mm,Y_mm,Z_mm"
        )
    header, delimiter, header_line = header_of(path, lines[0])
    table, numbers = cells_of(path, lines, delimiter)
    problems = row_problems(path, header, table[1:], numbers[1:])
    if len(table) == 1:
        problems.append(f"{path}:{header_line}: there are no rows below the header; add one row per point")
    if problems:
        raise DataError(problems)
    return Sheet(path, header, table[1:], header_line, numbers[1:])


def _holds_numbers(path: Path, line: tuple[int, str]) -> bool:
    """Return whether every cell of a line is a number."""
    try:
        return bool([to_number(cell) for cell in cells_of(path, [line], _delimiter(line[1]))[0][0]])
    except ValueError:
        return False


def first_cells(path: Path) -> list[str]:
    """Return the cells of the first line with content, as `read_csv` separates them; none of an empty file."""
    for line in _lines_with_text(path)[:1]:
        return cells_of(path, [line], _delimiter(line[1]))[0][0]
    return []


def _lines_with_text(path: Path) -> list[tuple[int, str]]:
    """Return (number, text) of every line that is neither empty nor a comment."""
    lines = enumerate(lines_of(read_text(path)), 1)
    return [(i, line) for i, line in lines if line.strip() and not line.lstrip().startswith("#")]


def _delimiter(line: str) -> str:
    """Return the separator of the cells of a header."""
    return max(",;\t", key=line.count)


def header_of(path: Path, first: tuple[int, str]) -> tuple[list[str], str, int]:
    """Return names of the columns, their separator, and their line. Raises DataError for a name that occurs twice."""
    delimiter = _delimiter(first[1])
    (header,), (line,) = cells_of(path, [first], delimiter)
    repeated = {name for name in header if header.count(name) > 1}
    if repeated:
        raise DataError(f'{path}:{line}: the column "{name}" is named twice; keep one' for name in repeated)
    return header, delimiter, line


def row_problems(path: Path, header: list[str], rows: list[list[str]], lines: list[int]) -> list[str]:
    """Return problems of rows of another length than the header."""
    ragged = [(line, len(row)) for line, row in zip(lines, rows) if len(row) != len(header)]
    problems = [
        f"{path}:{line}: {cells} cells where the header names {len(header)}" for line, cells in ragged
    ]
    if 1 < len(rows) == len(ragged) and min(cells for _, cells in ragged) > len(header):
        return [f"{problems[0]}, and so in all {len(rows)} rows{POINT}, and commas only separate the columns"]
    return problems


def cells_of(path: Path, lines: list[tuple[int, str]], delimiter: str) -> tuple[list[list[str]], list[int]]:
    """Return rows of cells and the line on which each begins. Raises DataError where a quotation mark is not closed."""
    reader = csv.reader([text + "\n" for _, text in lines], delimiter=delimiter, strict=True)
    table: list[list[str]] = []
    numbers: list[int] = []
    while True:
        line = lines[min(reader.line_num, len(lines) - 1)][0]
        try:
            table.append([unescape_cell(cell.strip()) for cell in next(reader)])
        except StopIteration:
            return table, numbers
        except csv.Error as error:
            why = str(error)
            if "field larger" in why:
                raise DataError(
                    f"{path}:{line}: a cell of more than {csv.field_size_limit():,} characters; shorten it"
                ) from None
            raise DataError(
                f'{path}:{line}: the quotation marks of this row do not match ({why}); write each " in a text twice'
            ) from None
        numbers.append(line)
