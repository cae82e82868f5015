"""ISG volumetric CSV: tables of component errors in mm and rad, as controls read them, read and written.

A header line names columns (`X EXX EYX EZX EAX EBX ECX`), position-independent errors have no argument column
(`A0Z B0Z C0Y`), `#` starts the next table, `//` comments; several argument columns (`Z X EXX ...`) give a grid.
Rotary arguments are in rad. Separators: blanks, commas or semicolons. Names of other literatures (xty, δy(x), Txy)
are accepted; only the name is translated, signs and units are those of ISO 230-1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.axes import axis_of, is_axis
from vcmm.core.error_names import canonical
from vcmm.core.errors import DataError, UsageError
from vcmm.core.run import Array
from vcmm.core.text import lines_of, read_text
from vcmm.files.sheets import Layout, numbers_of


def isg_text(file: ErrorFile, comment: str = "") -> str:
    """Return the text of a file; numbers with ten digits, mm and rad."""
    parts = [_table_text(t) for t in file.tables]
    if file.constants:
        names = list(file.constants)
        parts.append(" ".join(names) + "\n" + " ".join(f"{file.constants[n]:.10g}" for n in names) + "\n")
    head = f"// {comment}\n" if comment else ""
    return head + "#\n".join(parts)


def _table_text(table: ErrorTable) -> str:
    mesh = np.meshgrid(*table.grids, indexing="ij")
    columns = [m.ravel() for m in mesh] + [np.ravel(v) for v in table.values.values()]
    rows = [" ".join(f"{v:.10g}" for v in row) for row in np.stack(columns, axis=1)]
    return "\n".join([" ".join([*table.arguments, *table.values]), *rows]) + "\n"


def with_values(file: ErrorFile, values: Mapping[str, Array | float]) -> ErrorFile:
    """Return the same tables with other numbers: component name -> values in the shape of its grids, or one number."""
    tables = tuple(
        ErrorTable(
            t.arguments,
            t.grids,
            {
                n: np.reshape(np.asarray(values.get(n, v), dtype=float), np.shape(v))
                for n, v in t.values.items()
            },
            t.line,
        )
        for t in file.tables
    )
    return ErrorFile(tables, {n: float(values.get(n, v)) for n, v in file.constants.items()})


LAYOUT = Layout(r"[\s,;]+", remark="//")
NO_NUMBER = "not a number in {}; decimals are written with a point"
UNUSUAL = "a value is not finite or far too large; remove the row or measure it again"


@dataclass(frozen=True)
class ErrorTable:
    """One table. arguments: axis letters; grids: one increasing vector each; values[name] has the grids' shape."""

    arguments: tuple[str, ...]
    grids: tuple[Array, ...]
    values: dict[str, Array]
    line: int


@dataclass(frozen=True)
class ErrorFile:
    """All tables of a file and the position-independent errors (mm or rad)."""

    tables: tuple[ErrorTable, ...]
    constants: dict[str, float]


@dataclass(frozen=True)
class _Block:
    """Header and rows of one table: names in ISO 230-1, numbers (rows, names), line of the header and of every row."""

    arguments: tuple[str, ...]
    names: list[str]
    numbers: Array
    line: int
    lines: list[int]


def read_isg(path: str | Path) -> ErrorFile:
    """Read a file. Raises DataError with everything wrong in it, each with its line: unknown names, ragged rows,
    positions that do not increase, numbers that are not finite, an error given twice.
    """
    path = Path(path)
    tables: list[ErrorTable] = []
    constants: dict[str, float] = {}
    problems: list[str] = []
    occurrences: dict[str, int] = {}
    for rows in _blocks(read_text(path)):
        try:
            block = _block(path, rows, occurrences)
            if block.arguments:
                tables.append(_table(path, block))
            else:
                constants.update(_constants(path, block))
        except DataError as error:
            problems.extend(error.problems)
    if not tables and not constants and not problems:
        problems.append(
            f"{path}:1: the file holds no table; write for example a line X EXX EYX and rows below it"
        )
    if problems:
        raise DataError(problems)
    return ErrorFile(tuple(tables), constants)


def _blocks(text: str) -> list[list[tuple[int, list[str]]]]:
    """Return (line, words) of every line with content, table by table."""
    blocks: list[list[tuple[int, list[str]]]] = [[]]
    for row in LAYOUT.rows(lines_of(text)):
        if row.text.startswith("#"):
            blocks.append([])
        if row.text.lstrip("#").strip():
            blocks[-1].append((row.line, [w for w in LAYOUT.cells(row.text.lstrip("#")) if w]))
    return [block for block in blocks if block]


def _block(path: Path, rows: list[tuple[int, list[str]]], occurrences: dict[str, int]) -> _Block:
    line, words = rows[0]
    count = next((i for i, word in enumerate(words) if not is_axis(word)), len(words))
    problems: list[str] = []
    names = list(words[:count])
    for word in words[count:]:
        try:
            names.append(canonical(word))
        except UsageError as error:
            problems.append(
                f"{path}:{line}: {error} Axis letters come first, then errors such as EXX EYX EAX (with an axis) "
                "or A0Z B0Z C0Y X0C (without)"
            )
    for name in names[count:]:
        if name in occurrences or names.count(name) > 1:
            first = f" first in line {occurrences[name]}" if name in occurrences else ""
            problems.append(f"{path}:{line}: {name} is given twice,{first} here again; keep one")
        occurrences.setdefault(name, line)
    if not problems:  # an unknown name says nothing of what it would need
        problems += _kind_problems(path, line, names, count)
    numbers = _numbers(path, rows[1:], words, problems)
    if problems:
        raise DataError(list(dict.fromkeys(problems)))
    return _Block(tuple(words[:count]), names, numbers, line, [number for number, _ in rows[1:]])


def _kind_problems(path: Path, line: int, names: list[str], count: int) -> list[str]:
    """Return problems of the columns: component errors need an axis column, position-independent ones have none."""
    out = []
    for name in names[count:]:
        if count == 0 and name[0] == "E":
            out.append(
                f"{path}:{line}: {name} varies along {axis_of(name)}; put a column {axis_of(name)} before it"
            )
        if count and name[1] == "0":
            out.append(
                f"{path}:{line}: {name} does not depend on a position; give it in a table of its own, after #"
            )
    if count == len(names):
        out.append(
            f"{path}:{line}: the table names axes but no error; add for example E{names[0][0]}{names[0]}"
        )
    return out


def _numbers(path: Path, rows: list[tuple[int, list[str]]], words: list[str], problems: list[str]) -> Array:
    out = []
    for line, cells in rows:
        if len(cells) != len(words):
            problems.append(
                f"{path}:{line}: {len(cells)} numbers where the header names {len(words)} ({' '.join(words)})"
            )
            continue
        try:
            out.append(numbers_of(cells, f"{path}:{line}", NO_NUMBER, UNUSUAL))
        except DataError as error:
            problems.extend(error.problems)
    return np.array(out, dtype=float).reshape(len(out), len(words))


def _constants(path: Path, block: _Block) -> dict[str, float]:
    if len(block.numbers) != 1:
        raise DataError(
            f"{path}:{block.line}: position-independent errors {' '.join(block.names)} need one row, "
            f"got {len(block.numbers)}"
        )
    return {name: float(value) for name, value in zip(block.names, block.numbers[0])}


def _table(path: Path, block: _Block) -> ErrorTable:
    k, numbers = len(block.arguments), block.numbers
    if not len(numbers):
        raise DataError(f"{path}:{block.line}: the table {' '.join(block.names)} has no rows")
    if k == 1:
        _check_increasing(path, block)
    grids = tuple(np.unique(numbers[:, i]) for i in range(k))
    shape = tuple(len(g) for g in grids)
    nodes, counts = np.unique(numbers[:, :k], axis=0, return_counts=True)
    if (counts > 1).any():
        twice = nodes[int(np.argmax(counts > 1))]
        row = int(np.flatnonzero((numbers[:, :k] == twice).all(axis=1))[1])
        at = ", ".join(f"{a} = {v:g}" for a, v in zip(block.arguments, twice))
        raise DataError(f"{path}:{block.lines[row]}: the node {at} is given twice; remove one of the rows")
    if int(np.prod(shape)) != len(numbers):
        raise DataError(
            f"{path}:{block.line}: {len(numbers)} rows do not fill the grid of {' x '.join(str(s) for s in shape)} "
            f"nodes over {' '.join(block.arguments)}; give every combination once"
        )
    rows = numbers[np.lexsort(tuple(numbers[:, i] for i in reversed(range(k))))]
    values = {name: rows[:, k + i].reshape(shape) for i, name in enumerate(block.names[k:])}
    return ErrorTable(block.arguments, grids, values, block.line)


def _check_increasing(path: Path, block: _Block) -> None:
    q = block.numbers[:, 0]
    wrong = np.flatnonzero(np.diff(q) <= 0)
    if len(wrong):
        i = int(wrong[0]) + 1
        raise DataError(
            f"{path}:{block.lines[i]}: column {block.arguments[0]} is not increasing: {q[i]:g} after {q[i - 1]:g}; "
            "sort the rows and remove repeats"
        )
