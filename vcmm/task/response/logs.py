"""Build logs from the rows of a recording: a column of a quantity that changes with time is its log.

Lags and ringing follow the past of a quantity. Where no log is given, the values of the rows in the order of time serve.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vcmm.core.run import Array, Run, Series

TRACE = 0.05  # s between rows, from which on a structure of 10 Hz and more is not followed


@dataclass(frozen=True, eq=False)
class RememberingRun(Run):
    """A run that caches every lagged temperature: hundreds of candidates need the same ones."""

    memory: dict[tuple[int, int, float], tuple[Series, Array, Array]] = field(default_factory=dict)

    def lag(self, sensor: str, tau: float) -> Array:
        if tau == 0.0 or sensor not in self.series or "time_s" not in self.columns:
            return super().lag(sensor, tau)
        series, time = self.series[sensor], self.column("time_s")
        key = (id(series), id(time), tau)  # both are kept beside the result, so the ids stay theirs
        if key not in self.memory:
            self.memory[key] = (series, time, super().lag(sensor, tau))
        return self.memory[key][2]


def with_logs(run: Run) -> Run:
    """Return the run with the logs of its rows where no other log is known: temperatures, so that lags can be followed, the speed of
    the spindle, and the accelerations of a trace, so that the vibration after them can.

    Rows that share a time are averaged. A clock that goes back defines no past: then there are no logs.
    """
    further = {k: v for k, v in row_logs(run).items() if k not in run.series}
    return RememberingRun(run.position, run.offset, run.columns, run.labels, {**run.series, **further})


def row_logs(run: Run) -> dict[str, Series]:
    """Return the sensor or column -> log on the clock of the rows."""
    if "time_s" not in run.columns or np.any(np.diff(run.column("time_s")) < 0):
        return {}
    time, codes = np.unique(run.column("time_s"), return_inverse=True)
    if len(time) < 2:
        return {}
    trace = float(np.median(np.diff(time))) < TRACE
    count = np.bincount(codes)
    return {
        sensor_of(name): Series(time, np.bincount(codes, values) / count)
        for name, values in run.columns.items()
        if _is_temperature(name)
        or name in ("spindle_rpm", "spindle_load_W")
        or (trace and name.startswith("accel_") and np.any(values))
    }


def _is_temperature(name: str) -> bool:
    return name.startswith("temp_") and name.endswith("_C")


def sensor_of(column: str) -> str:
    """Return the name under which a run keeps the log: temp_air_C -> air."""
    return column.removeprefix("temp_").removesuffix("_C") if _is_temperature(column) else column
