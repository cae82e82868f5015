"""The map and the region within 2 % hold what they say."""

from __future__ import annotations

import numpy as np

from vcmm.measuring.fixture import Fixture, Freedom, pose_of, six_of
from vcmm.placing.fixture_boxes import boxes
from vcmm.placing.near_best import values_at
from vcmm.placing.travels import Travels


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
