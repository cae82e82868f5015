"""Rows that stand out are paid for by Huber's law."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.diagnosis.outlying import huber_loss


def test_rows_that_stay_within_the_bound_cost_what_least_squares_says():
    """Four rows of size 1, four degrees of freedom: s = 1, four times 1/2."""
    assert huber_loss(np.array([1.0, -1.0, 1.0, -1.0]), 4, 3.0) == pytest.approx(2.0)


def test_a_row_beyond_the_bound_is_paid_in_proportion():
    """1, 1, 1, 10 with the bound at 1: 3 / s^2 + 10 / s = 4, s = (10 + sqrt 148) / 8 = 2.7707;
    4 ln s + 3 / (2 s^2) + 10 / s - 1/2 = 4.0764 + 0.1954 + 3.6092 - 0.5 = 7.3810.
    """
    assert huber_loss(np.array([1.0, -1.0, 1.0, 10.0]), 4, 1.0) == pytest.approx(7.3810, abs=2e-4)


def test_the_unit_of_the_rows_only_moves_the_zero():
    """Rows 1000 times as large cost dof ln 1000 more, whatever they are: differences between answers stay."""
    rows = np.array([0.3, -1.1, 0.7, -0.2, 25.0])
    assert huber_loss(1e3 * rows, 4, 3.0) - huber_loss(rows, 4, 3.0) == pytest.approx(4 * np.log(1e3))
