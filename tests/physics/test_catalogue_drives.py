"""Drives, scales and motion: reversal, interpolation of scales, lag, pitch and ringing, cyclic errors of rotary axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import required
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.dynamics import DynamicPitch, StructuralVibration
from vcmm.physics.catalogue.encoder import EncoderInterpolation
from vcmm.physics.catalogue.lag import ReadoutDelay, ServoLag
from vcmm.physics.catalogue.reversal import Hysteresis, LostMotion, ReversalSpike
from vcmm.physics.catalogue.reversal_curve import LostMotionCurve
from vcmm.physics.structure.rotary import RotaryCyclic


def _run(x: list[float], offset=(0.0, 0.0, 0.0), **columns: list[float]) -> Run:
    n = len(x)
    position = {"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(position, np.tile(offset, (n, 1)), {k: np.array(v) for k, v in columns.items()})


def test_lost_motion_depends_on_the_place():
    # gap 1 um + 4 um/m x 0.25 m = 2 um: -1 um moving up, +1 um moving down
    error = machine(LostMotion("X", 1e-3, 4e-6)).tip_error(_run([250.0, 250.0], sense_X=[1.0, -1.0]))
    assert error[:, 0] == pytest.approx([-1e-3, 1e-3], abs=1e-15)


def test_lost_motion_may_change_sign_along_the_travel():
    # nodes 0 and 200 mm: s = (2 q - 200) / 200 = -1, 0, 1 at 0, 100, 200 mm. P2 = (3 s^2 - 1) / 2 = 1, -0.5, 1.
    # gap = 1 um + 10 um/m q + 8 um P2 = 9, 1 + 1 - 4 = -2, 1 + 2 + 8 = 11 um; moving up the error is -gap / 2
    effect = LostMotionCurve("X", np.array([0.0, 200.0]), 1e-3, 10e-6, np.array([8e-3]))
    assert effect.gap(np.array([0.0, 100.0, 200.0])) == pytest.approx([9e-3, -2e-3, 11e-3], abs=1e-15)
    error = machine(effect).tip_error(_run([0.0, 100.0, 200.0], sense_X=[1.0] * 3))
    assert error[:, 0] == pytest.approx([-4.5e-3, 1e-3, -5.5e-3], abs=1e-15)


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


def test_encoder_interpolation_follows_the_raw_reading():
    # period 20 um: a quarter at 5 um; raw 5 um: sine = 0.1 um. Without raw the position 10.005 mm = 500.25 periods
    effect = EncoderInterpolation("X", 0.1e-3, 0.0, 0.02)
    assert machine(effect).tip_error(_run([77.0], raw_X_mm=[0.005]))[0, 0] == pytest.approx(0.1e-3, abs=1e-12)
    assert effect.error_motion(_run([10.005]))[0, 0] == pytest.approx(0.1e-3, abs=1e-12)
    # twice per period: at 5 um half a wave, cosine = -1
    twice = EncoderInterpolation("X", 0.0, 0.1e-3, 0.02, 2)
    assert twice.error_motion(_run([0.005]))[0, 0] == pytest.approx(-0.1e-3, abs=1e-12)


def test_servo_lag_stays_behind():
    # 0.1 ms more than nominal at +50 mm/s: -5 um; the same for an axis that carries the workpiece
    run = _run([0.0, 0.0], speed_X_mm_s=[50.0, -20.0])
    assert machine(ServoLag("X", 1e-4)).tip_error(run)[:, 0] == pytest.approx([-5e-3, 2e-3], abs=1e-15)
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    table = Machine("m", "machine-tool", parse_structure("w X' b Y Z t"), axes, (ServoLag("X", 1e-4),))
    assert table.tip_error(run)[:, 0] == pytest.approx([-5e-3, 2e-3], abs=1e-15)


def test_unequal_lags_make_an_oval_at_45_degrees():
    # circle of R at speed v, CCW: velocity v (-sin, cos); lag of X alone: radial error = +v lag sin cos:
    # at 45 degrees 50 x 1e-4 x 0.5 = +2.5 um, at 135 degrees -2.5 um; running CW it turns over
    angle = np.radians([45.0, 135.0])
    for way in (1.0, -1.0):
        columns = {"speed_X_mm_s": -way * 50.0 * np.sin(angle)}
        six = ServoLag("X", 1e-4).error_motion(_run([0.0, 0.0], **columns))
        assert six[:, 0] * np.cos(angle) == pytest.approx([way * 2.5e-3, -way * 2.5e-3], abs=1e-15)


def test_readout_delay_runs_ahead_when_measuring():
    # 1 ms at (5, 0, -2) mm/s: tip error (-5, 0, +2) um, so indicated - true = (+5, 0, -2) um
    run = _run([0.0], speed_X_mm_s=[5.0], speed_Y_mm_s=[0.0], speed_Z_mm_s=[-2.0])
    late = machine(ReadoutDelay(1e-3))
    assert late.tip_error(run)[0] == pytest.approx([-5e-3, 0.0, 2e-3], abs=1e-15)
    assert late.indication_error(run)[0] == pytest.approx([5e-3, 0.0, -2e-3], abs=1e-15)


@pytest.mark.parametrize("axis", ["X", "Y"])
def test_dynamic_pitch_makes_a_hanging_tip_lag(axis: str):
    # 5 urad/(m/s^2) = 5e-9 rad per mm/s^2; at 2 m/s^2 10 urad; tip 300 mm below: 10e-6 x (-300) = -3 um along the axis
    run = _run([0.0], (0.0, 0.0, -300.0), **{f"accel_{axis}_mm_s2": [2000.0]})
    error = machine(DynamicPitch(axis, 5e-9)).tip_error(run)[0]
    assert error["XYZ".index(axis)] == pytest.approx(-3e-3, abs=1e-15)
    assert np.abs(error).sum() == pytest.approx(3e-3, abs=1e-15)


def test_dynamic_yaw():
    # yaw 10 urad about +Z, tip 200 mm in +Y: -10e-6 x 200 = -2 um in X
    run = _run([0.0], (0.0, 200.0, 0.0), accel_X_mm_s2=[2000.0])
    error = machine(DynamicPitch("X", 0.0, 5e-9)).tip_error(run)[0]
    assert error == pytest.approx([-2e-3, 0, 0], abs=1e-15)


def test_structural_vibration_rings_and_fades():
    # 20 Hz after 12.5 ms: a quarter of a wave, 0.5 um x exp(-0.05 x pi / 2) = 0.5 x 0.924465; other way round, other sign
    run = _run([0.0, 0.0], time_since_accel_s=[0.0125, 0.0125], sense_X=[1.0, -1.0])
    error = machine(StructuralVibration("X", 0.5e-3, 0.0, 20.0, 0.05)).tip_error(run)[:, 0]
    assert error == pytest.approx([0.4622325e-3, -0.4622325e-3], abs=1e-9)


def test_ringing_after_every_change_of_the_acceleration():
    # 1 m/s^2 from 0 s, off again at 25 ms: 20 Hz after 12.5 ms as above, 0.4622325 um; at 37.5 ms the first ringing is
    # 0.5 sin(1.5 pi) exp(-0.05 x 1.5 pi) = -0.5 x 0.790081, the second -0.5 x 0.924465: -0.857273 um; before it begins 0
    log = Series(np.array([0.0, 0.0249, 0.025]), np.array([1000.0, 1000.0, 0.0]))
    effect = StructuralVibration("X", 0.5e-3, 0.0, 20.0, 0.05, follows=1)
    run = replace(_run([0.0] * 3, time_s=[-1.0, 0.0125, 0.0375]), series={"accel_X_mm_s2": log})
    error = machine(effect).tip_error(run)[:, 0]
    assert error == pytest.approx([0.0, 0.4622325e-3, -0.857273e-3], abs=1e-9)
    assert required(effect) == ("time_s", "accel_X_mm_s2")
    with pytest.raises(ModelLimit, match="log of accel_X_mm_s2"):
        effect.error_motion(_run([0.0], time_s=[0.0]))


def test_rotary_cyclic_is_the_motion_of_the_axis_itself():
    # EXC: 2 um sin q at 30 deg: 1 um; second harmonic 3 um cos 2q at 60 deg: 3 x cos 120 = -1.5 um (sin 60 = 0.866025)
    run = Run({"X": np.zeros(2), "C": np.radians([30.0, 60.0])}, np.zeros((2, 3)))
    effect = RotaryCyclic("EXC", np.array([0.0, 2e-3, 3e-3, 0.0]))
    assert effect.error_motion(run)[:, 0] == pytest.approx([1e-3 + 1.5e-3, 1.732051e-3 - 1.5e-3], abs=1e-9)
    axes = {"X": Axis("X", (-1.0, 1.0)), "C": Axis("C", (-4.0, 4.0))}
    for structure, sign in (("w b X C t", 1.0), ("w C' b X t", -1.0)):
        still = Run({"X": np.zeros(1), "C": np.zeros(1)}, np.zeros((1, 3)))
        moved = Machine(
            "m", "cmm", parse_structure(structure), axes, (RotaryCyclic("EXC", np.array([2e-3])),)
        )
        assert moved.tip_error(still)[0] == pytest.approx([sign * 2e-3, 0, 0], abs=1e-15)
    # ECC turns: 5 urad at the angle zero, 100 mm out in x: +0.5 um in y
    out = Run({"X": np.zeros(1), "C": np.zeros(1)}, np.array([[100.0, 0.0, 0.0]]))
    turning = Machine(
        "m", "cmm", parse_structure("w b X C t"), axes, (RotaryCyclic("ECC", np.array([5e-6])),)
    )
    assert turning.tip_error(out)[0] == pytest.approx([0, 0.5e-3, 0], abs=1e-15)


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
