"""Gravity flexure: a head, ram or tube that turns sags differently in every attitude."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.declaration import URAD, About, ForDiagnosis, Site, Typical, Words
from vcmm.core.effect import Effect, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

DOWN = ("down_x", "down_y", "down_z")


def _gravity_flexure_make_at(
    cls: type[GravityFlexure], place: Mapping[str, Any], site: Site
) -> GravityFlexure:
    if not any(is_rotary(axis) for axis in site.tool):
        raise UsageError("without a head that turns its attitude is always the same")
    return cls(**place)


@dataclass(frozen=True, eq=False)
class GravityFlexure(Effect):
    """The tool turns towards the ground by angle x sin z, z the angle between tool and vertical; the tip goes with it.

    In the frame of the last tool-side axis a is the unit vector along the offset and g gravity (down_x, down_y, down_z):
    turn = angle a x g, shift = turn x offset. A tool without an offset has no attitude and does not move.
    """

    name = "gravity_flexure"
    per = "tool_head"
    needs = DOWN
    about = About(
        cites="Wallace, Proc. SPIE 4848 (2002) 125: tube flexure in proportion to the sine of the zenith distance; "
        "a beam under the lateral share of its own weight",
        words=Words(
            seen="the head sags by {angle} when it lies level",
            causes="weight of head, tool or tube on its bearing",
            confirm="the same place or target with the head turned over",
        ),
    )
    diagnosis = ForDiagnosis(
        make_at=_gravity_flexure_make_at,
    )
    angle: float = param(
        0.0,
        "urad",
        "turn of a level tool towards the ground",
        typical=Typical(20 * URAD, "a head of 0.3 m that sags 5 um; steel tubes of 1 m 20-300 urad"),
    )

    @property
    def link(self) -> str:
        return "tool"

    def error_motion(self, run: Run) -> Array:
        length = np.linalg.norm(run.offset, axis=1)
        along = run.offset / np.where(length > 0, length, 1.0)[:, None]
        turn = self.angle * np.cross(along, run.vector(*DOWN))
        return np.concatenate([np.cross(turn, run.offset), turn], axis=1)
