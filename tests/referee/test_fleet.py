"""Machines that wander, against numbers by hand."""

import numpy as np
import pytest

from referee import fleet


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
    assert sorted(kind for _, kind, _ in told) == ["collision", "collision", "encoder"]
    for day, kind, number in told:
        size = fleet.COLLISION if kind == "collision" else fleet.ENCODER
        # a walk of a day is 8 / 19 urad at most a few times over
        assert abs(theta[day, number] - theta[day - 1, number]) == pytest.approx(size, abs=2.5e-6)


def test_the_table_of_the_machine_file_states_what_is_drawn():
    # at 500 mm: slope 4 um/m x 0.5 m = 2 um, no bow; at 200 mm: hypot(0.8, 1.5 x 0.96) um
    assert np.sqrt(np.diag(fleet.known_curve(0)))[[2, 5]] == pytest.approx([np.hypot(0.8e-3, 1.44e-3), 2e-3])
