"""The best fit within free motions: the smallest largest departure of a profile, against linear programming and by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from vcmm.part.gps.freedom import largest_left, rows_for


def _by_programming(departures, moved):
    """min t under |d + M x| <= t."""
    k, f = moved.shape
    ones = np.ones((k, 1))
    rows = np.block([[moved, -ones], [-moved, -ones]])
    bound = np.concatenate([-departures, departures])
    return linprog([0.0] * f + [1.0], A_ub=rows, b_ub=bound, bounds=[(None, None)] * f + [(0, None)]).fun


@pytest.mark.parametrize("f", [1, 3, 6])
def test_the_largest_departure_of_a_profile_is_smallest(f):
    rng = np.random.default_rng(f)
    moved = rng.normal(size=(36, f))
    departures = np.concatenate([rng.normal(size=(40, 36)), rng.uniform(size=(40, 36)) ** 4]) * 1e-3
    found = largest_left(departures[..., None], moved[:, None], True)
    due = np.array([_by_programming(1e3 * d, moved) for d in departures]) * 1e-3
    assert found == pytest.approx(due, rel=1e-7)
    assert np.all(found < largest_left(departures[..., None], moved[:, None], False))


def test_blocks_of_rows_change_nothing(monkeypatch):
    rng = np.random.default_rng(7)
    moved, departures = rng.normal(size=(12, 1, 3)), rng.normal(size=(5, 4, 12, 1))
    whole = largest_left(departures, moved, True)
    monkeypatch.setattr("vcmm.part.fit.exchange.NUMBERS", 3 * 12 * 3)
    assert whole.shape == (5, 4)
    assert np.array_equal(largest_left(departures, moved, True), whole)


def test_a_shift_leaves_half_the_range():
    departures = np.array([[0.0, 0.001, 0.004], [0.002, 0.002, 0.002], [0.0, 0.0, 0.0]])
    found = largest_left(departures[..., None], np.ones((3, 1, 1)), True)
    assert found == pytest.approx([0.002, 0.0, 0.0], abs=1e-15)


def test_a_pattern_of_two_components_is_fitted_too():
    """Two places 2 mm apart in x and both 0.5 mm off in y: a shift along x halves the first and leaves the second."""
    departures = np.array([[-1.0, 0.5], [1.0, 0.5]])
    moved = np.array([[[1.0], [0.0]], [[1.0], [0.0]]])
    assert float(largest_left(departures, moved, True)) == pytest.approx(np.hypot(1.0, 0.5), rel=1e-12)


def test_rows_by_hand():
    """Along y at (3, 4, 0) about (1, 1, 0), 1 mm at 2: arm (1, 1.5, 0), arm x y = (0, 0, 1): a turn about z counts, about x and y does not."""
    rows = rows_for(np.array([3.0, 4.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0]), 2.0)
    assert rows.tolist() == [0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
