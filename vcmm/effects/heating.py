"""Heat that the machine makes itself: spindle growth, expansion of a ball screw with use."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.effect import Effect, at, motion, param
from vcmm.errors import UsageError
from vcmm.run import Array, Run


@dataclass(frozen=True, eq=False)
class SpindleGrowth(Effect):
    """A (1 - exp(-t / tau)) along the tool, from the spindle to the tip: a warm spindle pushes the tip down, to -Z.

    t is the time since the spindle was started, column spindle_on_s; where it is absent, time_s. By ISO 841 the +axis
    direction leads from the workpiece to the spindle, so growth is motion to the - side of the tool frame.
    """

    name = "spindle_growth"
    per = "axis"
    needs = ("time_s",)
    aliases = {"A": "amplitude"}  # noqa: RUF012 - read only
    cites = "ISO 230-3:2020: thermal distortion caused by a rotating spindle; ISO 841 (sense of Z)"
    axis: str = at("Z", "direction of the tool axis, X, Y or Z of the tool frame")
    amplitude: float = param(0.0, "um", "growth when warm; `A` in files")
    tau: float = param(
        1800.0, "s", "time constant of the spindle", scan=(300.0, 900.0, 1800.0, 3600.0, 7200.0)
    )

    def __post_init__(self) -> None:
        if self.axis not in ("X", "Y", "Z") or not self.tau > 0:
            raise UsageError(
                f'{self.id}: axis must be "X", "Y" or "Z" and tau positive, for example "1800 s"'
            )

    @property
    def link(self) -> str:
        return "tool"

    def error_motion(self, run: Run) -> Array:
        on = run.columns.get("spindle_on_s")
        time = np.maximum(run.column("time_s") if on is None else on, 0.0)  # cold before it starts
        return motion(run, **{self.axis: self.amplitude * np.expm1(-time / self.tau)})


@dataclass(frozen=True, eq=False)
class ScrewHeating(Effect):
    """(k q_a + shift) (1 - exp(-travel / distance)) e_a: a screw expands as it warms with the distance travelled.

    shift = -k q_f where the screw is held at q_f and not at zero. A distance far beyond the travel made gives an
    expansion in proportion to it.
    """

    name = "screw_heating"
    per = "axis"
    needs = ("travel_{axis}_mm",)
    cites = "ISO 230-3:2020: thermal distortion caused by moving linear axes"
    axis: str = at("X", "linear axis driven by a screw without a scale")
    k: float = param(0.0, "um/m", "strain of the warm screw")
    shift: float = param(0.0, "um", "shift of the axis zero when warm")
    distance: float = param(
        1e5, "mm", "travel after which 63 % is reached", scan=(3e3, 1e4, 3e4, 1e5, 3e5, 1e6)
    )

    def __post_init__(self) -> None:
        if not self.distance > 0:
            raise UsageError(f'{self.id}: distance must be positive; write for example distance = "100 m"')

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        warm = -np.expm1(-run.column(f"travel_{self.axis}_mm") / self.distance)
        return motion(run, **{self.axis: (self.k * run.q(self.axis) + self.shift) * warm})
