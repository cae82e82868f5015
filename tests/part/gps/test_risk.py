"""Risks against the exact numbers of JCGM 106 problems, zones by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vcmm.core.errors import UsageError
from vcmm.part.gps import risk
from vcmm.part.gps.risk import (
    Production,
    acceptance_limits,
    global_risk,
    guard_band,
    specific_risk,
    wrong_decisions,
    zone,
)

LIMITS = (-0.2, 0.2)
PROCESS = Production(0.0, 0.12)


def test_global_risks_of_a_known_problem():
    """Tolerance +-0.2, process N(0, 0.12), u = 0.04: simple acceptance 1.894 % and 3.721 %; guard band U = 0.08: 0.0469, 24.77 %."""
    simple = global_risk(LIMITS, 0.04, 0.0, PROCESS)
    assert (simple.consumer, simple.producer) == pytest.approx((0.01894, 0.03721), abs=1e-5)
    guarded = global_risk(LIMITS, 0.04, 0.08, PROCESS)
    assert (guarded.consumer, guarded.producer) == pytest.approx((0.000469, 0.2477), abs=1e-4)
    assert simple.out == pytest.approx(math.erfc(0.2 / 0.12 / math.sqrt(2)), rel=1e-9)


def test_global_risk_against_the_bivariate_normal():
    # one limit: P(true > 1, reading < 1) of a bivariate normal with covariance s^2, s^2; s^2, s^2 + u^2
    found = global_risk((-math.inf, 1.0), 0.3, 0.0, Production(0.5, 0.4))
    cover = np.array([[0.16, 0.16], [0.16, 0.25]])
    both = multivariate_normal([0.5, 0.5], cover).cdf([1.0, 1.0])
    reads = 0.5 * math.erfc(-0.5 / 0.5 / math.sqrt(2))
    assert found.consumer == pytest.approx(reads - both, abs=1e-5)
    assert found.acceptance == pytest.approx(reads, rel=1e-9)
    sharp = global_risk(LIMITS, 0.0, 0.0, PROCESS)
    assert (sharp.consumer, sharp.producer) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_zones_of_iso_14253():
    found = [zone(v, (0.0, 10.0), 1.0) for v in (5.0, 1.0, 0.5, -0.5, -1.5, 9.5, 10.5, 11.5)]
    assert found == [
        risk.IN_ACCEPT, risk.IN_ACCEPT, risk.IN_UNCERTAIN, risk.OUT_UNCERTAIN, risk.OUT_REJECT, risk.IN_UNCERTAIN,
        risk.OUT_UNCERTAIN, risk.OUT_REJECT,
    ]  # fmt: skip
    assert acceptance_limits((0.0, 10.0), 1.0) == (1.0, 9.0)
    assert acceptance_limits((0.0, 1.0), 0.6) is None
    assert (specific_risk(0.97, True), specific_risk(0.03, False)) == pytest.approx((0.03, 0.03))


def test_what_no_production_is():
    with pytest.raises(UsageError, match="state what the process makes"):
        Production(0.0, 0.0)
    with pytest.raises(UsageError, match="must rise"):
        global_risk((1.0, 0.0), 0.1, 0.0, PROCESS)


def test_no_uncertainty_no_risk():
    found = wrong_decisions(np.array([0.0]), np.zeros(1), (-1.0, 1.0), np.zeros(1), (0.0, 1.0))
    assert found.total[0] == pytest.approx(0.0, abs=1e-9)


def test_two_sided_without_guard_by_hand():
    """Parts and errors of one size u = s = 1, one limit at 0: the true and the indicated value are on different sides of 0
    with probability arccos(rho) / pi, rho = s / sqrt(s^2 + u^2) = 1/sqrt 2 (Sheppard 1899): 45 deg / 180 deg = 1/4."""
    found = wrong_decisions(np.array([1.0]), np.zeros(1), (-np.inf, 0.0), np.zeros(1), (0.0, 1.0))
    assert found.accept_bad[0] == pytest.approx(1 / 8, abs=1e-8)
    assert found.reject_good[0] == pytest.approx(1 / 8, abs=1e-8)
    assert found.no_decision[0] == pytest.approx(0.0, abs=1e-12)


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
    assert found.no_decision[0] == pytest.approx((~accepted & ~rejected).mean(), abs=error / 4)


def test_guard_bands():
    assert guard_band("guard band U", np.ones(1), np.full(1, 2.2))[0] == 2.2
    assert guard_band("probability 95 %", np.ones(1), np.full(1, 2.2))[0] == pytest.approx(1.6449, abs=1e-4)
