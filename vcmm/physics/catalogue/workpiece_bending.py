"""The workpiece gives way to the cutting force: a thin wall, a part on a soft fixture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Site, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import FORCE_COLUMNS, Array, Run

AXES = "xyz"


def _workpiece_bending_make_at(
    cls: type[WorkpieceBending], place: Mapping[str, Any], site: Site
) -> WorkpieceBending:
    """Return the effect for a part whose lowest recorded point is taken as the foot of the wall."""
    along = site.run.part_point[:, AXES.index(str(place.get("over", "z")))]
    return cls(**place, foot=float(along.min()), height=float(np.ptp(along)))


@dataclass(frozen=True, eq=False)
class WorkpieceBending(Effect):
    """+compliance x force x (h / height)^3 along one direction, force = that of the part on the tool, workpiece axes.

    The part is pushed the other way and springs back when the tool has gone, so that material is left as with a tool that bends. h is
    the height of the place over the foot of a wall, at which it is clamped: a cantilever gives way at the place of the load
    by h^3 / 3 E I. With foot = height = 0 the part yields as a whole on a soft fixture, and the share is 1.
    """

    name = "workpiece_bending"
    per = "direction"
    needs = FORCE_COLUMNS
    about = About(
        cites="Budak & Altintas, Int. J. Mach. Tools Manuf. 35 (1995) 459: static deflection of thin plates in peripheral milling",
        words=Words(
            seen="the part gives way to the cutting force along {direction} ({compliance})",
            causes="thin walls, few or soft clamps",
            confirm="a spring pass; clamp closer to the cut",
        ),
        belongs_to="part",
        needs_cut=True,
    )
    diagnosis = ForDiagnosis(
        make_at=_workpiece_bending_make_at,
    )
    direction: str = at("x", "x, y or z of the workpiece as it lies on the machine: where it gives way")
    over: str = at("z", "coordinate along which the wall rises, workpiece axes", quiet=True)
    compliance: float = param(
        0.0,
        "um/N",
        "displacement per force at `height` over the foot",
        typical=Typical(
            0.05 * UM,
            "aluminium wall 30 mm high, 5 mm thick, 50 mm long: 30^3 / (3 x 7e4 x 521) mm/N = 0.25 um/N",
        ),
    )
    foot: float = 0.0
    height: float = 0.0

    def __post_init__(self) -> None:
        if self.direction not in AXES or self.over not in AXES:
            raise UsageError(f'{self.id}: direction and over must be "x", "y" or "z"')
        if self.height < 0.0:
            raise UsageError(
                f'{self.id}: height = {self.height:g} mm is negative; write for example height = "30 mm"'
            )

    @property
    def link(self) -> str:
        return "tip"

    def error_motion(self, run: Run) -> Array:
        share = np.ones(run.n)
        if self.height:
            share = np.maximum((run.part_point[:, AXES.index(self.over)] - self.foot) / self.height, 0.0) ** 3
        force = run.column(f"force_{self.direction}_N")
        return motion(run, **{self.direction.upper(): self.compliance * force * share})
