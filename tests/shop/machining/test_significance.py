"""Significance by hand, and where no number is small enough for it."""

from __future__ import annotations

import math

import pytest

from vcmm.shop.machining.significance import log_p, p_in_words


def test_two_numbers_by_hand():
    """Chi-square with two degrees of freedom: p = exp(-gain / 2). F with 2 and 10, scatter 1: p = (1 + gain / 10)^-5."""
    assert log_p(6.0, 2, None) == pytest.approx(-3.0)
    assert log_p(10.0, 2, (10.0, 10)) == pytest.approx(-5.0 * math.log(2.0))


def test_beyond_the_smallest_number_the_tail_goes_on():
    assert log_p(2000.0, 2, None) == pytest.approx(-1000.0)
    # 400 freedoms: p = (1 + gain / 400)^-200 = 101^-200, ln p = -923
    assert log_p(40000.0, 2, (400.0, 400)) == pytest.approx(-200.0 * math.log(101.0), rel=1e-3)
    assert p_in_words(0.0) == "p below 1e-290"
