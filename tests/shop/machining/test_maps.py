"""Nets over features, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.part.part import Feature
from vcmm.shop.machining.maps import MARGIN, net

Z = np.array([0.0, 0.0, 1.0])


def test_a_plane_to_its_margin():
    """40 x 20 mm, 1 % of the size from each edge: 19.6 and 9.8 mm from the middle."""
    over = net(Feature("top", "plane", np.zeros(3), Z, np.zeros(0), extent=(40.0, 20.0)), 5)
    assert over.points.shape == (25, 3)
    assert np.ptp(over.points, axis=0).max() == pytest.approx(40.0 * (1 - 2 * MARGIN))
    assert over.faces.shape == (2 * 4 * 4, 3)
    first, second, third = (over.points[over.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(second - first, third - first), axis=1).sum() / 2
    assert area == pytest.approx(39.2 * 19.6)


def test_a_cylinder_all_round():
    over = net(Feature("c", "cylinder", np.zeros(3), Z, np.array([10.0]), extent=(30.0,)), 5)
    assert len(over.first) == 9
    assert np.hypot(*over.points[:, :2].T) == pytest.approx(np.full(len(over.points), 10.0))
    assert np.einsum("ni,ni->n", over.points[:, :2], over.normals[:, :2]) == pytest.approx(
        np.full(len(over.points), 10.0)
    )


def test_points_have_no_net():
    assert net(Feature("p", "point", np.zeros(3), Z, np.zeros(0))) is None
