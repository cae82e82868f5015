"""vcmm/physics/catalogue/encoder_harmonics.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.encoder_harmonics import EncoderHarmonics


def one_row(position=(0.0, 0.0, 0.0), **columns: float) -> Run:
    named = {k: np.array([v]) for k, v in columns.items()}
    return Run({a: np.array([q]) for a, q in zip("XYZ", position)}, np.zeros((1, 3)), named)


def test_harmonics_of_a_scale():
    # r = 5 um of a period of 20 um is a quarter turn: cos 0, sin 1; twice it: cos -1, sin 0
    # 1 x 0 + 2 x 1 + 3 x (-1) + 4 x 0 = -1 um
    effect = EncoderHarmonics("X", np.array([1e-3, 2e-3, 3e-3, 4e-3]), 0.02)
    assert effect.error_motion(one_row((0.005, 0, 0)))[0, 0] == pytest.approx(-1e-3, abs=1e-15)
    raw = one_row((7.7, 0, 0), raw_X_mm=0.005)
    assert effect.error_motion(raw)[0, 0] == pytest.approx(-1e-3, abs=1e-15)
    with pytest.raises(UsageError, match="go together"):
        EncoderHarmonics("X", np.zeros(3))
