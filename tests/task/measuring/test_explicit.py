"""Points that are given one by one lie on their surface, or are refused by number."""

from __future__ import annotations

import numpy as np
import pytest

from tests.task.measuring.test_strategies import BORE, NONE, TOP
from vcmm.core.errors import UsageError
from vcmm.part.mesh import Mesh
from vcmm.part.part import Feature
from vcmm.task.measuring.explicit import on_surface


def test_explicit_points_get_their_normals() -> None:
    angle = np.arange(6.0)
    points = np.stack([15.0 * np.cos(angle), 15.0 * np.sin(angle), angle], axis=1)
    same, normals = on_surface(BORE, points)
    np.testing.assert_array_equal(same, points)
    np.testing.assert_allclose(normals[0], [-1, 0, 0])
    _, given = on_surface(BORE, points, normals=2.0 * normals)
    np.testing.assert_allclose(given, normals)


def test_explicit_points_off_the_surface_are_named() -> None:
    points = np.array([[0.0, 0, 20], [1, 0, 20], [0, 1, 20.5]])
    with pytest.raises(UsageError, match=r'"top": point 3 lies 0\.5 mm from the nominal surface'):
        on_surface(TOP, points)
    assert len(on_surface(TOP, points, tolerance=0.6)[0]) == 3
    with pytest.raises(UsageError, match="point 2 points into the material"):
        on_surface(TOP, points, normals=[[0, 0, 1], [0, 0, -1], [0, 0, 1]], tolerance=0.6)
    with pytest.raises(UsageError, match="as many normals"):
        on_surface(TOP, points, normals=[[0, 0, 1]], tolerance=0.6)
    with pytest.raises(UsageError, match="at least 3 points"):
        on_surface(TOP, points[:2])
    with pytest.raises(UsageError, match="finite"):
        on_surface(TOP, points * np.nan)


def test_points_on_a_mesh_take_the_normal_of_the_facet() -> None:
    free = Feature("free", "mesh", np.zeros(3), np.zeros(3), NONE)
    mesh = Mesh(np.array([[0, 0, 1], [4, 0, 1], [0, 4, 1.0]]), np.array([[0, 1, 2]]))
    _, normals = on_surface(free, [[1.0, 1.0, 1.001]], mesh=mesh)
    np.testing.assert_allclose(normals, [[0, 0, 1]])
    with pytest.raises(UsageError, match="pass the mesh"):
        on_surface(free, [[1.0, 1.0, 1.0]])
    with pytest.raises(UsageError, match=r"lies 0\.5 mm"):
        on_surface(free, [[1.0, 1.0, 1.5]], mesh=mesh)
