"""Travels and known ranges: which axis and which point is named."""

from __future__ import annotations

import pytest

from tests.placing.cases import plate
from vcmm.core.errors import ModelLimit
from vcmm.placing.rows import Rows
from vcmm.placing.travels import Travels


def test_travels_name_axis_and_point(tmp_path):
    scenario = plate(tmp_path, "", ('shift = "300 250 -300 mm"', 'shift = "20 250 -300 mm"'))
    problems = Travels(Rows.of(scenario)).problems(scenario.pose)
    assert [p.constraint for p in problems] == ["travel of axis X"]
    assert problems[0].point.startswith(("top#", "front#"))
    with pytest.raises(ModelLimit, match="axis X"):
        scenario.task()
