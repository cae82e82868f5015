"""Hand-computed numbers of the routes and of their agreement."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.answer.routes.calibrated_part import CalibratedValue, Warmth, calibrated_part
from vcmm.answer.routes.estimate import (
    PART_EXPANSION,
    READING,
    Contribution,
    RouteEstimate,
    agreement,
    agreements,
    coverage_factor,
)
from vcmm.answer.routes.positions import Corrections, StandardReadings, corrections, several_positions
from vcmm.core.errors import UsageError


def test_a_calibrated_part_by_hand() -> None:
    """20 repeats, ten at +1 um and ten at +3 um of 50 mm, calibrated 50.000 +- 0.5 um (k = 1).

    b = 2 um; u_p = sqrt(20 / 19) um = 1.02598; u_p / sqrt(20) = 0.22942; |22 - 20| 1e-6 50 = 0.1 um twice.
    u^2 = 0.25 + 1.052632 + 0.052632 + 0.01 + 0.01 = 1.375263, u = 1.172716 um, U = 2.345432 um.
    """
    repeats = 50.0 + 1e-3 * np.repeat([1.0, 3.0], 10)
    found = calibrated_part(50.010, repeats, CalibratedValue(50.0, 0.5e-3), Warmth(22.0, 1e-6, 50.0))
    assert found.value == pytest.approx(50.008, abs=1e-12)
    assert found.u * 1e3 == pytest.approx(1.172716, abs=1e-6)
    assert found.k == 2.0
    assert found.expanded * 1e3 == pytest.approx(2.345432, abs=2e-6)
    # nu = u^4 / (u_p^4 / 19 + (u_p / sqrt 20)^4 / 19) = 1.891349 / (1.108033 + 0.002770) * 19 = 32.35
    assert found.dof == pytest.approx(32.35, abs=0.01)
    assert not found.remarks


def test_few_repeats_take_students_factor() -> None:
    """Three repeats of scatter alone: nu = 2 (1 + 1/3)^2 / (1 + 1/9) = 3.2; t of 95.45 % lies between 3.31 (3) and 2.87 (4)."""
    found = calibrated_part(10.0, np.array([9.999, 10.0, 10.001]), CalibratedValue(10.0, 0.0))
    assert found.dof == pytest.approx(3.2)
    assert 2.87 < found.k < 3.31
    assert "3 repeats; ISO 15530-3 asks for 20" in found.remarks[0]
    with pytest.raises(UsageError, match="shows no scatter"):
        calibrated_part(10.0, np.array([10.0]), CalibratedValue(10.0, 0.0))


def test_standards_by_hand() -> None:
    """Centres of 200 mm indicated 200.0004: e_L = 2e-6; a ring of 50 mm indicated 49.9991: delta = (-0.9 - 0.1) um / -2 = 0.5 um.

    u of the first: hypot(0.1, 0.1 / sqrt 1) um / 200 mm (two readings 0.2 um apart: s / sqrt 2 = 0.1 um); of delta:
    sqrt(0.2^2 + (50 u(e_L))^2) um / 2. A block of 200 mm then reads 0.4 um of scale and 2 x 0.5 um of tip too much.
    """
    ring = StandardReadings("ring", 50.0, 0.2e-3, np.array([49.9991]))
    u_scale = math.hypot(0.1e-3, 0.1e-3) / 200
    for kind, error in (("centres", 0.4e-3), ("length", 1.4e-3)):
        readings = 200.0 + error + np.array([-0.1e-3, 0.1e-3])
        found = corrections([StandardReadings(kind, 200.0, 0.1e-3, readings), ring])
        assert found.value == pytest.approx([2e-6, 0.5e-3])
        if kind == "centres":
            assert np.sqrt(np.diag(found.covariance)) == pytest.approx(
                [u_scale, math.hypot(0.2e-3, 50 * u_scale) / 2]
            )
    # nu of the readings: (sqrt 2)^4 / (1^4 / 1) = 4 in units of 0.1 um
    assert found.dof == pytest.approx(4.0)
    # two rings that differ by 4 standard uncertainties of their mean: chi^2 = 8 for 1 degree of freedom
    apart = [StandardReadings("ring", 50.0, 0.2e-3, np.array([50.0 + e])) for e in (-0.4e-3, 0.4e-3)]
    found = corrections(apart)
    assert found.is_shown == (False, True)
    assert found.covariance[1, 1] == pytest.approx(8 * (0.1e-3) ** 2 / 2)


def test_several_positions_by_hand() -> None:
    """Means 30.001, 30.003 and 30.005: mean 30.003, s = 2 um, s / sqrt 3 = 1.154701 um; c = (30, -2), e_L = 10e-6 +- 5e-6,
    delta = 0.5 +- 0.1 um, correlation -1/2: value 30.003 - 0.0003 + 0.001 = 30.0037, u^2 = 4/3 + 0.0225 + 0.04 + 2 * 0.5 * 0.15 * 0.2.
    """
    readings = {"a": np.array([30.0, 30.002]), "b": np.array([30.003]), "c": np.array([30.005])}
    scatter = np.array([5e-6, 0.1e-3])
    covariance = np.outer(scatter, scatter) * np.array([[1.0, -0.5], [-0.5, 1.0]])
    known = Corrections(np.array([1e-5, 0.5e-3]), covariance, (True, True))
    found = several_positions(readings, (30.0, -2.0), known)
    assert found.value == pytest.approx(30.0037)
    assert found.u**2 * 1e6 == pytest.approx(4 / 3 + 0.0225 + 0.04 + 0.03)
    assert found.k == pytest.approx(coverage_factor(2 * (4 / 3 + 0.0925) ** 2 / (4 / 3) ** 2))
    bare = several_positions(readings, (30.0, -2.0), Corrections())
    assert bare.value == pytest.approx(30.003)
    assert len(bare.remarks) == 2
    assert (
        "no ring or sphere was measured: the error of the tip is in the value and not in U, so no E_n is given"
        in bare.remarks
    )
    assert (len(agreements([found, found])), agreements([found, bare])) == (
        1,
        (),
    )  # the model's U holds that error as well
    with pytest.raises(UsageError, match="in 1 position"):
        several_positions({"a": np.array([1.0])}, (0.0, 0.0), Corrections())


def test_what_is_shared_cancels() -> None:
    """Shared: reading (0.5, 0.6) and expansion 0.3. Apart: 1.0 and 0.2: u_d = sqrt(1.04), E_n = 1.5 / (2 sqrt 1.04) = 0.735."""
    one = RouteEstimate(
        "a",
        1.5e-3,
        (Contribution("machine", 1e-3), Contribution(READING, 0.5e-3), Contribution(PART_EXPANSION, 0.3e-3)),
        2.0,
    )
    other = RouteEstimate(
        "b",
        0.0,
        (Contribution("cal", 0.2e-3), Contribution(READING, 0.6e-3), Contribution(PART_EXPANSION, 0.3e-3)),
        2.0,
    )
    found = agreement(one, other)
    assert found.common_inputs == (READING, PART_EXPANSION)
    assert found.en == pytest.approx(1.5 / (2 * math.sqrt(1.04)))
    assert found.agrees
    # (1 + 0.25 + 0.09 + 0.04 + 0.36 + 0.09 - 1.04) / 2 = 0.395 um^2
    assert found.covariance * 1e6 == pytest.approx(0.395)
    # nothing shared: U = 2 sqrt(0.25 + 0.04 + 0.36 + 0.09) um = 1.7205 um
    assert not agreement(RouteEstimate("c", 1.8e-3, (Contribution("x", 0.5e-3),), 2.0), other).agrees


def test_student_factors_of_the_table() -> None:
    """JCGM 100:2008, table G.2: 95.45 % of 10 degrees of freedom 2.28, of 20 2.13, infinite 2.00."""
    assert coverage_factor(10) == pytest.approx(2.28, abs=0.005)
    assert coverage_factor(20) == pytest.approx(2.13, abs=0.005)
    assert coverage_factor(math.inf) == 2.0
