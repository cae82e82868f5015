"""Drift and steps that move two or three directions at one time: one event or one time constant, a vector of sizes.

The second shapes of step_change, linear_drift and thermal_drift, and reported as such. One cause moves them
together: three answers along x, y and z with three moments say less than one with one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.declaration import HOUR, UM, About, ChoosesColumns, ForDiagnosis, Prior, Typical, Words
from vcmm.core.effect import COLUMN, Effect, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import T0_DEG_C, Array, Run

PLANES = ("xyz", "xy", "xz", "yz")


def _vector_elements(effect: _Vector) -> tuple[str, ...]:
    return tuple(effect.directions)


@dataclass(frozen=True, eq=False)
class _Vector(Effect):
    diagnosis = ForDiagnosis(
        # most things move along one axis
        prior=Prior(share=0.3),
        moves_together=True,
        elements=_vector_elements,
    )
    directions: str = at("xyz", "xyz, or two of them: workpiece axes", quiet=True, forms=PLANES)

    def __post_init__(self) -> None:
        if self.directions not in PLANES:
            raise UsageError(f'{self.name}: directions = "{self.directions}"; allowed: {", ".join(PLANES)}')
        given = np.asarray(getattr(self, self.diagnosis.size_name), dtype=float)
        if not given.any():  # nothing stated: as many zeros as there are directions
            object.__setattr__(self, self.diagnosis.size_name, np.zeros(len(self.directions)))
        elif given.shape != (len(self.directions),):
            raise UsageError(
                f"{self.id}: {self.diagnosis.size_name} has {given.size} numbers; expected {len(self.directions)}, one each for {self.directions}"
            )

    @property
    def link(self) -> str:
        return "tip"

    def _along(self, shape: Array) -> Array:
        """Return the shape (n,) times the vector, (n, 6)."""
        out = np.zeros((len(shape), 6))
        for letter, amount in zip(
            self.directions, np.asarray(getattr(self, self.diagnosis.size_name), dtype=float)
        ):
            out[:, COLUMN[letter.upper()]] = amount * shape
        return out


def _step_vector_file_note(effect: StepVector) -> str:
    return "acts from t1 on the clock of the recording; a job whose time_s begins at 0 is before it"


@dataclass(frozen=True, eq=False)
class StepVector(_Vector):
    """a for t > t1, a vector: a bump or a slipped clamp moves all directions at one moment."""

    name = "step_change_vector"
    diagnosis = ForDiagnosis(
        family="step_change",
        prior=Prior(share=0.3),
        size_name="a",
        moves_together=True,
        elements=_vector_elements,
        file_note=_step_vector_file_note,
    )
    per = "machine"
    needs = ("time_s",)
    about = About(
        cites="Page, Biometrika 41 (1954) 100: change at an unknown time",
        words=Words(
            seen="something moved by {a} at {t1}, in several directions at once",
            causes="a slipped clamp, a bump or a changed probe",
            confirm="look what happened at that time; touch the datum again",
        ),
    )
    a: Any = param(
        lambda: np.zeros(3),
        "um",
        "size of the step",
        shape="(3,)",
        typical=Typical(2 * UM, "a slipped clamp or a bump: 1-10 um"),
    )
    t1: float = param(
        600.0, "s", "time of the step", scan=(60.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 14400.0)
    )

    def error_motion(self, run: Run) -> Array:
        return self._along((run.column("time_s") > self.t1).astype(float))


def _drift_vector_file_note(effect: DriftVector) -> str:
    return "acts with time_s of a job, counted as in the recording; at time_s = 0 it is zero"


@dataclass(frozen=True, eq=False)
class DriftVector(_Vector):
    """c t, a vector: the foundation or a column moves askew to the axes."""

    name = "linear_drift_vector"
    diagnosis = ForDiagnosis(
        family="linear_drift",
        prior=Prior(share=0.3),
        size_name="c",
        moves_together=True,
        elements=_vector_elements,
        file_note=_drift_vector_file_note,
    )
    per = "machine"
    needs = ("time_s",)
    about = About(
        cites="ISO 230-3:2020: drift under constant environment",
        words=Words(
            seen="the tip drifts by {c}, askew to the axes",
            causes="warming up, settling or a foundation",
            confirm="touch a reference point every ten minutes",
        ),
    )
    c: Any = param(
        lambda: np.zeros(3),
        "um/h",
        "speed of the drift",
        shape="(3,)",
        typical=Typical(2 * UM / HOUR, "as linear_drift"),
    )

    def error_motion(self, run: Run) -> Array:
        return self._along(run.column("time_s"))


@dataclass(frozen=True, eq=False)
class ThermalVector(_Vector, ChoosesColumns):
    """k (T lagged by tau - 20 degC), a vector: one part of the frame warms and moves the tip askew."""

    name = "thermal_drift_vector"
    diagnosis = ForDiagnosis(
        family="thermal_drift",
        prior=Prior(share=0.3),
        size_name="k",
        moves_together=True,
        elements=_vector_elements,
    )
    per = "sensor"
    about = About(
        cites="ISO 230-3:2020 (environmental temperature variation error); first-order lag",
        words=Words(
            seen="the tip moves askew as the temperature {sensor} rises ({k}, after {tau})",
            causes="a part of the frame warms with it",
            confirm="log a reference point for three time constants over a temperature step",
        ),
    )
    sensor: str = at("air", "temperature sensor: column temp_<sensor>_C")
    k: Any = param(
        lambda: np.zeros(3),
        "um/K",
        "displacement per temperature difference",
        shape="(3,)",
        typical=Typical(2 * UM, "as thermal_drift"),
    )
    tau: float = param(
        0.0, "s", "time constant of the structure", scan=(60.0, 300.0, 1200.0, 3600.0, 10800.0)
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tau < 0:
            raise UsageError(f"{self.id}: tau = {self.tau:g} s is negative; a lag is zero or positive")

    def required_columns(self) -> tuple[str, ...]:
        return (f"temp_{self.sensor}_C",)

    def error_motion(self, run: Run) -> Array:
        return self._along(run.lag(self.sensor, self.tau) - T0_DEG_C)
