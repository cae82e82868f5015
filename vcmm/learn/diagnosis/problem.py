"""Problem: a recording against a machine, as arrays. Everything later works on these.

residual = value - baseline(machine);   nuisance (m, p);   calibration (m, r), unit normal;   u (m,)
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Ints, Whitener, whitener
from vcmm.core.effect import Effect
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.sanity import series_of, without_gaps
from vcmm.task.response.observe import Observer, known_here, noise_u, nuisance_columns
from vcmm.task.response.recording import Recording

FIELD = "field"  # a covariance beside those of the machine's Inputs: physics without a name


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
    stated: tuple[tuple[str, Array], ...] = ()  # Input id, its columns (m, r) of `calibration`

    @property
    def m(self) -> int:
        return len(self.residual)

    @property
    def own_uncertainty(self) -> Array:
        """Uncertainty of this recording alone (m, r), see `known_here`."""
        return known_here(self.recording, self.machine)

    def whitener(self, u: Array | None = None, rho: float = 0.0) -> Whitener:
        """Return the whitener, with noise weights and correlation of the audit where given."""
        return whitener(self.u if u is None else u, self.nuisance, self.calibration, self.before, rho)

    def columns(self, effect: Effect, names: Sequence[str]) -> Array:
        """Return the change of the observation per canonical unit of each element of the parameters, (m, k)."""
        return np.concatenate([self.observer.of_parameter(effect, name) for name in names], axis=1)

    def with_statement(self, name: str, columns: Array) -> Problem:
        """Return the problem with one more covariance, columns (m, r) per unit normal, beside the statements of the machine file."""
        stated = (*self.stated, (name, columns))
        return replace(self, stated=stated, calibration=_beside(self.m, stated))

    def without_statements(self, statements: Collection[str]) -> Problem:
        """Return the problem without the statements under some Input ids: the rows alone determine these quantities then."""
        kept = tuple((name, columns) for name, columns in self.stated if name not in statements)
        return replace(self, stated=kept, calibration=_beside(self.m, kept))

    def per_observation(self, values: Array) -> Array:
        """Return a column of the run (n,) as one value per observation (m,)."""
        return np.asarray(values)[self.recording.row]


def make_problem(recording: Recording, machine: Machine) -> Problem:
    """Predict the recording from the machine alone. Raises what `observe` raises: columns or positions that do not fit."""
    observer = Observer(recording, machine)
    recording = observer.recording
    columns, _ = nuisance_columns(recording, machine)
    stated = tuple(observer.calibration())
    m = len(recording.value)
    return Problem(
        recording,
        machine,
        observer.run,
        recording.value - observer.baseline(),
        noise_u(recording, machine),
        np.reshape(columns, (m, -1)),
        _beside(m, stated),
        neighbours_of(recording),
        observer,
        stated,
    )


def _beside(m: int, stated: Sequence[tuple[str, Array]]) -> Array:
    return np.concatenate([np.zeros((m, 0)), *(columns for _, columns in stated)], axis=1)


def neighbours_of(recording: Recording) -> Ints:
    """Return the preceding observation of each (m,); none where no column holds the time: the rows of a table are no series."""
    time = recording.run.columns.get("time_s")
    if time is None:
        return np.full(recording.m, -1, dtype=np.intp)
    return without_gaps(predecessors(recording.row), np.asarray(time[recording.row]))


def predecessors(row: Ints) -> Ints:
    """Return for each observation the one before it in the same series: same place within its row, the row before; -1: none."""
    out = np.full(len(row), -1, dtype=np.intp)
    for members in series_of(np.asarray(row, dtype=np.intp)):
        out[members[1:]] = members[:-1]
    return out


def generator(seed: int, name: str) -> np.random.Generator:
    """Return the random numbers of one purpose: a pure function of (seed, name)."""
    digest = hashlib.blake2b(f"{int(seed)}\n{name}".encode(), digest_size=8).digest()
    return np.random.default_rng(int.from_bytes(digest, "little"))
