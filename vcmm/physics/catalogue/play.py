"""Play that is no step: partly made up along a way after the reversal, or growing with what the axis carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import PLAY, UM, About, ChoosesColumns, ForDiagnosis, Prior, Typical
from vcmm.core.effect import Effect, at, declared_columns, motion, param, required
from vcmm.core.errors import UsageError
from vcmm.core.play import share_taken_up
from vcmm.core.run import Array, Run

LONGEST = 3.0  # mm or rad: of the ways that are tried


def _backlash_ramp_shows_in(effect: BacklashRamp, run: Run) -> bool:
    """Rows stand on the ways that are tried, and not at their ends only."""
    since = run.columns.get(required(effect)[1])
    return since is not None and len(np.unique(since[since < LONGEST])) > 2


@dataclass(frozen=True, eq=False)
class BacklashRamp(Effect, ChoosesColumns):
    """-1/2 (gap - ramp s / distance) d_a e_a up to s = distance, then -1/2 (gap - ramp) d_a: play partly made up on the way.

    The second shape of backlash, and reported as such. s is the distance since the last reversal. A slide that hangs back by
    the whole gap at first and creeps after it, because friction lets go or a counterweight takes over.
    """

    name = "backlash_ramp"
    diagnosis = ForDiagnosis(
        family="backlash",
        shared_physics="play",
        shows_in=_backlash_ramp_shows_in,
    )
    per = "axis"
    about = About(
        cites="ISO 230-2:2014, 2.16; friction that falls after a reversal: Armstrong et al., Automatica 30 (1994) 1083",
        along_axis=True,
    )
    needs = ("sense_{axis}", "since_reversal_{axis}_mm")
    axis: str = at("X", "linear or rotary axis")
    gap: float = param(0.0, "um", "lost motion at the reversal", typical=Typical(1 * UM, "as backlash", PLAY))
    ramp: float = param(
        0.0, "um", "what of it is made up on the way", typical=Typical(1 * UM, "as backlash", PLAY)
    )
    distance: float = param(
        0.3, "mm", "way after a reversal on which it is made up", scan=(0.03, 0.1, 0.3, 1.0, 3.0)
    )

    def __post_init__(self) -> None:
        if not self.distance > 0:
            raise UsageError(f'{self.id}: distance must be positive; write for example distance = "0.1 mm"')

    @property
    def link(self) -> str:
        return self.axis

    def required(self) -> tuple[str, ...]:
        """Rotary axes count the distance since reversal in rad."""
        columns = declared_columns(self)
        return columns if self.axis in "XYZ" else tuple(c.replace("_mm", "_rad") for c in columns)

    def error_motion(self, run: Run) -> Array:
        sense, since = share_taken_up(run, self.axis), run.column(required(self)[1])
        gap = self.gap - self.ramp * np.minimum(since / self.distance, 1.0)
        return motion(run, **{self.axis: -0.5 * gap * sense})


def _loaded_play_shows_in(effect: LoadedPlay, run: Run) -> bool:
    load = run.columns.get("load_kg")
    return load is not None and float(np.ptp(load)) > 0


@dataclass(frozen=True, eq=False)
class LoadedPlay(Effect):
    """-1/2 (g0 + g_load load) d_a e_a, load in kg: friction under a load winds the drive up before the slide follows.

    The third shape of lost_motion, and reported as such.
    """

    name = "lost_motion_loaded"
    diagnosis = ForDiagnosis(
        family="lost_motion",
        prior=Prior(share=0.3),
        shared_physics="play",
        shows_in=_loaded_play_shows_in,
    )
    per = "axis"
    about = About(
        cites="lost motion = friction over stiffness of the drive, friction = coefficient x weight; ISO 230-2:2014, 2.16",
        along_axis=True,
        gap_parameter="g0",
    )
    needs = ("sense_{axis}", "load_kg")
    axis: str = at("X", "linear or rotary axis that carries the load")
    g0: float = param(0.0, "um", "lost motion without load", typical=Typical(1 * UM, "as backlash", PLAY))
    g_load: float = param(
        0.0,
        "um/kg",
        "lost motion per mass carried",
        typical=Typical(0.01 * UM, "100 kg x 9.8 m/s^2 x friction 0.1 over 100 N/um = 1 um", PLAY / 100),
    )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        gap = self.g0 + self.g_load * run.column("load_kg")
        return motion(run, **{self.axis: -0.5 * gap * share_taken_up(run, self.axis)})
