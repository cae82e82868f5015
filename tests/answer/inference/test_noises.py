"""Ladders of noise in the residuals of a feature, by hand."""

from __future__ import annotations

import math

import numpy as np

from vcmm.answer.inference.noises import NONE, Noises, Rung


def test_rungs_of_touches_known_by_a_limit() -> None:
    """Residuals of 2^-8 mm. From a sixteenth of them, 2^-12, one rung to a doubling: n / 2 = -12, -11, -10; from the half of them, 2^-9, two.
    Two waves: chi-squared with 2 degrees of freedom lies below 1/4 with 1 - exp(-1/8), so three points end at 2^-8 sqrt(3 / (1/4)) = 2^-6.21, of which
    the next half power is 2^-6: n = -12.
    """
    nothing = np.zeros((2, 2))
    noises = Noises(machine=nothing, systematic=nothing, scatter=np.eye(2), points=3)
    rungs = noises.rungs(np.full(3, 2.0**-8), 1.0 - math.exp(-1 / 8))
    assert rungs == (tuple(Rung(NONE, n) for n in (-24, -22, -20, -18, -17, -16, -15, -14, -13, -12)),)
