"""What a fixture allows: faces turned down, departures of a pose."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.measuring.fixture import DOWN, Fixture, Freedom, off_fixture, pose_of, turned_down


@pytest.mark.parametrize("direction", [*DOWN.values(), (0.6, 0.0, -0.8), (0.36, 0.48, 0.8)])
def test_a_face_is_turned_down(direction):
    a, b = turned_down(direction)
    assert np.allclose(
        pose_of(np.array([0, 0, 0, a, b, 0])).turn(np.array(direction)), [0, 0, -1], atol=1e-12
    )


def test_plus_x_down_by_hand():
    # Ry(90 deg) takes x = (1, 0, 0) to (cos 90, 0, -sin 90) = (0, 0, -1)
    assert turned_down((1, 0, 0)) == pytest.approx((0.0, np.pi / 2)) or turned_down((1, 0, 0))[
        1
    ] == pytest.approx(np.pi / 2)


def test_departures_by_hand():
    """Ranges, lists (turns go round), slots, faces: mm and rad by which a pose misses them."""
    fixture = Fixture((Freedom("x", 10.0, 20.0), Freedom("turn_z", values=(0.0, np.pi / 2))))
    six = np.array(
        [[7.0, 0, 0, 0, 0, -0.1], [21.5, 0, 0, 0, 0, 2 * np.pi - 0.2], [15.0, 9, 9, 0, 0, np.pi / 2]]
    )
    shift, turn = off_fixture(fixture, six)
    assert shift == pytest.approx([3.0, 1.5, 0.0])
    assert turn == pytest.approx([0.1, 0.2, 0.0])
    slots = Fixture(slots=((0.0, 0.0, 0.0), (100.0, 0.0, 0.0)))
    assert off_fixture(slots, np.array([[97.0, 4.0, 0, 0, 0, 0]]))[0] == pytest.approx([5.0])
    down = Fixture(faces={"bottom": (0.0, 0.0, -1.0), "side": (1.0, 0.0, 0.0)})
    assert off_fixture(down, np.array([[0, 0, 0, 0.3, 0, 1.0]]))[1] == pytest.approx([0.3])
    fixed = Fixture((Freedom("y", values=(5.0, 9.0)),))
    assert off_fixture(fixed, np.array([[0, 6.5, 0, 0, 0, 0.0]]))[0] == pytest.approx([1.5])
