"""Backlash: an axis stops short of its target by half the lost motion, on the side it came from."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.declaration import PLAY, UM, About, ForDiagnosis, Opposite, Trade, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.play import share_taken_up
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class Backlash(Effect):
    """-1/2 gap d_a e_a with d_a = +1 or -1 the direction in which the axis last moved (ISO 230-2: B = -gap)."""

    name = "backlash"
    about = About(
        cites="ISO 230-2:2014, 2.16 reversal error B = mean(up) - mean(down)",
        trade=Trade("backlash of {where}", "approach from one side, or compensate the reversal"),
        words=Words(
            seen="{where} stops {gap} short after reversing",
            causes="wear of the {where} nut or belt, or a low preload",
            confirm="approach one place from both sides, at equal speed",
            opposite=Opposite(
                "gap",
                "{where} stops {gap} too far after reversing",
                causes="a reversal compensation that is set too large, or a sign",
                confirm="approach one place from both sides with the compensation switched off",
                rare="goes too far after reversing",
            ),
        ),
        along_axis=True,
        gap_parameter="gap",
    )
    diagnosis = ForDiagnosis(
        special_case_of=("lost_motion", "hysteresis", "lost_motion_speed"),
        shared_physics="play",
        is_uniform=True,
    )
    per = "axis"
    needs = ("sense_{axis}",)
    axis: str = at("X", "linear or rotary axis")
    gap: float = param(
        0.0,
        "um",
        "lost motion on reversal",
        typical=Typical(1 * UM, "usual: CMM 0.1-0.5, machine tool 1-10 um", PLAY),
    )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        return motion(run, **{self.axis: -0.5 * self.gap * share_taken_up(run, self.axis)})
