"""Mistakes of the log with one number: a clock of the logs that is late or early, or runs too fast or too slowly.

    clock_offset    T(t) was logged at t + s              clock_drift    T(t) was logged at t + s (t - t1) / (t2 - t1)

t1 and t2 are the first and the last row, s seconds, positive where the log is late. Trial values lie evenly within half of the duration to either
side; the best one is searched between its neighbours, and each pays its share of the trials. Only logs with a clock of their own are asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array, Run, Series
from vcmm.learn.diagnosis.scans import MOST_STEPS
from vcmm.task.response.logs import sensor_of

OFFSET, DRIFT = "clock_offset", "clock_drift"


@dataclass(frozen=True)
class ClockMistake:
    """what, and how the run would read with a log that is s seconds late."""

    what: str
    corrected: Callable[[float], Run]
    values: tuple[float, ...]

    def text(self, seconds: float) -> str:
        late = "late" if seconds > 0 else "early"
        at_end = " at the last row" if self.what == DRIFT else ""
        return f"the clock of the logs, {abs(seconds):.4g} s {late}{at_end}"


def clock_mistakes(run: Run) -> Iterator[ClockMistake]:
    """Offset and drift of all logs together, where there are logs with a clock of their own."""
    if "time_s" not in run.columns:
        return
    time = run.column("time_s")
    own = {n: log for n, log in run.series.items() if not _is_of_rows(log, time)}
    span = float(np.ptp(time))
    if not own or span <= 0:
        return
    trials = np.linspace(-0.5, 0.5, MOST_STEPS + 1) * span
    values = tuple(float(v) for v in trials[trials != 0.0])
    yield ClockMistake(OFFSET, lambda s: _with_clock(run, own, lambda t: t - s), values)
    yield ClockMistake(
        DRIFT, lambda s: _with_clock(run, own, lambda t: t - s * (t - time.min()) / span), values
    )


def _is_of_rows(log: Series, time: Array) -> bool:
    return bool(np.isin(log.time, time).all()) and len(log.time) >= len(np.unique(time))


def _with_clock(run: Run, own: dict[str, Series], true_time: Callable[[Array], Array]) -> Run:
    """The run with logs at their true times, and with the columns that were read from them."""
    series = {n: Series(true_time(log.time), log.value) for n, log in own.items()}
    time = run.column("time_s")
    columns = {}
    for name, values in run.columns.items():
        log = own.get(sensor_of(name))
        if log is not None and np.array_equal(values, np.interp(time, log.time, log.value)):
            columns[name] = np.interp(time, series[sensor_of(name)].time, log.value)
    return replace(run.with_columns(columns), series={**run.series, **series})
