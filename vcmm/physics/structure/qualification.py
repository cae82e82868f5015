"""Stylus qualification: what is wrong with the qualified tip offset and radius, together.

Offset and radius come from one fit to the reference sphere and are correlated; one effect keeps them together.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Trade, Typical, WithResponse
from vcmm.core.effect import Effect, at, param
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class StylusQualification(Effect, WithResponse):
    """indicated - true = (d1, d2, d3) + d4 n: qualified minus actual offset, and actual minus qualified radius."""

    name = "stylus_qualification"
    about = About(
        cites="ISO 10360-5: stylus qualification on the reference sphere; Gaussian sphere fit",
        trade=Trade(
            "qualification of stylus {where}",
            "qualify stylus {where} with more touches, on a sphere with a better certificate",
        ),
    )
    per = "stylus"
    needs = ("nx", "ny", "nz")
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    stylus: str = at("", "stylus name; empty = all")
    d: Any = param(
        lambda: np.zeros(4),
        "um",
        "offset x y z and radius",
        shape="(4,)",
        typical=Typical(1 * UM, "qualification: 0.2-3 um"),
    )

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        d = np.asarray(self.d, dtype=float)
        out = np.zeros((run.n, 6))
        out[:, :3] = run.label_mask("stylus", self.stylus)[:, None] * (d[:3] + d[3] * run.normal)
        return out

    def response(self, name: str, run: Run) -> Array:
        out, mine = np.zeros((run.n, 6, 4)), run.label_mask("stylus", self.stylus)
        for i in range(3):
            out[:, i, i] = mine
        out[:, :3, 3] = mine[:, None] * run.normal
        return out
