"""Codes of ISO 286 and general tolerances against numbers of the printed tables."""

from __future__ import annotations

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
