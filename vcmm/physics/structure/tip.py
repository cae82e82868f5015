"""The tip of a stylus beside what was qualified: its radius and its offset. Readings, indicated - true.

The stylus column of a run says which stylus was used; an effect with stylus = "" acts on every row.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Opposite, Trade, Typical, Words
from vcmm.core.effect import Effect, along, at, param
from vcmm.core.run import Array, Run

FAMILY = "probe"  # what an evaluation declares it with


@dataclass(frozen=True, eq=False)
class _Tip(Effect):
    per = "stylus"
    stylus: str = at("", "stylus name; empty = all")

    @property
    def link(self) -> str:
        return "reading"


@dataclass(frozen=True, eq=False)
class TipRadius(_Tip):
    """+dr along n, dr = actual - qualified radius: a ball larger than believed makes shafts larger, bores smaller."""

    name = "tip_radius"
    about = About(
        cites="ISO 10360-5: stylus tip qualification; geometry of a ball on a surface",
        trade=Trade("radius of the tip {where}", "clean and qualify the stylus again"),
        words=Words(
            seen="the tip is {dr} larger than qualified",
            causes="worn or dirty tip, or a bad qualification",
            confirm="clean and qualify again; touch a ring and a plug",
            opposite=Opposite("dr", "the tip is {dr} smaller than qualified"),
        ),
    )
    needs = ("nx", "ny", "nz")
    dr: float = param(
        0.0, "um", "actual minus qualified tip radius", typical=Typical(0.5 * UM, "qualification: 0.1-2 um")
    )

    def error_motion(self, run: Run) -> Array:
        return along(run, run.normal, self.dr * run.label_mask("stylus", self.stylus))


@dataclass(frozen=True, eq=False)
class TipOffset(_Tip):
    """The qualified tip offset is wrong by a vector: indicated = true + (qualified - actual offset)."""

    name = "tip_offset"
    about = About(
        cites="ISO 10360-5: stylus qualification; rigid shift of all touches of one stylus",
    )
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    d: Any = param(
        lambda: np.zeros(3),
        "um",
        "qualified minus actual offset, machine axes",
        shape="(3,)",
        typical=Typical(1 * UM, "qualification: 0.2-3 um"),
    )

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, :3] = run.label_mask("stylus", self.stylus)[:, None] * np.asarray(self.d, dtype=float)
        return out
