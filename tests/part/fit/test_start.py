"""Start values from the points alone: exact for exact points."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.part.fit.elements import ELEMENTS, free_pose
from vcmm.part.fit.gauss import algebraic_start

ANGLE = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)


def start(kind: str, points: np.ndarray, axis: np.ndarray | None = None):
    element = ELEMENTS[kind]
    return algebraic_start(element, free_pose(element, False), points.T[None], axis)


def test_a_sphere_through_exact_points():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    state = start("sphere", np.array([0.1, -0.2, 0.3]) + 0.7 * normals)
    assert state.point[0] == pytest.approx([0.1, -0.2, 0.3])
    assert state.sizes[0] == pytest.approx([0.7])


def test_a_plane_by_its_smallest_direction():
    points = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    assert np.abs(start("plane", points).axis[0]) == pytest.approx([0.0, 0.0, 1.0])


def test_a_line_by_its_largest_direction():
    points = np.array([[0.6, 0, 0.8]]) * np.linspace(-1, 1, 5)[:, None]
    assert np.abs(start("line", points).axis[0] @ [0.6, 0, 0.8]) == pytest.approx(1.0)


def test_a_cylinder_whose_axis_is_searched():
    axis = np.array([0.0, 0.6, 0.8])
    u, v = np.array([1.0, 0, 0]), np.cross(axis, [1.0, 0, 0])
    ring = 0.5 * (np.cos(ANGLE)[:, None] * u + np.sin(ANGLE)[:, None] * v)
    points = np.concatenate([ring + h * axis for h in (-0.8, 0.0, 0.8)])
    state = start("cylinder", points)
    assert abs(state.axis[0] @ axis) == pytest.approx(1.0, abs=1e-9)
    assert state.sizes[0] == pytest.approx([0.5], abs=1e-9)


def test_a_cone_about_a_known_axis():
    # radius 0.5 at the height 0, growing by tan(0.2)
    height = np.repeat([-0.5, 0.0, 0.5], len(ANGLE))
    rho, turn = 0.5 + np.tan(0.2) * height, np.tile(ANGLE, 3)
    points = np.stack([rho * np.cos(turn), rho * np.sin(turn), height], axis=1)
    state = start("cone", points, np.array([[0.0, 0.0, 1.0]]))
    assert state.sizes[0] == pytest.approx([0.5, 0.2])
