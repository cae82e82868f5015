"""Logs that the rows of a recording hold by themselves: a column of a quantity that changes with time is its log.

Lags and ringing follow the past of a quantity. Where no log is given, the values of the rows in the order of time serve.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vcmm.run import Array, Run, Series

TRACE = 0.05  # s between rows, from which on a structure of 10 Hz and more is not followed


@dataclass(frozen=True, eq=False)
class RememberingRun(Run):
    """A run that works out every lagged temperature once: hundreds of candidates ask for the same ones."""

    memory: dict[tuple[int, int, float], tuple[Series, Array, Array]] = field(default_factory=dict)

    def lagged(self, sensor: str, tau: float) -> Array:
        if tau == 0.0 or sensor not in self.series or "time_s" not in self.columns:
            return super().lagged(sensor, tau)
        series, time = self.series[sensor], self.column("time_s")
        key = (id(series), id(time), tau)  # both are kept beside the result, so the ids stay theirs
        if key not in self.memory:
            self.memory[key] = (series, time, super().lagged(sensor, tau))
        return self.memory[key][2]


def with_logs(run: Run) -> Run:
    """Temperatures given row by row also serve as logs over time, so that lags can be followed; the accelerations of a
    trace likewise, so that what they leave ringing can.
    """
    if "time_s" not in run.columns:
        return run
    time, first = np.unique(run.column("time_s"), return_index=True)
    names = [c.removeprefix("temp_").removesuffix("_C") for c in run.columns if c.startswith("temp_")]
    logs = {
        n: Series(time, run.column(f"temp_{n}_C")[first])
        for n in names
        if n not in run.series and len(time) > 1
    }
    if "spindle_rpm" in run.columns and "spindle_rpm" not in run.series and len(time) > 1:
        logs["spindle_rpm"] = Series(time, run.column("spindle_rpm")[first])
    if len(time) > 1 and float(np.median(np.diff(time))) < TRACE:
        moved = [c for c in run.columns if c.startswith("accel_") and np.any(run.columns[c])]
        logs |= {c: Series(time, run.column(c)[first]) for c in moved if c not in run.series}
    return RememberingRun(run.position, run.offset, run.columns, run.labels, {**run.series, **logs})
