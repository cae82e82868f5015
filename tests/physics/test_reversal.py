"""vcmm/physics/catalogue/reversal.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import required
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.dynamics import DynamicPitch, StructuralVibration
from vcmm.physics.catalogue.encoder import EncoderInterpolation
from vcmm.physics.catalogue.reversal import Hysteresis, LostMotion, ReversalSpike
from vcmm.physics.structure.rotary import RotaryCyclic


def _run(x: list[float], offset=(0.0, 0.0, 0.0), **columns: list[float]) -> Run:
    n = len(x)
    position = {"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(position, np.tile(offset, (n, 1)), {k: np.array(v) for k, v in columns.items()})


def test_lost_motion_depends_on_the_place():
    # gap 1 um + 4 um/m x 0.25 m = 2 um: -1 um moving up, +1 um moving down
    error = machine(LostMotion("X", 1e-3, 4e-6)).tip_error(_run([250.0, 250.0], sense_X=[1.0, -1.0]))
    assert error[:, 0] == pytest.approx([-1e-3, 1e-3], abs=1e-15)


def test_hysteresis_turns_round_after_a_reversal():
    # amplitude 1 um, moving up: +1 at the reversal, -(1 - 2/e) = -0.264241 after one distance, -1 far from it
    run = _run([0.0] * 3, sense_X=[1.0] * 3, since_reversal_X_mm=[0.0, 0.5, 50.0])
    error = machine(Hysteresis("X", 1e-3, 0.5)).tip_error(run)[:, 0]
    assert error == pytest.approx([1e-3, -0.264241e-3, -1e-3], abs=1e-9)
    # what it was before the reversal, moving down, far from the last one: no jump
    before = _run([0.0], sense_X=[-1.0], since_reversal_X_mm=[50.0])
    assert Hysteresis("X", 1e-3, 0.5).error_motion(before)[0, 0] == pytest.approx(error[0], abs=1e-15)


def test_reversal_spike_has_two_shapes():
    # behind the new direction. gamma: 0, then -3 um at the distance, -3 x 2/e = -2.207277 at twice it
    run = _run([0.0] * 4, sense_X=[1.0, 1.0, 1.0, -1.0], since_reversal_X_mm=[0.0, 0.3, 0.6, 0.3])
    gamma = machine(ReversalSpike("X", 3e-3, 0.3)).tip_error(run)[:, 0]
    assert gamma == pytest.approx([0.0, -3e-3, -2.207277e-3, 3e-3], abs=1e-9)
    # exponential: -3 at once, -3/e = -1.103638, -3/e^2 = -0.406006
    sharp = ReversalSpike("X", 3e-3, 0.3, "exponential").error_motion(run)[:, 0]
    assert sharp == pytest.approx([-3e-3, -1.103638e-3, -0.406006e-3, 1.103638e-3], abs=1e-9)


def test_reversal_of_a_rotary_axis_counts_in_rad():
    columns = {"sense_C": np.array([1.0]), "since_reversal_C_rad": np.array([0.3])}
    run = Run({"C": np.zeros(1)}, np.zeros((1, 3)), columns)
    assert required(ReversalSpike("C", 5e-6, 0.3)) == ("sense_C", "since_reversal_C_rad")
    assert ReversalSpike("C", 5e-6, 0.3).error_motion(run)[0, 5] == pytest.approx(-5e-6, abs=1e-15)


def test_words_are_checked():
    with pytest.raises(UsageError, match='"exponential" or "gamma"'):
        ReversalSpike("X", shape="square")
    with pytest.raises(UsageError, match="distance must be positive"):
        Hysteresis("X", distance=0.0)
    with pytest.raises(UsageError, match="period = 0 mm must be positive"):
        EncoderInterpolation("X", period=0.0)
    with pytest.raises(UsageError, match='must be "X", "Y" or "Z"'):
        DynamicPitch("C")
    with pytest.raises(UsageError, match="frequency must be positive"):
        StructuralVibration("X", frequency=0.0)
    with pytest.raises(UsageError, match="not a component error of a rotary axis"):
        RotaryCyclic("EXX")


def test_an_angle_that_is_read_late_runs_ahead_of_the_axis():
    from vcmm.core.run import Run
    from vcmm.physics.catalogue.lag import RotaryReadoutDelay

    n = np.zeros(3)
    speed = np.array([0.5, -0.5, 0.0])
    run = Run({"C": n}, np.zeros((3, 3)), {"speed_C_rad_s": speed})
    # 34 ms at 0.5 rad/s: 17 mrad behind what is read, nothing at rest
    assert RotaryReadoutDelay("C", 34e-3).error_motion(run)[:, 5] == pytest.approx([-0.017, 0.017, 0.0])
    with pytest.raises(UsageError, match="rotary"):
        RotaryReadoutDelay("X")
