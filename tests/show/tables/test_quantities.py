"""Numbers as people read them: hand-computed."""

from __future__ import annotations

import math

import pytest

from vcmm.show.tables import quantities as q

NAN = math.nan


def test_lengths_and_angles():
    assert q.length_text(30.000124, "mm") == "30.00012 mm"
    assert q.length_text(math.radians(90.0), "rad") == "90.000000 deg"
    assert q.value_on_page(math.radians(45.0), "rad") == "45.000000°"
    assert q.length_text(NAN, "mm") == "–"


def test_small_differences():
    assert q.deviation_text(-1.234e-3, "mm") == "-1.23 µm"
    assert q.deviation_text(2.5e-6, "rad") == "+2.50 µrad"
    assert q.deviation_text(2.5e-6, "rad", signed=False) == "2.50 µrad"
    assert q.departure_on_page(1.2345e-3, "mm") == "1.23"
    assert q.departure_on_page(-2.5e-6, "rad") == "−2.50 µrad"
    assert q.departure_on_page(9e-10, "mm") == "0"  # 0.9 pm is rounding
    assert q.departure_on_page(math.inf, "mm") == "–"


def test_what_rounds_to_nothing_has_no_minus():
    """-0.04 um with one decimal is nothing; a shift of the work offsets said "-0.0 µm"."""
    shift, offset = q.fixed(1, "um", 1e3, signed=True), q.fixed(1, "um", 1e3)
    assert [shift.terminal(v, "") for v in (-4e-5, 4e-5, -6e-5)] == ["+0.0 µm", "+0.0 µm", "-0.1 µm"]
    assert offset.terminal(-4e-5, "") == "0.0 µm"
    assert q.percent(0).terminal(-0.004, "") == "0%"
    assert q.in_file(4, 1e3)(-4e-9, "") == "0.0000"
    assert q.deviation_text(-4e-6, "mm") == "+0.00 µm"  # the column of biases said "-0.00 µm"


def test_very_small_differences():
    assert q.FINE.terminal(1.26e-7, "mm") == "0.13 nm"
    assert q.FINE.terminal(1.26e-9, "rad") == "0.0013 µrad"
    assert q.FINE.page is not None
    assert q.FINE.page(1.26e-7, "mm") == "0.13 nm"
    assert q.FINE.page(NAN, "mm") == q.FINE.terminal(NAN, "mm") == "not checked"


def test_intervals():
    assert q.span_text([-1.2e-4, 3.1e-4], "mm") == "[-0.12, +0.31] µm"
    assert q.span_text([-6e-17, math.inf], "mm") == "[+0.00, +inf] µm"  # a nominal of 6e-17 mm is none
    assert q.span([-1.2e-4, 3.1e-4], "mm") == "−0.120 … 0.310"
    assert q.span(None, "mm") == "–"


@pytest.mark.parametrize(
    ("writing", "value", "terminal", "page"),
    [
        (q.SHARE, 0.2473, "24.7 %", "24.7%"),
        (q.SHARE, None, "–", "–"),
        (q.fixed(2, "um", 1e3, signed=True), 1.2345e-3, "+1.23 µm", "+1.23 µm"),
        (q.fixed(1), -0.25, "-0.2", "-0.2"),  # halves go to the even digit
        (q.fixed(3), NAN, "–", "–"),
    ],
)
def test_writings(writing, value, terminal, page):
    assert writing.terminal(value, "mm") == terminal
    assert writing.page(value, "mm") == page


def test_shares_of_tables():
    assert q.percent(1).terminal(0.0123, "mm") == "1.2%"
    assert q.percent(0, signed=True).terminal(-0.5, "mm") == "-50%"
    assert q.percent(0).terminal(None, "mm") == "–"


def test_cells_of_files():
    assert q.in_file(4, 1e3)(1.23456e-3, "mm") == "1.2346"
    assert q.in_file(4)(NAN, "mm") == ""
    assert q.small_in_file(1.5e-6, "rad") == "1.5"
    assert q.small_in_file(None, "mm") == ""
