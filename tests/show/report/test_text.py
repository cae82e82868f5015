"""Words and numbers: rounding, dashes, widths."""

from __future__ import annotations

import math

import pytest

from tests.show.report.drawn import NAN
from vcmm.core.errors import UsageError
from vcmm.show.report import blocks as report
from vcmm.show.report.text import align_decimals, as_written, shorten, text_width


@pytest.mark.parametrize(
    ("x", "digits", "expected"),
    [
        (0.012345, 3, "0.0123"),
        (9.996, 3, "10.0"),  # rounds to 1.00e1: three digits again
        (12345.6, 3, "12346"),  # digits of the integer part are never destroyed
        (-1.5, 2, "−1.5"),
        (0.0, 3, "0"),
        (1.2e-7, 3, "1.20 × 10⁻⁷"),
        (NAN, 3, "–"),
        (math.inf, 3, "–"),
        (None, 3, "–"),
    ],
)
def test_number(x: float | None, digits: int, expected: str) -> None:
    assert report.number(x, digits) == expected


@pytest.mark.parametrize(
    ("x", "u", "expected"),
    [
        (110.00042, 0.00113, "110.0004 ± 0.0011"),
        (1.0, 0.0996, "1.00 ± 0.10"),  # 0.0996 -> 0.10, so the value goes to 0.01
        (4567.0, 123.0, "4570 ± 120"),  # the place is tens
        (-0.00004, 0.0012, "0.0000 ± 0.0012"),  # no minus zero
        (2.5, 0.0, "2.5 ± 0"),
        (NAN, 0.1, "–"),
        (1.0, math.inf, "–"),
        (0.125, 0.10, "0.13 ± 0.10"),  # half goes up
    ],
)
def test_with_uncertainty(x: float, u: float, expected: str) -> None:
    assert report.with_uncertainty(x, u) == expected


def test_numbers_refuse_nonsense() -> None:
    with pytest.raises(UsageError, match="significant digit"):
        report.number(1.0, 0)
    with pytest.raises(UsageError, match="negative"):
        report.with_uncertainty(1.0, -0.1)


def test_plain_and_aligned() -> None:
    assert as_written(30.021) == "30.021"
    assert as_written(100.0004) == "100.0004"
    assert as_written(-0.0) == "0"
    # the largest, 0.62, shows three digits: three decimals for all; 0.0001 would read 0.000
    assert align_decimals([0.62, 0.09, 0.0001, NAN, 0.0]) == ["0.620", "0.090", "0.0001", "–", "0.000"]


def test_shorten_fits() -> None:
    text = shorten("thermal expansion of the part", 12.5, 80)
    assert text_width(text, 12.5) <= 80
    head, tail = text.split("…")
    assert "thermal expansion of the part".startswith(head)
    assert "thermal expansion of the part".endswith(tail)
    names = [f"stylus_qualification[down].d by {cause}" for cause in ("repeatability", "sphere diameter")]
    assert len({shorten(n, 12.0, 200.0) for n in names}) == 2
    assert shorten("bore", 12.5, 1) == "…"
    assert shorten("bore", 12.5, 80) == "bore"
