"""Run: what the machine did, row by row. A plan, an NC program and a recording all become a Run.

A Run has axis positions, the tip offset, and a checked mapping of named columns. Column names are those of
recording files and always state the unit (`time_s`, `temp_part_C`, `speed_X_mm_s`); angles are kept in rad, so
`probe_angle_deg` of a file is `probe_angle_rad` here. Labels (`stylus`, `feature`, `pose` ...) are text columns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.core.memory import keep_in_hand

keep_in_hand()
Array = npt.NDArray[np.float64]
T0_DEG_C = 20.0  # ISO 1: the reference temperature of every dimension
# workpiece axes, where rotary axes turn the tool
TOOL_AXIS_COLUMNS = ("tool_axis_x", "tool_axis_y", "tool_axis_z")
FORCE_COLUMNS = ("force_x_N", "force_y_N", "force_z_N")  # of the part on the tool, workpiece axes
POWER_COLUMN = "spindle_load_W"  # cutting power, over the time of the program
OFFSET_LABEL = "work_offset"  # the label that names the work offset a row was cut under
MOST_KEPT = 2**20  # numbers of lags of a run that are kept, 8 MB
PROBE_LABEL = "probed"  # label: which touch of a program a row is, counted from 1, "" for others


@dataclass(frozen=True)
class Series:
    """A logged quantity with its own clock: time (k,) s, increasing; value (k,)."""

    time: Array
    value: Array


@dataclass(frozen=True, eq=False)
class Run:
    """n rows of what was done.

    position: axis letter -> (n,) mm or rad, as indicated (measuring) or commanded (machining).
    offset: (n, 3) mm, tip relative to the frame of the last tool-side axis.
    columns: name with unit -> (n,) float.   labels: name -> (n,) text.   series: sensor -> Series.
    """

    position: Mapping[str, Array]
    offset: Array
    columns: Mapping[str, Array] = field(default_factory=dict)
    labels: Mapping[str, npt.NDArray[np.str_]] = field(default_factory=dict)
    series: Mapping[str, Series] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.offset.ndim != 2 or self.offset.shape[1] != 3:
            raise UsageError(
                f"offset must have shape (n, 3), got {self.offset.shape}; use numpy.zeros((n, 3)) for none"
            )
        for kind, table in (("position", self.position), ("column", self.columns), ("label", self.labels)):
            _check_rows(kind, table, self.n)

    @property
    def n(self) -> int:
        return int(self.offset.shape[0])

    def q(self, axis: str) -> Array:
        """Return the position of one axis (n,), mm or rad."""
        if axis not in self.position:
            raise ModelLimit(f"the run has no position of axis {axis}.{choose_from(axis, self.position)}")
        return self.position[axis]

    def column(self, name: str) -> Array:
        """Return one named column (n,). Raises ModelLimit when it is absent, with the closest name."""
        if name not in self.columns:
            raise ModelLimit(f"the run has no column {name}.{choose_from(name, sorted(self.columns))}")
        return self.columns[name]

    def vector(self, *names: str) -> Array:
        """Return several columns side by side, (n, len(names))."""
        return np.stack([self.column(name) for name in names], axis=1)

    @property
    def normal(self) -> Array:
        """Outward surface normal or sensitive direction (n, 3), workpiece axes."""
        return self.vector("nx", "ny", "nz")

    @property
    def tip(self) -> Array:
        """Nominal tip position (n, 3) mm in workpiece axes; the machine fills it in before it evaluates effects."""
        return self.vector("tip_x_mm", "tip_y_mm", "tip_z_mm")

    @property
    def part_point(self) -> Array:
        """Vector from the part's origin to the tip (n, 3) mm, workpiece axes; the tip itself where no part is known."""
        if "part_x_mm" in self.columns:
            return self.vector("part_x_mm", "part_y_mm", "part_z_mm")
        return self.tip

    def copies(self, label: str) -> tuple[list[str], npt.NDArray[np.intp]]:
        """Return the values of a redraw label and the code of each row: `machine` one value, `touch` one per row."""
        if label in ("machine", "setup", "run") and label not in self.labels:
            return [label], np.zeros(self.n, dtype=np.intp)
        if label == "touch" and label not in self.labels:
            return [str(i) for i in range(self.n)], np.arange(self.n)
        if label not in self.labels:
            labels = ["machine", "setup", "run", "touch", *self.labels]
            raise UsageError(f'redraw = "{label}" names no label of this run.{choose_from(label, labels)}')
        values, codes = encode_labels(self.labels[label])
        return [str(v) for v in values], codes

    def label_mask(self, label: str, value: str) -> Array:
        """Return 1 in the rows whose label has this value (one of "a,b"; any for ""), else 0; (n,)."""
        if not value:
            return np.ones(self.n)
        if label not in self.labels:
            return np.zeros(self.n)
        return np.isin(self.labels[label], value.split(",")).astype(float)

    def lag(self, sensor: str, tau: float) -> Array:
        """Return the temperature of a sensor behind a first-order lag (n,), degC: tau dT'/dt = T - T', steady before the log.

        Without a log, a column with one value in all rows is taken as steady; the lag then changes nothing.

        Exact for a log that is linear between its entries. Raises ModelLimit where the log ends more than one of its
        own intervals before a row.
        """
        name = f"temp_{sensor}_C"
        if tau == 0.0 and name in self.columns:
            return self.column(name)
        if sensor not in self.series:
            values = self.column(name)  # says what is missing
            if tau == 0.0 or (values == values[0]).all():
                return values
            raise ModelLimit(
                f"a lag of {tau:g} s needs a log of {name} over time (time_s and {name} columns or a series)"
            )
        lags = _LAGS.setdefault(self, {})
        if (sensor, tau) not in lags:
            series, time = self.series[sensor], self.column("time_s")
            _check_log_reaches(name, series, time)
            while len(lags) > MOST_KEPT // max(self.n, 1):
                del lags[next(iter(lags))]  # the oldest
            lags[sensor, tau] = first_order_lag(series, tau, time)
            lags[sensor, tau].flags.writeable = False
        return lags[sensor, tau]

    def with_columns(self, columns: Mapping[str, Array]) -> Run:
        """Return a copy with some columns added or replaced."""
        _check_rows("column", columns, self.n)
        run = object.__new__(Run)  # the others were looked at when this one was made
        run.__dict__.update(self.__dict__, columns={**self.columns, **columns})
        return run

    def take(self, rows: npt.NDArray[np.intp] | slice) -> Run:
        """Return a copy with some of the rows, in the order given."""
        return Run(
            {k: v[rows] for k, v in self.position.items()},
            self.offset[rows],
            {k: v[rows] for k, v in self.columns.items()},
            {k: v[rows] for k, v in self.labels.items()},
            self.series,
        )


_LAGS: WeakKeyDictionary[Run, dict[tuple[str, float], Array]] = WeakKeyDictionary()
"""Lags of a run that were asked last: every number of an effect, and every part of a search, asks for the same ones."""


def encode_labels(labels: npt.NDArray[np.str_]) -> tuple[npt.NDArray[np.str_], npt.NDArray[np.intp]]:
    """Return the sorted values of labels (n,) and the code (n,) of each: np.unique of the first of every stretch of equal ones."""
    first = np.flatnonzero(np.concatenate([[True] * min(len(labels), 1), labels[1:] != labels[:-1]]))
    values, codes = np.unique(labels[first], return_inverse=True)
    return values, np.repeat(codes, np.diff(np.append(first, len(labels))))


def _check_rows(kind: str, table: Mapping[str, npt.NDArray[Any]], n: int) -> None:
    """Raise UsageError for a position, column or label of another number of rows, ModelLimit for a number that is not finite."""
    for name, values in table.items():
        if values.shape != (n,):
            raise UsageError(f"{kind} {name} has shape {values.shape}, but the run has {n} rows")
        if kind != "label" and not np.isfinite(values).all():
            bad = int(np.flatnonzero(~np.isfinite(values))[0])
            raise ModelLimit(
                f"{kind} {name} is not a finite number in row {bad + 1}; remove or repair that row"
            )


def _check_log_reaches(name: str, series: Series, time: Array) -> None:
    last = float(series.time[-1])
    interval = last - float(series.time[-2]) if len(series.time) > 1 else 0.0
    late = np.flatnonzero(time > last + interval)
    if len(late):
        raise ModelLimit(
            f"row {late[0] + 1} is at {time[late[0]]:g} s, but the log of {name} ends at {last:g} s; extend the log"
        )


def first_order_lag(series: Series, tau: float, time: Array) -> Array:
    """Return the response (n,) at `time` of tau y' + y = T to a log T that is linear between its entries and held after the last.

    Over a stretch of length h from (T0, y0), with x = h / tau:  y = T + (y0 - T0) e^-x - (T - T0) (1 - e^-x) / x.
    The last factor tends to 1 for a step (h = 0), so steps cost no accuracy.
    """
    if tau == 0.0:
        return np.interp(time, series.time, series.value)
    lagged = _behind_the_log(series, tau)
    before = np.clip(np.searchsorted(series.time, time, side="right") - 1, 0, len(lagged) - 1)
    x = np.maximum(time - series.time[before], 0.0) / tau
    now = np.interp(time, series.time, series.value)
    return now + _fading(lagged[before] - series.value[before], now - series.value[before], x)


def _behind_the_log(series: Series, tau: float) -> Array:
    """Return the response (m,) at the entries of the log, each from the one before it."""
    kept, share = _kept_and_share(np.diff(series.time) / tau)
    lost = np.diff(series.value) * share
    lagged = [float(series.value[0])]
    steps = zip(series.value[:-1].tolist(), series.value[1:].tolist(), kept.tolist(), lost.tolist())
    for last, value, keeps, loses in steps:
        lagged.append(value + ((lagged[-1] - last) * keeps - loses))
    return np.array(lagged)


def _fading(behind: Array, rise: Array, x: Array) -> Array:
    """Return what the response still lacks after x time constants: (y0 - T0) e^-x - rise (1 - e^-x) / x."""
    kept, share = _kept_and_share(x)
    return behind * kept - rise * share


def _kept_and_share(x: Array) -> tuple[Array, Array]:
    """Return e^-x and (1 - e^-x) / x, which tends to 1 at x = 0."""
    return np.exp(-x), np.where(x > 0, -np.expm1(-x) / np.where(x > 0, x, 1.0), 1.0)
