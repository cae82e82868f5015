"""Other kinds of recording: a laser run after ISO 230-2, and a circular test in both directions with correlated noise."""

from __future__ import annotations

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.task.response.recording import Recording

UM = 1e-3


def laser(error, noise=0.6 * UM, seed=1):
    """11 positions, 5 cycles, both directions along X; error(q, sense) is actual - commanded."""
    there = np.arange(0, 501, 50.0)
    q = np.tile(np.r_[there, there[::-1]], 5)
    sense = np.tile(np.r_[np.ones(11), -np.ones(11)], 5)
    n = len(q)
    columns = {"sense_X": sense, "nx": np.ones(n), "ny": np.zeros(n), "nz": np.zeros(n)}
    run = Run({"X": q, "Y": np.zeros(n), "Z": np.zeros(n)}, np.zeros((n, 3)), columns)
    value = error(q, sense) + noise * np.random.default_rng(seed).standard_normal(n)
    along = np.tile([1.0, 0.0, 0.0], (n, 1))
    rows, none = np.arange(n), np.full(n, -1)
    return Recording(
        "laser", "displacement", run, value, False, rows, along, none, None, {"zero": ""}, Normal(noise)
    )


@pytest.mark.parametrize(
    ("error", "names"),
    [
        (lambda q, s: 0 * q, []),
        (lambda q, s: -0.5 * 2 * UM * s, ["backlash"]),
        (lambda q, s: -0.5 * (1 * UM + 6e-6 * q) * s, ["lost_motion"]),
        (lambda q, s: -0.5 * 2 * UM * s + 8e-6 * q, ["scale_factor", "backlash"]),
    ],
)
def test_laser_run(error, names):
    found = diagnose_recording(laser(error), make.machine(), 1, 500)
    assert sorted(a.effect for a in found.answer) == sorted(names)


def test_scale_and_cosine_error_share_a_laser_run_that_reads_short_and_not_one_that_reads_long():
    """A beam askew reads L (1 - theta^2 / 2): what is read too long is the axis. Short, either may be: odds of a few, and the next
    measurement says what separates them.
    """
    short, long = (
        diagnose_recording(laser(lambda q, s, k=k: k * q), make.machine(), 1, 500) for k in (-8e-6, 8e-6)
    )
    (one,) = short.answer
    assert {one.effect, *one.cannot_be_told_from} >= {"scale_factor", "cosine_error"}
    assert 0.2 < one.probability < 0.8
    assert any({"scale_factor", "cosine_error"} == {*s.separates} for s in short.next_measurement)
    (one,) = long.answer
    assert (one.effect, one.cannot_be_told_from) == ("scale_factor", ())


def circle(error, rho=0.6, noise=0.3 * UM, seed=2):
    """Radius 150 mm, both directions, radial error with AR(1) noise."""
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    angle, turn = np.r_[angle, angle[::-1]], np.r_[np.ones(300), -np.ones(300)]
    n = len(angle)
    radial = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    speed = 16.0 * turn[:, None] * np.stack([-np.sin(angle), np.cos(angle), np.zeros(n)], axis=1)
    columns = {"time_s": 0.2 * np.arange(n)}
    for i, axis in enumerate("XYZ"):
        columns |= {f"n{axis.lower()}": radial[:, i], f"speed_{axis}_mm_s": speed[:, i]}
        columns[f"sense_{axis}"] = np.where(speed[:, i] >= 0, 1.0, -1.0)
    position = {"X": 300 + 150 * radial[:, 0], "Y": 250 + 150 * radial[:, 1], "Z": np.full(n, -100.0)}
    run = Run(position, np.zeros((n, 3)), columns)
    white = np.random.default_rng(seed).standard_normal(n)
    for i in range(1, n):
        white[i] = rho * white[i - 1] + np.sqrt(1 - rho**2) * white[i]
    value = error(run) + noise * white
    rows, none = np.arange(n), np.full(n, -1)
    free = {"centre": "", "zero": ""}
    return Recording("circle", "path", run, value, False, rows, radial, none, None, free, Normal(noise))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("error", "names"),
    [
        (lambda r: np.zeros(r.n), []),
        (lambda r: -0.5 * 2 * UM * r.columns["sense_Y"] * r.columns["ny"], ["backlash"]),
        (lambda r: -8e-6 * r.position["Y"] * r.columns["nx"], ["squareness"]),
        (
            lambda r: -3e-4 * r.columns["speed_X_mm_s"] * r.columns["nx"],
            ["servo_lag", "servo_lag"],
        ),  # of X, or of Y
    ],
)
def test_circular_test(error, names):
    found = diagnose_recording(circle(error), make.machine(), 1, 500)
    assert [a.effect for a in found.answer] == names
    assert any("correlated" in text for text in found.noise_findings)
