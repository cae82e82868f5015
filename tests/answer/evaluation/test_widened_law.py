"""The law of a sum with a part of either sign, against the normal distribution by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.answer.evaluation.interval import Linear
from vcmm.answer.evaluation.summary import summarise
from vcmm.answer.evaluation.widened_law import sum_with_random_signs, widen
from vcmm.core.laws import Normal


def phi(x: float) -> float:
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


def test_two_normal_hills_by_hand() -> None:
    """x of N(3, 1), 2 to either side: P(Y <= 4) = [Phi(4 - 3 + 2) + Phi(4 - 3 - 2)] / 2 = [Phi(3) + Phi(-1)] / 2."""
    law = widen(Linear(3.0, [(Normal(1.0), np.ones(1))]), np.array([2.0, 2.0]))
    by_hand = (phi(3.0) + phi(-1.0)) / 2
    assert by_hand == pytest.approx(0.578653, abs=1e-6)
    assert law.cdf(4.0) == pytest.approx(by_hand, abs=1e-4)
    low, high = law.interval(0.95)
    assert low + high == pytest.approx(6.0, abs=1e-3)  # its middle stays
    # 95 %: [Phi(h + 2) + Phi(h - 2)] / 2 = 0.975, Phi(h - 2) = 0.95 + 0.00013, h = 2 + 1.646
    assert (high - low) / 2 == pytest.approx(3.646, abs=5e-3)
    assert law.interval(0.95, "upper")[1] == pytest.approx(law.quantile(0.95), abs=1e-9)
    assert law.probability(low, high) == pytest.approx(0.95, abs=1e-6)


def test_a_form_alone_and_nothing_else() -> None:
    """Nothing uncertain but a form of 5 to either side: all but nothing lies between -5 and 5."""
    law = widen(Linear(0.0, []), np.full(4, 5.0))
    assert law.interval(0.95) == pytest.approx((-5.0, 5.0), abs=1e-9)


def test_drawn_law_mirrored_and_added_up() -> None:
    """A law of trials leans to one side; its mirror image to the other. 3 and 4 of either sign are 7 or 1."""
    law = widen(summarise(np.random.default_rng(1).exponential(1.0, 20_000)), np.zeros(1))
    assert law.reflect(0.0).quantile(0.025) == pytest.approx(-law.quantile(0.975), abs=1e-6)
    assert set(np.round(sum_with_random_signs([np.full(64, 3.0), np.full(64, 4.0)]), 9)) == {1.0, 7.0}
