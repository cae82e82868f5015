"""The map and the region within 2 % hold what they say."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.cases import plate
from vcmm.answer.placing.fixture_boxes import boxes
from vcmm.answer.placing.near_best import region, table_map, values_at
from vcmm.answer.placing.rows import Rows
from vcmm.answer.placing.search import SearchOutcome
from vcmm.answer.placing.travels import Travels
from vcmm.task.measuring.fixture import Fixture, Freedom, pose_of, six_of


@pytest.mark.thorough
def test_map_and_region_hold_what_they_say(placed):
    chart, flat = placed.map, placed.region
    assert chart.names == ("x", "y")
    assert chart.values.shape == (33, 33)
    assert np.nanmin(chart.values) >= placed.best.value * (1 - 1e-9)
    box = boxes(
        Fixture((*(Freedom(n, -np.inf, np.inf) for n in ("x", "y")), Freedom("turn_z", -np.pi, np.pi))),
        six_of(placed.objective.scenario.pose),
        Travels(placed.objective.closed.rows),
    )[0]
    rng = np.random.default_rng(77)
    poses = np.tile(placed.best.pose, (300, 1))
    for i, (low, high) in zip((0, 1, 5), flat.box.values()):
        poses[:, i] = rng.uniform(low, high, 300)
    values = values_at(placed.objective, box, poses)
    assert (values <= placed.best.value * 1.02).mean() > 0.98  # checked on other poses than these
    assert flat.convenient is not None
    assert flat.convenient_value <= placed.best.value * 1.02
    placed.objective.scenario.at(pose_of(flat.convenient)).task()  # it can be measured there


class Bowl:
    """1 + 1e-5 r^2 about (420, 130): within 2 % up to r = sqrt(2000) = 44.7 mm."""

    unit = "mm"

    def values(self, poses):
        return 1.0 + 1e-5 * ((poses[:, 0] - 420.0) ** 2 + (poses[:, 1] - 130.0) ** 2)


def test_the_region_of_a_bowl_by_hand(tmp_path):
    scenario = plate(tmp_path)
    box = boxes(
        Fixture((Freedom("x", 300.0, 500.0), Freedom("y", 100.0, 300.0))),
        six_of(scenario.pose),
        Travels(Rows.of(scenario)),
    )[0]
    pose = six_of(scenario.pose)
    pose[:2] = 420.0, 130.0
    outcome = SearchOutcome(box, box.unit(pose[None])[0], pose, 1.0, 1, ())
    found = region(Bowl(), outcome, np.array([1.0, 1.01, 1.02, 1.03]), seed=1)
    assert found.share == 0.75
    # along x the grid of 5 mm ends at 44.7 -> 40 mm to both sides; y ends at the fixture, 30 mm below, and 40 above
    assert np.hypot(40.0, 40.0) > 44.7  # so that the box of both is shrunk once by 0.7: 28, 21 and 28 mm
    assert found.box["x"] == pytest.approx((392.0, 448.0))
    assert found.box["y"] == pytest.approx((109.0, 158.0))
    assert found.convenient[:2].tolist() == [400.0, 100.0]  # 36 mm away: 1.013
    assert found.convenient_value == pytest.approx(1.013)
    chart = table_map(Bowl(), outcome, nodes=5)
    assert chart.x.tolist() == [300.0, 350.0, 400.0, 450.0, 500.0]
    assert chart.values[0, 2] == pytest.approx(1.0 + 1e-5 * (400 + 900))
