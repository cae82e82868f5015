"""Screw pitch: a sine of the position."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.pitch import ScrewPitch


def _x(effect: ScrewPitch, *q: float) -> np.ndarray:
    return effect.error_motion(Run({"X": np.array(q)}, np.zeros((len(q), 3))))[:, 0]


def test_quarter_period():
    # 0.5 um sin(2 pi 2.5 / 10) = 0.5 um; half a period 0; three quarters -0.5 um
    assert _x(ScrewPitch("X", 0.5e-3, 0.0, 10.0), 2.5, 5.0, 7.5) == pytest.approx(
        [0.5e-3, 0.0, -0.5e-3], abs=1e-15
    )
    # cosine part -0.2 um: at 0 -0.2 um, at 5 mm +0.2 um
    assert _x(ScrewPitch("X", 0.0, -0.2e-3, 10.0), 0.0, 5.0) == pytest.approx([-0.2e-3, 0.2e-3], abs=1e-15)


def test_second_harmonic_peaks_twice_per_turn():
    # sin(2 x 2 pi q / 10) = 1 at q = 1.25 and 6.25 mm
    assert _x(ScrewPitch("X", 0.5e-3, 0.0, 10.0, harmonic=2), 1.25, 6.25) == pytest.approx(0.5e-3, abs=1e-15)


def test_period_must_be_positive():
    with pytest.raises(UsageError, match="must be positive"):
        ScrewPitch("X", 0.5e-3, 0.0, 0.0)
