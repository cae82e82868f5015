"""Thermal logs of Klipper: an axis homed onto a switch repeatedly while bed and frame warm.

Lines of metadata begin with #; then a table with `time` (2021/06/13-05:42:16, or seconds), `mcu_pos_z` (steps of the motor at the
switch) and temperatures `frame_t`, `bed_t` ... in degC. Set values (`bed_target`) are left out, and so is `sample`. The length of
a step is in the file (# step_dist=0.0025) or in `[counter] step = "0.0025 mm"`, which counts where both are there: published
heads are wrong at times. The switch does not move: the position at which the axis finds it is the indication.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError, UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.core.text import read_text
from vcmm.files.observations import axis_direction
from vcmm.files.sheets import Sheet, read_csv
from vcmm.task.response.recording import Recording

CLOCKS = ("%Y/%m/%d-%H:%M:%S", "%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M:%S")
NOT_READ = re.compile(r"sample|.*_target")
FAILED_MOVE_MM = 1.0  # mm from the middle: no homing, but a move that failed


@dataclass(frozen=True, eq=False)
class Homings:
    """n homings: time (n,) s from the first; height (n,) mm from their median; temperatures; line of each in the file."""

    time: Array
    height: Array
    temperatures: Mapping[str, Array]
    axis: str
    lines: Array


def read_klipper(path: str | Path, step: float | None = None) -> Homings:
    """Read a log. step: mm per step of the motor. Raises DataError with column, line and fix."""
    path = Path(path)
    stated = re.search(r"^#\s*step_dist\s*=\s*([\d.eE+-]+)", read_text(path), re.MULTILINE)
    if step is None and stated is None:
        raise DataError(
            f'{path}:1: the length of a step is not stated; add [counter] with step = "0.0025 mm"'
        )
    length = step if step is not None else float(stated[1])  # type: ignore[index]
    sheet = read_csv(path)
    at = sheet.head
    counters = [c for c in sheet.header if re.fullmatch(r"mcu_pos_[xyz]", c)]
    if len(counters) != 1 or "time" not in sheet.header:
        raise DataError(
            f"{at}: expected time and one of mcu_pos_x, mcu_pos_y, mcu_pos_z; the columns are {', '.join(sheet.header)}"
        )
    sensors = [c for c in sheet.header if c.endswith("_t")]
    ignored = [c for c in sheet.header if NOT_READ.fullmatch(c)]
    problems = sheet.unknown(
        [*counters, "time", *sensors, *ignored],
        lambda name: " of a thermal log; temperatures end in _t, as in frame_t",
    )
    if problems:
        raise DataError(problems)
    height = sheet.numbers(counters[0]) * length
    height = height - float(np.median(height))
    kept = np.abs(height) < FAILED_MOVE_MM
    time = _seconds(sheet)
    temperatures = {f"temp_{c.removesuffix('_t')}_C": sheet.numbers(c)[kept] for c in sensors}
    return Homings(
        time[kept], height[kept], temperatures, counters[0][-1].upper(), np.array(sheet.lines)[kept]
    )


def _seconds(sheet: Sheet) -> Array:
    """Return the column time in s from the first row."""
    cells = sheet.words("time")
    clock = next((c for c in CLOCKS if _reads(cells[0], c)), None)
    if clock is None:
        time = sheet.numbers("time")
        return time - time[0]
    wrong = [i for i, cell in enumerate(cells) if not _reads(cell, clock)]
    if wrong:
        raise DataError(f'{sheet.at(wrong[0])}: "{cells[wrong[0]]}" is no time like "{cells[0]}"')
    times = [datetime.strptime(cell, clock) for cell in cells]
    return np.array([(t - times[0]).total_seconds() for t in times])


def _reads(cell: str, clock: str) -> bool:
    try:
        datetime.strptime(cell, clock)
    except ValueError:
        return False
    return True


def recording_of_homings(
    homings: Homings, machine: Machine, at: Mapping[str, float], offset: Array
) -> Recording:
    """Return homings as displacements along their axis, indicated - true; the axis is at `at`, or at zero."""
    if homings.axis not in machine.chain.letters:
        raise UsageError(
            f"the machine {machine.chain.structure} has no axis {homings.axis}; correct it, or the log"
        )
    n = len(homings.time)
    position = {a: np.full(n, at.get(a, 0.0)) for a in machine.chain.letters}
    run = Run(position, np.tile(np.asarray(offset, dtype=float), (n, 1)))
    direction = axis_direction(machine, run, homings.axis)
    columns = {"time_s": homings.time, **homings.temperatures} | {
        f"n{c}": direction[:, i] for i, c in enumerate("xyz")
    }
    return Recording(
        "",
        "displacement",
        run.with_columns(columns),
        value=homings.height,
        measuring=True,
        row=np.arange(n),
        direction=direction,
        other=np.full(n, -1, dtype=np.intp),
        lines=homings.lines.astype(np.intp),
    )
