"""The spindle warms by what it has to cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, Opposite, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import POWER_COLUMN, Array, Run, Series, first_order_lag

FULL_LOAD = 1e3  # W


@dataclass(frozen=True, eq=False)
class SpindleLoadGrowth(Effect):
    """amplitude x (P / 1 kW behind a lag tau), along the tool, to the - side of its frame: a warm spindle pushes the tip down.

    P is the cutting power, from the log spindle_load_W: of the forces of a cut or as the control logged it, the power of running
    without a cut taken off. That comes on top of spindle_growth, the growth of a spindle that runs free.
    """

    name = "spindle_load_growth"
    per = "axis"
    needs = ("time_s", POWER_COLUMN)
    about = About(
        cites="ISO 230-3:2020: thermal distortion caused by a rotating spindle; Bossmanns & Tu, Int. J. Mach. Tools Manuf. 39 (1999) 1345",
        words=Words(
            seen="the spindle grows with its load by {amplitude} per kW with a time constant {tau}",
            causes="heat of motor and bearings under load",
            confirm="the same cut with half the feed, after a pause",
            opposite=Opposite(
                "amplitude",
                "the spindle draws back under load by {amplitude} per kW with a time constant {tau}",
            ),
        ),
        belongs_to="tool",
        needs_cut=True,
    )
    axis: str = at("Z", "direction of the tool axis, X, Y or Z of the tool frame")
    amplitude: float = param(
        0.0, "um", "growth under 1 kW when warm", typical=Typical(5 * UM, "usual: 2-20 um per kW")
    )
    tau: float = param(900.0, "s", "time constant", scan=(300.0, 900.0, 2700.0))

    def __post_init__(self) -> None:
        if self.axis not in ("X", "Y", "Z") or not self.tau > 0:
            raise UsageError(f'{self.id}: axis must be "X", "Y" or "Z" and tau positive, for example "900 s"')

    @property
    def link(self) -> str:
        return "tool"

    def error_motion(self, run: Run) -> Array:
        log = run.series.get(POWER_COLUMN)
        if log is None:
            raise ModelLimit(
                "spindle_load_growth needs a log of spindle_load_W over time_s: a cut with stock, material and teeth has one, or add load_log"
            )
        cold = Series(np.append(log.time[0] - 1e-6, log.time), np.append(0.0, log.value / FULL_LOAD))
        return motion(
            run, **{self.axis: -self.amplitude * first_order_lag(cold, self.tau, run.column("time_s"))}
        )
