"""Backlash: sign and size of the reversal."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import parameter_fields, typical
from vcmm.core.run import Run
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.play import BacklashRamp
from vcmm.physics.catalogue.reversal import Hysteresis, LostMotion, ReversalSpike


def _run(sense: list[float]) -> Run:
    n = len(sense)
    return Run({a: np.zeros(n) for a in "XYZ"}, np.zeros((n, 3)), {"sense_X": np.array(sense)})


def test_half_the_gap_behind_the_direction_of_motion():
    # -1/2 x 1.2 um x (+1) = -0.6 um; moving down +0.6 um; never moved: nothing
    error = machine(Backlash("X", 1.2e-3)).tip_error(_run([1.0, -1.0, 0.0]))
    assert error[:, 0] == pytest.approx([-0.6e-3, 0.6e-3, 0.0], abs=1e-15)
    assert np.all(error[:, 1:] == 0.0)


def test_reversal_error_of_iso_230_2_is_minus_the_gap():
    # B = mean(up) - mean(down) = -0.6 - (+0.6) = -1.2 um
    up, down = machine(Backlash("X", 1.2e-3)).tip_error(_run([1.0, -1.0]))[:, 0]
    assert up - down == pytest.approx(-1.2e-3, abs=1e-15)


@pytest.mark.parametrize("effect", [Backlash, BacklashRamp, Hysteresis, LostMotion, ReversalSpike])
def test_play_of_an_axis_that_turns_is_an_angle(effect):
    """5-30 arcsec are 24-145 urad; 1 um taken for 1e-3 rad would be 206 arcsec."""
    (name,) = {"gap", "amplitude", "g0", "height"} & {f.name for f in parameter_fields(effect)}
    assert typical(effect("C"), name) == pytest.approx(50e-6)
    assert typical(effect("Y"), name) >= 1e-3
