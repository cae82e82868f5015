"""Ball screw pitch error: a sine of the position with the lead as period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class ScrewPitch(Effect):
    """(sine sin(h w q) + cosine cos(h w q)) e_a, w = 2 pi / period; h = 1 is once per turn of the screw."""

    name = "screw_pitch"
    per = "axis"
    about = About(
        cites="ISO 230-2; cyclic error of a screw, period = lead",
        words=Words(
            seen="{where} errs with a period of {period} ({amplitude})",
            causes="the screw, its bearing or a gear; compare with the lead",
            confirm="measure in steps of an eighth of the period over two periods",
        ),
        along_axis=True,
        aliases={"amplitude": "sine"},
    )
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change", "map_interpolation"),
    )
    axis: str = at("X", "linear axis")
    sine: float = param(
        0.0, "um", "sine part; `amplitude` in files", typical=Typical(1 * UM, "usual: 0.5-5 um once per turn")
    )
    cosine: float = param(0.0, "um", "cosine part", typical=Typical(1 * UM, "usual: 0.5-5 um once per turn"))
    period: float = param(
        10.0,
        "mm",
        "lead of the screw",
        scan=(2.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0),
        most=40.0,  # ISO 3408-2: the largest nominal lead
    )
    harmonic: int = at(1, "1 = once per turn of the screw, 2 = twice ...", quiet=True)

    def __post_init__(self) -> None:
        if not self.period > 0:
            raise UsageError(
                f'{self.id}: period = {self.period:g} mm must be positive; write for example period = "10 mm"'
            )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        phase = 2 * np.pi * self.harmonic / self.period * run.q(self.axis)
        return motion(run, **{self.axis: self.sine * np.sin(phase) + self.cosine * np.cos(phase)})
