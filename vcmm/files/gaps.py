"""Gaps of sensors: blank cells of a temperature, logs that end before the rows do.

Between two readings a temperature is linear in time, as a log is between its entries. Rows before the first and after the last
reading have no value: they are set aside, for no effect of that sensor can say what they hold. Where that would be more than half
of the rows the column is set aside instead. Both are told.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Run, Series
from vcmm.files.columns import Sheet, is_temperature
from vcmm.files.large_tables import ColumnSheet
from vcmm.task.response.recording import Recording

Mask = npt.NDArray[np.bool_]
BLANK = ("", "nan", "na", "n/a")
HALF = 0.5  # of the rows: with more set aside a recording has lost more than a sensor


@dataclass(frozen=True, eq=False)
class Gaps:
    """aside (n,): rows without a value; notes: what was done, in words."""

    aside: Mask
    notes: tuple[str, ...] = field(default=())


def fill_gaps(sheet: Sheet) -> tuple[Sheet, Gaps]:
    """The table with blank temperatures filled in between readings, and the rows that cannot be."""
    gaps = Gaps(np.zeros(sheet.count, dtype=bool))
    if isinstance(sheet, ColumnSheet):  # its reader has refused blanks
        return sheet, gaps
    for name in [n for n in sheet.header if is_temperature(n)]:
        i = sheet.header.index(name)
        blank = np.array([row[i].strip().lower() in BLANK for row in sheet.rows])
        if blank.any() and not blank.all():
            sheet, gaps = _without_blanks(sheet, name, blank, gaps)
    return sheet, gaps


def _without_blanks(sheet: Sheet, name: str, blank: Mask, gaps: Gaps) -> tuple[Sheet, Gaps]:
    i = sheet.header.index(name)
    known = np.flatnonzero(~blank)
    value = replace(sheet, rows=[sheet.rows[k] for k in known]).numbers(name)
    outside = blank.copy()
    if "time_s" in sheet.header:
        time = sheet.numbers("time_s")
        order = np.argsort(time[known], kind="stable")
        at, read = time[known][order], value[order]
        outside = blank & ((time < at[0]) | (time > at[-1]))
        new = np.interp(time, at, read)
    else:
        new = np.full(sheet.count, float(np.median(value)))
    said = f"{name} is blank in {int(blank.sum())} of {sheet.count} rows ({_lines(sheet, blank)})"
    if outside.mean() > HALF:
        header = [n for n in sheet.header if n != name]
        rows = [row[:i] + row[i + 1 :] for row in sheet.rows]
        gone = f"{said}: the column is set aside, what depends on it is not testable"
        return replace(sheet, header=header, rows=rows), replace(gaps, notes=(*gaps.notes, gone))
    rows = [
        [*row[:i], repr(float(new[k])), *row[i + 1 :]] if blank[k] else row
        for k, row in enumerate(sheet.rows)
    ]
    told = [said]
    if (blank & ~outside).any():
        told.append(f"{int((blank & ~outside).sum())} are interpolated in time between its readings")
    if outside.any():
        told.append(f"{int(outside.sum())} have no reading on both sides and are set aside")
    return (
        replace(sheet, rows=rows),
        Gaps(gaps.aside | outside, (*gaps.notes, "; ".join(told))),
    )


def _lines(sheet: Sheet, rows: Mask) -> str:
    first, last = np.flatnonzero(rows)[[0, -1]]
    return f"lines {sheet.lines[first]} to {sheet.lines[last]}"


def reaching(run: Run, logs: Mapping[str, Series]) -> tuple[dict[str, Series], Gaps]:
    """Logs that reach all rows: of one that ends earlier the last value is held, for rows that are set aside; one that more than
    half of the rows lie beyond is set aside itself.
    """
    gaps, out = Gaps(np.zeros(run.n, dtype=bool)), dict(logs)
    if "time_s" not in run.columns:
        return out, gaps
    time = run.column("time_s")
    for name, log in logs.items():
        beyond = time > _reach(log)
        if not beyond.any():
            continue
        last, end = float(log.time[-1]), float(time.max())
        said = f"the log of {name} ends at {last:g} s, the data at {end:g} s"
        if beyond.mean() > HALF:
            del out[name]
            gone = f"{said}: the log is set aside, what depends on it is not testable"
            gaps = replace(gaps, notes=(*gaps.notes, gone))
            continue
        held = Series(np.append(log.time, end), np.append(log.value, log.value[-1]))
        out[name] = held
        told = f"{said}: {int(beyond.sum())} of {run.n} rows lie beyond it and are set aside; extend the log to use them"
        gaps = Gaps(gaps.aside | beyond, (*gaps.notes, told))
    return out, gaps


def _reach(log: Series) -> float:
    """One interval after the last entry: until then it is as good as between two."""
    last = float(log.time[-1])
    return last + (last - float(log.time[-2]) if len(log.time) > 1 else 0.0)


def set_aside(recording: Recording, gaps: Gaps) -> Recording:
    """The recording without the observations of some rows, and what is to be told."""
    if not gaps.notes:
        return recording
    notes = (*recording.notes, *gaps.notes)
    n = len(gaps.aside)  # second ends of lengths are rows behind those of the table
    touched = gaps.aside[recording.row % n]
    touched = touched | np.where(recording.other >= 0, gaps.aside[recording.other % n], False)
    return replace(recording.take(~touched), notes=notes)


def blanks_of_log(sheet: Sheet, name: str) -> Mask:
    """(n,) bool: entries of a log's column that are blank."""
    if isinstance(sheet, ColumnSheet):
        return np.zeros(sheet.count, dtype=bool)
    i = sheet.header.index(name)
    return np.array([row[i].strip().lower() in BLANK for row in sheet.rows])
