"""Digits: the error of a point from the rounding of its written coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Trade, Typical
from vcmm.core.effect import Effect, along, param
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class Resolution(Effect):
    """A departure of one reading along n, by the rounding of its coordinates: half a step at most along an axis.

    The roundings of x, y and z are independent and have the variance a^2 / 12 each (a: step); along any unit vector n that is
    (nx^2 + ny^2 + nz^2) a^2 / 12 = a^2 / 12, the variance of a uniform law of half width a / 2.
    """

    name = "resolution"
    about = About(
        cites="JCGM 100:2008, F.2.2.1 (resolution of a digital indication)",
        trade=Trade("resolution of the display", "read with more digits"),
        is_random=True,
    )
    per = "machine"
    needs = ("nx", "ny", "nz")
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    value: float = param(
        0.0,
        "um",
        "departure of the reading along n",
        typical=Typical(0.05 * UM, "files of measuring software: 0.1 um; rounded ones 1-10 um"),
    )

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        return along(run, run.normal, np.full(run.n, self.value))
