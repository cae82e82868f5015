"""Risks against the exact numbers of JCGM 106 problems, zones by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vcmm.core.errors import UsageError
from vcmm.gps import risk
from vcmm.gps.risk import Production, acceptance_limits, global_risk, specific_risk, zone

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
    assert found.accepted == pytest.approx(reads, rel=1e-9)
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
