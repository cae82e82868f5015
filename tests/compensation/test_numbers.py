"""How numbers are rounded and written, by hand."""

from __future__ import annotations

import pytest

from vcmm.compensation.numbers import Diffusion, format_number, nearest


def test_rounding_is_carried_along_a_chain() -> None:
    """Four times 0.3 of a step: 0, 1, 0, 0 steps; what is carried never exceeds half a step, and 1.2 steps have become 1."""
    one = Diffusion(1.0)
    assert [one.next(0.3) for _ in range(4)] == [0.0, 1.0, 0.0, 0.0]
    assert one.carry == pytest.approx(0.2)
    one.forget()
    assert one.next(0.3) == 0.0


@pytest.mark.parametrize(
    ("value", "decimals", "like", "text"),
    [
        (1.23456, 3, "", "1.235"),
        (-0.0001, 3, "", "0.000"),  # no minus zero
        (0.5, 3, ".25", ".500"),
        (-0.5, 3, "-.25", "-.500"),
        (2.0, 3, "+1.", "+2.000"),
        (2.5, 2, "1,5", "2,50"),
    ],
)
def test_the_style_of_the_word_that_is_replaced(value, decimals, like, text) -> None:
    assert format_number(value, decimals, like) == text


def test_increments_have_no_point() -> None:
    assert format_number(1.5, 3, "1000", increments=True) == "1500"
    assert nearest(0.0374, 0.005) == pytest.approx(0.035)
