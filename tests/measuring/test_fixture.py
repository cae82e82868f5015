"""What a fixture allows: faces turned down, departures of a pose."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.measuring.fixture import DOWN, pose_of, turned_down


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
