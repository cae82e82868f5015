"""The route of ISO 15530-3:2011: a calibrated part of the same kind, measured repeatedly in the same way as the other parts.

    b = mean of the repeats - calibrated value                systematic error, taken off every later reading
    U = k sqrt(u_cal^2 + u_p^2 + u_b^2 + u_w^2)               k = 2 from 20 repeats on

u_cal  of the calibration of the part
u_p    of the procedure: standard deviation of the repeats
u_b    of the systematic error: mean of n repeats u_p / sqrt(n), and |T - 20 degC| u_alpha L of the calibrated part
u_w    of the measured part: |T - 20 degC| u_alpha L, and what its form and roughness add from part to part
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vcmm.answer.routes.estimate import (
    PART_EXPANSION,
    READING,
    Contribution,
    RouteEstimate,
    coverage_factor,
    effective_dof,
)
from vcmm.core.errors import UsageError
from vcmm.core.run import T0_DEG_C, Array

METHOD = "calibrated part"
ISO_REPEATS, LEAST_REPEATS = 20, 2  # repeats that ISO 15530-3 asks for; without two there is no scatter


@dataclass(frozen=True)
class CalibratedValue:
    """Statement of the certificate of a part for one characteristic: value and u, mm or rad; from_part: u from part to part."""

    value: float
    u: float
    from_part: float = 0.0


@dataclass(frozen=True)
class Warmth:
    """temperature: of the part while it was measured, degC; u_alpha: of its expansion, 1/K; length: that expands, mm."""

    temperature: float = T0_DEG_C
    u_alpha: float = 0.0
    length: float = 0.0

    @property
    def u(self) -> float:
        """|T - 20 degC| u_alpha L, mm."""
        return abs(self.temperature - T0_DEG_C) * self.u_alpha * self.length


def calibrated_part(
    reading: float, repeats: Array, calibration: CalibratedValue, warmth: Warmth | None = None
) -> RouteEstimate:
    """Correct a reading of another part, mm or rad, by the error that the repeats (n,) of the calibrated part show.

    warmth: of both parts, which are of one material. UsageError for fewer than two repeats.
    """
    n = len(repeats)
    if n < LEAST_REPEATS:
        raise UsageError(
            f"{n} repeat of the calibrated part shows no scatter; ISO 15530-3 asks for {ISO_REPEATS}, and {LEAST_REPEATS} are the least"
        )
    u_p, heat = float(np.std(repeats, ddof=1)), (warmth or Warmth()).u
    contributions = (
        Contribution("calibration of the calibrated part", calibration.u),
        Contribution(READING, u_p, n - 1),
        Contribution("systematic error, mean of the repeats", u_p / math.sqrt(n), n - 1),
        Contribution("expansion of the calibrated part", heat),
        Contribution(PART_EXPANSION, heat),
        Contribution("form and roughness from part to part", calibration.from_part),
    )
    kept = tuple(c for c in contributions if c.u > 0 or c.name == READING)
    systematic = float(np.mean(repeats)) - calibration.value
    k, remarks = 2.0, []
    if n < ISO_REPEATS:
        k = coverage_factor(effective_dof(kept))
        remarks = [f"{n} repeats; ISO 15530-3 asks for {ISO_REPEATS}, so k is Student's {k:.2f} and not 2"]
    return RouteEstimate(METHOD, reading - systematic, kept, k, tuple(remarks))
