"""Gravity flexure: a head, ram or tube that turns sags differently in every attitude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.effect import Effect, param
from vcmm.core.run import Array, Run

DOWN = ("down_x", "down_y", "down_z")


@dataclass(frozen=True, eq=False)
class GravityFlexure(Effect):
    """The tool turns towards the ground by angle x sin z, z the angle between tool and vertical; the tip goes with it.

    In the frame of the last tool-side axis a is the unit vector along the offset and g gravity (down_x, down_y, down_z):
    turn = angle a x g, shift = turn x offset. A tool without an offset has no attitude and does not move.
    """

    name = "gravity_flexure"
    per = "tool_head"
    needs = DOWN
    cites = (
        "Wallace, Proc. SPIE 4848 (2002) 125: tube flexure in proportion to the sine of the zenith distance; "
        "a beam under the lateral share of its own weight"
    )
    angle: float = param(0.0, "urad", "turn of a level tool towards the ground")

    @property
    def link(self) -> str:
        return "tool"

    def error_motion(self, run: Run) -> Array:
        length = np.linalg.norm(run.offset, axis=1)
        along = run.offset / np.where(length > 0, length, 1.0)[:, None]
        turn = self.angle * np.cross(along, run.vector(*DOWN))
        return np.concatenate([np.cross(turn, run.offset), turn], axis=1)
