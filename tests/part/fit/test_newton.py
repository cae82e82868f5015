"""Descent to the least squares, and the foot of the point on the axis."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.part.fit.elements import ELEMENTS, free_pose
from vcmm.part.fit.newton import State, descend, seat, to_local


def test_a_circle_in_company_and_alone():
    # four points at 1, 1, 1 and 1.4: the best circle by symmetry has its centre on x; compare a fine search
    circle = ELEMENTS["cylinder"]
    points = np.array([[1.4, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]).T[None]
    begin = State(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.ones((1, 1)))
    state, done, _, _ = descend(circle, free_pose(circle, True), points, begin, 1e-12)
    assert done.all()

    def cost(x: float) -> float:
        rho = np.hypot(points[0, 0] - x, points[0, 1])
        return float(((rho - rho.mean()) ** 2).sum())

    grid = np.linspace(-0.5, 0.5, 200_001)
    best = grid[np.argmin([cost(x) for x in grid[::100]]) * 100]
    assert state.point[0, 0] == pytest.approx(best, abs=1e-3)
    assert cost(state.point[0, 0]) <= cost(best) + 1e-12
    twice = State(*(np.repeat(a, 2, axis=0) for a in begin))
    pair, _, _, _ = descend(circle, free_pose(circle, True), np.repeat(points, 2, axis=0), twice, 1e-12)
    assert np.array_equal(pair.point[0], state.point[0])


def test_local_coordinates_run_along_the_axis():
    state = State(np.array([[1.0, 0, 0]]), np.array([[0.0, 0.0, 1.0]]), np.ones((1, 1)))
    local, frame = to_local(np.array([[[1.0], [0.0], [5.0]]]), state)
    assert local[0, :, 0] == pytest.approx([0.0, 0.0, 5.0])
    assert frame[0, 2].tolist() == [0.0, 0.0, 1.0]


def test_the_point_of_a_cylinder_is_the_foot_of_the_origin():
    state = State(np.array([[1.0, 2.0, 7.0]]), np.array([[0.0, 0.0, 1.0]]), np.ones((1, 1)))
    assert seat(ELEMENTS["cylinder"], state).point[0].tolist() == [1.0, 2.0, 0.0]
    assert seat(ELEMENTS["sphere"], state).point[0].tolist() == [1.0, 2.0, 7.0]


def test_the_radius_of_a_cone_goes_with_its_point():
    # 45 deg: 7 lower the radius is 7 smaller
    state = State(np.array([[0.0, 0.0, 7.0]]), np.array([[0.0, 0.0, 1.0]]), np.array([[10.0, np.pi / 4]]))
    assert seat(ELEMENTS["cone"], state).sizes[0] == pytest.approx([3.0, np.pi / 4])
