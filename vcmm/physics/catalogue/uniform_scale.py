"""Uniform scale: all axes travel too far by one share, because everything is warmer than it is taken to be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import LINEAR
from vcmm.core.declaration import About, ForDiagnosis, Opposite, Prior, Trade, Typical, Words
from vcmm.core.effect import Effect, param
from vcmm.core.run import Array, Run

LEAST_TRAVEL_MM = 1.0  # mm: an axis that moves less shows no scale


def _uniform_scale_shows_in(effect: UniformScale, run: Run) -> bool:
    moved = [a for a in LINEAR if a in run.position and float(np.ptp(run.position[a])) > LEAST_TRAVEL_MM]
    warm = [c for c in run.columns if c.startswith(("temp_part", "temp_scale"))]
    return len(moved) > 1 and not warm


@dataclass(frozen=True, eq=False)
class UniformScale(Effect):
    """k (q_x, q_y, q_z): with k = +5 um/m a place at (400, 200, 0) mm is reached 2 um and 1 um too far.

    The second shape of scale_factor, and reported as such, without an axis: one number where a temperature, a coefficient of
    expansion or a unit is wrong for all scales or for the part. A recording with thermometers of part or scales has names for
    that, and needs none of this.
    """

    name = "uniform_scale"
    about = About(
        cites="JCGM 100:2008, H.1: one temperature for all lengths; ISO 1 (20 degC)",
        trade=Trade("one scale of all axes", "log the temperatures of part and scales"),
        words=Words(
            seen="all axes travel too far in proportion to the distance ({k})",
            causes="machine or part was warmer or colder than taken, or a wrong coefficient of expansion",
            confirm="log the temperatures of part and scales, and measure again 2 K apart",
            signed=("k",),
            opposite=Opposite("k", "all axes travel too short in proportion to the distance ({k})"),
        ),
    )
    diagnosis = ForDiagnosis(
        family="scale_factor",
        # beside the scale of one axis it is that of another in disguise: 3 nats, beyond what a swap must win
        prior=Prior(share=0.05),
        is_uniform=True,
        shows_in=_uniform_scale_shows_in,
    )
    per = "machine"
    k: float = param(
        0.0,
        "um/m",
        "error per length, the same along X, Y and Z",
        typical=Typical(10e-6, "1 K of steel is 11.5 um/m"),
    )

    @property
    def link(self) -> str:
        return "command"

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        for i, axis in enumerate(LINEAR):
            if axis in run.position:
                out[:, i] = self.k * run.position[axis]
        return out
