"""Codes of ISO 286 and general tolerances against numbers of the printed tables."""

from __future__ import annotations

import itertools
import math

import pytest

from vcmm.core.errors import UsageError
from vcmm.part.gps.general import general_limits, general_zone
from vcmm.part.gps.iso286 import limits_of_code


@pytest.mark.parametrize(
    ("code", "size", "low", "high"),
    [
        ("H7", 30, 0, 21), ("H7", 10, 0, 15), ("H8", 50, 0, 39), ("H11", 100, 0, 220), ("G6", 25, 7, 20), ("F7", 40, 25, 50),
        ("E9", 60, 60, 134), ("D10", 20, 65, 149), ("JS9", 30, -26, 26), ("K7", 30, -15, 6), ("K6", 30, -11, 2), ("M7", 30, -21, 0),
        ("N7", 30, -28, -7), ("P7", 30, -35, -14), ("N9", 30, -52, 0), ("R7", 30, -41, -20), ("S7", 60, -72, -42), ("M8", 30, -29, 4),
        ("K7", 3, -10, 0), ("M6", 300, -41, -9), ("C11", 45, 130, 290),
    ],
)  # fmt: skip
def test_bores(code: str, size: float, low: float, high: float) -> None:
    assert limits_of_code(code, size, True) == pytest.approx((low * 1e-3, high * 1e-3), abs=5e-7)


@pytest.mark.parametrize(
    ("code", "size", "low", "high"),
    [
        ("h6", 30, -13, 0), ("g6", 30, -20, -7), ("f7", 30, -41, -20), ("e8", 80, -106, -60), ("d9", 100, -207, -120),
        ("js6", 30, -6.5, 6.5), ("k6", 30, 2, 15), ("m6", 30, 8, 21), ("n6", 30, 15, 28), ("p6", 30, 22, 35), ("r6", 60, 41, 60),
        ("s6", 30, 35, 48), ("k8", 30, 0, 33), ("h9", 3, -25, 0), ("c11", 20, -240, -110),
    ],
)  # fmt: skip
def test_shafts(code: str, size: float, low: float, high: float) -> None:
    assert limits_of_code(code, size, False) == pytest.approx((low * 1e-3, high * 1e-3), abs=5e-7)


def test_codes_that_mean_nothing_here() -> None:
    with pytest.raises(UsageError, match='a bore takes capitals, for example "H7"'):
        limits_of_code("h7", 30.0, True)
    with pytest.raises(UsageError, match="up to 500 mm"):
        limits_of_code("H7", 600.0, True)
    with pytest.raises(UsageError, match="not held here"):
        limits_of_code("zb7", 30.0, False)
    with pytest.raises(UsageError, match="no tolerance code"):
        limits_of_code("7H", 30.0, True)


def test_iso_2768() -> None:
    assert general_limits("ISO 2768-mK", "size", 30.0) == (-0.2, 0.2)
    assert general_limits("ISO 2768-f", "distance", 30.1) == (-0.15, 0.15)
    assert general_limits("ISO 2768-m", "size", 2.0) == (-0.1, 0.1)
    assert general_limits("ISO 2768-c", "angle", 60.0) == pytest.approx(
        (-math.radians(0.5), math.radians(0.5))
    )
    assert general_limits("ISO 2768-K", "size", 30.0) is None
    assert general_zone("ISO 2768-mK", "flatness", 80.0) == 0.2
    assert general_zone("ISO 2768-mH", "perpendicularity", 80.0) == 0.2
    assert general_zone("ISO 2768-mL", "circular_runout", 40.0) == 0.5
    assert general_zone("ISO 2768-m", "flatness", 80.0) is None
    with pytest.raises(UsageError, match="no tolerance for 2500 mm"):
        general_limits("ISO 2768-f", "size", 2500.0)
    with pytest.raises(UsageError, match="is no general tolerance"):
        general_limits("ISO 2768-x", "size", 25.0)


def test_a_grade_by_its_formula() -> None:
    """IT5 = 7 i, i = 0.45 D^(1/3) + 0.001 D um with D = sqrt(120 * 180) = 146.97 mm: i = 0.45 * 5.277 + 0.147 = 2.522, 7 i = 17.65, rounded 18."""
    assert limits_of_code("h5", 150.0, False) == pytest.approx((-0.018, 0.0), abs=5e-7)


def test_every_number_is_nearer_to_its_grade_than_to_the_next() -> None:
    """IT5 to IT16 are 7, 10, 16, 25, 40, ... 1000 i (ISO 286-1, rounded, small sizes coarsely); the nearest two grades differ by 10 / 7, of which
    the root is 1.195."""
    ends = [1, 3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500]
    grades = zip(range(5, 17), (7, 10, 16, 25, 40, 64, 100, 160, 250, 400, 640, 1000))
    for (grade, multiple), (low, high) in itertools.product(grades, itertools.pairwise(ends)):
        mean = math.sqrt(low * high)
        zone = multiple * (0.45 * mean ** (1 / 3) + 0.001 * mean)
        stated = 1e3 * limits_of_code(f"H{grade}", high, True)[1]
        assert max(stated / zone, zone / stated) < math.sqrt(10 / 7), (grade, high)
