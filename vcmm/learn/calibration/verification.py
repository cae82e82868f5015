"""Test a machine file on a recording that it was not made from: residuals before and after, and coverage of its band.

Nuisance of the recording (its zero, its station, the place of the artefact) is fitted to it, in both cases alike. With P that projects it
out, the rest of the readings has the covariance P (C C' + noise^2) P', C the Inputs of the machine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.readings import free_nuisance
from vcmm.learn.calibration.result import rms
from vcmm.learn.calibration.solve import nuisance_basis
from vcmm.task.instruments.tracker import locate_stations
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer, noise_u
from vcmm.task.response.recording import Recording

INSIDE = 1.959964  # of the normal law, 95 %


@dataclass(frozen=True)
class IndependentTest:
    """One recording: rms before and after (mm or rad), share of readings within the 95 % band, rms of the band's u; angle?"""

    name: str
    n: int
    before: float
    after: float
    inside: float
    u: float
    angle: bool

    @property
    def unit(self) -> str:
        return "urad" if self.angle else "um"

    @property
    def scale(self) -> float:
        """Factor to um or urad."""
        return 1e6 if self.angle else 1e3

    @property
    def gain(self) -> float:
        """Share of the rms that the calibration removes."""
        return 1.0 - self.after / self.before if self.before > 0 else 0.0


def put_to_test(recording: Recording, before: Machine, after: Machine, noise: float = 0.0) -> IndependentTest:
    """Test a machine file; see the docstring of this module. before: the machine as it was known; after: the machine file, read back.

    noise: standard uncertainty of a reading (mm or rad) where neither recording nor machine states one.
    """
    rest, _ = remainder(recording, before)
    left, spread = remainder(recording, after, noise)
    u = np.sqrt(np.maximum(np.diag(spread), 0.0))
    return IndependentTest(
        name=recording.name,
        n=recording.m,
        before=rms(rest),
        after=rms(left),
        inside=float((np.abs(left) <= INSIDE * u).mean()),
        u=rms(u),
        angle=recording.kind == "angle",
    )


def remainder(recording: Recording, machine: Machine, noise: float = 0.0) -> tuple[Array, Array]:
    """Return the part (m,) that the machine does not predict, nuisance projected out, and its covariance (m, m)."""
    recording, _ = free_nuisance(recording, machine)
    recording, _ = locate_stations(recording, machine)
    observer = Observer(recording, machine)
    basis = nuisance_basis(nuisance_columns(recording, machine)[0])
    value = recording.value - observer.baseline()
    left = value - basis @ (basis.T @ value)
    columns = [np.zeros((recording.m, 0)), *(c for _, c in observer.calibration())]
    fitted = np.concatenate(columns, axis=1)
    fitted = fitted - basis @ (basis.T @ fitted)
    u = _noise(recording, machine, noise, left)
    free = np.eye(recording.m) - basis @ basis.T
    return left, fitted @ fitted.T + (free * u**2) @ free.T


def _noise(recording: Recording, machine: Machine, noise: float, left: Array) -> Array:
    if noise > 0:
        return np.full(recording.m, noise)
    try:
        return noise_u(recording, machine)
    except ModelLimit:
        return np.full(recording.m, rms(left))


def check_independent(test: Recording, used: list[Recording]) -> None:
    """Raises UsageError where a test recording holds the readings that the calibration was made from."""
    for readings in used:
        if readings.m == test.m and np.array_equal(readings.value, test.value):
            raise UsageError(
                f"{test.name} holds the same readings as {readings.name}, from which the machine was calibrated; state the gain on a separate "
                "test: a diagonal, another artefact, another run"
            )
