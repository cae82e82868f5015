"""Probabilities of wrong decisions against counting and against a number made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.placing.risk import guard_band, wrong_decisions


def test_no_uncertainty_no_risk():
    found = wrong_decisions(np.array([0.0]), np.zeros(1), (-1.0, 1.0), np.zeros(1), (0.0, 1.0))
    assert found.total[0] == pytest.approx(0.0, abs=1e-9)


def test_two_sided_without_guard_by_hand():
    """Parts and errors of one size u = s = 1, one limit at 0: the true and the indicated value are on different sides of 0
    with probability arccos(rho) / pi, rho = s / sqrt(s^2 + u^2) = 1/sqrt 2 (Sheppard 1899): 45 deg / 180 deg = 1/4."""
    found = wrong_decisions(np.array([1.0]), np.zeros(1), (-np.inf, 0.0), np.zeros(1), (0.0, 1.0))
    assert found.accept_bad[0] == pytest.approx(1 / 8, abs=1e-8)
    assert found.reject_good[0] == pytest.approx(1 / 8, abs=1e-8)
    assert found.undecided[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("u", "bias", "rule"), [(0.2, 0.1, "guard band U"), (0.05, 0.0, "probability 95 %")])
def test_against_counting(u, bias, rule):
    rng = np.random.default_rng(5)
    true = 0.1 + 0.4 * rng.standard_normal(2_000_000)
    said = true + bias + u * rng.standard_normal(len(true))
    guard = guard_band(rule, np.array([u]), np.array([2 * u]))
    good = np.abs(true) <= 1
    accepted, rejected = np.abs(said) <= 1 - guard, np.abs(said) > 1 + guard
    found = wrong_decisions(np.array([u]), np.array([bias]), (-1.0, 1.0), guard, (0.1, 0.4))
    error = 4 / np.sqrt(len(true))
    assert found.accept_bad[0] == pytest.approx((accepted & ~good).mean(), abs=error / 20)
    assert found.reject_good[0] == pytest.approx((rejected & good).mean(), abs=error / 20)
    assert found.undecided[0] == pytest.approx((~accepted & ~rejected).mean(), abs=error / 4)


def test_guard_bands():
    assert guard_band("guard band U", np.ones(1), np.full(1, 2.2))[0] == 2.2
    assert guard_band("probability 95 %", np.ones(1), np.full(1, 2.2))[0] == pytest.approx(1.6449, abs=1e-4)
