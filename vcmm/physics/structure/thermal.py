"""Thermal drift: the structure moves with a temperature, behind a first-order lag."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.declaration import UM, About, ChoosesColumns, ForDiagnosis, Opposite, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import T0_DEG_C, Array, Run
from vcmm.core.valid_range import check_range, checked_temperatures


@dataclass(frozen=True, eq=False)
class ThermalDrift(Effect, ChoosesColumns):
    """k (T lagged by tau - 20 degC) along one direction of the workpiece axes.

    trained: temperatures from which k and tau come, as "18 degC to 31 degC"; beyond them it refuses.
    """

    name = "thermal_drift"
    per = "direction, sensor"
    about = About(
        cites="ISO 230-3:2020 (environmental temperature variation error); first-order lag",
        words=Words(
            seen="the tip moves towards +{direction} as the temperature {sensor} rises ({k}, after {tau})",
            causes="a part of the frame warms with it",
            confirm="log a reference point for three time constants over a temperature step",
            signed=("k",),
            opposite=Opposite(
                "k", "the tip moves towards -{direction} as the temperature {sensor} rises ({k}, after {tau})"
            ),
        ),
    )
    direction: str = at("z", "x, y or z of the workpiece axes")
    sensor: str = at("air", "temperature sensor: column temp_<sensor>_C")
    k: float = param(
        0.0,
        "um/K",
        "displacement per temperature difference",
        typical=Typical(2 * UM, "usual: CMM 1-5, machining centre 10-50 um/K"),
    )
    tau: float = param(
        0.0, "s", "time constant of the structure", scan=(60.0, 300.0, 1200.0, 3600.0, 10800.0)
    )

    trained: str = ""

    def __post_init__(self) -> None:
        if self.direction not in ("x", "y", "z"):
            raise UsageError(f'thermal_drift: direction = "{self.direction}" must be "x", "y" or "z"')
        if self.tau < 0:
            raise UsageError(f"{self.id}: tau = {self.tau:g} s is negative; a lag is zero or positive")
        check_range(self.trained, self.trained and self.id)

    @property
    def link(self) -> str:
        return "tip"

    def required_columns(self) -> tuple[str, ...]:
        return (f"temp_{self.sensor}_C",)

    def error_motion(self, run: Run) -> Array:
        behind = checked_temperatures(
            self.trained, self.trained and self.id, self.sensor, run.lag(self.sensor, self.tau)
        )
        return motion(run, **{self.direction.upper(): self.k * (behind - T0_DEG_C)})


@dataclass(frozen=True, eq=False)
class ThermalDriftTwoLags(Effect, ChoosesColumns):
    """k (T lagged by tau - 20 degC) + k_slow (T lagged by tau_slow - 20 degC): a light part and a heavy one.

    The second shape of thermal_drift, and reported as such: slides follow the air in minutes, a bed in hours.
    """

    name = "thermal_drift_two_lags"
    diagnosis = ForDiagnosis(
        family="thermal_drift",
    )
    per = "direction, sensor"
    needs = ("time_s",)
    about = About(
        cites="ISO 230-3:2020 (environmental temperature variation error); sum of two first-order lags",
    )
    direction: str = at("z", "x, y or z of the workpiece axes")
    sensor: str = at("air", "temperature sensor: column temp_<sensor>_C")
    k: float = param(
        0.0,
        "um/K",
        "displacement per temperature difference of the fast part",
        typical=Typical(2 * UM, "as thermal_drift"),
    )
    k_slow: float = param(
        0.0,
        "um/K",
        "displacement per temperature difference of the slow part",
        typical=Typical(2 * UM, "as thermal_drift"),
    )
    tau: float = param(300.0, "s", "time constant of the fast part", scan=(60.0, 300.0, 1200.0))
    tau_slow: float = param(7200.0, "s", "time constant of the slow part", scan=(3600.0, 10800.0, 21600.0))
    trained: str = ""

    def __post_init__(self) -> None:
        if self.direction not in ("x", "y", "z"):
            raise UsageError(f'{self.name}: direction = "{self.direction}" must be "x", "y" or "z"')
        if min(self.tau, self.tau_slow) < 0:
            raise UsageError(f"{self.id}: tau is negative; a lag is zero or positive")
        check_range(self.trained, self.trained and self.id)

    @property
    def link(self) -> str:
        return "tip"

    def required_columns(self) -> tuple[str, ...]:
        return (f"temp_{self.sensor}_C",)

    def error_motion(self, run: Run) -> Array:
        fast, slow = (
            checked_temperatures(
                self.trained, self.trained and self.id, self.sensor, run.lag(self.sensor, tau)
            )
            - T0_DEG_C
            for tau in (self.tau, self.tau_slow)
        )
        amount = self.k * fast + self.k_slow * slow
        return motion(run, **{self.direction.upper(): amount})
