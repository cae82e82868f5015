"""The search for a wave in time, on numbers made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.shop.machining.waves import frequencies_of, largest_wave, slow_courses, wave_columns

TIME = np.sort(np.random.default_rng(0).uniform(0.0, 600.0, 80))
NORMALS = np.eye(3)[np.arange(80) % 3]


def test_grid_from_three_waves_over_the_duration_to_half_of_the_rate():
    """31 points, one per second: 30 s; 3/30 to below 1/2 Hz in steps of a third of 1/30 is 3 * (15 - 3) = 36 frequencies."""
    f = frequencies_of(np.arange(31.0))
    assert (len(f), f[0]) == (36, pytest.approx(3.0 / 30.0))
    assert f[-1] == pytest.approx((3.0 + 35.0 / 3.0) / 30.0)
    assert len(frequencies_of(np.arange(29.0))) == 0  # too few points


def test_a_wave_is_found_with_its_period_and_all_of_its_energy():
    """3 um cos along x and 4 um sin along y, u = 1 um: the gain is the sum of squares, but for the step of the grid."""
    phase = 2 * np.pi * TIME / 25.0
    rest = NORMALS[:, 0] * 3e-3 * np.cos(phase) + NORMALS[:, 1] * 4e-3 * np.sin(phase)
    found = largest_wave(np.eye(80) / 1e-3, np.zeros((80, 0)), rest, NORMALS, TIME)
    assert found is not None
    assert found.period == pytest.approx(25.0, rel=0.01)
    assert found.freedom == 6
    assert 0.88 * np.sum(rest**2) / 1e-6 < found.gain <= np.sum(rest**2) / 1e-6 + 1e-9


def test_what_is_taken_out_before_is_no_wave():
    """A wave that stands in the base adds nothing: only rounding is left of it."""
    columns = wave_columns(25.0, NORMALS, TIME)
    base = np.linalg.qr(columns)[0]
    found = largest_wave(np.eye(80), base, columns @ np.arange(1.0, 7.0), NORMALS, TIME)
    assert found is None or found.gain < 1e-20


def test_a_growth_that_levels_off_is_a_slow_course():
    """14 um (1 - exp(-t / 150 s)) along z in 600 s: six half cosines leave a hundredth of it, and no wave takes its place."""
    rest = NORMALS[:, 2] * 14e-3 * (1.0 - np.exp(-TIME / 150.0))
    base = np.linalg.qr(np.hstack([NORMALS, slow_courses(NORMALS, TIME)]))[0]
    left = rest - base @ (base.T @ rest)
    assert np.sqrt(np.sum(left**2)) < 0.02 * np.sqrt(np.sum(rest**2))
    found = largest_wave(np.eye(80) / 1e-3, base, rest, NORMALS, TIME)
    assert found is not None
    assert found.gain < 1e-3 * np.sum(rest**2) / 1e-6
