"""Scale factor: an axis travels too far in proportion to its position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.declaration import About, ForDiagnosis, Opposite, Trade, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.kinematics import FULL_TURN
from vcmm.core.run import Array, Run


def _scale_factor_remark(effect: ScaleFactor, run: Run) -> str:
    if not is_rotary(effect.axis) or float(np.ptp(run.q(effect.axis))) <= FULL_TURN:
        return ""
    return (
        f"a saw over a full turn of {effect.axis}: after 360 degrees the axis is where it was, so this is no geometry but the"
        " gain or the wrap-around of the readout"
    )


@dataclass(frozen=True, eq=False)
class ScaleFactor(Effect):
    """k q_a e_a: with k = +5 um/m an axis at 400 mm is 2 um too far in + direction."""

    name = "scale_factor"
    about = About(
        cites="ISO 230-2; linear positioning error",
        trade=Trade("scale of {where}", "measure a step gauge or laser along {where} and correct it"),
        words=Words(
            seen="{where} travels too far in proportion to the distance ({k})",
            causes="a scale, a gain or a temperature that is not compensated",
            confirm="a step gauge or laser along {where}, at two temperatures",
            signed=("k",),
            opposite=Opposite("k", "{where} travels too short in proportion to the distance ({k})"),
        ),
        along_axis=True,
    )
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change", "map_interpolation"),
        shared_physics="geometry",
        is_uniform=True,
        remark=_scale_factor_remark,
    )
    per = "axis"
    axis: str = at("X", "linear axis")
    k: float = param(
        0.0,
        "um/m",
        "error per travelled length",
        typical=Typical(
            5e-6,
            "usual: scale or gain error 1-10 ppm; of an axis that turns 0.1-1 %, the gain of a potentiometer, resolver or step counter",
            1e-3,
        ),
    )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        return motion(run, **{self.axis: self.k * run.q(self.axis)})
