"""Gaps of sensors: blank cells of a temperature, logs that end before the rows do.

Between two readings a temperature is linear in time, as a log is between its entries. Rows before the first and after the last
reading have no value: the nearest one is held there, and `unread` of the recording names them, since no effect of that sensor can be evaluated
there (see vcmm.learn.diagnosis.sensor_gaps). Where that would be more than half of the rows the column is set aside instead. Notes
report both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Run, Series
from vcmm.files.sheets import Sheet, is_temperature
from vcmm.task.response.recording import Recording

Mask = npt.NDArray[np.bool_]
HALF = 0.5  # of the rows: with more of them a recording has lost more than a sensor


@dataclass(frozen=True, eq=False)
class Gaps:
    """Result of filling gaps. unread: column -> rows (n,) without a value; notes: the changes, in words."""

    unread: Mapping[str, Mask] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def fill_gaps(sheet: Sheet) -> tuple[Sheet, Gaps]:
    """Return the table with blank temperatures filled in between readings and held beyond, and the rows of the latter."""
    gaps = Gaps()
    for name in [n for n in sheet.header if is_temperature(n)]:
        blank = sheet.blanks(name)
        if blank.any() and not blank.all():
            sheet, gaps = _without_blanks(sheet, name, blank, gaps)
    return sheet, gaps


def _without_blanks(sheet: Sheet, name: str, blank: Mask, gaps: Gaps) -> tuple[Sheet, Gaps]:
    filled = np.flatnonzero(~blank)
    value = sheet.take(filled).numbers(name)
    outside = blank.copy()
    if "time_s" in sheet.header:
        time = sheet.numbers("time_s")
        order = np.argsort(time[filled], kind="stable")
        at, read = time[filled][order], value[order]
        outside = blank & ((time < at[0]) | (time > at[-1]))
        new = np.interp(time, at, read)
    else:
        new = np.full(sheet.count, float(np.median(value)))
    remark = f"{name} is blank in {int(blank.sum())} of {sheet.count} rows ({_lines(sheet, blank)})"
    if outside.mean() > HALF:
        gone = f"{remark}: the column is set aside, what depends on it is not testable"
        return sheet.without(name), replace(gaps, notes=(*gaps.notes, gone))
    remarks = [remark]
    if (blank & ~outside).any():
        remarks.append(f"{int((blank & ~outside).sum())} are interpolated in time between its readings")
    if outside.any():
        remarks.append(f"{int(outside.sum())} have no reading on both sides")
    return sheet.with_numbers(name, blank, new), _with(gaps, name, outside, "; ".join(remarks))


def _with(gaps: Gaps, name: str, rows: Mask, note: str) -> Gaps:
    unread = {**gaps.unread, name: rows} if rows.any() else gaps.unread
    return Gaps(unread, (*gaps.notes, note))


def _lines(sheet: Sheet, rows: Mask) -> str:
    first, last = np.flatnonzero(rows)[[0, -1]]
    return f"lines {sheet.lines[first]} to {sheet.lines[last]}"


def reaching(run: Run, logs: Mapping[str, Series]) -> tuple[dict[str, Series], Gaps]:
    """Return logs that reach all rows: of one that ends earlier the last value is held; one that more than half of the rows lie beyond is
    set aside.
    """
    gaps, out = Gaps(), dict(logs)
    if "time_s" not in run.columns:
        return out, gaps
    time = run.column("time_s")
    for name, log in logs.items():
        beyond = time > _reach(log)
        if not beyond.any():
            continue
        last, end = float(log.time[-1]), float(time.max())
        remark = f"the log of {name} ends at {last:g} s, the data at {end:g} s"
        if beyond.mean() > HALF:
            del out[name]
            gone = f"{remark}: the log is set aside, what depends on it is not testable"
            gaps = replace(gaps, notes=(*gaps.notes, gone))
            continue
        series = Series(np.append(log.time, end), np.append(log.value, log.value[-1]))
        out[name] = series
        gaps = _with(gaps, name, beyond, f"{remark}: {int(beyond.sum())} of {run.n} rows lie beyond it")
    return out, gaps


def _reach(log: Series) -> float:
    """Return the end of a log: one interval after the last entry, until which it is as good as between two."""
    last = float(log.time[-1])
    return last + (last - float(log.time[-2]) if len(log.time) > 1 else 0.0)


def note_gaps(recording: Recording, gaps: Gaps) -> Recording:
    """Return the recording with the rows that sensors did not read, and the notes."""
    if not gaps.notes:
        return recording
    n = recording.run.n  # second ends of lengths are rows behind those of the table
    unread = tuple((name, np.resize(rows, n)) for name, rows in gaps.unread.items())
    return replace(recording, notes=(*recording.notes, *gaps.notes), unread=(*recording.unread, *unread))
