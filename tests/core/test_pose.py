from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.pose import Pose, triad, unit

QUARTER = math.pi / 2.0


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    # the part of the contract's example: 10 mm along the part's x lie at 300, 250 + 10, -200 in the machine
    machine_from_part = Pose.from_turns((300.0, 250.0, -200.0), (0.0, 0.0, QUARTER))
    np.testing.assert_allclose(machine_from_part.apply((10.0, 0.0, 0.0)), [300.0, 260.0, -200.0], atol=1e-12)
    np.testing.assert_allclose(machine_from_part.turn((10.0, 0.0, 0.0)), [0.0, 10.0, 0.0], atol=1e-12)


def test_turns_act_about_fixed_axes_x_then_y_then_z() -> None:
    # z -> (about x, +90) -> -y -> (about z, +90) -> +x ; the other order would leave z at -y
    assert Pose.from_turns(np.zeros(3), (QUARTER, 0.0, QUARTER)).turn((0.0, 0.0, 1.0)) == pytest.approx(
        [1, 0, 0]
    )
    # x -> (about y, +90) -> -z -> (about z) -> -z
    assert Pose.from_turns(np.zeros(3), (0.0, QUARTER, QUARTER)).turn((1.0, 0.0, 0.0)) == pytest.approx(
        [0, 0, -1]
    )


@pytest.mark.parametrize(
    "turns", [(0.1, -0.7, 2.5), (-3.0, 1.2, 0.3), (0.4, QUARTER, 0.0), (0.4, -QUARTER, 0.0)]
)
def test_turns_can_be_read_back(turns: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(Pose.from_turns(np.zeros(3), turns).turns(), turns, atol=1e-9)


def test_inverse_and_product() -> None:
    b_from_a = Pose.from_turns((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    c_from_b = Pose.from_turns((-4.0, 5.0, 6.0), (-1.0, 0.5, 2.0))
    p = np.array([7.0, -8.0, 9.0])
    both = c_from_b.apply(b_from_a.apply(p))
    np.testing.assert_allclose((c_from_b @ b_from_a).apply(p), both, atol=1e-13)
    np.testing.assert_allclose(b_from_a.then(c_from_b).apply(p), both, atol=1e-13)
    np.testing.assert_allclose((b_from_a @ b_from_a.inverse()).apply(p), p, atol=1e-13)
    np.testing.assert_allclose(Pose.identity().apply(p), p)


def test_a_batch_gives_each_trial_its_own_pose() -> None:
    turns = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, QUARTER]])
    batch = Pose.from_turns([[0.0, 0.0, 0.0], [0.0, 0.0, 5.0]], turns)
    x = np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(batch.apply(x), [[1, 0, 0], [0, 1, 5]], atol=1e-15)
    points = np.arange(12.0).reshape(4, 3)
    assert batch.apply(points).shape == (2, 4, 3)
    np.testing.assert_allclose(batch.apply(points)[1, 2], [-7.0, 6.0, 13.0], atol=1e-14)  # of (6, 7, 8)
    np.testing.assert_allclose(batch.apply_each(np.stack([x, 2 * x])), [[1, 0, 0], [0, 2, 5]], atol=1e-15)
    np.testing.assert_allclose(batch.inverse().apply_each(batch.apply(x)), [x, x], atol=1e-15)
    np.testing.assert_allclose((batch @ batch.inverse()).rotation, np.stack([np.eye(3)] * 2), atol=1e-15)


def test_bad_poses_are_refused() -> None:
    with pytest.raises(UsageError, match="mirror"):
        Pose(np.diag([1.0, 1.0, -1.0]), np.zeros(3))
    with pytest.raises(UsageError, match="orthonormal"):
        Pose(np.eye(3) * 1.001, np.zeros(3))
    with pytest.raises(UsageError, match="finite"):
        Pose(np.eye(3), np.array([0.0, np.nan, 0.0]))
    with pytest.raises(UsageError, match="shift"):
        Pose(np.eye(3), np.zeros((2, 3)))
    with pytest.raises(UsageError, match="direction"):
        unit(np.zeros(3))


def test_the_arrays_of_a_pose_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        Pose.identity().shift[0] = 1.0


def test_triad_is_right_handed_and_starts_from_x() -> None:
    np.testing.assert_allclose(triad((0, 0, 2)), np.eye(3))
    np.testing.assert_allclose(triad((0, -1, 0)), [[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    np.testing.assert_allclose(triad((1, 0, 0)), [[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    np.testing.assert_allclose(triad((0, 0, 1), towards=(0, 3, 9)), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    assert np.linalg.det(triad((0.3, -0.5, 0.2))) == pytest.approx(1.0)
