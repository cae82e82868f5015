"""Tables of very many rows, column by column: CSV read piece by piece, Parquet by pyarrow.

Cells may hold the same as in `read_csv`, which keeps every cell as text: some 100 bytes. Here a number takes 8 bytes,
a label as many letters as the longest one, and pieces of PIECE rows are text for a moment. A piece of plain numbers is read by numpy's
own reader; any other, and any in which something is wrong, cell by cell.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.confinement import check_inside
from vcmm.core.errors import DataError, Environment
from vcmm.core.run import Array
from vcmm.core.text import LARGEST, is_file, read_head, read_text
from vcmm.core.units import ABSOLUTE_ZERO
from vcmm.files.columns import LABELS, file_columns, known_column
from vcmm.files.sheets import Layout, Sheet, cells_of, header_of, is_temperature, read_csv, row_problems

LARGE = 8_000_000  # bytes of a CSV file that is read piece by piece
PIECE = 50_000  # rows
_ODD = re.compile(r"[^0-9eE+\-. ]")  # no character of a plain number
TYPES = (
    "double",
    "float",
    "halffloat",
    "int8",
    "int16",
    "int32",
    "int64",
    "uint8",
    "uint16",
    "uint32",
    "uint64",
)


@dataclass(frozen=True)
class ColumnSheet(Sheet):
    """A Sheet that holds columns instead of rows. values: numbers (n,) or texts (n,) by name; a blank temperature is NaN."""

    values: dict[str, Any] = field(default_factory=dict)

    @property
    def count(self) -> int:
        return len(self.lines)

    def numbers(self, name: str) -> Array:
        values = np.asarray(self.values[name], dtype=float)
        blank = np.isnan(values)
        if blank.any():
            raise DataError(
                f"{self.at(int(np.argmax(blank)))}: column {name} has no value in {int(blank.sum())} rows, here first; repair or"
                " remove them"
            )
        return values

    def blanks(self, name: str) -> np.ndarray:
        values = self.values[name]
        return np.isnan(values) if values.dtype.kind == "f" else np.zeros(self.count, dtype=bool)

    def take(self, rows: np.ndarray) -> ColumnSheet:
        values = {n: v[rows] for n, v in self.values.items()}
        return replace(self, values=values, lines=np.asarray(self.lines)[rows])

    def without(self, name: str) -> ColumnSheet:
        values = {n: v for n, v in self.values.items() if n != name}
        return replace(self, header=[n for n in self.header if n != name], values=values)

    def with_numbers(self, name: str, rows: np.ndarray, new: Array) -> ColumnSheet:
        return replace(self, values=self.values | {name: np.where(rows, new, self.values[name])})

    def texts(self, name: str) -> np.ndarray:
        return np.asarray(self.values[name], dtype=np.str_)

    def words(self, name: str) -> list[str]:
        return list(map(str, self.texts(name)))


def read_table(path: str | Path) -> Sheet:
    """Read a table of any size: .parquet by pyarrow, large CSV files piece by piece, others as `read_csv`. Raises DataError."""
    path = Path(path)
    check_inside(path)
    if path.suffix.lower() == ".parquet":
        return _parquet(path)
    if not is_file(path) or path.stat().st_size < LARGE:
        return read_csv(path)
    return _read_stream(path)


def _read_stream(path: Path) -> Sheet:
    """Read numbers and labels of a CSV file, PIECE rows at a time."""
    header: list[str] = []
    head_line, delimiter = 0, ","
    parts: dict[str, list[Any]] = {}
    lines: list[Any] = []
    for at, text in _pieces(path):
        quick = _quick(text, header, delimiter) if header else None
        if quick is not None:
            for name in header:
                parts[name].append(quick[name])
            lines.append(np.arange(at + 1, at + len(text) + 1))
            continue
        if any("\0" in line for line in text):
            read_text(path)  # refuses it and says where
        piece = _data_lines(at, text)
        if piece and not header:
            header, delimiter, head_line = header_of(path, piece[0])
            parts = {name: [] for name in header}
            piece = piece[1:]
        if piece:
            block = _one_by_one(path, piece, header, head_line, delimiter)
            for i, name in enumerate(header):
                parts[name].append(_column(block, i))
            lines.append(np.array(block.lines))
    if not lines:
        return read_csv(path)  # says what is missing
    values = {name: np.concatenate(parts.pop(name)) for name in header}
    return ColumnSheet(path, header, [], head_line, np.concatenate(lines), values)  # type: ignore[arg-type]


def _pieces(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield (lines before it, lines with their ends) of every piece."""
    try:
        with path.open(encoding="utf-8-sig", newline=None) as file:
            at = 0
            while text := list(islice(file, PIECE)):
                yield at, text
                at += len(text)
    except UnicodeDecodeError:
        read_text(path)  # says where
        raise


def _data_lines(at: int, text: list[str]) -> list[tuple[int, str]]:
    """Return (line, text) of lines that are not empty and no comments."""
    pairs = ((k, line.rstrip("\n")) for k, line in enumerate(text, at + 1))
    return [(k, line) for k, line in pairs if line.strip() and not line.lstrip().startswith("#")]


def _quick(text: list[str], header: list[str], delimiter: str) -> dict[str, Any] | None:
    """Read columns of a piece by numpy's reader, which takes plain numbers alone; None where a line needs a closer look.

    That is: quotation marks, comments, empty lines, another count of cells, what is no number or beyond its bounds. The slow way
    then reads the piece, or says what is wrong.
    """
    joined = "".join(text)
    if any(mark in joined for mark in "\"'#\0") or "\n\n" in joined or not joined.strip():
        return None
    numbers = {name: name not in LABELS and known_column(name, _COLUMNS) for name in header}
    if not any(numbers.values()):  # of texts alone a blank line would be a row
        return None
    kinds = [(f"{k}", float if numbers[name] else object) for k, name in enumerate(header)]
    try:
        table = np.atleast_1d(np.loadtxt(text, kinds, comments=None, delimiter=delimiter))
    except ValueError:
        return None
    if len(table) != len(text):
        return None
    out: dict[str, Any] = {}
    for k, name in enumerate(header):
        values = table[f"{k}"]
        if not numbers[name]:
            out[name] = np.array([cell.strip() for cell in values], dtype=np.str_)
        elif _is_plain(values, name):
            out[name] = values.copy()
        else:
            return None
    return out


def _is_plain(values: Array, name: str) -> bool:
    """Return whether all numbers of a column are within the bounds of any table."""
    low = ABSOLUTE_ZERO if is_temperature(name) else -LARGEST
    return bool(values.min() >= low and values.max() <= LARGEST)


def _one_by_one(
    path: Path, piece: list[tuple[int, str]], header: list[str], head_line: int, delimiter: str
) -> Sheet:
    """Return the cells of a piece as text. Raises DataError for rows of another length than the header."""
    table, numbers = _rows(path, piece, delimiter)
    problems = row_problems(path, header, table, numbers)
    if problems:
        raise DataError(problems)
    return Sheet(path, header, table, head_line, numbers)


def _rows(path: Path, piece: list[tuple[int, str]], delimiter: str) -> tuple[list[list[str]], list[int]]:
    """Return cells and line of every row."""
    if any('"' in text or "'" in text for _, text in piece):
        return cells_of(path, piece, delimiter)
    layout = Layout(delimiter)
    return [layout.cells(text) for _, text in piece], [k for k, _ in piece]


def _column(sheet: Sheet, i: int) -> Any:
    """Return column i of a piece; DataError as `Sheet.numbers` raises it."""
    name, cells = sheet.header[i], [row[i] for row in sheet.rows]
    if name in LABELS or not known_column(name, _COLUMNS):
        return np.array(cells, dtype=np.str_)
    if is_temperature(name) and (blank := sheet.blanks(name)).any():
        out = np.full(sheet.count, np.nan)
        out[~blank] = sheet.take(np.flatnonzero(~blank)).numbers(name)
        return out
    if not _ODD.search("".join(cells)):
        try:
            values = np.array([float(c) for c in cells])
        except ValueError:
            return sheet.numbers(name)
        if _is_plain(values, name):
            return values
    return sheet.numbers(name)


_COLUMNS = file_columns()


def _parquet(path: Path) -> Sheet:
    """Return columns of a Parquet file; a row is named by its number, 1 the first."""
    read_head(path)
    try:
        from pyarrow import ArrowException, parquet
    except ImportError:
        raise Environment('Parquet files need pyarrow: pip install "vcmm[parquet]"') from None
    try:
        file = parquet.ParquetFile(path)
        header, count = list(file.schema_arrow.names), file.metadata.num_rows
        _check_parquet(path, header, count)
        values, problems = {}, []
        for name in header:  # one after the other: pyarrow's column is gone before the next is read
            column = file.read(columns=[name]).column(0)
            column_problems = _parquet_problems(path, name, column)
            problems += column_problems
            if not column_problems:
                values[name] = _values(name, column)
    except (ArrowException, OSError, ValueError) as error:
        raise DataError(f"{path}:1: no Parquet file ({error}); export it again") from None
    if problems:
        raise DataError(problems)
    return ColumnSheet(path, header, [], 1, np.arange(1, count + 1), values)  # type: ignore[arg-type]


def _check_parquet(path: Path, header: list[str], count: int) -> None:
    """Raises DataError for names that stand twice, and where there are no rows."""
    problems = [
        f'{path}:1: the column "{n}" is named twice; keep one'
        for n in {n for n in header if header.count(n) > 1}
    ]
    if count == 0:
        problems.append(f"{path}:1: there are no rows; add one row per point")
    if problems:
        raise DataError(problems)


def _parquet_problems(path: Path, name: str, column: Any) -> list[str]:
    """Return problems of a column: empty cells but of temperatures, another type than numbers, numbers beyond all bounds, with the first row."""
    sensor = is_temperature(name)
    if column.null_count == len(column) or (column.null_count and not sensor):
        first = int(np.flatnonzero(column.is_null().to_numpy())[0]) + 1
        return [
            f"{path}:{first}: column {name} has no value in {column.null_count} rows, here first; repair or remove them"
        ]
    if name in LABELS or not known_column(name, _COLUMNS):
        return []
    if str(column.type) not in TYPES:
        return [f"{path}:1: column {name} holds {column.type}, not numbers; write it as double"]
    values = column.to_numpy().astype(float, copy=False)
    low = ABSOLUTE_ZERO if sensor else -LARGEST
    blank = np.isnan(values) & sensor & ~np.isnan(values).all()
    wrong = np.flatnonzero(~((values >= low) & (values <= LARGEST)) & ~blank)
    if not len(wrong):
        return []
    k = int(wrong[0])
    return [
        f"{path}:{k + 1}: {values[k]:g} in column {name} is outside {low:g} to {LARGEST:g}, {len(wrong)} such rows; repair them"
    ]


def _values(name: str, column: Any) -> Any:
    if str(column.type) in TYPES and name not in LABELS:
        return column.to_numpy().astype(float, copy=False)
    return np.concatenate([np.array([str(v) for v in c.to_pylist()], dtype=np.str_) for c in column.chunks])
