"""Encoder harmonics: the shape of an unequal division within one signal period, as one sum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Typical
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class EncoderHarmonics(Effect):
    """Sum over h of (c_2h-1 cos(h w r) + c_2h sin(h w r)) e_a, w = 2 pi / period, r the raw reading of the scale.

    The second shape of encoder_interpolation, and reported as such: offsets (h = 1), unequal gains (2) and saturation (3, 4) of
    one pair of signals are one fault of one encoder, and not four. r as in encoder_interpolation.
    """

    name = "encoder_harmonics"
    diagnosis = ForDiagnosis(
        family="encoder_interpolation",
        size_name="amplitude",
        follows_raw_scale=True,
    )
    per = "axis"
    about = About(
        cites="Heydemann, Applied Optics 20 (1981) 3382; harmonics of the signals themselves add orders 3 and 4",
        along_axis=True,
        aliases={"amplitude": "coefficients"},
    )
    axis: str = at("X", "linear axis with a scale")
    coefficients: Any = param(
        lambda: np.zeros(4), "um", "cosine and sine of each harmonic, in turn; `amplitude` in files", shape="(powers,)",
        typical=Typical(0.1 * UM, "as encoder_interpolation"), lengths=(4, 8),
    )  # fmt: skip
    period: float = param(
        0.02,
        "mm",
        "signal period of the scale",
        scan=(0.004, 0.008, 0.016, 0.02, 0.04, 0.1, 0.2, 0.5, 1.0, 2.0),
    )

    def __post_init__(self) -> None:
        if not self.period > 0:
            raise UsageError(
                f'{self.id}: period = {self.period:g} mm must be positive; write for example period = "20 um"'
            )
        if np.size(self.coefficients) % 2:
            raise UsageError(
                f"{self.id}: {np.size(self.coefficients)} coefficients; cosine and sine go together"
            )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        raw = run.columns.get(f"raw_{self.axis}_mm")
        r, c = run.q(self.axis) if raw is None else raw, np.asarray(self.coefficients, dtype=float)
        order = np.arange(len(c)) // 2 + 1
        phase = 2 * np.pi / self.period * r[:, None] * order
        waves = np.where(np.arange(len(c)) % 2 == 0, np.cos(phase), np.sin(phase))
        return motion(run, **{self.axis: waves @ c})
