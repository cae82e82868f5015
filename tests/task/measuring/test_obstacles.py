"""Clamps and table: where their corners are, and what contradicts."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.core.pose import Pose
from vcmm.task.measuring.obstacles import Clamp, Surroundings


def clamp(name: str = "jaw", z: float = 0.0) -> Clamp:
    return Clamp(name, (10.0, 20.0, 30.0), Pose(np.eye(3), np.array([100.0, 0.0, z])))


def test_corners_by_hand():
    corners = clamp().corners()
    assert corners.min(axis=0).tolist() == [95.0, -10.0, -15.0]
    assert corners.max(axis=0).tolist() == [105.0, 10.0, 15.0]
    assert len(np.unique(corners, axis=0)) == 8


def test_what_contradicts_is_reported_together():
    with pytest.raises(DataError) as caught:
        Surroundings(clamps=(clamp(), clamp(z=-50.0)), table=-20.0)
    assert len(caught.value.problems) == 2
    assert "Two clamps are named" in caught.value.problems[0]
    assert "lies below the table at -20 mm" in caught.value.problems[1]
    # 10 mm of the second stand above a table at -45 mm
    Surroundings(clamps=(clamp(), clamp("stop", z=-50.0)), table=-45.0)
