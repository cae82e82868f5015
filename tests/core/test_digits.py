"""The step in which numbers are written, by pencil."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.digits import written_step


@pytest.mark.parametrize(
    ("cells", "step"),
    [
        (["12.34", "5.17", "0.02"], 0.01),
        (["10.00", "10.00"], 0.01),  # written on purpose
        (["15.0", "0.0", "10.0"], 0.0),  # exact numbers as a program prints them
        (["12.34000", "5.17000", "0.02000", "7.11000", "3.05000", "9.96000"], 0.01),  # rounded before
        (["15.000000", "0.000000"], 1e-6),  # round by chance or nominal: what is written counts
        (["1.2345e1", "2.3e-2"], 1e-3),
        (["12,34", "5,17"], 0.01),
        (["101", "203", "307", "409", "512"], 1.0),
        (["ring", "nan"], 0.0),
    ],
)
def test_step(cells: list[str], step: float) -> None:
    assert written_step([cells]) == pytest.approx(step, rel=1e-12)


def test_the_finest_column_counts() -> None:
    """Heights are set, 5 and 15 mm; x and y are measured."""
    assert written_step([["12.3456", "9.1111"], ["5.00", "15.00"]]) == pytest.approx(1e-4)


def test_steps_of_five() -> None:
    cells = [f"{0.005 * k:.3f}" for k in np.random.default_rng(1).integers(0, 9999, 60)]
    assert written_step([cells]) == pytest.approx(0.005)
