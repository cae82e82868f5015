"""Ranges that a number was learnt from: their text, and refusal beyond a tenth of them."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.valid_range import check_range, checked_temperatures, trained_range


def test_a_range_is_rounded_outwards_and_left_by_a_tenth_at_most():
    """18.004 to 30.001 degC is 18 to 30.01; a tenth of 12.01 K beyond 30.01 is 31.211."""
    text = trained_range(18.004, 30.001)
    assert text == "18 degC to 30.01 degC"
    near = np.array([18.0, 31.2, 20.0])
    assert checked_temperatures(text, "drift", "air", near) is near
    with pytest.raises(ModelLimit, match=r"temp_air_C = 31.22 degC lies beyond.*18 degC to 30.01 degC"):
        checked_temperatures(text, "drift", "air", np.array([20.0, 31.22]))


def test_20_degrees_are_no_extrapolation():
    assert checked_temperatures("25 degC to 40 degC", "drift", "air", np.array([20.0])) == pytest.approx(
        [20.0]
    )
    with pytest.raises(ModelLimit):
        checked_temperatures("25 degC to 40 degC", "drift", "air", np.array([20.1]))


@pytest.mark.parametrize("text", ["18 to 31", "31 degC to 18 degC", "18 K to 31 K"])
def test_a_text_that_is_no_range(text):
    with pytest.raises(UsageError, match="write for example"):
        check_range(text, "thermal_drift[z,air]")
