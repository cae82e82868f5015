"""Logs that follow from a program: speed of the spindle and acceleration of the axes over its time.

An effect that follows a log (the growth of a spindle by its speed, the ringing of an axis) finds it in a recording; a program states its
speeds, and its time law the accelerations, so a cut needs no file of them. Only the logs that an effect of the machine needs are made.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from vcmm.core.effect import Effect, required
from vcmm.core.run import Array, Run, Series
from vcmm.shop.motion.toolpath import Toolpath

SPEED = "spindle_rpm"


def with_own_logs(run: Run, path: Toolpath, effects: Iterable[Effect], parts: int = 1) -> Run:
    """Return the run (its time_s counts from the start of the first of `parts` parts in a row) with the logs that the effects need."""
    needed = {column for effect in effects for column in required(effect)}
    made = {name: _in_a_row(log, path.seconds, parts) for name in needed if (log := _log(path, name))}
    return replace(run, series={**made, **run.series}) if made else run


def _log(path: Toolpath, name: str) -> Series | None:
    values = path.columns.get(name)
    if values is None or not path.n:
        return None
    if name == SPEED:
        return _steps(path.time, np.abs(values))
    if name.startswith("accel_"):
        return Series(path.time, values)
    return None


def _steps(time: Array, value: Array) -> Series:
    """Return values that hold from the row before to each row, as a log: two entries where the value changes."""
    change = np.flatnonzero(np.diff(value[1:])) + 1  # the last row of a level, where another one follows
    at = np.concatenate([time[:1], np.repeat(time[change], 2), time[-1:]])
    level = value[np.concatenate([change, [len(value) - 1]])]
    return Series(at, np.repeat(level, 2))


def _in_a_row(log: Series, seconds: float, parts: int) -> Series:
    """Return the log of several parts, one after another without a pause."""
    begin = np.repeat(np.arange(parts) * seconds, len(log.time))
    return Series(begin + np.tile(log.time, parts), np.tile(log.value, parts))
