"""The boxes of a fixture reach the travels and no further; what would open one is said."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.cases import plate
from vcmm.answer.placing.fixture_boxes import boxes, default_fixture
from vcmm.answer.placing.rows import Rows
from vcmm.answer.placing.travels import Travels
from vcmm.core.errors import ModelLimit
from vcmm.task.measuring.fixture import Fixture, Freedom, pose_of, six_of


def test_boxes_reach_the_travels_and_no_further(tmp_path):
    """Corners of the box touch the travels: the largest and smallest positions of an axis are its ends."""
    scenario = plate(tmp_path)
    rows = Rows.of(scenario)
    box = boxes(default_fixture(), six_of(scenario.pose), Travels(rows))[0]
    six, ok = box.poses(np.array([[0.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.9]]))
    assert ok.all()
    at = rows.axis_positions(six)
    assert at[0, :, 0].min() == pytest.approx(0.0, abs=1e-9)
    assert at[1, :, 0].max() == pytest.approx(600.0, abs=1e-9)
    assert at[2, :, 1].max() == pytest.approx(500.0, abs=1e-9)
    for row in six:  # the plan accepts them
        scenario.at(pose_of(row)).task()
    assert np.allclose(box.unit(six), [[0.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.9]])


def test_no_reachable_pose_says_what_would_open_one(tmp_path):
    """The bore's lowest point needs Z = shift + 5 mm + 120 mm stylus; the fixture holds the part 100 mm too low."""
    scenario = plate(tmp_path)
    low = np.concatenate([six_of(scenario.pose)[:2], [-640.0], [0, 0, 0]])
    with pytest.raises(ModelLimit, match=r"travel of axis Z allows z from -524 to"):
        boxes(
            Fixture((Freedom("z", -660.0, -640.0), Freedom("x", 0.0, 600.0))), low, Travels(Rows.of(scenario))
        )
    # -524 - -640 = 116
    with pytest.raises(
        ModelLimit, match=r"move its upper end up by 116 mm to open a single pose, by 126 mm to leave 10 mm"
    ):
        boxes(Fixture((Freedom("z", -660.0, -640.0),)), low, Travels(Rows.of(scenario)))
