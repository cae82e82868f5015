"""Known uncertainty of a recording, as a table: one column per independent draw, one row per observation.

The heading is the id of the Input, "#" and a number where it has several draws, and the unit: "tool_radius[1].dr_um",
"scatter.value#2_um" (of recordings of angles _urad). A number is the change of the observation by one standard deviation of the draw.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import csv_of
from vcmm.files.sheets import read_csv
from vcmm.task.response.recording import Recording

InputColumns = tuple[tuple[str, Array], ...]


def read_known(path: Path, recording: Recording) -> InputColumns:
    """Read the table of a recording. DataError: headings without unit, cells that are no numbers, another number of rows."""
    sheet, unit, scale = read_csv(path), *_unit(recording)
    if len(sheet.rows) != recording.m:
        raise DataError(
            f"{path}: {len(sheet.rows)} rows, but the recording has {recording.m} observations; write one row for each, in the same order"
        )
    out: dict[str, list[Array]] = {}
    for heading in sheet.header:
        if not heading.endswith(unit):
            raise DataError(
                f'{path}:{sheet.header_line}: column "{heading}" states no unit; its name ends in {unit}'
            )
        out.setdefault(heading.removesuffix(unit).split("#")[0], []).append(sheet.numbers(heading) / scale)
    return tuple((name, np.stack(columns, axis=1)) for name, columns in out.items())


def known_text(recording: Recording) -> str:
    """Return the table as CSV."""
    unit, scale = _unit(recording)
    names: list[str] = []
    columns: list[Array] = []
    for name, values in recording.known:
        names += _headings(name, values.shape[1], unit)
        columns.append(values * scale)
    return csv_of([names, *np.concatenate(columns, axis=1).tolist()])


def _headings(name: str, count: int, unit: str) -> Sequence[str]:
    return [name + unit] if count == 1 else [f"{name}#{k + 1}{unit}" for k in range(count)]


def _unit(recording: Recording) -> tuple[str, float]:
    """Return the ending of the headings, and the factor from mm or rad."""
    return ("_urad", 1e6) if recording.kind == "angle" else ("_um", 1e3)
