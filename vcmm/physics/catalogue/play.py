"""Play that is no step: partly made up along a way after the reversal, or growing with what the axis carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import PLAY, UM, About, ChoosesColumns, ForDiagnosis, Prior, Typical
from vcmm.core.effect import Effect, at, declared_columns, motion, param, required
from vcmm.core.errors import UsageError
from vcmm.core.play import bends, share_taken_up
from vcmm.core.run import Array, Run

LONGEST = 3.0  # mm or rad: of the ways that are tried


def _backlash_ramp_shows_in(effect: BacklashRamp, run: Run) -> bool:
    """Return whether rows lie within the ways that are tried, and not at their ends only."""
    since = run.columns.get(required(effect)[1])
    return since is not None and len(np.unique(since[since < LONGEST])) > 2


def _bends(effect: BacklashRamp | PlayOperator, run: Run) -> bool:
    """Does the ramp end within the ways of the rows?"""
    if effect.required_columns()[1] not in run.columns:
        return True
    return bends(run, effect.axis, 1.0 - np.minimum(effect.way(run) / effect.distance, 1.0))


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
        shows_at=_bends,
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

    def required_columns(self) -> tuple[str, ...]:
        """Return the columns: rotary axes count the distance since reversal in rad."""
        columns = declared_columns(self)
        return columns if self.axis in "XYZ" else tuple(c.replace("_mm", "_rad") for c in columns)

    def way(self, run: Run) -> Array:
        """Return the distance since the last reversal (n,)."""
        return run.column(self.required_columns()[1])

    def error_motion(self, run: Run) -> Array:
        sense, since = share_taken_up(run, self.axis), self.way(run)
        gap = self.gap - self.ramp * np.minimum(since / self.distance, 1.0)
        return motion(run, **{self.axis: -0.5 * gap * sense})


def _play_operator_shows_in(effect: PlayOperator, run: Run) -> bool:
    """Return whether the axis turns round within the rows, and some rows lie on the way after it."""
    since = run.columns.get(effect.required_columns()[1])
    sense = run.columns.get(effect.required_columns()[0])
    if since is None or sense is None or not len(since):
        return False
    way = effect.way(run)
    return bool(np.isinf(way).any()) and len(np.unique(way[np.isfinite(way)])) > 2


@dataclass(frozen=True, eq=False)
class PlayOperator(Effect, ChoosesColumns):
    """-1/2 gap d_a (2 min(s / distance, 1) - 1) e_a: the slide stays on its side and comes over on the way after a reversal.

    The third shape of backlash, and reported as such: the play operator of a path. s is the distance since the last reversal; in a
    recording the slide has come over before the first one (s = inf), as column turned_X says. Rigid parts come over within distance = gap; where the drive also
    winds up the way is longer.
    """

    name = "backlash_operator"
    diagnosis = ForDiagnosis(
        family="backlash",
        shared_physics="play",
        shows_in=_play_operator_shows_in,
        shows_at=_bends,
    )
    per = "axis"
    about = About(
        cites="Krasnosel'skii & Pokrovskii, Systems with Hysteresis (1989), 2: the operator of play; ISO 230-2:2014, 2.16",
        along_axis=True,
    )
    needs = ("sense_{axis}", "since_reversal_{axis}_mm")
    axis: str = at("X", "linear or rotary axis")
    gap: float = param(0.0, "um", "lost motion", typical=Typical(1 * UM, "as backlash", PLAY))
    distance: float = param(
        0.01,
        "mm",
        "way on which the slide comes over",
        scan=(1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0),
    )

    def __post_init__(self) -> None:
        if not self.distance > 0:
            raise UsageError(f'{self.id}: distance must be positive; write for example distance = "0.1 mm"')

    @property
    def link(self) -> str:
        return self.axis

    def required_columns(self) -> tuple[str, ...]:
        """Return the columns: rotary axes count the distance since reversal in rad."""
        columns = declared_columns(self)
        return columns if self.axis in "XYZ" else tuple(c.replace("_mm", "_rad") for c in columns)

    def way(self, run: Run) -> Array:
        """Return the distance since the last reversal within the rows (n,), infinite before the first one."""
        since, turned = run.column(self.required_columns()[1]), run.columns.get(f"turned_{self.axis}")
        return since if turned is None else np.where(turned > 0, since, np.inf)

    def error_motion(self, run: Run) -> Array:
        over = 2.0 * np.minimum(self.way(run) / self.distance, 1.0) - 1.0
        return motion(run, **{self.axis: -0.5 * self.gap * share_taken_up(run, self.axis) * over})


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
