"""Workpiece heating: what is cut warm is too small when it is cold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import HOUR, About, Trade, Typical, Words
from vcmm.core.effect import Effect, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class WorkpieceHeating(Effect):
    """-k t p, p from the part's origin, t = time_s: k = alpha x heating rate; after cooling the part is too small.

    With tau the part comes to rest with the air: t is replaced by tau (1 - exp(-t / tau)); 0 = it warms for ever.
    """

    name = "workpiece_heating"
    about = About(
        cites="Bryan, CIRP Annals 39 (1990) 645: international status of thermal error research",
        trade=Trade("heating of the part while it is cut", "measure after cooling, or cut with a pause"),
        words=Words(
            seen="the part grows while it is cut ({k})",
            causes="heat of cutting",
            confirm="measure again after cooling; cut with a pause",
        ),
        belongs_to="part",
        needs_cut=True,  # heat of cutting
        on_cut_part="stated",
    )
    per = "part"
    needs = ("time_s",)
    k: float = param(
        0.0,
        "um/(m h)",
        "strain per cutting time",
        typical=Typical(20e-6 / HOUR, "steel 11.5 um/(m K) at 1-3 K in an hour of cutting"),
    )
    tau: float = param(0.0, "s", "time constant of the part, 0 = none", scan=(600.0, 1800.0, 3600.0, 10800.0))

    def __post_init__(self) -> None:
        if self.tau < 0:
            raise UsageError(f"workpiece_heating: tau = {self.tau:g} s is negative; leave it out for none")

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        time = run.column("time_s")
        warm = -self.tau * np.expm1(-time / self.tau) if self.tau else time
        x, y, z = run.part_point.T * (-self.k * warm)
        return motion(run, X=x, Y=y, Z=z)
