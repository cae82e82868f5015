"""Temperatures that change while a part is cut: a log of the machine's sensors over the time of the program.

Rows of the cut have the temperatures of their time, and the log behind them for effects that lag. The zero was set at a time
of its own, before the program began or at its start.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array, Run
from vcmm.program.setup import TemperatureLog


def add_temperatures(run: Run, log: TemperatureLog | None) -> Run:
    """Return the run (its column time_s counts from the start of the program) with the logs of the sensors. ModelLimit: the log ends more
    than one of its
    intervals before the cut."""
    if log is None:
        return run
    return _at(run, log, run.column("time_s"))


def warmed_when_set(run: Run, log: TemperatureLog | None) -> Run:
    """Return rows in which zeros were set, with the temperatures of that time."""
    if log is None:
        return run
    time = np.full(run.n, log.zero_set)
    return _at(run.with_columns({"time_s": time}), log, time)


def _at(run: Run, log: TemperatureLog, time: Array) -> Run:
    columns: dict[str, Array] = {}
    for sensor, series in log.sensors.items():
        interval = float(np.diff(series.time[-2:], prepend=series.time[-1:]).max())
        if time.max(initial=-np.inf) > series.time[-1] + interval:
            raise ModelLimit(
                f"the log of temperatures ends at {series.time[-1]:.0f} s, the program runs to {time.max():.0f} s by the time law; log the whole program"
            )
        value = np.interp(time, series.time, series.value)
        columns |= {f"{kind}_{sensor}_C": value for kind in ("temp", "reading")}
    return replace(run.with_columns(columns), series={**run.series, **log.sensors})
