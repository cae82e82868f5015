"""vcmm/physics/catalogue/dynamics.py: values by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import required
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.dynamics import DynamicPitch, StructuralVibration


def _run(x: list[float], offset=(0.0, 0.0, 0.0), **columns: list[float]) -> Run:
    n = len(x)
    position = {"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(position, np.tile(offset, (n, 1)), {k: np.array(v) for k, v in columns.items()})


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
