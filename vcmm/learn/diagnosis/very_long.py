"""Recordings of millions of rows: the diagnosis takes MOST of their observations, with a note.

The information of a diagnosis grows with the root of the rows, its cost with the rows. So of more than MOST observations some are
taken before anything else: one at random of each stretch of successive rows, by the rule of vcmm.learn.diagnosis.thinning (every label and
sense by itself, rows near a reversal and rare labels in full), by the clock and not by the file. All that follows, held-out rows,
intervals and rms too, is computed from the taken rows: rows that were not taken are not fitted, and errors in them do no harm.
Every row keeps the data of the whole recording about its past (senses, distances, temperatures at its time). Logs of temperatures of
more than ENTRIES are means of ENTRIES stretches: at a day of 10^7 rows one every 4 s, where the quickest lag looked for is a minute.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.run import Series
from vcmm.learn.diagnosis.row_order import rows_in_order
from vcmm.learn.diagnosis.thinning import Mask, choose_rows, loss, of_rows
from vcmm.task.response.recording import Recording

MOST = 100_000  # observations of a diagnosis
ENTRIES = 20_000  # of a log


def few_enough(recording: Recording, most: int = MOST) -> Recording:
    """Return the recording with about `most` of its observations, or as it is where it has no more."""
    if recording.m <= most:
        return recording
    run = recording.run
    kept = _choose_rows(recording, most / recording.m)
    if recording.kind == "displacement":  # lengths are counted from the first row of a set-up
        kept[np.unique(run.copies("setup")[1], return_index=True)[1]] = True
    some = of_rows(recording, kept)
    series = {
        name: log if name.startswith("accel_") else average_log(log) for name, log in run.series.items()
    }
    return replace(
        some, run=replace(some.run, series=series), chosen_from=recording.chosen_from or recording.m
    )


def few_together(recordings: Sequence[Recording], most: int = MOST) -> Sequence[Recording]:
    """Return the recordings that together have about `most` observations, each the same share of its own."""
    whole = sum(r.m for r in recordings)
    if whole <= most:
        return recordings
    return [few_enough(r, max(most * r.m // whole, 1)) for r in recordings]


def _choose_rows(recording: Recording, share: float) -> Mask:
    """Return which run rows (n,) are taken: about that share of those that were observed, evenly in time."""
    run = recording.run
    observed = np.zeros(run.n, dtype=bool)
    observed[recording.row] = True
    rows = rows_in_order(run, recording)
    rows = rows[observed[rows]]
    as_it_is = np.array_equal(rows, np.arange(run.n))
    out = np.zeros(run.n, dtype=bool)
    out[rows[choose_rows(run if as_it_is else run.take(rows), share)]] = True
    return out


def average_log(log: Series, entries: int = ENTRIES) -> Series:
    """Return the log, or means of time and value over `entries` stretches of it: linear courses stay as they are."""
    n = len(log.time)
    if n <= entries:
        return log
    first = np.linspace(0, n, entries + 1).astype(np.intp)
    count = np.diff(first)
    return Series(*(np.add.reduceat(v, first[:-1]) / count for v in (log.time, log.value)))


def thinning_notes(recording: Recording) -> tuple[str, ...]:
    """Return a note on the rows taken and the loss, in words; nothing where all rows are there."""
    of = recording.chosen_from
    if not of:
        return ()
    time = recording.run.columns.get("time_s")
    apart = ""
    if time is not None and np.ptp(time) > 0:
        apart = f", on average {np.ptp(time) / max(recording.run.n - 1, 1):.3g} s apart"
    return (
        f'of {of} observations {recording.m} were taken, evenly over the rows{apart}; "all rows" are these. Intervals are up to'
        f" {loss(recording.m, of):.1f} times as wide as with all; what is shorter than the rows taken lie apart is not followed:"
        " for that, diagnose a shorter stretch of the recording",
    )
