"""Rounded centres and words of a new program, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.compensation.mill import SETUP, body, run, scale
from vcmm.compensation.writer import best_centre

HEAD = "%\nO1\nG21 G17 G40 G80 G90 G94 G54\nG0 X0 Y0 Z0\n"


def test_the_rounded_centre_keeps_both_radii_alike() -> None:
    """From (0, 0) to (2, 0): a centre at I 1.04, J 0.3 rounds to 1.0 in X, where both ends are equally far, not to 1.1."""
    wanted, origin, end = np.array([1.04, 0.3]), np.zeros(2), np.array([2.0, 0.0])
    assert best_centre(wanted, origin, end, 0.1) == pytest.approx((1.0, 0.3))
    # the same in diameters along X: 2.08, counted from 0, on whole steps of 0.1: 2.0
    twice = best_centre(wanted * [2, 1], origin, end, 0.1, (0.5, 1.0))
    assert twice == pytest.approx((2.0, 0.3))


def test_only_numbers_that_must_change_change(tmp_path) -> None:
    """X 100 errs by +10 um at 100 um/m: X 99.990; Y and the feed stay, byte for byte."""
    text = f"{HEAD}G1 X100. Y5. F500 (CUT)\nM30\n%\n"
    found = run(tmp_path, text, scale(100.0), SETUP)
    assert "G1 X99.990 Y5. F500 (CUT)\n" in body(found)


def test_increments_do_not_drift(tmp_path) -> None:
    """Ten steps of 10 mm with 12 um/m: each is 0.12 um short of the grid, and the last still ends at 99.9988 -> 99.999."""
    text = f"{HEAD}G91\n" + "G1 X10. F500\n" * 10 + "M30\n%\n"
    found = run(tmp_path, text, scale(12.0), SETUP)
    steps = [float(line.split("X")[1].split()[0]) for line in body(found) if line.startswith("G1 X")]
    assert sum(steps) == pytest.approx(99.999, abs=1e-9)
