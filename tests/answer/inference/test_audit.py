"""The audit's score interval, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.answer.inference.audit import wilson


def test_the_score_interval_of_a_share():
    """8 of 10 with z = 2: middle (0.8 + 4/20) / (1 + 4/10) = 1 / 1.4; half 2 / 1.4 x sqrt(0.8 x 0.2 / 10 + 4 / 400) = sqrt(0.026) / 0.7."""
    low, high = wilson(0.8, 10, 2.0)
    assert (low, high) == pytest.approx((0.483935, 0.944636), abs=1e-6)
    assert (high - low) / 2 == pytest.approx(math.sqrt(0.026) / 0.7, rel=1e-12)
    # 10 of 10: middle 1.2 / 1.4 = 6/7, half sqrt(0.01) / 0.7 = 1/7
    assert wilson(1.0, 10, 2.0) == pytest.approx((5 / 7, 1.0), rel=1e-12)
    assert wilson(0.0, 10, 2.0) == pytest.approx((0.0, 2 / 7), abs=1e-12)
