"""Etalon Exchange Format ("Vendor" variant): one section per error, mm and rad; position errors as VALUE.

[C0Y]
VALUE = 0.0000048
[EXX]
Gridpoints = {
0.0 0.0
100.0 0.0012
} // end of EXX
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from vcmm.core.error_names import canonical
from vcmm.core.errors import DataError, UsageError
from vcmm.core.text import brief, is_usual, lines_of, read_text, to_number
from vcmm.files.foreign.isg import ErrorFile, ErrorTable


def is_etalon(text: str) -> bool:
    """Whether the first line that is no comment opens a section such as [EXX]."""
    lines = (line.split("//")[0].strip() for line in lines_of(text))
    return next((line for line in lines if line), "").startswith("[")


def read_etalon(path: str | Path) -> ErrorFile:
    """Read a file. Raises DataError with file and line: unknown names, ragged rows, not monotonic, not finite."""
    path = Path(path)
    tables: list[ErrorTable] = []
    constants: dict[str, float] = {}
    name, header, rows, inside = "", 0, list[tuple[float, float]](), False
    for number, raw in enumerate(lines_of(read_text(path)), 1):
        line, here = raw.split("//")[0].strip(), f"{path}:{number}"
        if section := re.fullmatch(r"\[(\w+)\]", line):
            name, header = _canonical_name(section[1], here), number
        elif value := re.fullmatch(r"VALUE\s*=\s*(\S+)", line, re.IGNORECASE):
            constants[name] = _number(value[1], here)
        elif re.fullmatch(r"Gridpoints\s*=\s*\{", line, re.IGNORECASE):
            rows, inside = [], True
        elif line == "}" and inside:
            tables.append(_table(name, rows, f"{path}:{header}", header))
            inside = False
        elif inside and len(line.split()) == 2:
            rows.append((_number(line.split()[0], here), _number(line.split()[1], here)))
        elif line:
            raise DataError(
                f'{here}: "{brief(line)}" is not understood; allowed are [EXX], VALUE = number, Gridpoints = {{, "x value" rows, }}'
            )
    if inside:
        raise DataError(f"{path}:{header}: Gridpoints of {name} has no closing }}")
    return ErrorFile(tuple(tables), constants)


def _canonical_name(name: str, here: str) -> str:
    try:
        return canonical(name)
    except UsageError as error:
        raise DataError(f"{here}: {error}") from None


def _number(text: str, here: str) -> float:
    try:
        value = to_number(text)
    except ValueError:
        raise DataError(
            f'{here}: "{brief(text)}" is not a number; decimals are written with a point'
        ) from None
    if not is_usual(value):
        raise DataError(
            f"{here}: {brief(text)} is not finite or far too large; remove the row or measure it again"
        )
    return value


def _table(name: str, rows: list[tuple[float, float]], here: str, line: int) -> ErrorTable:
    if name[1:2] == "0" or not rows:
        raise DataError(f"{here}: Gridpoints need a component error such as [EXX] and at least one row")
    numbers = np.array(rows)
    if not (np.diff(numbers[:, 0]) > 0).all():
        raise DataError(
            f"{here}: the positions of {name} are not increasing; sort the rows and remove repeats"
        )
    return ErrorTable((name[2],), (numbers[:, 0],), {name: numbers[:, 1]}, line)
