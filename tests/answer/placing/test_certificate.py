"""What the certificate says: a better pose is seen, the scan is fresh, the least influences are an estimate."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.answer.placing.cases import plate, with_field
from vcmm.answer.placing.certificate import _even, _floor, _hidden_gain, _spacing, certify, scan, scan_after
from vcmm.answer.placing.fixture_boxes import boxes
from vcmm.answer.placing.objective import Uncertain
from vcmm.answer.placing.rows import Rows
from vcmm.answer.placing.search import search
from vcmm.answer.placing.travels import Travels
from vcmm.task.measuring.fixture import Fixture, Freedom, Goal, six_of


def silent(text: str, share: float) -> None:
    del text, share


class Bowl:
    """Two bowls in x and y: the lower at (420, 130), value 1."""

    unit = "mm"

    def values(self, poses):
        x, y = poses[:, 0], poses[:, 1]
        low = 1.0 + 1e-5 * ((x - 420) ** 2 + (y - 130) ** 2)
        return np.minimum(low, 1.02 + 1e-6 * ((x - 120) ** 2 + (y - 400) ** 2))


def found_boxes(scenario, *freedoms):
    ends = [Freedom(n, -np.inf, np.inf) for n in ("x", "y")]
    return boxes(Fixture((*ends, *freedoms)), six_of(scenario.pose), Travels(Rows.of(scenario)))


def test_the_certificate_sees_a_better_pose(tmp_path):
    """A search that was stopped in the wrong bowl is found out, and the slopes leave room for what is hidden."""
    box = found_boxes(plate(tmp_path))
    good = search(Bowl(), box, evaluations=2000)
    seen = scan(Bowl(), box, 1024, 0, silent)
    better = certify(Bowl(), box, np.array([120.0, 400, -300, 0, 0, 0]), 1.02, seen).better
    assert better == pytest.approx(1 - seen.values.min() / 1.02)
    assert 0.015 < better <= 0.02 / 1.02
    found = certify(Bowl(), box, good.pose, good.value, seen)
    assert found.better == 0
    assert 0 < found.hidden_gain < 0.05
    assert "none better among" in found.text
    assert "no bounds" in found.text
    assert f"better by {found.hidden_gain:.2%}" in found.text
    assert "too coarse" in replace(found, hidden_gain=2.5).text  # more than all of it: nothing is known


def test_the_search_goes_on_from_a_better_pose_and_a_fresh_scan_follows(tmp_path):
    box = found_boxes(plate(tmp_path))
    good = search(Bowl(), box, evaluations=300)
    same, first, earlier = scan_after(Bowl(), box, good, 256, 0, silent)
    assert same is good
    assert earlier == 0.0
    bad = replace(good, pose=np.array([120.0, 400, -300, 0, 0, 0]), value=1.02)
    found, fresh, earlier = scan_after(Bowl(), box, bad, 256, 0, silent)
    assert earlier == pytest.approx(1 - first.values.min() / 1.02)
    assert found.value == pytest.approx(1.0, abs=1e-5)
    assert len(fresh.poses) == 256
    assert not (fresh.poses[:, None, :2] == first.poses[None, :, :2]).all(axis=2).any()
    assert "a scan before this one" in certify(Bowl(), box, found.pose, found.value, fresh, earlier).text


def test_what_the_certificate_says_is_not_made_true_by_going_on(tmp_path):
    """Values without any order: the best of n further poses beats the best of n that were seen before every other time."""

    def noise(p):
        drawn = np.sin(12.9898 * p[:, 0] + 78.233 * p[:, 1]) * 43758.5453
        return 1.0 + drawn - np.floor(drawn)

    rough, box = SimpleNamespace(unit="", values=noise), found_boxes(plate(tmp_path))
    start = replace(search(rough, box, evaluations=50), value=1.9)
    better = []
    for seed in range(20):
        found, seen, earlier = scan_after(rough, box, start, 1024, seed, silent)
        assert earlier > 0
        better.append(seen.values.min() < found.value)
    assert 0 < sum(better) < 20


def test_least_influences_are_an_estimate_that_counts_the_pose_found(tmp_path):
    """With every influence at its least the value is below that of every pose looked at, the one found among them."""
    scenario = with_field(plate(tmp_path), 3)
    objective = Uncertain.of(scenario, Goal({"U": 1.0}, {"bore diameter": 0.5, "bore to front": 0.5}))
    box = found_boxes(scenario, Freedom("turn_z", -np.pi, np.pi))
    found = search(objective, box, evaluations=400)
    for count in (16, 128):  # few poses of the scan, all of them worse than the one found
        seen = scan(objective, box, count, 0, silent)
        certificate = certify(objective, box, found.pose, found.value, seen)
        assert certificate.floor is not None
        least = found.value * (1 - certificate.floor)
        assert least <= min(found.value, seen.values.min())
    alone = _floor(objective, seen.poses[:0], found.pose, found.value)
    assert alone == pytest.approx(0.0, abs=1e-9)  # of the pose found alone: nothing to save


def test_what_the_slopes_leave_by_hand():
    """A slope of 3 per unit: the lowest pose of the scan, 2.75, may hide 3 x 0.1 = 0.3 beside it: 2.45, 10.9 % below 2.75."""
    rising = SimpleNamespace(values=lambda p: 2.0 + 3.0 * p[:, 0])
    box = SimpleNamespace(poses=lambda u: (np.tile(u, (1, 6)), np.ones(len(u), dtype=bool)))
    unit, values = np.array([[0.5], [0.25]]), np.array([3.5, 2.75])
    assert _hidden_gain(rising, box, unit, values, 2.75, 0.1) == pytest.approx(0.3 / 2.75)  # type: ignore[arg-type]
    assert _hidden_gain(rising, box, unit, values, 2.0, 0.1) == 0.0  # type: ignore[arg-type]


def test_an_even_scan_leaves_no_large_gap():
    """Sixteen poses in one freedom lie within a sixteenth of the range, each draw no farther than that."""
    unit = _even(1, 16, [1, 7, 0])
    assert sorted((unit[:, 0] * 16).astype(int).tolist()) == list(range(16))
    assert 0.03 < _spacing(unit).max() <= 1 / 16
    assert _even(0, 16, [1]).shape == (1, 0)
