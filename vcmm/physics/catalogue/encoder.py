"""Encoder interpolation: the scale's signals are no pure sine and cosine, so each period is divided unequally."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


def _encoder_interpolation_remark(effect: EncoderInterpolation, run: Run) -> str:
    """Return the remark that the second wave of one period is the first of half of it: a recording knows the wave only."""
    if effect.harmonic < 2:
        return ""
    wave = effect.period / effect.harmonic
    return (
        f"a wave of {wave:.4g} mm: unequal gains of signals of {effect.period:.4g} mm, or offsets of signals of {wave:.4g} mm;"
        " the data sheet of the scale decides"
    )


@dataclass(frozen=True, eq=False)
class EncoderInterpolation(Effect):
    """(sine sin(h w r) + cosine cos(h w r)) e_a, w = 2 pi / period, r the raw reading of the scale.

    r is the column raw_X_mm (raw_C_rad); where it is absent the position. h = 1: offsets of the two signals; h = 2:
    unequal amplitudes or a phase that is not 90 degrees.
    """

    name = "encoder_interpolation"
    per = "axis"
    about = About(
        cites="Heydemann, Applied Optics 20 (1981) 3382: quadrature signals with offsets and unequal gains",
        words=Words(
            seen="the scale of {where} errs within its signal period of {period} ({amplitude})",
            causes="offset or unequal gain of the encoder signals; dirt",
            confirm="a slow scan over 0.1 mm, raw counts logged",
        ),
        along_axis=True,
        aliases={"amplitude": "sine"},
    )
    diagnosis = ForDiagnosis(
        special_case_of=("map_interpolation",),
        follows_raw_scale=True,
        remark=_encoder_interpolation_remark,
    )
    axis: str = at("X", "axis with a scale")
    sine: float = param(
        0.0,
        "um",
        "sine part; `amplitude` in files",
        typical=Typical(0.1 * UM, "0.2-1 % of the signal period: 40-200 nm at 20 um"),
    )
    cosine: float = param(
        0.0,
        "um",
        "cosine part",
        typical=Typical(0.1 * UM, "0.2-1 % of the signal period: 40-200 nm at 20 um"),
    )
    period: float = param(
        0.02,
        "mm",
        "signal period of the scale",
        scan=(0.004, 0.008, 0.016, 0.02, 0.04, 0.1, 0.2, 0.5, 1.0, 2.0),
    )
    harmonic: int = at(
        1, "1 = offsets of the signals, 2 = unequal amplitudes or phase", quiet=True, tries=(1, 2)
    )

    def __post_init__(self) -> None:
        if not self.period > 0:
            raise UsageError(
                f'{self.id}: period = {self.period:g} mm must be positive; write for example period = "20 um"'
            )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        raw = run.columns.get(f"raw_{self.axis}_{'mm' if self.axis in 'XYZ' else 'rad'}")
        phase = 2 * np.pi * self.harmonic / self.period * (run.q(self.axis) if raw is None else raw)
        return motion(run, **{self.axis: self.sine * np.sin(phase) + self.cosine * np.cos(phase)})
