"""Pictures of a machine: reach of the tip, surfaces of features, magnification of ellipsoids."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import BORE, LEFT, machine
from vcmm.part.part import Feature
from vcmm.show.pages.view import feature_mesh, magnification, reach


def test_reach_is_the_travel_moved_by_the_stylus():
    low, high = reach(machine(), np.array([0.0, 5.0, -100.0]))
    assert low.tolist() == [-1000.0, -995.0, -1100.0]
    assert high.tolist() == [1000.0, 1005.0, 900.0]


def test_surfaces_of_features():
    plane = feature_mesh(LEFT)
    assert plane is not None
    corners = np.asarray(plane.vertices)
    assert corners[:, 0] == pytest.approx([-50.0] * 4)
    assert np.ptp(corners, axis=0)[1:].tolist() == pytest.approx([40.0, 20.0])
    bore = feature_mesh(BORE)
    assert bore is not None
    vertices = np.asarray(bore.vertices)
    assert np.hypot(*vertices[:, :2].T).max() == pytest.approx(15.0)
    assert (vertices[:, 2].min(), vertices[:, 2].max()) == pytest.approx((0.0, 20.0))
    point = Feature("p", "point", np.zeros(3), np.array([0.0, 0.0, 1.0]), np.zeros(0))
    assert feature_mesh(point) is None


def test_ellipsoids_are_about_a_fifteenth_of_the_part():
    """u = 1 um on 150 mm: 10 mm / 1 um = 10 000, a round number already; with 3 um 3333, rounded down to 2000."""
    points = np.array([[0.0, 0.0, 0.0], [150.0, 0.0, 0.0]])
    for u, factor in ((1e-3, 1e4), (3e-3, 2e3)):
        assert magnification(points, np.tile(np.diag([u**2, 0, 0]), (2, 1, 1))) == pytest.approx(factor)
    assert magnification(points, np.zeros((2, 3, 3))) == 1.0


def test_a_magnification_whose_logarithm_rounds_up():
    """Exact factor a hair below 1000: log10 gives 3, and no round number is as small; the next is taken."""
    u = 150.0 / 15 / 999.9999999999999
    points = np.array([[0.0, 0.0, 0.0], [150.0, 0.0, 0.0]])
    assert magnification(points, np.tile(np.diag([u**2, 0, 0]), (2, 1, 1))) == pytest.approx(1000.0)
