"""Logs with their own clock ([[series]]: time_s, temp_<name>_C ...), joined to the rows of a run by time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError, UsageError, did_you_mean
from vcmm.core.run import Array, Run, Series
from vcmm.files.columns import run_columns
from vcmm.files.large_tables import read_table
from vcmm.files.sheets import Sheet
from vcmm.task.response.logs import sensor_of
from vcmm.task.response.recording import Ints

LOG_COLUMNS = (
    "pressure_hPa",
    "humidity_pct",
    "spindle_rpm",
    "spindle_load_W",
    "load_kg",
)  # besides temp_<name>_C


def read_logs(paths: Sequence[Path]) -> dict[str, Series]:
    """Read all log files: column name -> Series. Raises DataError with every problem of every file."""
    out: dict[str, Series] = {}
    problems: list[str] = []
    for path in paths:
        try:
            series = _read_log(path)
        except DataError as error:
            problems.extend(error.problems)
            continue
        problems += [
            f"{path}:1: {name} is logged in another file already; keep one" for name in series if name in out
        ]
        out |= series
    if problems:
        raise DataError(problems)
    return out


def _read_log(path: Path) -> dict[str, Series]:
    sheet = read_table(path)
    columns = ["time_s", *LOG_COLUMNS, *(c for c in run_columns() if c.startswith("temp_"))]
    problems = [] if "time_s" in sheet.header else [f"{sheet.head}: a log needs the column time_s"]
    numbers: dict[str, Array] = {}
    rows: dict[str, Ints] = {}
    for name in sheet.header:
        if name not in columns and not (name.startswith("temp_") and name.endswith("_C")):
            problems.append(f'{sheet.head}: unknown column "{name}" of a log.{did_you_mean(name, columns)} Allowed: time_s, temp_<name>_C, {", ".join(LOG_COLUMNS)}')  # fmt: skip
            continue
        try:
            numbers[name], rows[name] = _entries(sheet, name)
        except DataError as error:
            problems.extend(error.problems)
    back = np.flatnonzero(np.diff(numbers.get("time_s", np.zeros(1))) < 0)
    if len(back):
        problems.append(f"{sheet.at(int(back[0]) + 1)}: time_s goes back; sort the rows of the log by time")
    if problems:
        raise DataError(problems)
    time = numbers.pop("time_s")
    return {name: Series(time[rows[name]], values) for name, values in numbers.items()}


def _entries(sheet: Sheet, name: str) -> tuple[Array, Ints]:
    """Return entries of one column, and their rows: a sensor that was not read has no entry there, as one with a slower clock."""
    blank = sheet.blanks(name)
    if name == "time_s" or blank.all():
        blank = np.zeros(sheet.count, dtype=bool)  # the reader says what is wrong
    if not blank.any():
        return sheet.numbers(name), np.arange(sheet.count)
    kept = np.flatnonzero(~blank)
    return sheet.take(kept).numbers(name), kept


def add_logs(run: Run, logs: dict[str, Series]) -> Run:
    """Return the run with its logs, and with each log at time_s as a column where the data have none of that name.

    Between entries a log is linear, before the first it is steady. Raises UsageError where the data have no time_s. How far
    logs reach is not checked here (see vcmm.files.gaps).
    """
    if not logs:
        return run
    if "time_s" not in run.columns:
        raise UsageError(
            "logs are joined by time, but the data have no column time_s; add it or remove [[series]]"
        )
    time = run.column("time_s")
    new = {n: np.interp(time, log.time, log.value) for n, log in logs.items() if n not in run.columns}
    series = {**run.series, **{sensor_of(n): log for n, log in logs.items()}}
    return replace(run.with_columns(new), series=series)


def with_readings(run: Run) -> Run:
    """Return the run with the readings of the sensors of scales and part as separate columns: the recorded temperatures.

    The control corrects with these readings, while an Input on temp_scale_x_C moves the true temperature; so a
    correction with the right coefficient still leaves the error of its sensor.
    """
    corrected = [n for n in run.columns if n == "temp_part_C" or n.startswith("temp_scale_")]
    new = {f"reading_{n.removeprefix('temp_')}": run.columns[n] for n in corrected}
    return run.with_columns({n: values for n, values in new.items() if n not in run.columns})
