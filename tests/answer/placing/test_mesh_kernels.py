"""Distance to one triangle by hand, in each of the regions around it, and the solid angle it fills."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.placing._mesh_kernels import mesh_distance

CORNERS = np.array([[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]])


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("point", "distance"),
    [
        ((1.0, 1.0, 2.0), 2.0),  # above the face
        ((-3.0, -4.0, 0.0), 5.0),  # at the first corner
        ((7.0, -4.0, 0.0), 5.0),  # at the second
        ((-3.0, 8.0, 0.0), 5.0),  # at the third
        ((2.0, -3.0, 4.0), 5.0),  # beside the first edge
        ((-3.0, 2.0, 4.0), 5.0),  # beside the last
        ((4.0, 4.0, 1.0), 3.0),  # beside the slant: sqrt(8 + 1)
    ],
)
def test_regions_of_a_triangle(point, distance):
    found, _ = mesh_distance(np.array([point]), CORNERS)
    assert found[0] == pytest.approx(distance)


def test_solid_angle_by_hand():
    """Three far points on the axes fill an octant: 1/8 of the sphere, negative the other way round."""
    octant = 1e6 * np.array([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]])
    _, turn = mesh_distance(np.zeros((1, 3)), octant)
    assert turn[0] == pytest.approx(1 / 8)
    _, other = mesh_distance(np.zeros((1, 3)), octant[:, ::-1].copy())
    assert other[0] == pytest.approx(-1 / 8)
