"""Rotary cyclic errors: harmonics of the angle, from an eccentric encoder, bearing or gear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.axes import axis_of, is_component, is_rotary
from vcmm.core.declaration import UM, URAD, About, ForDiagnosis, Typical, Words
from vcmm.core.effect import COLUMN, Effect, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class RotaryCyclic(Effect):
    """c1 cos(q) + c2 sin(q) + c3 cos(2 q) + c4 sin(2 q) ... in one component of a rotary axis, q its angle.

    ECC of axis C is its positioning error (eccentric encoder: once per turn), EXC and EYC its radial, EZC its axial
    motion, EAC and EBC its tilt. Own motion of the axis.
    """

    name = "rotary_cyclic"
    per = "component"
    own = True
    about = About(
        cites="ISO 230-1:2012 (error motions of rotary axes); ISO 230-7:2015 (Fourier analysis of error motion)",
        words=Words(
            seen="{where} errs once or a few times per turn ({amplitude})",
            causes="eccentric encoder, bearing or gear",
            confirm="compare at angles 180 degrees apart",
        ),
        aliases={"amplitude": "coefficients"},
    )
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change",),
        size_name="amplitude",
    )
    component: str = at("ECC", "component error of a rotary axis, for example ECC, EXC, EAC")
    coefficients: Any = param(
        lambda: np.zeros(2), "mm or rad", "cosine and sine of each harmonic, in turn; `amplitude` in files",
        shape="(powers,)", typical=Typical(5 * UM, "five-axis machines: 1-20 um, 5-50 urad", 10 * URAD), lengths=(2, 4, 8)
    )  # fmt: skip

    def __post_init__(self) -> None:
        c = self.component
        if not (is_component(c) and is_rotary(axis_of(c))):
            raise UsageError(
                f'component = "{c}" is not a component error of a rotary axis; write for example "ECC" or "EXC"'
            )

    @property
    def link(self) -> str:
        return axis_of(self.component)

    def error_motion(self, run: Run) -> Array:
        q, c = run.q(self.link), np.asarray(self.coefficients, dtype=float)
        waves = [np.sin(k // 2 * q + q) if k % 2 else np.cos(k // 2 * q + q) for k in range(len(c))]
        out = np.zeros((run.n, 6))
        out[:, COLUMN[self.component[1]]] = np.stack(waves, axis=1) @ c
        return out
