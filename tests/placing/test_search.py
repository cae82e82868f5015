"""The search, its certificate, and the whole job on drawn problems with a known answer or a dense reference."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import qmc

import vcmm
from tests.placing.cases import plate, with_field
from tests.placing.drawn import problem
from vcmm.measuring.fixture import Fixture, Freedom, Goal, pose_of, six_of
from vcmm.placing.certificate import _floor, certify, scan, scan_after
from vcmm.placing.confirm import _batches, fresh_seed
from vcmm.placing.flat import values_at
from vcmm.placing.objective import Uncertain
from vcmm.placing.rows import Rows
from vcmm.placing.search import Counted, search
from vcmm.placing.space import boxes
from vcmm.placing.travels import Problem, Travels


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


def test_the_lower_of_two_bowls(tmp_path):
    found = search(Bowl(), found_boxes(plate(tmp_path)), evaluations=2000)
    assert found.pose[:2] == pytest.approx([420, 130], abs=0.05)
    assert found.value == pytest.approx(1.0, abs=1e-6)
    assert found.evaluations <= 2000


def test_an_optimum_at_the_end_of_the_travel(tmp_path):
    """Uphill in +x: the lowest value is where an axis stands at its end."""
    slope = SimpleNamespace(unit="mm", values=lambda p: 1 + 1e-3 * (p[:, 0] + p[:, 1]))
    scenario = plate(tmp_path)
    found = search(slope, found_boxes(scenario), evaluations=1500)
    at = Rows.of(scenario).wanted(found.pose[None])[0]
    assert at[:, 0].min() == pytest.approx(0.0, abs=1e-6)
    assert at[:, 1].min() == pytest.approx(0.0, abs=1e-6)


def test_a_constraint_of_another_kind_is_kept(tmp_path):
    """Poses with x > 350 are forbidden; the lower bowl is out, its slope at the border is not."""

    class West:
        def problems(self, pose):
            return [Problem("wall", "a wall", "x", 1.0)] if pose.shift[0] > 350 else []

        def feasible(self, poses):
            return poses[:, 0] <= 350

    scenario = plate(tmp_path)
    box = boxes(
        Fixture((Freedom("x", 0, 600), Freedom("y", 0, 500))),
        six_of(scenario.pose),
        Travels(Rows.of(scenario)),
        (West(),),
    )
    found = search(Bowl(), box, evaluations=3000)
    assert found.pose[0] <= 350
    dense, ok = box[0].poses(qmc.Sobol(2, seed=1).random(16384))
    assert found.value <= Bowl().values(dense[ok]).min() * 1.0001


@pytest.mark.parametrize("seed", [2, 3])
def test_drawn_problems_against_a_dense_scan(seed):
    """A small version of tools/place_statistics.py: 3000 evaluations against a scan of 8000."""
    one = problem(seed)
    found = search(one.objective, one.boxes, evaluations=3000, seed=seed)
    assert found.evaluations <= 3000
    for box in one.boxes:
        ask = Counted(box, one.objective)
        best = min(ask(part).min() for part in np.array_split(qmc.Sobol(box.d, seed=9).random_base2(13), 4))
        assert found.value <= best * 1.001


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
    assert 0 < found.hidden < 0.05
    assert "none better among" in found.text
    assert "no bounds" in found.text
    assert f"better by {found.hidden:.2%}" in found.text
    assert "too coarse" in replace(found, hidden=2.5).text  # more than all of it: nothing is known


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


@pytest.fixture(scope="module")
def placed(tmp_path_factory):
    scenario = with_field(plate(tmp_path_factory.mktemp("plate")), 3)
    goal = Goal({"U": 1.0}, {"bore diameter": 0.5, "bore to front": 0.5})
    return vcmm.place(scenario, goal=goal, evaluations=800, scanned=256, trials=10_000, constraints=())


def test_gain_is_confirmed_out_of_sample(placed):
    """The gain by paired trials agrees with the closed form within its standard error and what k is good for."""
    sure = placed.confirmation
    assert sure is not None
    assert placed.present is not None
    assert sure.confirmed
    assert sure.seed == fresh_seed(placed.seed) != placed.seed
    closed = placed.present.value - placed.best.value
    assert sure.gain == pytest.approx(closed, abs=4 * sure.u_gain + 0.02 * closed)
    assert (
        0 < sure.u_gain < 0.1 * sure.gain
    )  # common random numbers: the difference is known better than either


def test_order_of_the_poses_and_the_full_evaluation(placed):
    assert placed.best.value <= placed.median.value <= placed.worst.value
    assert placed.best.value < placed.present.value
    for at, result in ((placed.best, placed.after), (placed.present, placed.before)):
        for i in placed.objective.smooth:
            assert result.characteristics[i].u == pytest.approx(at.u[i], rel=1e-3)
            assert result.characteristics[i].expanded == pytest.approx(at.expanded[i], rel=0.02)


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


def test_the_same_seed_gives_the_same_answer(tmp_path):
    scenario = with_field(plate(tmp_path), 5)
    options = {
        "evaluations": 100,
        "scanned": 32,
        "trials": 1000,
        "constraints": (),
        "goal": Goal({"U": 1.0}, {"bore diameter": 1.0}),
    }
    first, again = vcmm.place(scenario, **options), vcmm.place(scenario, **options)
    assert np.array_equal(first.best.pose, again.best.pose)
    assert first.confirmation == again.confirmation


def test_present_pose_out_of_reach_is_said(tmp_path):
    scenario = plate(tmp_path, "", ('shift = "300 250 -300 mm"', 'shift = "20 250 -300 mm"'))
    found = vcmm.place(
        scenario, evaluations=100, scanned=32, trials=1000, goal=Goal({"U": 1.0}, {"bore diameter": 1.0})
    )
    assert found.present is None
    assert found.before is None
    assert found.gain is None
    assert found.problems[0].constraint == "travel of axis X"
    assert any("cannot be used" in w for w in found.warnings)


def test_discrete_choices_are_enumerated(tmp_path):
    scenario = with_field(plate(tmp_path), 4)
    slots = ((150.0, 150.0, -300.0), (300.0, 250.0, -300.0), (430.0, 330.0, -300.0))
    turns = Freedom("turn_z", values=tuple(np.radians([0.0, 90.0, 180.0])))
    goal = Goal({"U": 1.0}, {"bore to front": 1.0})
    found = vcmm.place(
        scenario, fixture=Fixture((turns,), slots), goal=goal, evaluations=100, scanned=32, trials=1000
    )
    every = np.array([[*s, 0, 0, t] for s in slots for t in turns.values])
    values = found.objective.values(every)
    assert np.allclose(found.best.pose, every[values.argmin()])
    assert found.label.startswith("slot ")


def test_risk_and_cost_objectives(tmp_path):
    """What the closed form integrates is what the confirmation counts; a cost is prices times probabilities."""
    scenario, weights = with_field(plate(tmp_path), 3), {"bore diameter": 1.0}
    six = six_of(scenario.pose)
    risk = Uncertain.of(scenario, Goal({"risk": 1.0}, weights))
    judged = risk.judged(0, risk.spread(six[None]))
    assert risk.values(six[None])[0] == pytest.approx(judged.total[0])
    counted = _batches(risk, six, 7, 30)  # 150 000 trials of a probability of 0.4 %: 4 % by chance
    assert counted.mean() == pytest.approx(judged.total[0], rel=0.12)
    cost = Uncertain.of(scenario, Goal({"cost": 1.0}, weights, {"accept_bad": 100.0, "undecided": 2.0}))
    assert cost.values(six[None])[0] == pytest.approx(100 * judged.accept_bad[0] + 2 * judged.undecided[0])
