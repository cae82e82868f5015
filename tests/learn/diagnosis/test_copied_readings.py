"""Stretches of a recording that stand in it twice."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.learn.diagnosis.copied_readings import _equal_share


def test_the_share_of_equal_pairs_by_hand():
    """Of 1 1 1 2 the 4 x 3 / 2 = 6 pairs hold 3 x 2 / 2 = 3 equal ones; of four values that differ one pair in six is allowed for."""
    assert _equal_share(np.array([1.0, 1.0, 1.0, 2.0])) == pytest.approx(3 / 6)
    assert _equal_share(np.array([1.0, 2.0, 3.0, 4.0])) == pytest.approx(1 / 6)
    assert _equal_share(np.array([1.0, 1.0, 2.0, 2.0])) == pytest.approx(2 / 6)  # one pair of each
