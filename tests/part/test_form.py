"""Lobes on a round feature."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import BORE, LEFT
from vcmm.core.errors import UsageError
from vcmm.part.form import Lobes
from vcmm.part.part import frame


def test_three_lobes_by_hand():
    # cos 3 theta at 0, 20 and 60 deg from u: 1, 0.5, -1
    u, v, _ = frame(BORE)
    theta = np.radians([0.0, 20.0, 60.0])
    points = 15.0 * (np.cos(theta)[:, None] * u + np.sin(theta)[:, None] * v)
    assert Lobes(3, 2e-3).deviation(BORE, points) == pytest.approx([2e-3, 1e-3, -2e-3])
    assert Lobes(3, 2e-3, np.radians(20.0)).deviation(BORE, points)[1] == pytest.approx(2e-3)


def test_a_plane_has_no_lobes():
    with pytest.raises(UsageError, match="not of a plane"):
        Lobes(3, 1e-3).deviation(LEFT, np.zeros((1, 3)))
