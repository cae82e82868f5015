"""Travels and known ranges: which axis and which point is named."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.cases import plate
from tests.build import scenario
from vcmm.answer.placing.rows import Rows
from vcmm.answer.placing.travels import Travels
from vcmm.core.declaration import KnownRange
from vcmm.core.effect import known_range
from vcmm.core.errors import ModelLimit
from vcmm.core.pose import Pose
from vcmm.physics.structure.component import ComponentSpline
from vcmm.physics.structure.residual import CorrelatedField
from vcmm.physics.structure.scatter import Scatter


def test_travels_name_axis_and_point(tmp_path):
    there = plate(tmp_path, "", ('shift = "300 250 -300 mm"', 'shift = "20 250 -300 mm"'))
    problems = Travels(Rows.of(there)).problems(there.pose)
    assert [p.constraint for p in problems] == ["travel of axis X"]
    assert problems[0].point.startswith(("top#", "front#"))
    with pytest.raises(ModelLimit, match="axis X"):
        there.task()


def test_intervals_by_hand():
    """Travels of +-1000 mm, tip centres at x = +-52 mm and z = 5 to 15 mm, a stylus of 100 mm down."""
    travels = Travels(Rows.of(scenario()))
    low, high = travels.intervals(np.zeros((1, 6)))
    assert (low[0, 0], high[0, 0]) == pytest.approx((-948.0, 948.0))
    assert (low[0, 2], high[0, 2]) == pytest.approx((-1105.0, 885.0))
    quarter = np.array([[0, 0, 0, 0, 0, np.pi / 2]])
    assert travels.intervals(quarter)[1][0, 1] == pytest.approx(948.0)  # x has become y
    six = np.array([[948.0, 0, 0, 0, 0, 0], [948.1, 0, 0, 0, 0, 0]])
    assert travels.feasible(six).tolist() == [True, False]
    found = travels.problems(Pose(np.eye(3), np.array([950.5, 0.0, 0.0])))
    assert [(p.name, p.constraint, p.amount) for p in found] == [
        ("travel", "travel of axis X", pytest.approx(2.5))
    ]
    assert found[0].text == f"travel of axis X at {found[0].point}: 2.5 mm too far"


def test_known_ranges_by_hand():
    spline = ComponentSpline("EXY", nodes=np.array([0.0, 200.0, 500.0]), values=np.zeros(3))
    assert list(spline.known_range()) == [KnownRange("range of the table EXY", 1, 0.0, 500.0)]
    at = np.array([[0.0, -10, 5], [100.0, 20, 30], [50.0, 0, 10]])
    field = CorrelatedField(nodes=at, deviation=np.full((3, 3), 1e-3), length=100.0)
    name = "range of correlated_field"
    assert list(field.known_range()) == [
        KnownRange(name, 0, 0, 100, "tip"),
        KnownRange(name, 1, -10, 20, "tip"),
        KnownRange(name, 2, 5, 30, "tip"),
    ]
    assert list(known_range(Scatter())) == []
