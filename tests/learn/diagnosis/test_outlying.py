"""Rows that stand out are paid for by a law of heavy tails."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from vcmm.answer.evaluation.gaussian import whitener
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.search import heavy_loss, largest_row_support
from vcmm.learn.diagnosis.select import SelectedTerm, Setting, fit_jointly


def test_rows_of_one_size_are_their_own_scale():
    """Four rows of size 1, four degrees of freedom, law of 4: the mean of 5 x^2 / (2 + x^2) is 1 at x^2 = 1/2, s^2 = 2;
    4 (ln sqrt 2 + 5/2 ln(1 + 1/4)) = 4 (0.34657 + 0.55786) = 3.6177.
    """
    assert heavy_loss(np.array([1.0, -1.0, 1.0, -1.0]), 4) == pytest.approx(3.6177, abs=1e-4)


def test_a_row_far_off_costs_the_logarithm_of_its_size():
    """Of 1000 rows one stands out: 100 times as far costs 5 ln 10 = 11.5 nats more at 10 times, not 100 times as many."""
    rows = np.random.default_rng(1).standard_normal(1000)
    cost = [heavy_loss(np.append(rows, far), 1001) for far in (100.0, 1000.0)]
    assert cost[1] - cost[0] == pytest.approx(5.0 * np.log(10.0), rel=1e-2)


def test_the_unit_of_the_rows_only_moves_the_zero():
    """Rows 1000 times as large cost dof ln 1000 more, whatever they are: differences between answers stay."""
    rows = np.array([0.3, -1.1, 0.7, -0.2, 25.0])
    assert heavy_loss(1e3 * rows, 4) - heavy_loss(rows, 4) == pytest.approx(4 * np.log(1e3))


def test_the_row_that_speaks_most_is_told_at_the_scales_of_both_answers():
    """Rows 3, 1, -1, 1; a name of the first alone takes all of it. v = s^2:

    without it 45 / (2 v + 9) + 15 / (2 v + 1) = 4 has v = 4.5, the first row costs ln(4.5) / 2 + 5/2 ln 2 = 2.4849;
    with it 15 / (2 v + 1) = 4 has v = 1.375, the first row costs ln(1.375) / 2 = 0.1592, which is 2.3257 less;
    any other row costs 1.0154 and 0.9346, 0.0808 less.
    """
    rows, first = np.array([3.0, 1.0, -1.0, 1.0]), np.array([[1.0], [0.0], [0.0], [0.0]])
    white = whitener(np.ones(4), np.zeros((4, 0)), np.zeros((4, 0)))
    family = Family("first", {}, (Option(None, first, np.ones(1), ("k",), 0.0),))
    setting = Setting(
        dictionary([family], white), white, rows, np.inf, 0.0, Refiner(cast(Problem, None), white)
    )
    name = fit_jointly((SelectedTerm(family, family.options[0], first, 1000.0),), setting)
    assert largest_row_support(name, setting, fit_jointly((), setting)) == pytest.approx(2.3257, abs=1e-4)
