"""The referee's transforms against numbers by hand, signs of the contract."""

import numpy as np
import pytest

from referee.kinematics import Geometry, perfect, pose, tip_error, turn

AT = np.array([[300.0, 200.0, -100.0]])
ARM = np.array([0.0, 0.0, -120.0])


def with_error(axis, column, size):
    machine = perfect()

    def error(q):
        table = np.zeros((len(q), 6))
        table[:, column] = size
        return table

    return Geometry({**machine.errors, axis: error}, np.zeros(3), np.zeros(3))


@pytest.mark.parametrize("axis", "XYZ")
def test_a_translation_moves_the_tip_by_itself(axis):
    for column in range(3):
        wanted = np.zeros(3)
        wanted[column] = 0.001
        assert np.allclose(tip_error(with_error(axis, column, 0.001), AT, ARM)[0], wanted, atol=1e-12)


def test_pitch_of_z_swings_the_stylus():
    # 10 urad about Y, arm (0, 0, -120): b x r = (10e-6 * -120, 0, 0)
    assert np.allclose(tip_error(with_error("Z", 4, 10e-6), AT, ARM)[0], [-0.0012, 0, 0], atol=1e-8)


def test_yaw_of_x_reaches_only_what_x_carries():
    # X carries Z and the stylus, which have no arm in x and y: yaw does nothing, roll about X moves y by +10e-6 * 220
    assert np.allclose(tip_error(with_error("X", 5, 10e-6), AT, ARM)[0], 0, atol=1e-8)
    assert np.allclose(tip_error(with_error("X", 3, 10e-6), AT, ARM)[0], [0, 0.0022, 0], atol=2e-8)


def test_yaw_of_y_has_the_whole_arm_of_x():
    # Y carries X: (0, 0, c) x (300, 0, -220) = (0, 300 c, 0)
    assert np.allclose(tip_error(with_error("Y", 5, 10e-6), AT, ARM)[0], [0, 0.003, 0], atol=2e-8)


@pytest.mark.parametrize(
    ("number", "wanted"),
    [(2, (-200e-5, 0, 0)), (1, (-100e-5, 0, 0)), (0, (0, 100e-5, 0))],
)
def test_squareness_turns_the_travel_only(number, wanted):
    # C0Y = +c: (-c y, 0, 0); B0Z = +b: (b z, 0, 0), z = -100; A0Z = +a: (0, -a z, 0)
    square = np.zeros(3)
    square[number] = 1e-5
    machine = Geometry(perfect().errors, square, np.zeros(3))
    assert np.allclose(tip_error(machine, AT, ARM)[0], wanted, atol=5e-8)


def test_play_stops_short_of_the_target():
    machine = Geometry(perfect().errors, np.zeros(3), np.array([0.002, 0, 0]))
    assert np.allclose(tip_error(machine, AT, ARM, np.array([[1.0, 0, 0]]))[0], [-0.001, 0, 0])
    assert np.allclose(tip_error(machine, AT, ARM, np.array([[-1.0, 0, 0]]))[0], [0.001, 0, 0])


def test_a_quarter_turn_and_its_order():
    assert np.allclose(turn(np.array([0, 0, np.pi / 2])) @ [1, 0, 0], [0, 1, 0])
    matrix, _ = pose(np.zeros(3), np.array([90.0, 0, 90.0]))  # about x first: z -> -y; then about z: -y -> x
    assert np.allclose(matrix @ [0, 0, 1], [1, 0, 0])
