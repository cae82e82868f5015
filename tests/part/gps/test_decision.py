from __future__ import annotations

import math

import pytest

from vcmm.core.errors import UsageError
from vcmm.part.gps.decision import conformance_probability, decide


def test_the_limit_at_1645_u_is_where_conforming_ends() -> None:
    # normal law: P(z <= 1.645) = 0.950015, P(z <= 1.644) = 0.949913; the lower limit is 100 u away
    inside = decide(0.0, (-100.0, 1.645), u=1.0)
    assert inside.text == "conforms"
    assert inside.p_conform == pytest.approx(0.950015, abs=1e-6)
    assert inside.guard == pytest.approx(1.644854, abs=1e-6)
    assert inside.rule == "probability 95 %"
    assert decide(0.0, (-100.0, 1.644), u=1.0).text == "undecided"
    assert decide(0.0, (-1.645, 100.0), u=1.0).text == "conforms"


def test_beyond_the_limit_by_1645_u_it_does_not_conform() -> None:
    assert decide(1.645, (-100.0, 0.0), u=1.0).text == "does not conform"
    assert decide(1.644, (-100.0, 0.0), u=1.0).text == "undecided"
    assert decide(0.0, (-100.0, 0.0), u=1.0).p_conform == pytest.approx(0.5)


def test_a_wide_uncertainty_rejects_no_part() -> None:
    # limits +-4 um, u = 100 um: P(-0.04 < z < 0.04) = 2 * 0.0159534 = 0.031907, though the part reads its nominal size
    wide = decide(50.0, (49.996, 50.004), u=0.1)
    assert wide.p_conform == pytest.approx(0.031907, abs=1e-6)
    assert wide.text == "undecided"
    assert "U is larger than the tolerance" in wide.reason
    # beyond the upper limit by 1.644 u and 1.646 u: P(true > 50.004) = 0.9499 and 0.9501
    assert decide(50.004 + 0.1644, (49.996, 50.004), u=0.1).text == "undecided"
    assert decide(50.004 + 0.1646, (49.996, 50.004), u=0.1).text == "does not conform"
    assert decide(49.996 - 0.1646, (49.996, 50.004), u=0.1).text == "does not conform"


def test_both_limits_count_together() -> None:
    # limits at +-1.7 u: 1 - 2 * 0.0445655 = 0.910869: undecided, although each limit alone leaves 95.5 %
    both = decide(5.0, (5.0 - 0.0017, 5.0 + 0.0017), u=0.001)
    assert both.p_conform == pytest.approx(0.910869, abs=1e-6)
    assert both.text == "undecided"


def test_a_given_probability_replaces_the_normal_law() -> None:
    assert decide(0.0, (-1.0, 1.0), probability_of_conformance=0.95).text == "conforms"
    assert decide(0.0, (-1.0, 1.0), probability_of_conformance=0.949, u=0.001).text == "undecided"
    assert decide(0.0, (-1.0, 1.0), probability_of_conformance=0.05).text == "does not conform"
    assert decide(0.0, (-1.0, 1.0), probability_of_conformance=0.5).guard is None


def test_zero_is_no_limit_of_a_zone() -> None:
    # 2 um of 10 um with u = 2 um: P(y <= 10) = P(z <= 4) = 0.999968. Two-sided it would lose P(y < 0) = 15.9 %
    zone = decide(0.002, (0.0, 0.010), u=0.002, one_sided=True)
    assert zone.p_conform == pytest.approx(0.999968, abs=1e-6)
    assert zone.text == "conforms"
    assert decide(0.002, (0.0, 0.010), u=0.002).text == "undecided"


def test_guard_band_of_the_expanded_uncertainty() -> None:
    limits, rule = (30.0, 30.021), "guard band U"
    # acceptance zone 30.004 to 30.017, rejection below 29.996 and above 30.025
    cases = [(30.0041, "conforms"), (30.0039, "undecided"), (29.9959, "does not conform"), (30.0169, "conforms"),
             (30.0171, "undecided"), (30.0249, "undecided"), (30.0251, "does not conform")]  # fmt: skip
    for value, text in cases:
        assert decide(value, limits, U=0.004, rule=rule).text == text
        assert decide(value, limits, u=0.002, rule=rule).text == text  # U = 2 u
    assert decide(30.01, limits, U=0.004, rule=rule).guard == 0.004
    assert decide(30.01, limits, U=0.004, rule=rule).p_conform is None
    # a guard band wider than half the tolerance accepts nothing
    assert decide(30.0105, limits, U=0.011, rule=rule).text == "undecided"


def test_probability_in_the_tails_and_without_uncertainty() -> None:
    # P(z > 8) = 6.22096e-16, from either side
    assert conformance_probability(0.0, (8.0, math.inf), 1.0) == pytest.approx(6.22096e-16, rel=1e-5, abs=0.0)
    assert conformance_probability(0.0, (-math.inf, -8.0), 1.0) == pytest.approx(
        6.22096e-16, rel=1e-5, abs=0.0
    )
    assert conformance_probability(1.0, (0.0, 1.0), 0.0) == 1.0
    assert conformance_probability(1.1, (0.0, 1.0), 0.0) == 0.0
    assert conformance_probability(3.0, (-math.inf, math.inf), 1.0) == 1.0


def test_bad_calls_are_refused() -> None:
    with pytest.raises(UsageError, match="guard band U"):
        decide(0.0, (0.0, 1.0), u=1.0, rule="guardband")
    with pytest.raises(UsageError, match="needs u"):
        decide(0.0, (0.0, 1.0))
    with pytest.raises(UsageError, match="needs U or u"):
        decide(0.0, (0.0, 1.0), rule="guard band U")
    with pytest.raises(UsageError, match="exchange"):
        decide(0.0, (1.0, 0.0), u=1.0)
    with pytest.raises(UsageError, match="not finite"):
        decide(math.nan, (0.0, 1.0), u=1.0)
    with pytest.raises(UsageError, match="u must be"):
        decide(0.0, (0.0, 1.0), u=-1.0)
    with pytest.raises(UsageError, match="between 0 and 1"):
        decide(0.0, (0.0, 1.0), probability_of_conformance=1.2)
