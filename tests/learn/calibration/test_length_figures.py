"""ISO 10360-2: the error of every length against the limit of that length, and the probability that belongs to it."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.learn.calibration.acceptance import against_limits


def test_the_largest_share_of_the_limit_and_its_probability_by_pencil() -> None:
    """MPE = 1 um + L/100: 2 um at 100 mm, 11 um at 1000 mm.

    machine   |E| at 100, 1000 mm   E/MPE           largest
    1         1.0, 6.6 um           0.50, 0.60      0.60 at 1000 mm
    2         2.4, 6.6 um           1.20, 0.60      1.20 at 100 mm
    3         1.8, 5.5 um           0.90, 0.50      0.90 at 100 mm
    4         2.2, 8.8 um           1.10, 0.80      1.10 at 100 mm
    The largest |E| (6.6, 6.6, 5.5, 8.8 um) is that of the long length and far within its limit: it would say that all pass.
    Mean of the largest 3.8 / 4 = 0.95, standard deviation sqrt((0.35^2 + 0.25^2 + 0.05^2 + 0.15^2) / 4) = 0.22913; two of four pass.
    """
    errors = np.array([[1.0, 6.6], [2.4, 6.6], [1.8, 5.5], [2.2, 8.8]]) * 1e-3
    found = against_limits("E0", errors, np.array([2e-3, 11e-3]), np.array([100.0, 1000.0]))
    assert found.ratio == pytest.approx(0.95)
    assert found.u_ratio == pytest.approx(0.229129, abs=1e-6)
    assert (found.at_mm, found.p_pass) == (100.0, 0.5)
    assert found.limit_um == pytest.approx(2.0)
