"""The smallest relaxation that opens a pose."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.placing_independent import job
from vcmm.answer.placing.reach import CONSTRAINTS, Feasibility
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


class _Table:
    """Violations (2 poses, all constraints) that are given."""

    def __init__(self, **lacks: list[float]) -> None:
        self.lacks = np.stack([lacks.get(name, [0.0, 0.0]) for name in CONSTRAINTS], axis=1)

    def amounts(self, poses):
        return self.lacks


def test_no_constraint_gives_way_for_another():
    """The first pose lacks 5 mm of travel alone; the second 1 mm of table and 2 mm of travel: it opens for no single constraint."""
    found = relaxation(_Table(travel=[5.0, 2.0], table=[0.0, 1.0]), [HERE, HERE + 1.0])
    assert [(r.constraint, r.amount, r.pose[0]) for r in found] == [("travel", 5.0, 0.0)]
