"""Reversal: lost motion that depends on the place, hysteresis, and the spike when an axis turns round.

d_a is the direction in which the axis last moved (0 where it is not known), s the distance since its last reversal.
Friction holds an axis back, so all three are negative along the new direction, as backlash is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.declaration import (
    PLAY,
    UM,
    About,
    ChoosesColumns,
    ForDiagnosis,
    Opposite,
    Trade,
    Typical,
    Words,
)
from vcmm.core.effect import Effect, at, choice, declared_columns, motion, param, required
from vcmm.core.errors import UsageError
from vcmm.core.play import bends, share_taken_up
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class _Reversal(Effect, ChoosesColumns):
    per = "axis"
    about = About(
        along_axis=True,
    )
    axis: str = at("X", "linear or rotary axis")

    @property
    def link(self) -> str:
        return self.axis

    def required_columns(self) -> tuple[str, ...]:
        """Return the columns: rotary axes count the distance since reversal in rad."""
        columns = declared_columns(self)
        return columns if self.axis in "XYZ" else tuple(c.replace("_mm", "_rad") for c in columns)

    def _since(self, run: Run) -> Array:
        return run.column(required(self)[1])


def _check_distance(effect: Effect, distance: float) -> None:
    if not distance > 0:
        raise UsageError(f'{effect.id}: distance must be positive; write for example distance = "0.1 mm"')


@dataclass(frozen=True, eq=False)
class LostMotion(_Reversal):
    """-1/2 (g0 + g1 q_a) d_a e_a: backlash that changes along the travel (wind-up of a screw, unequal wear)."""

    name = "lost_motion"
    about = replace(
        _Reversal.about,
        cites="ISO 230-2:2014, 2.16 reversal error at each position; wind-up of a screw held at one end",
        trade=Trade("lost motion of {where}", "approach from one side, or compensate the reversal"),
        words=Words(
            seen="{where} stops short after reversing, by a gap that changes along the axis ({g0} at zero, {g1})",
            causes="wind-up of the screw, or a nut worn unevenly",
            confirm="approach five places of {where} from both sides",
            signed=("g0", "g1"),
            opposite=Opposite(
                "g0",
                "{where} stops too far after reversing, by an amount that changes along the axis ({g0} at zero, {g1})",
                causes="a reversal compensation that is set too large, or a sign",
                confirm="approach five places of {where} from both sides with the compensation switched off",
            ),
        ),
        gap_parameter="g0",
    )
    diagnosis = ForDiagnosis(
        special_case_of=("hysteresis",),
        shared_physics="play",
    )
    needs = ("sense_{axis}",)
    axis: str = at("X", "linear axis")
    g0: float = param(0.0, "um", "lost motion at zero", typical=Typical(1 * UM, "as backlash", PLAY))
    g1: float = param(
        0.0,
        "um/m",
        "lost motion per travelled length",
        typical=Typical(
            4e-6, "usual: wind-up 1-10 um over 1 m; short worn screws 10 um over 10 mm", most=2e-3
        ),
    )

    def error_motion(self, run: Run) -> Array:
        gap = self.g0 + self.g1 * run.q(self.axis)
        return motion(run, **{self.axis: -0.5 * gap * share_taken_up(run, self.axis)})


def _bends(effect: Hysteresis | ReversalSpike, run: Run) -> bool:
    """Does the course after a reversal bend within the ways of the rows?"""
    if effect.required_columns()[1] not in run.columns:
        return True
    return bends(run, effect.axis, effect.remaining_share(run))


@dataclass(frozen=True, eq=False)
class Hysteresis(_Reversal):
    """-amplitude d_a (1 - 2 exp(-s / distance)) e_a: from +amplitude at a reversal to -amplitude far from it.

    Dahl's friction against a spring. Far from reversals it is a backlash with gap = 2 amplitude; only the way there
    tells them apart.
    """

    name = "hysteresis"
    diagnosis = ForDiagnosis(
        shared_physics="play",
        shows_at=_bends,
    )
    needs = ("sense_{axis}", "since_reversal_{axis}_mm")
    about = replace(
        _Reversal.about,
        cites="Dahl, A solid friction model, Aerospace Corporation TOR-0158(3107-18)-1 (1968)",
        words=Words(
            seen="{where} settles only after some way past a reversal ({amplitude})",
            causes="friction of guides or seals, elastic drive",
            confirm="reverse with several path lengths and compare",
        ),
    )
    amplitude: float = param(
        0.0, "um", "half the width of the loop", typical=Typical(1 * UM, "usual: 0.2-3 um", PLAY)
    )
    distance: float = param(
        0.5, "mm", "distance over which friction turns round", scan=(0.02, 0.1, 0.5, 2.0, 10.0, 50.0)
    )

    def __post_init__(self) -> None:
        _check_distance(self, self.distance)

    def remaining_share(self, run: Run) -> Array:
        """Return the share (n,) of the loop that is not yet gone through."""
        return np.exp(-self._since(run) / self.distance)

    def error_motion(self, run: Run) -> Array:
        loop = 1 - 2 * self.remaining_share(run)
        return motion(run, **{self.axis: -self.amplitude * run.column(f"sense_{self.axis}") * loop})


@dataclass(frozen=True, eq=False)
class ReversalSpike(_Reversal):
    """-height d_a pulse(s) e_a: for a moment after a reversal the axis sticks behind its command.

    exponential: exp(-s / distance), highest at once;   gamma: (s / distance) exp(1 - s / distance), which rises to
    the height at s = distance and falls again.
    """

    name = "reversal_spike"
    diagnosis = ForDiagnosis(shows_at=_bends)
    needs = ("sense_{axis}", "since_reversal_{axis}_mm")
    about = replace(
        _Reversal.about,
        cites="ISO 230-4:2022 circular tests; Armstrong-Helouvry et al., Automatica 30 (1994) 1083 (friction at reversal)",
        words=Words(
            seen="{where} sticks and jumps at reversals ({height})",
            causes="friction that the control does not compensate",
            confirm="a circular test at two feeds and two radii",
        ),
    )
    height: float = param(
        0.0, "um", "height of the pulse", typical=Typical(3 * UM, "ball bar: 1-15 um over 0.1-1 mm", PLAY)
    )
    distance: float = param(0.3, "mm", "length of the pulse", scan=(0.03, 0.1, 0.3, 1.0, 3.0))
    shape: str = choice("gamma", ("gamma", "exponential"))

    def __post_init__(self) -> None:
        _check_distance(self, self.distance)
        if self.shape not in ("exponential", "gamma"):
            raise UsageError(f'{self.id}: shape = "{self.shape}" must be "exponential" or "gamma"')

    def remaining_share(self, run: Run) -> Array:
        """Return the pulse (n,)."""
        x = self._since(run) / self.distance
        return np.exp(-x) if self.shape == "exponential" else x * np.exp(1 - x)

    def error_motion(self, run: Run) -> Array:
        return motion(
            run, **{self.axis: -self.height * run.column(f"sense_{self.axis}") * self.remaining_share(run)}
        )
