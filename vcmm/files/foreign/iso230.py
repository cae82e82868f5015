"""Positioning runs along one axis, in the manner of ISO 230-2: targets approached from both sides, run after run.

A table has the columns target_mm (target_deg), run, direction (up/down, +/-, forward/backward) and deviation_um
(deviation_urad, deviation_arcsec) or actual_mm (actual_deg); temperatures and time_s may follow. The assignments
TGT_DATA[i]=, REF_DATA_FWD[i,j]=, REF_DATA_BWD[i,j]= of ecmc test scripts are read too.

Deviations are actual - target, in tool-relative sense. A recording holds indicated - true = -(actual - target).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import DataError, UsageError, did_you_mean
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.core.text import brief, is_usual, lines_of, read_text, to_number
from vcmm.files.columns import LABELS, conditions_of, file_columns, known_column
from vcmm.files.observations import axis_direction
from vcmm.files.sheets import Layout, Sheet, SheetColumn, read_csv
from vcmm.task.response.recording import Recording

TARGET = SheetColumn("target", units=("mm", "deg"))
OBSERVED = SheetColumn("deviation", units=("um", "mm", "urad", "arcsec"), others=(("actual", ("mm", "deg")),))
COLUMNS = (TARGET, OBSERVED, SheetColumn("run"), SheetColumn("direction"))
UP = ("up", "+", "1", "+1", "forward", "fwd", "positive", "↑")
DOWN = ("down", "-", "-1", "backward", "bwd", "negative", "↓")
_ASSIGNMENT = re.compile(
    r"(?:TEST_DATA=)?\s*(?P<name>\w+)\s*(?:\[(?P<i>[0-9]{1,9})(?:,(?P<j>[0-9]{1,9}))?\])?\s*=\s*(?P<value>.*)"
)
_SETTINGS = ("REF_PV", "TEST_PV", "TGT_SET_PV", "UNIT", "CYCLES", "POSITIONS", "DEC")


@dataclass(frozen=True, eq=False)
class PositioningRuns:
    """k approaches in the order in which they were made.

    target (k,), deviation (k,) actual - target, mm (rad for a rotary axis), tool-relative. direction (k,) +1 or -1, the
    side of approach. run (k,) labels. columns: further columns (k,). axis: its letter, "" where the file names none.
    """

    target: Array
    deviation: Array
    direction: Array
    run: np.ndarray
    columns: Mapping[str, Array] = field(default_factory=dict)
    labels: Mapping[str, np.ndarray] = field(default_factory=dict)
    axis: str = ""
    rotary: bool = False


def recording_of_runs(
    runs: PositioningRuns,
    machine: Machine,
    axis: str,
    at: Mapping[str, float],
    offset: Array,
    measuring: bool = True,
) -> Recording:
    """Runs of an axis as a recording: displacement along the axis, for a rotary axis angle about it.

    at: where the other axes stood, mm or rad.   offset (3,) mm: the reflector relative to the last tool-side axis.
    measuring: in the sense indicated - true, else actual - commanded. Raises UsageError for an axis that the machine
    lacks or that does not fit the unit of the targets.
    """
    if axis not in machine.chain.letters:
        raise UsageError(
            f"the machine {machine.chain.structure} has no axis {axis}; name the right one in [line] axis"
        )
    if runs.rotary != is_rotary(axis):
        unit = "degrees" if runs.rotary else "mm"
        raise UsageError(
            f"the targets are in {unit}, which does not fit axis {axis}; name the right one in [line] axis"
        )
    k = len(runs.target)
    position = {a: np.full(k, q) for a, q in at.items()} | {axis: runs.target}
    run = Run(position, np.tile(np.asarray(offset, dtype=float), (k, 1)))
    direction = axis_direction(machine, run, axis)
    columns = dict(runs.columns) | {f"sense_{axis}": runs.direction}
    columns |= {f"n{c}": direction[:, i] for i, c in enumerate("xyz")}
    run = Run(position, run.offset, columns, dict(runs.labels) | {"run": runs.run})
    value = -runs.deviation if measuring else runs.deviation
    kind = "angle" if is_rotary(axis) else "displacement"
    none = np.full(k, -1, dtype=np.intp)
    return Recording(
        "", kind, run, value=value, measuring=measuring, row=np.arange(k), direction=direction, other=none
    )


def read_iso230(path: str | Path) -> PositioningRuns:
    """Read a table of runs or an ecmc data file. Raises DataError with every problem, each with its line."""
    path = Path(path)
    text = read_text(path)
    return _ecmc(path, text) if re.search(r"^\s*TGT_DATA\[", text, re.MULTILINE) else _table(read_csv(path))


def _table(sheet: Sheet) -> PositioningRuns:
    problems = sheet.missing(COLUMNS)
    target, observed = (sheet.quantities_or(column, problems) for column in (TARGET, OBSERVED))
    direction = _directions(sheet, problems) if "direction" in sheet.header else np.zeros(0)
    columns, labels = _other_columns(sheet, problems)
    rotary, name = "target_deg" in sheet.header, sheet.heading(OBSERVED)
    if name and (name.endswith(("_urad", "_arcsec", "_deg"))) != rotary:
        problems.append(f"{sheet.head}: {name} does not fit the unit of the targets")
    if problems or target is None or observed is None:
        raise DataError(problems)
    deviation = observed - target if name.startswith("actual_") else observed
    run = labels.pop("run")
    return PositioningRuns(target, deviation, direction, run, columns, labels, rotary=rotary)


def _directions(sheet: Sheet, problems: list[str]) -> Array:
    out = np.zeros(sheet.count)
    for j, cell in enumerate(sheet.words("direction")):
        word = cell.lower()
        out[j] = 1.0 if word in UP else -1.0 if word in DOWN else 0.0
        if not out[j]:
            problems.append(f'{sheet.at(j)}: direction "{brief(cell)}" is not understood; write up or down')
    return out


def _other_columns(sheet: Sheet, problems: list[str]) -> tuple[dict[str, Array], dict[str, np.ndarray]]:
    """Return conditions and labels beside target, deviation and direction."""
    own_headings = [*TARGET.headings, *OBSERVED.headings, "direction"]
    headings = [
        c
        for c in file_columns()
        if c == "time_s" or c.startswith(("temp_", "pressure", "humidity", "dead_path"))
    ]
    return conditions_of(
        sheet,
        own_headings,
        lambda name: known_column(name, headings),
        lambda name: f" of positioning runs.{did_you_mean(name, [*own_headings, *headings, *LABELS])}",
        problems,
    )


def _ecmc(path: Path, text: str) -> PositioningRuns:
    """Read assignments of an ecmc ISO 230-2 script: per cycle the targets forward, then back."""
    targets: dict[int, float] = {}
    actual: dict[tuple[int, int, int], float] = {}
    problems: list[str] = []
    lines = lines_of(text)
    for row in Layout(remark="#").rows(lines):
        match, at = _ASSIGNMENT.match(row.text), f"{path}:{row.line}"
        if match and match["value"]:
            _assign(match, at, targets, actual, problems)
        elif row.text.removeprefix("TEST_DATA="):
            problems.append(f"{at}: not understood: {brief(lines[row.line - 1].strip())}")
    if problems:
        raise DataError(problems)
    return _cycles(path, targets, actual)


def _assign(
    match: re.Match[str],
    at: str,
    targets: dict[int, float],
    actual: dict[tuple[int, int, int], float],
    problems: list[str],
) -> None:
    name, value = match["name"], match["value"].strip()
    if name in _SETTINGS:
        if name == "UNIT" and value != "mm":
            problems.append(f'{at}: UNIT = "{value}" is not known; only mm is')
        return
    try:
        read = to_number(value)
    except ValueError:
        read = np.nan
    if not is_usual(read):
        problems.append(f'{at}: "{brief(value)}" is no finite number')
    elif name == "TGT_DATA" and match["i"]:
        targets[int(match["i"])] = read
    elif name in ("REF_DATA_FWD", "REF_DATA_BWD") and match["j"]:
        actual[int(match["j"]), 0 if name.endswith("FWD") else 1, int(match["i"])] = read
    else:
        problems.append(f"{at}: not understood: {brief(match.group())}")


def _cycles(
    path: Path, targets: dict[int, float], actual: dict[tuple[int, int, int], float]
) -> PositioningRuns:
    unknown = sorted({i for _, _, i in actual} - set(targets))
    if unknown or not actual:
        what = f"TGT_DATA[{unknown[0]}] is missing" if unknown else "there is no REF_DATA_FWD or REF_DATA_BWD"
        raise DataError(f"{path}:1: {what}")
    ordered = sorted(actual, key=lambda key: (key[0], key[1], targets[key[2]] * (-1.0 if key[1] else 1.0)))
    target = np.array([targets[i] for _, _, i in ordered])
    side = np.array([-1.0 if back else 1.0 for _, back, _ in ordered])
    cycle = np.array([str(j) for j, _, _ in ordered], dtype=np.str_)
    return PositioningRuns(target, np.array([actual[key] for key in ordered]) - target, side, cycle)
