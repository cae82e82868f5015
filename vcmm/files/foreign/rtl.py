"""Renishaw laser files (.rtl), linear positioning, as several open readers and writers agree on their structure.

    HEADER:: File Type: linear    TARGET DATA:: Targets : (mm), Flags:    USER-TEXT:: Axis: X ...
    RUNS:: Run-count: 4           DEVIATIONS:: rows "run target deviation" (um)          ENVIRONMENT:: ...   EOF::

Not checked against a file of the maker. Deviations are read as laser - target, after the laser's own compensation of
air and material. Angular files are refused: the unit of their deviations is not known for certain.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import brief, lines_of, read_text
from vcmm.files.foreign.iso230 import PositioningRuns
from vcmm.files.sheets import Layout, Row, numbers_of

SECTIONS = ("HEADER", "TARGET DATA", "USER-TEXT", "RUNS", "DEVIATIONS", "EQUIPMENT", "ENVIRONMENT", "EOF")
CONDITIONS = {"air temp": "temp_air_C", "air press": "pressure_hPa", "air humid": "humidity_pct"}
_COUNT = re.compile(r"[0-9]{1,9}")
_MATERIAL = re.compile(r"mat temp (\d)")
NO_NUMBER = '"{}" holds no finite numbers; decimals take a point'
Lines = list[Row]


def read_rtl(path: str | Path) -> PositioningRuns:
    """Read a linear .rtl file. Raises DataError with every problem, each with its line.

    Air and material readings become the constant columns temp_air_C, pressure_hPa, humidity_pct, temp_material_C.
    """
    path = Path(path)
    sections = _sections(path, read_text(path))
    _check_type(path, sections)
    targets = _targets(path, sections["TARGET DATA"])
    run, index, deviation = _deviations(path, sections, len(targets))
    target = targets[index]
    columns = _environment(path, sections.get("ENVIRONMENT", []), len(target))
    labels = np.array([str(r) for r in run], dtype=np.str_)
    axis = _value(sections.get("USER-TEXT", []), "axis")
    letter = axis.upper() if axis.upper() in tuple("XYZ") else ""
    return PositioningRuns(
        target=target,
        deviation=deviation * 1e-3,
        direction=_directions(run, target),
        run=labels,
        columns=columns,
        labels={},
        axis=letter,
    )


def _sections(path: Path, text: str) -> dict[str, Lines]:
    out: dict[str, Lines] = {}
    name, problems = "", []
    for row in Layout().rows(lines_of(text)):
        at, line = row.line, row.text
        if line.endswith("::"):
            name = line[:-2].strip().upper()
            if name not in SECTIONS or name in out:
                what = "twice" if name in out else f"not known; known are {', '.join(SECTIONS)}"
                problems.append(f'{path}:{at}: the section "{brief(name)}" is {what}')
            out.setdefault(name, [])
        elif not name:
            problems.append(f"{path}:{at}: a .rtl file begins with HEADER::")
            break
        else:
            out[name].append(row)
    missing = [s for s in ("TARGET DATA", "DEVIATIONS") if s not in out]
    problems += [f"{path}:1: the section {s}:: is missing" for s in missing if name]
    if problems or missing:
        raise DataError(problems or f"{path}:1: the file is empty")
    return out


def _value(lines: Lines, key: str) -> str:
    """Return the text after 'key :' ('' where it is missing)."""
    for row in lines:
        word, colon, value = row.text.partition(":")
        if colon and word.strip().lower() == key:
            return value.strip()
    return ""


def _check_type(path: Path, sections: dict[str, Lines]) -> None:
    kind = _value(sections.get("HEADER", []), "file type").lower()
    if kind != "linear":
        raise DataError(
            f'{path}:1: File Type "{kind or "none"}" cannot be read, only linear; export a table instead'
        )


def _targets(path: Path, lines: Lines) -> Array:
    """Return the wrapped list of targets (k,) mm."""
    numbers: list[float] = []
    count, reading, at = 0, False, lines[0].line if lines else 1
    for row in lines:
        number, line = row.line, row.text
        word, colon, rest = line.partition(":")
        key = word.strip().lower()
        if colon:
            reading = key == "targets"
            count = _whole(path, number, rest) if key == "target-count" else count
            at, line = (number, rest) if reading else (at, "")
        elif not reading:
            raise DataError(f"{path}:{number}: not understood: {brief(line)}")
        numbers += _numbers(path, number, line.split() if colon else row.cells)
    if not numbers or (count and len(numbers) != count):
        raise DataError(f"{path}:{at}: {len(numbers)} targets, where Target-count says {count}")
    return np.array(numbers)


def _deviations(path: Path, sections: dict[str, Lines], k: int) -> tuple[Array, Array, Array]:
    """run (n,), target index (n,) from 0, deviation (n,) um."""
    rows, problems = [], []
    for row in sections["DEVIATIONS"]:
        number, line, cells = row.line, row.text, row.cells
        if line.lower().startswith("run target"):
            continue
        if len(cells) != 3 or not (_COUNT.fullmatch(cells[0]) and _COUNT.fullmatch(cells[1])):
            problems.append(f'{path}:{number}: "{brief(line)}" is not a row of run, target, deviation')
            continue
        if not 1 <= int(cells[1]) <= k:
            problems.append(f"{path}:{number}: target {cells[1]} does not exist; there are {k}")
            continue
        rows.append((int(cells[0]), int(cells[1]) - 1, *_numbers(path, number, cells[2:])))
    stated = _value(sections.get("RUNS", []), "run-count")
    runs = len({r for r, _, _ in rows})
    if not problems and (not rows or (stated and stated != str(runs))):
        problems.append(
            f"{path}:{sections['DEVIATIONS'][0].line if rows else 1}: {runs} runs, where Run-count says {stated or 'none'}"
        )
    if problems:
        raise DataError(problems)
    table = np.array(rows)
    return table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2]


def _directions(run: Array, target: Array) -> Array:
    """Return +1 or -1 per row: the direction of the targets of its run; runs of one target go up and down in turn."""
    out = np.ones(len(run))
    for value in np.unique(run):
        rows = np.flatnonzero(run == value)
        way = target[rows[-1]] - target[rows[0]]
        out[rows] = np.sign(way) if way else (1.0 if value % 2 else -1.0)
    return out


def _environment(path: Path, lines: Lines, n: int) -> dict[str, Array]:
    out: dict[str, list[float]] = {}
    for row in lines:
        word, _, value = row.text.partition(":")
        key = word.strip().lower()
        name = "temp_material_C" if _MATERIAL.fullmatch(key) else CONDITIONS.get(key, "")
        if name:
            out.setdefault(name, []).extend(_numbers(path, row.line, value.split()[:1]))
    return {name: np.full(n, np.mean(values)) for name, values in out.items() if values}


def _numbers(path: Path, line: int, cells: list[str]) -> list[float]:
    return numbers_of(cells, f"{path}:{line}", NO_NUMBER, NO_NUMBER)


def _whole(path: Path, line: int, text: str) -> int:
    if not _COUNT.fullmatch(text.strip()):
        raise DataError(f'{path}:{line}: "{brief(text.strip())}" is not a whole number')
    return int(text)
