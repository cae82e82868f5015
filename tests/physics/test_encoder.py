"""vcmm/physics/catalogue/encoder.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.encoder import EncoderInterpolation


def _run(x: list[float], offset=(0.0, 0.0, 0.0), **columns: list[float]) -> Run:
    n = len(x)
    position = {"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(position, np.tile(offset, (n, 1)), {k: np.array(v) for k, v in columns.items()})


def test_encoder_interpolation_follows_the_raw_reading():
    # period 20 um: a quarter at 5 um; raw 5 um: sine = 0.1 um. Without raw the position 10.005 mm = 500.25 periods
    effect = EncoderInterpolation("X", 0.1e-3, 0.0, 0.02)
    assert machine(effect).tip_error(_run([77.0], raw_X_mm=[0.005]))[0, 0] == pytest.approx(0.1e-3, abs=1e-12)
    assert effect.error_motion(_run([10.005]))[0, 0] == pytest.approx(0.1e-3, abs=1e-12)
    # twice per period: at 5 um half a wave, cosine = -1
    twice = EncoderInterpolation("X", 0.0, 0.1e-3, 0.02, 2)
    assert twice.error_motion(_run([0.005]))[0, 0] == pytest.approx(-0.1e-3, abs=1e-12)
