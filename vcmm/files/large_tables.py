"""Tables of very many rows, column by column: CSV read piece by piece, Parquet by pyarrow.

What a cell may hold is the same as in `read_csv`, which keeps every cell as text: some 100 bytes. Here a number takes 8 bytes,
a label as many letters as the longest one, and pieces of PIECE rows are text for a moment.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.errors import DataError, Environment
from vcmm.core.run import Array
from vcmm.core.text import LARGEST, is_file, read_head, read_text
from vcmm.core.units import ABSOLUTE_ZERO
from vcmm.files.columns import (
    LABELS,
    Sheet,
    cells_of,
    file_columns,
    header_of,
    known_column,
    read_csv,
    row_problems,
)

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
    """A Sheet that holds columns instead of rows. values: numbers (n,) or texts (n,) by name."""

    values: dict[str, Any] = field(default_factory=dict)

    @property
    def count(self) -> int:
        return len(self.lines)

    def numbers(self, name: str) -> Array:
        return np.asarray(self.values[name], dtype=float)

    def texts(self, name: str) -> np.ndarray:
        return np.asarray(self.values[name], dtype=np.str_)


def read_table(path: str | Path) -> Sheet:
    """A table of any size: .parquet by pyarrow, large CSV files piece by piece, others as `read_csv`. Raises DataError."""
    path = Path(path)
    if path.suffix.lower() == ".parquet":
        return _parquet(path)
    if not is_file(path) or path.stat().st_size < LARGE:
        return read_csv(path)
    return _streamed(path)


def _streamed(path: Path) -> Sheet:
    """Numbers and labels of a CSV file, PIECE rows at a time."""
    header: list[str] = []
    head_line, delimiter = 0, ","
    parts: dict[str, list[Any]] = {}
    lines: list[Array] = []
    for piece in _pieces(path):
        if not header:
            header, delimiter, head_line = header_of(path, piece[0])
            parts = {name: [] for name in header}
            piece = piece[1:]
        if piece:
            table, numbers = _rows(path, piece, delimiter)
            problems = row_problems(path, header, table, numbers)
            if problems:
                raise DataError(problems)
            one = Sheet(path, header, table, head_line, numbers)
            for i, name in enumerate(header):
                parts[name].append(_column(one, i))
            lines.append(np.array(numbers))
    if not lines:
        return read_csv(path)  # says what is missing
    values = {name: np.concatenate(parts.pop(name)) for name in header}
    return ColumnSheet(path, header, [], head_line, np.concatenate(lines), values)  # type: ignore[arg-type]


def _pieces(path: Path) -> Iterator[list[tuple[int, str]]]:
    """(line, text) of lines that are not empty and no comments."""
    try:
        with path.open(encoding="utf-8-sig", newline=None) as file:
            at = 0
            while text := list(islice(file, PIECE)):
                kept = [(at + k, one.rstrip("\n")) for k, one in enumerate(text, 1)]
                at += len(text)
                kept = [(k, one) for k, one in kept if one.strip() and not one.lstrip().startswith("#")]
                if kept:
                    yield kept
    except UnicodeDecodeError:
        read_text(path)  # says where
        raise


def _rows(path: Path, piece: list[tuple[int, str]], delimiter: str) -> tuple[list[list[str]], list[int]]:
    """Cells and line of every row."""
    if any('"' in text or "'" in text for _, text in piece):
        return cells_of(path, piece, delimiter)
    return [[c.strip() for c in text.split(delimiter)] for _, text in piece], [k for k, _ in piece]


def _column(sheet: Sheet, i: int) -> Any:
    """Column i of a piece; DataError as `Sheet.numbers` says it."""
    name, cells = sheet.header[i], [row[i] for row in sheet.rows]
    if name in LABELS or not known_column(name, _KNOWN):
        return np.array(cells, dtype=np.str_)
    if not _ODD.search("".join(cells)):
        try:
            found = np.array([float(c) for c in cells])
        except ValueError:
            return sheet.numbers(name)
        if np.abs(found).max() <= LARGEST and (not name.startswith("temp_") or found.min() >= ABSOLUTE_ZERO):
            return found
    return sheet.numbers(name)


_KNOWN = file_columns()


def _parquet(path: Path) -> Sheet:
    """Columns of a Parquet file; a row is told by its number, 1 the first."""
    read_head(path)
    try:
        from pyarrow import ArrowException, parquet
    except ImportError:
        raise Environment('Parquet files need pyarrow: pip install "vcmm[parquet]"') from None
    try:
        table = parquet.ParquetFile(path).read()
    except (ArrowException, OSError, ValueError) as error:
        raise DataError(f"{path}:1: no Parquet file ({error}); export it again") from None
    header = list(table.column_names)
    problems = [
        f'{path}:1: the column "{n}" is named twice; keep one'
        for n in {n for n in header if header.count(n) > 1}
    ]
    if table.num_rows == 0:
        problems.append(f"{path}:1: there are no rows; add one row per point")
    for name in () if problems else header:
        problems += _parquet_problems(path, name, table.column(name))
    if problems:
        raise DataError(problems)
    values = {n: _values(n, table.column(n)) for n in header}
    return ColumnSheet(path, header, [], 1, np.arange(1, table.num_rows + 1), values)  # type: ignore[arg-type]


def _parquet_problems(path: Path, name: str, column: Any) -> list[str]:
    """Empty cells, another type than numbers, numbers beyond all bounds: with the first row."""
    if column.null_count:
        first = int(np.flatnonzero(column.is_null().to_numpy())[0]) + 1
        return [
            f"{path}:{first}: column {name} has no value in {column.null_count} rows, here first; repair or remove them"
        ]
    if name in LABELS or not known_column(name, _KNOWN):
        return []
    if str(column.type) not in TYPES:
        return [f"{path}:1: column {name} holds {column.type}, not numbers; write it as double"]
    found = column.to_numpy().astype(float)
    low = ABSOLUTE_ZERO if name.startswith("temp_") and "gradient" not in name else -LARGEST
    wrong = np.flatnonzero(~((found >= low) & (found <= LARGEST)))
    if not len(wrong):
        return []
    k = int(wrong[0])
    return [
        f"{path}:{k + 1}: {found[k]:g} in column {name} is outside {low:g} to {LARGEST:g}, {len(wrong)} such rows; repair them"
    ]


def _values(name: str, column: Any) -> Any:
    if str(column.type) in TYPES and name not in LABELS:
        return column.to_numpy().astype(float)
    return np.array([str(v) for v in column.to_pylist()], dtype=np.str_)
