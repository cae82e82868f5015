"""What a placement returns: its gain, and its document."""

from __future__ import annotations

import json

import numpy as np
import pytest

from vcmm.answer.placing.near_best import Map
from vcmm.answer.placing.result import freedom_key, map_json, place_json, pose_json


def test_poses_and_maps_as_json():
    six = np.array([1.0, 2.0, 3.0, 0.0, np.pi / 2, -np.pi])
    assert pose_json(six)["turn_deg"] == pytest.approx([0.0, 90.0, -180.0])
    assert pose_json(six)["shift_mm"] == [1.0, 2.0, 3.0]
    assert (freedom_key("x"), freedom_key("turn_z")) == ("x_mm", "turn_z_rad")
    chart = Map(("x", "turn_z"), np.array([1.0, 2.0]), np.array([0.5]), np.array([[4.0, np.nan]]))
    assert map_json(chart) == {
        "over": ["x_mm", "turn_z_rad"],
        "x_mm": [1.0, 2.0],
        "turn_z_rad": [0.5],
        "objective": [[4.0, None]],
    }


@pytest.mark.thorough
def test_a_scan_that_is_too_coarse_estimates_nothing(placed):
    from dataclasses import replace

    coarse = replace(placed, certificate=replace(placed.certificate, hidden_gain=1.7))
    assert place_json(coarse)["certificate"]["hidden"] is None
    assert (
        place_json(replace(placed, certificate=replace(placed.certificate, hidden_gain=0.04)))["certificate"][
            "hidden"
        ]
        == 0.04
    )


def test_the_document_says_what_was_found(placed):
    body = json.loads(json.dumps(place_json(placed)))
    gain = 1.0 - placed.best.value / placed.present.value
    assert body["present"]["gain"] == pytest.approx(gain) == pytest.approx(placed.gain)
    assert body["objective"]["value"] == placed.best.value
    assert body["confirmation"]["confirmed"] is True
    why = {row["name"]: row for row in body["why"]}
    for c in placed.after.characteristics:
        inputs = {b["input"]: b["u_best_" + c.unit] for b in why[c.name]["budget"]}
        assert inputs == {b.input: b.u for b in c.budget}
