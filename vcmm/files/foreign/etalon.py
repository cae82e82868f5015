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
from itertools import islice
from pathlib import Path

import numpy as np

from vcmm.core.error_names import canonical
from vcmm.core.errors import DataError, UsageError
from vcmm.core.text import brief, lines_of, read_text
from vcmm.files.foreign.isg import ErrorFile, ErrorTable
from vcmm.files.sheets import Layout, numbers_of

LAYOUT = Layout(remark="//")


def is_etalon(text: str) -> bool:
    """Return whether the first line that is no comment opens a section such as [EXX]."""
    return any(row.text.startswith("[") for row in islice(LAYOUT.rows(lines_of(text)), 1))


def read_etalon(path: str | Path) -> ErrorFile:
    """Read a file. Raises DataError with file and line: unknown names, ragged rows, not monotonic, not finite."""
    path = Path(path)
    tables: list[ErrorTable] = []
    constants: dict[str, float] = {}
    name, header, rows, inside = "", 0, list[tuple[float, ...]](), False
    for row in LAYOUT.rows(lines_of(read_text(path))):
        line, here = row.text, f"{path}:{row.line}"
        if section := re.fullmatch(r"\[(\w+)\]", line):
            name, header = _canonical_name(section[1], here), row.line
        elif value := re.fullmatch(r"VALUE\s*=\s*(\S+)", line, re.IGNORECASE):
            (constants[name],) = numbers_of([value[1]], here)
        elif re.fullmatch(r"Gridpoints\s*=\s*\{", line, re.IGNORECASE):
            rows, inside = [], True
        elif line == "}" and inside:
            tables.append(_table(name, rows, f"{path}:{header}", header))
            inside = False
        elif inside and len(row.cells) == 2:
            rows.append(tuple(number for cell in row.cells for number in numbers_of([cell], here)))
        else:
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


def _table(name: str, rows: list[tuple[float, ...]], here: str, line: int) -> ErrorTable:
    if name[1:2] == "0" or not rows:
        raise DataError(f"{here}: Gridpoints need a component error such as [EXX] and at least one row")
    numbers = np.array(rows)
    if not (np.diff(numbers[:, 0]) > 0).all():
        raise DataError(
            f"{here}: the positions of {name} are not increasing; sort the rows and remove repeats"
        )
    return ErrorTable((name[2],), (numbers[:, 0],), {name: numbers[:, 1]}, line)
