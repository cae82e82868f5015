"""Rows in which a sensor has no reading: unusable for the effects of that sensor, and used for all others.

Effects of a sensor are unknown where it was not read, so names that depend on it are tested in the rows that it read. Where none of
them is found there, and the machine holds none, these rows hold nothing of it: all rows are used again, without the sensor.
Where one is found its share of the other rows is unknown, and they are set aside. A note reports either case.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from vcmm.core.effect import Effect, required
from vcmm.task.response.logs import sensor_of
from vcmm.task.response.recording import Recording


def rows_with_all_readings(recording: Recording) -> Recording:
    """Return the observations at which every sensor has a reading."""
    if not recording.unread:
        return recording
    aside = np.any([rows for _, rows in recording.unread], axis=0)
    return replace(recording.take(~recording.touching(aside)), unread=())


def without_sensors(recording: Recording, names: Iterable[str]) -> Recording:
    """Return all observations, without some of the columns that have no reading in some rows, and without their logs."""
    gone = set(names)
    run = recording.run
    readings = {f"reading_{n.removeprefix('temp_')}" for n in gone}
    columns = {n: v for n, v in run.columns.items() if n not in gone | readings}
    series = {n: s for n, s in run.series.items() if n not in {sensor_of(g) for g in gone}}
    kept = tuple((n, rows) for n, rows in recording.unread if n not in gone)
    return replace(recording, run=replace(run, columns=columns, series=series), unread=kept)


def rows_for_effects(recording: Recording, effects: Iterable[Effect]) -> Recording:
    """Return all observations that the effects leave: rows set aside where one of them needs a sensor that was not read there, other
    sensors with gaps left out.
    """
    needed = sensors_of(recording, effects)
    return rows_with_all_readings(without_sensors(recording, {n for n, _ in recording.unread} - set(needed)))


def sensors_of(recording: Recording, effects: Iterable[Effect]) -> tuple[str, ...]:
    """Return, of the columns with rows without a reading, those that some of the effects need."""
    every = tuple(effects)
    return tuple(n for n, _ in recording.unread if any(_needs(e, n) for e in every))


def _needs(effect: Effect, column: str) -> bool:
    reading = f"reading_{column.removeprefix('temp_')}"
    return bool({column, reading} & set(required(effect))) or (
        str(getattr(effect, "sensor", "")) == sensor_of(column)
    )
