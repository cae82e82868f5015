"""The smallest relaxation that opens a pose."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.placing_independent import job
from vcmm.answer.placing.reach import Feasibility
from vcmm.answer.placing.relax import no_reachable_pose, relaxation

HERE = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])


@pytest.mark.thorough
def test_relaxation_by_hand():
    """x may only lie between 170 and 190: the nearest, 170, lacks 5 mm of travel, and nothing else."""
    check = Feasibility.of(job(both=False))
    low, high = HERE.copy(), HERE.copy()
    low[0], high[0] = 170.0, 190.0
    points = np.linspace(low, high, 5)
    found = relaxation(check, points, low, high, polish=40)
    assert found[0].constraint == "travel"
    assert found[0].amount == pytest.approx(5.0, abs=1e-6)
    error = no_reachable_pose(found, check, found[0].pose)
    assert "travel by 5 mm" in str(error)
    assert "point 2 on top" in str(error)


def test_relaxation_of_an_open_space_is_zero():
    check = Feasibility.of(job(both=False))
    assert relaxation(check, HERE)[0].amount == 0.0
