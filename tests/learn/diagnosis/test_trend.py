"""How a number went in time: drift, step, steady, otherwise; by hand, and on numbers that do not change."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.learn.diagnosis.trend import Trend, presence, trend

YEARS = (0.0, 1.0, 2.0, 3.0)


def with_u(values, u=0.1):
    return [None if v is None else (v, u) for v in values]


def test_a_drift_by_hand():
    """Slope 1 +- 0.1 / sqrt(5) a year, three years; a line gains 500 of chi-square, the best step 400."""
    found = trend(YEARS, with_u([0, 1, 2, 3]))
    assert (found.kind, found.first, found.last) == ("drift", 0, 3)
    assert (found.amount, found.u) == pytest.approx((3.0, 3 * 0.1 / 5**0.5))


def test_a_step_by_hand():
    """0 0 2 2: the step gains 400, a line 320; u = 0.1 sqrt(1/2 + 1/2)."""
    found = trend(YEARS, with_u([0, 0, 2, 2]))
    assert (found.kind, found.first, found.last) == ("step", 1, 2)
    assert (found.amount, found.u) == pytest.approx((2.0, 0.1))


def test_two_recordings_and_those_without_a_date_know_only_a_step():
    assert trend((0.0, 1.0), with_u([0, 1])) == Trend("step", 1.0, pytest.approx(0.1 * 2**0.5), 0, 1)
    assert trend((None, 1.0, 2.0, 3.0), with_u([0, 0, 2, 2])).kind == "step"
    assert (
        trend((None, 1.0, 2.0, 3.0), with_u([0, 1, 2, 3])).kind == "irregular"
    )  # the order of files is no time
    assert trend((0.0, 1.0), with_u([0, 0.2])).kind == "steady"  # 1.4 of its standard uncertainty


def test_what_scatters_beyond_its_uncertainty_is_no_step():
    """0 1 0 1 0: the best step leaves a chi-square of 100 for two degrees of freedom."""
    assert trend((0.0, 1.0, 2.0, 3.0, 4.0), with_u([0, 1, 0, 1, 0])).kind == "irregular"


def test_what_is_not_found_is_left_out_and_numbers_count_all_recordings():
    found = trend((0.0, 1.0, 2.0, 3.0, 4.0), with_u([0, None, 0, 2, 2]))
    assert (found.kind, found.first, found.last) == ("step", 2, 3)
    assert trend(YEARS, with_u([None, 1, None, None])) == Trend("")
    assert trend(YEARS, with_u([1, 2, 3, 4], u=0.0)) == Trend("")  # without an uncertainty nothing is judged


def test_when_it_was_found():
    assert presence(with_u([1, 1])) == ("always", None, None)
    assert presence(with_u([None, None, 1, 1])) == ("appears", 1, 2)
    assert presence(with_u([1, None])) == ("goes", 0, 1)
    assert presence(with_u([1, None, 1])) == ("now and then", None, None)


@pytest.mark.thorough
def test_steady_numbers_are_called_so():
    """Less often than 1 in 370 otherwise: of 2000 at most 14, which 5.4 expected exceed with a chance of 0.001."""
    rng = np.random.default_rng(1)
    years = np.linspace(0, 1, 12)
    other = sum(trend(years, with_u(rng.standard_normal(12), 1.0)).kind != "steady" for _ in range(2000))
    assert other <= 14
