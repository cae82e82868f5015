"""Play that grows with the speed of the approach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import PLAY, UM, About, ChoosesColumns, ForDiagnosis, Prior, Trade, Typical, Words
from vcmm.core.effect import Effect, at, declared_columns, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.play import share_taken_up
from vcmm.core.run import Array, Run

REFERENCE = 1000.0 / 60.0  # mm/s: 1000 mm/min
REFERENCE_TURN = 2 * np.pi / 6.0  # rad/s: 10 turns a minute
LEAST_SPEED_SHARE = 1e-3  # of the reference: slower is no approach
APART = 1.2  # ratio of speeds from which a power of them shows


def _speeds(effect: SpeedPlay, run: Run) -> Array | None:
    """Return the speeds (n,) over the reference, without a sense; None where they were not recorded."""
    speed = run.columns.get(effect.required_columns()[1])
    return None if speed is None else np.abs(speed) / effect.reference


def _shows_in(effect: SpeedPlay, run: Run) -> bool:
    """Return whether the axis came at two speeds or more."""
    speed = _speeds(effect, run)
    moved = speed[speed > LEAST_SPEED_SHARE] if speed is not None else np.zeros(0)
    return len(moved) > 1 and float(moved.max()) > APART * float(moved.min())


@dataclass(frozen=True, eq=False)
class SpeedPlay(Effect, ChoosesColumns):
    """-1/2 gap (|v| / v0)^power d_a e_a, v0 = 1000 mm/min (10 turns a minute): with power 0 it is a backlash.

    Friction of guides and seals winds the drive up before the slide follows; viscous friction grows with the speed and Coulomb friction does not, so that
    together they grow by a power between 0 and 1. With power 1 it is a `servo_lag`.
    """

    name = "lost_motion_speed"
    per = "axis"
    about = About(
        cites="Armstrong-Helouvry, Dupont & Canudas de Wit, Automatica 30 (1994) 1083: friction over speed; lost motion = friction over stiffness",
        trade=Trade(
            "lost motion of {where}",
            "approach from one side at one speed, or compensate the reversal at that speed",
        ),
        words=Words(
            seen="{where} stops short after reversing, by a gap of {gap} at 1000 mm/min that goes with the speed to the power {power}",
            causes="viscous friction of guides or seals against an elastic drive",
            confirm="approach one place from both sides at three speeds",
            signed=("power",),
        ),
        along_axis=True,
        gap_parameter="gap",
    )
    diagnosis = ForDiagnosis(
        prior=Prior(share=0.3),
        shared_physics="play",
        shows_in=_shows_in,
    )
    needs = ("sense_{axis}", "speed_{axis}_mm_s")
    axis: str = at("X", "linear or rotary axis")
    gap: float = param(
        0.0,
        "um",
        "lost motion at 1000 mm/min (10 turns a minute)",
        typical=Typical(1 * UM, "as backlash", PLAY),
    )
    power: float = param(0.3, "1", "power of the speed", scan=(0.3, 0.15, 0.6), most=1.0)

    def __post_init__(self) -> None:
        if not self.power >= 0:
            raise UsageError(
                f"{self.id}: power = {self.power:g} must not be below zero: rows that stand still would have no size"
            )

    @property
    def link(self) -> str:
        return self.axis

    @property
    def reference(self) -> float:
        """Reference speed v0, mm/s or rad/s."""
        return REFERENCE if self.axis in "XYZ" else REFERENCE_TURN

    def required_columns(self) -> tuple[str, ...]:
        """Return the columns: rotary axes have their speed in rad/s."""
        columns = declared_columns(self)
        return columns if self.axis in "XYZ" else tuple(c.replace("_mm_s", "_rad_s") for c in columns)

    def error_motion(self, run: Run) -> Array:
        speed = np.abs(run.column(self.required_columns()[1])) / self.reference
        return motion(
            run, **{self.axis: -0.5 * self.gap * speed**self.power * share_taken_up(run, self.axis)}
        )
