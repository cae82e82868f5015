"""Run: what the machine did, row by row. A plan, an NC program and a recording all end here.

A Run has axis positions, the tip offset, and a checked mapping of named columns. Column names are those of
recording files and always state the unit (`time_s`, `temp_part_C`, `speed_X_mm_s`); angles are kept in rad, so
`probe_angle_deg` of a file is `probe_angle_rad` here. Labels (`stylus`, `feature`, `pose` ...) are text columns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from vcmm.errors import ModelLimit, UsageError, choose_from

Array = npt.NDArray[np.float64]
T0_DEG_C = 20.0  # ISO 1: the reference temperature of every dimension


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
            for name, values in table.items():
                if values.shape != (self.n,):
                    raise UsageError(f"{kind} {name} has shape {values.shape}, but the run has {self.n} rows")
                if kind != "label" and not np.isfinite(values).all():
                    bad = int(np.flatnonzero(~np.isfinite(values))[0])
                    raise ModelLimit(
                        f"{kind} {name} is not a finite number in row {bad + 1}; remove or repair that row"
                    )

    @property
    def n(self) -> int:
        return int(self.offset.shape[0])

    def q(self, axis: str) -> Array:
        """Position of one axis (n,), mm or rad."""
        if axis not in self.position:
            raise ModelLimit(f"the run has no position of axis {axis}.{choose_from(axis, self.position)}")
        return self.position[axis]

    def column(self, name: str) -> Array:
        """One named column (n,). Raises ModelLimit when it is absent, with the closest name."""
        if name not in self.columns:
            raise ModelLimit(f"the run has no column {name}.{choose_from(name, sorted(self.columns))}")
        return self.columns[name]

    def vector(self, *names: str) -> Array:
        """Several columns side by side, (n, len(names))."""
        return np.stack([self.column(name) for name in names], axis=1)

    @property
    def normal(self) -> Array:
        """Outward surface normal or sensitive direction (n, 3), workpiece axes."""
        return self.vector("nx", "ny", "nz")

    @property
    def tip(self) -> Array:
        """Nominal tip position (n, 3) mm in workpiece axes; the machine fills it in before effects are asked."""
        return self.vector("tip_x_mm", "tip_y_mm", "tip_z_mm")

    @property
    def part_point(self) -> Array:
        """Vector from the part's origin to the tip (n, 3) mm, workpiece axes; the tip itself where no part is known."""
        if "part_x_mm" in self.columns:
            return self.vector("part_x_mm", "part_y_mm", "part_z_mm")
        return self.tip

    def copies(self, label: str) -> tuple[list[str], npt.NDArray[np.intp]]:
        """Values of a redraw label and the code of each row: `machine` one value, `touch` one per row."""
        if label in ("machine", "setup", "run") and label not in self.labels:
            return [label], np.zeros(self.n, dtype=np.intp)
        if label == "touch" and label not in self.labels:
            return [str(i) for i in range(self.n)], np.arange(self.n)
        if label not in self.labels:
            known = ["machine", "setup", "run", "touch", *self.labels]
            raise UsageError(f'redraw = "{label}" names no label of this run.{choose_from(label, known)}')
        values, codes = np.unique(self.labels[label], return_inverse=True)
        return [str(v) for v in values], codes

    def used(self, label: str, value: str) -> Array:
        """1 in the rows whose label has this value (in every row for ""), else 0; (n,)."""
        if not value:
            return np.ones(self.n)
        return (self.labels[label] == value).astype(float) if label in self.labels else np.zeros(self.n)

    def lagged(self, sensor: str, tau: float) -> Array:
        """Temperature of a sensor behind a first-order lag (n,), degC: tau dT'/dt = T - T', steady before the log."""
        name = f"temp_{sensor}_C"
        if tau == 0.0:
            return self.column(name)
        if sensor not in self.series:
            raise ModelLimit(
                f"a lag of {tau:g} s needs a log of {name} over time (time_s and {name} columns or a series)"
            )
        series = self.series[sensor]
        return np.interp(self.column("time_s"), series.time, _first_order_lag(series, tau))

    def with_columns(self, columns: Mapping[str, Array]) -> Run:
        """A copy with some columns added or replaced."""
        return replace(self, columns={**self.columns, **columns})

    def take(self, rows: npt.NDArray[np.intp] | slice) -> Run:
        """A copy with some of the rows, in the order given."""
        return Run(
            {k: v[rows] for k, v in self.position.items()},
            self.offset[rows],
            {k: v[rows] for k, v in self.columns.items()},
            {k: v[rows] for k, v in self.labels.items()},
            self.series,
        )


def _first_order_lag(series: Series, tau: float) -> Array:
    """Exact response to the piecewise-linear log: T'(t+h) = T' e + (T1 - s tau) + ... with s the slope."""
    out = np.empty_like(series.value)
    out[0] = series.value[0]
    for i in range(1, len(out)):
        h = series.time[i] - series.time[i - 1]
        slope = (series.value[i] - series.value[i - 1]) / h
        decay = np.exp(-h / tau)
        # particular solution of tau y' + y = T0 + s t is T0 + s (t - tau)
        out[i] = (out[i - 1] - series.value[i - 1] + slope * tau) * decay + series.value[i] - slope * tau
    return out
