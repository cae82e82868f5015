"""ISG volumetric CSV: tables of component errors in mm and rad, as controls read them.

A header line names columns (`X EXX EYX EZX EAX EBX ECX`), position-independent errors have no argument column
(`A0Z B0Z C0Y`), `#` starts the next table, `//` comments; several argument columns (`Z X EXX ...`) give a grid.
Rotary arguments are in rad. Separators: blanks, commas or semicolons.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.errors import DataError
from vcmm.run import Array

COMPONENT = re.compile(r"E[XYZABC][XYZABC]$")
LOCATION = re.compile(r"E?([XYZABC])[O0]([XYZABC])$")


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


def read_isg(path: str | Path) -> ErrorFile:
    """Read a file. Raises DataError with file and line: unknown names, ragged rows, not monotonic, not finite."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror}") from None
    tables: list[ErrorTable] = []
    constants: dict[str, float] = {}
    for block in _blocks(text):
        line, names = block[0]
        arguments = _checked_header(path, line, names)
        numbers = _numbers(path, block[1:], names)
        if not arguments:
            if len(numbers) != 1:
                raise DataError(
                    f"{path}:{line}: position-independent errors {' '.join(names)} need one row, got {len(numbers)}"
                )
            constants.update({canonical(name): float(v) for name, v in zip(names, numbers[0])})
        else:
            tables.append(_table(path, line, arguments, names, numbers))
    return ErrorFile(tuple(tables), constants)


def canonical(name: str) -> str:
    """EC0Y, COY, C0Y -> C0Y; component errors unchanged."""
    match = LOCATION.match(name)
    return f"{match[1]}0{match[2]}" if match and not COMPONENT.match(name) else name


def _blocks(text: str) -> list[list[tuple[int, list[str]]]]:
    blocks: list[list[tuple[int, list[str]]]] = [[]]
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.split("//")[0].strip()
        if line.startswith("#"):
            blocks.append([])
            line = line.lstrip("#").strip()
        if line:
            blocks[-1].append((number, [w for w in re.split(r"[\s,;]+", line) if w]))
    return [block for block in blocks if block]


def _checked_header(path: Path, line: int, names: list[str]) -> tuple[str, ...]:
    arguments = tuple(n for n in names if n in tuple("XYZABC"))
    for name in names[len(arguments) :]:
        if not (COMPONENT.match(name) or LOCATION.match(name)):
            raise DataError(
                f'{path}:{line}: unknown column "{name}"; allowed are axis letters first, then component errors such as '
                "EXX EYX EAX (with an argument column) or A0Z B0Z C0Y X0C (without)"
            )
    if len(set(names)) != len(names):
        raise DataError(f"{path}:{line}: a column is named twice in {' '.join(names)}")
    return arguments


def _numbers(path: Path, rows: list[tuple[int, list[str]]], names: list[str]) -> Array:
    out = []
    for line, words in rows:
        if len(words) != len(names):
            raise DataError(
                f"{path}:{line}: {len(words)} numbers where the header names {len(names)} ({' '.join(names)})"
            )
        try:
            values = [float(w) for w in words]
        except ValueError:
            raise DataError(
                f"{path}:{line}: not a number in {' '.join(words)}; decimals are written with a point"
            ) from None
        if not np.isfinite(values).all():
            raise DataError(f"{path}:{line}: a value is not finite; remove the row or measure it again")
        out.append(values)
    return np.array(out, dtype=float).reshape(len(out), len(names))


def _table(path: Path, line: int, arguments: tuple[str, ...], names: list[str], numbers: Array) -> ErrorTable:
    if not len(numbers):
        raise DataError(f"{path}:{line}: the table {' '.join(names)} has no rows")
    k = len(arguments)
    grids = tuple(np.unique(numbers[:, i]) for i in range(k))
    shape = tuple(len(g) for g in grids)
    if k == 1 and not (np.diff(numbers[:, 0]) > 0).all():
        bad = int(np.flatnonzero(np.diff(numbers[:, 0]) <= 0)[0]) + 1
        raise DataError(
            f"{path}:{line}: column {arguments[0]} is not increasing: row {bad + 1} of the table has {numbers[bad, 0]:g} "
            f"after {numbers[bad - 1, 0]:g}; sort the rows and remove repeats"
        )
    if int(np.prod(shape)) != len(numbers):
        raise DataError(
            f"{path}:{line}: {len(numbers)} rows do not fill the grid of {' x '.join(str(s) for s in shape)} nodes "
            f"over {' '.join(arguments)}; give every combination once"
        )
    order = np.lexsort(tuple(numbers[:, i] for i in reversed(range(k))))
    sorted_rows = numbers[order]
    if any(
        not (sorted_rows[:, i].reshape(shape) == g.reshape([-1 if j == i else 1 for j in range(k)])).all()
        for i, g in enumerate(grids)
    ):
        raise DataError(
            f"{path}:{line}: a node of the grid over {' '.join(arguments)} is given twice and another is missing"
        )
    values = {name: sorted_rows[:, k + i].reshape(shape) for i, name in enumerate(names[k:])}
    return ErrorTable(arguments, grids, values, line)
