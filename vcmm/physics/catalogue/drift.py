"""Drift and steps in time: what moved while the recording was made, whatever the cause."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import HOUR, UM, About, ForDiagnosis, Opposite, Prior, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

CUT = Prior(
    rare_with="cut_length_mm"
)  # while a tool cuts its spindle runs: that is the usual cause of a drift, and has a name


@dataclass(frozen=True, eq=False)
class _Drift(Effect):
    needs = ("time_s",)
    direction: str = at("z", "x, y or z of the workpiece axes")

    def __post_init__(self) -> None:
        if self.direction not in ("x", "y", "z"):
            raise UsageError(f'{self.name}: direction = "{self.direction}" must be "x", "y" or "z"')

    @property
    def link(self) -> str:
        return "tip"

    def _along(self, run: Run, amount: Array) -> Array:
        return motion(run, **{self.direction.upper(): amount})


def _linear_drift_file_note(effect: LinearDrift) -> str:
    return "acts with time_s of a job, counted as in the recording; at time_s = 0 it is zero"


@dataclass(frozen=True, eq=False)
class LinearDrift(_Drift):
    """c t along one direction of the workpiece axes, t = time_s: with c = 2 um/h the tip is 1 um off after 30 min."""

    name = "linear_drift"
    per = "direction"
    about = About(
        cites="ISO 230-3:2020: drift under constant environment",
        words=Words(
            seen="the tip drifts towards +{direction} by {c}",
            causes="warming up, settling or a foundation",
            confirm="touch a reference point every ten minutes",
            opposite=Opposite("c", "the tip drifts towards -{direction} by {c}"),
        ),
    )
    diagnosis = ForDiagnosis(
        prior=CUT,
        file_note=_linear_drift_file_note,
    )
    c: float = param(
        0.0,
        "um/h",
        "speed of the drift",
        typical=Typical(2 * UM / HOUR, "usual: 1-5 um in an hour after switching on"),
    )

    def error_motion(self, run: Run) -> Array:
        return self._along(run, self.c * run.column("time_s"))


def _settling_drift_file_note(effect: SettlingDrift) -> str:
    return "acts with time_s of a job, counted as in the recording"


@dataclass(frozen=True, eq=False)
class SettlingDrift(_Drift):
    """c tau (1 - exp(-t / tau)): a drift that begins with the speed c and dies away, the run-in after a start.

    The second shape of linear_drift, and reported as such; for tau far above the duration it is linear_drift.
    """

    name = "settling_drift"
    diagnosis = ForDiagnosis(
        family="linear_drift",
        prior=CUT,
        file_note=_settling_drift_file_note,
    )
    per = "direction"
    about = About(
        cites="ISO 230-3:2020: warm-up towards a steady state; first-order response to switching on",
    )
    c: float = param(
        0.0,
        "um/h",
        "speed of the drift at the start",
        typical=Typical(10 * UM / HOUR, "usual: 5-30 um/h in the first minutes after a start"),
    )
    tau: float = param(1800.0, "s", "time constant of settling", scan=(300.0, 900.0, 2700.0, 8100.0))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.tau > 0:
            raise UsageError(f"{self.id}: tau = {self.tau:g} s must be above zero")

    def error_motion(self, run: Run) -> Array:
        settled = -np.expm1(-run.column("time_s") / self.tau)
        return self._along(run, self.c * self.tau * settled)


def _step_change_file_note(effect: StepChange) -> str:
    return "acts from t1 on the clock of the recording; a job whose time_s begins at 0 is before it"


@dataclass(frozen=True, eq=False)
class StepChange(_Drift):
    """a for t > t1 along one direction of the workpiece axes: a bump, a slipped clamp, a datum taken anew."""

    name = "step_change"
    per = "direction"
    about = About(
        cites="Page, Biometrika 41 (1954) 100: change at an unknown time",
        words=Words(
            seen="something moved towards +{direction} by {a} at {t1}",
            causes="a slipped clamp, a bump or a changed probe",
            confirm="look what happened at that time; touch the datum again",
            opposite=Opposite("a", "something moved towards -{direction} by {a} at {t1}"),
        ),
    )
    diagnosis = ForDiagnosis(
        file_note=_step_change_file_note,
    )
    a: float = param(
        0.0, "um", "size of the step", typical=Typical(2 * UM, "a slipped clamp or a bump: 1-10 um")
    )
    t1: float = param(
        600.0, "s", "time of the step", scan=(60.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 14400.0)
    )

    def error_motion(self, run: Run) -> Array:
        return self._along(run, np.where(run.column("time_s") > self.t1, self.a, 0.0))
