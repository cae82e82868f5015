"""Machines that wander, against numbers by hand."""

import numpy as np
import pytest

from referee import fleet, follow


def test_the_signs_of_a_machine():
    # 10 um/m in X over 500 mm: 5 um; C0Y = 20 urad at y = 100: -2 um in x; B0Z = 30 urad at z = 200: +6 um in x; A0Z = 40 urad: -8 um in y
    theta = np.array([10e-6, 0, 0, 0, 0, 0, 20e-6, 30e-6, 40e-6])
    (error,) = fleet.tip(theta, np.array([[500.0, 100.0, 200.0]]))
    assert error == pytest.approx([5e-3 - 2e-3 + 6e-3, -8e-3, 0.0])


def test_a_bow_is_zero_at_both_ends_and_one_in_the_middle():
    theta = np.array([0, 0, 0, 2e-3, 0, 0, 0, 0, 0])
    x = np.array([[0.0, 0, 0], [250.0, 0, 0], [500.0, 0, 0]])
    assert fleet.tip(theta, x)[:, 0] == pytest.approx([0.0, -2e-3, 0.0])  # 4 x 0.5 x (0.5 - 1) = -1
    # between nodes at 200 and 300 mm (4 x 0.4 x -0.6 = -0.96) the table is a straight line
    assert fleet.tabulated(theta, fleet.NODES, x)[:, 0] == pytest.approx([0.0, -1.92e-3, 0.0])


def test_a_year_holds_what_is_told_of_it():
    theta, told = fleet.draw_year(np.random.default_rng(1), events=True)
    quiet, none = fleet.draw_year(np.random.default_rng(1), events=False)
    assert theta.shape == quiet.shape == (366, 9)
    assert none == []
    assert sorted(kind for _, kind, _ in told) == ["collision", "collision", "door", "encoder"]
    for day, kind, number in told:
        if kind == "door":  # off by 20 um/m and 15 urad while one check is done, and back the next day
            assert day % 7 == 0
            assert theta[day, :3] - theta[day - 1, :3] == pytest.approx(fleet.DOOR, abs=3e-6)
            assert theta[day + 1, :3] - theta[day, :3] == pytest.approx(-fleet.DOOR, abs=3e-6)
            continue
        size = fleet.COLLISION if kind == "collision" else fleet.ENCODER
        # a walk of a day is 8 / 19 urad at most a few times over
        assert abs(theta[day, number] - theta[day - 1, number]) == pytest.approx(size, abs=2.5e-6)


def test_the_table_of_the_machine_file_states_what_is_drawn():
    # at 500 mm: slope 4 um/m x 0.5 m = 2 um, no bow; at 200 mm: hypot(0.8, 1.5 x 0.96) um
    assert np.sqrt(np.diag(fleet.known_curve(0)))[[2, 5]] == pytest.approx([np.hypot(0.8e-3, 1.44e-3), 2e-3])


def test_shares_and_rates_have_their_exact_intervals():
    # 0 of 10: high 1 - 0.025^(1/10); 10 of 10: low 0.025^(1/10); no alarm in 10 years: -ln 0.025 / 10
    assert follow.exact_share(0, 10) == pytest.approx((0, 0, 1 - 0.025**0.1))
    assert follow.exact_share(10, 10) == pytest.approx((1, 0.025**0.1, 1))
    assert follow.exact_rate(0, 10) == pytest.approx((0, 0, -np.log(0.025) / 10))
    # shares 0.9 and 1.0: mean 0.95, s = 0.0707, u = 0.05, t(1) = 12.7062
    assert follow.share_of_machines([0.9, 1.0]) == pytest.approx((0.95, 0.95 - 0.635310, 0.95 + 0.635310))


def test_a_door_is_judged_on_its_day_and_its_return_is_no_false_alarm():
    names = [f"{d:03d}_probe.toml" for d in (0, 7, 14, 21)]
    alarms = [False, True, True, True]
    checks = [
        {"recording": n, "alarm": a, "changed": [{"name": "everything"}]} for n, a in zip(names, alarms)
    ]
    told = [(7, "door", -1)]
    assert follow.judge_changes({"checks": checks}, told) == [
        {"kind": "door", "found": True, "named": True, "said": "everything"}
    ]
    assert follow.false_alarms({"checks": checks}, told) == ["021_probe.toml"]
