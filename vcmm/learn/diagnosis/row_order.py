"""One order of the rows, independent of the order of the file: by time, else by the contents of the rows.

A diagnosis draws simulated recordings row by row and compares neighbours; with an order of its own its answer does not depend on
how a table was sorted. Neighbours in time are known only where a column holds the time: rows of a table
sorted by place are no series.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run, encode_labels
from vcmm.task.response.observe import Observer
from vcmm.task.response.recording import Ints, Recording


def sort_rows(recording: Recording, machine: Machine) -> Recording:
    """Return the same recording, rows by time (else by position, columns and labels), the observations of a row by direction."""
    recording = replace(recording, run=_run_with_counts(recording, machine))
    run = recording.run
    rows, row, other, first = _order(recording)
    moved = replace(recording, row=row, other=other).take(first)
    lines = None if recording.lines is None else recording.lines[rows]
    return replace(moved, run=run.take(rows), lines=lines)


def in_file_order(recording: Recording, machine: Machine, values: Array) -> Array:
    """Return the values (m,) of `in_order(recording, machine)`, such as residuals, in the order of the recording itself."""
    out = np.empty_like(values)
    out[_order(replace(recording, run=_run_with_counts(recording, machine)))[3]] = values
    return out


def _order(recording: Recording) -> tuple[Ints, Ints, Ints, Ints]:
    """Return the run rows in their order, row and other of every observation among these, and the observations in their order."""
    rows = rows_in_order(recording.run, recording)
    place = np.empty(recording.run.n, dtype=np.intp)
    place[rows] = np.arange(recording.run.n)
    row, other = place[recording.row], np.where(recording.other >= 0, place[recording.other], -1)
    first = _lexical([row.astype(float), other.astype(float), *recording.direction.T, recording.value])
    return rows, row, other, first


def _run_with_counts(recording: Recording, machine: Machine) -> Run:
    """Return the run with the lengths that an instrument counted from the first row of the file."""
    if recording.kind != "displacement":
        return recording.run
    run = Observer(recording, machine).run
    return recording.run.with_columns({c: v for c, v in run.columns.items() if c.startswith("counted_")})


def rows_in_order(run: Run, recording: Recording) -> Ints:
    """Return the run rows in their order; rows that agree in everything are sorted by their observations."""
    if "time_s" in run.columns and bool((np.diff(run.columns["time_s"]) > 0).all()):
        return np.arange(run.n)
    position = [run.position[a] for a in sorted(run.position)]
    columns = [run.columns[c] for c in sorted(run.columns) if not c.startswith("counted_")]
    labels = [encode_labels(run.labels[k])[1].astype(float) for k in sorted(run.labels)]
    sums = np.zeros(run.n)
    np.add.at(sums, recording.row, recording.value)
    time = [run.columns["time_s"]] if "time_s" in run.columns else []
    return _lexical([*time, *position, *run.offset.T, *columns, *labels, sums])


def _lexical(keys: Sequence[Array]) -> Ints:
    """Return the order by the first key, then the second ..."""
    return np.lexsort(list(reversed(keys))).astype(np.intp)
