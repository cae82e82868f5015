"""Growth of a spindle that runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, ChoosesColumns, Opposite, Trade, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Array, Run, Series, first_order_lag

FULL_SPEED = 1e4  # per min


@dataclass(frozen=True, eq=False)
class SpindleGrowth(Effect, ChoosesColumns):
    """A (1 - exp(-t / tau)) along the tool, from the spindle to the tip: a warm spindle pushes the tip down, to -Z.

    t is the time since the spindle was started, column spindle_on_s; where it is absent, time_s. With follows = 1 the
    growth follows the speed instead, A (n / 10 000 per min) behind a lag tau, from the log spindle_rpm. By ISO 841 the +axis
    direction leads from the workpiece to the spindle, so growth is motion to the - side of the tool frame.
    """

    name = "spindle_growth"
    about = About(
        cites="ISO 230-3:2020: thermal distortion caused by a rotating spindle; ISO 841 (sense of Z)",
        trade=Trade("growth of the spindle {where}", "warm the spindle up before the cut"),
        words=Words(
            seen="the spindle grows by {A} with a time constant {tau}",
            causes="warming of bearings and motor",
            confirm="touch a reference while the spindle runs and stops",
            opposite=Opposite("A", "the spindle draws back by {A} with a time constant {tau}"),
        ),
        aliases={"A": "amplitude"},
        belongs_to="tool",
    )
    per = "axis"
    needs = ("time_s",)
    axis: str = at("Z", "direction of the tool axis, X, Y or Z of the tool frame")
    amplitude: float = param(
        0.0, "um", "growth when warm; `A` in files", typical=Typical(20 * UM, "usual: 10-60 um")
    )
    tau: float = param(
        1800.0, "s", "time constant of the spindle", scan=(300.0, 900.0, 1800.0, 3600.0, 7200.0)
    )
    follows: int = at(
        0, "1 = follows the speed of the spindle, 0 = one start", quiet=True, tries=(0, 1), forms=(0, 1)
    )

    def __post_init__(self) -> None:
        if self.axis not in ("X", "Y", "Z") or not self.tau > 0:
            raise UsageError(
                f'{self.id}: axis must be "X", "Y" or "Z" and tau positive, for example "1800 s"'
            )

    @property
    def link(self) -> str:
        return "tool"

    def required_columns(self) -> tuple[str, ...]:
        return (*self.needs, "spindle_rpm") if self.follows else self.needs

    def error_motion(self, run: Run) -> Array:
        if self.follows:
            return motion(run, **{self.axis: -self.amplitude * self._speed(run)})
        on = run.columns.get("spindle_on_s")
        time = np.maximum(run.column("time_s") if on is None else on, 0.0)  # cold before it starts
        return motion(run, **{self.axis: self.amplitude * np.expm1(-time / self.tau)})

    def _speed(self, run: Run) -> Array:
        """Return the speed behind the lag (n,), in 10 000 per min; the spindle is cold where its log begins."""
        log = run.series.get("spindle_rpm")
        if log is None:
            raise ModelLimit("spindle_growth with follows = 1 needs a log of spindle_rpm over time_s; add it")
        cold = Series(np.append(log.time[0] - 1e-6, log.time), np.append(0.0, log.value / FULL_SPEED))
        return first_order_lag(cold, self.tau, run.column("time_s"))
