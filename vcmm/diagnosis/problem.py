"""Problem: a recording against a machine, as arrays. Everything later works on these.

residual = value - baseline(machine);   nuisance (m, p);   calibration (m, r), unit normal;   u (m,)
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.diagnosis.sanity import without_gaps
from vcmm.effect import Effect
from vcmm.gaussian import Ints, Whitener, whitener
from vcmm.machine import Machine
from vcmm.observe import Observer, noise_u, nuisance_columns
from vcmm.recording import Recording
from vcmm.run import Array, Run, Series

TRACE = 0.05  # s between rows, from which on a structure of 10 Hz and more is not followed


@dataclass(frozen=True, eq=False)
class Problem:
    """m observations of n rows. `run` is prepared (nominal tip as columns); before (m,) is the preceding observation."""

    recording: Recording
    machine: Machine
    run: Run
    residual: Array
    u: Array
    nuisance: Array
    calibration: Array
    before: Ints
    observer: Observer

    @property
    def m(self) -> int:
        return len(self.residual)

    def whitener(self, u: Array | None = None, rho: float = 0.0) -> Whitener:
        """The whitener, with noise weights and correlation of the audit where given."""
        return whitener(self.u if u is None else u, self.nuisance, self.calibration, self.before, rho)

    def columns(self, effect: Effect, names: Sequence[str]) -> Array:
        """(m, k): change of the observation per canonical unit of each element of the parameters."""
        return np.concatenate([self.observer.of_parameter(effect, name) for name in names], axis=1)

    def of_rows(self, values: Array) -> Array:
        """A column of the run (n,) as one value per observation (m,)."""
        return np.asarray(values)[self.recording.row]


def make_problem(recording: Recording, machine: Machine) -> Problem:
    """Predict the recording from the machine alone. Raises what `observe` raises: columns or positions that do not fit."""
    recording = replace(recording, run=with_logs(recording.run))
    observer = Observer(recording, machine)
    columns, _ = nuisance_columns(recording, machine)
    known = [c for _, c in observer.calibration()]
    m = len(recording.value)
    return Problem(
        recording,
        machine,
        observer.run,
        recording.value - observer.baseline(),
        noise_u(recording, machine),
        np.reshape(columns, (m, -1)),
        np.concatenate([np.zeros((m, 0)), *known], axis=1),
        without_gaps(predecessors(recording.row), _times(recording)),
        observer,
    )


def _times(recording: Recording) -> Array | None:
    time = recording.run.columns.get("time_s")
    return None if time is None else np.asarray(time[recording.row])


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


def predecessors(row: Ints) -> Ints:
    """For each observation the one before it in the same series: same place within its row, the row before; -1: none."""
    row = np.asarray(row, dtype=np.intp)
    order = np.argsort(row, kind="stable")
    first = np.r_[True, np.diff(row[order]) > 0]
    starts = np.maximum.accumulate(np.where(first, np.arange(len(row)), 0))
    place = np.arange(len(row)) - starts
    out = np.full(len(row), -1, dtype=np.intp)
    for k in range(int(place.max(initial=0)) + 1):
        members = order[place == k]
        out[members[1:]] = members[:-1]
    return out


def generator(seed: int, name: str) -> np.random.Generator:
    """Random numbers of one purpose: a pure function of (seed, name)."""
    digest = hashlib.blake2b(f"{int(seed)}\n{name}".encode(), digest_size=8).digest()
    return np.random.default_rng(int.from_bytes(digest, "little"))
