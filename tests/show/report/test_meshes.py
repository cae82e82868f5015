"""Volumes and directions of the solids."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.show.report import blocks as report


def volume(solid: tuple[np.ndarray, np.ndarray]) -> float:
    v, f = solid
    a, b, c = (v[f[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_mesh_volumes() -> None:
    def polygon(radius: float, n: int) -> float:
        return n / 2 * radius**2 * math.sin(2 * math.pi / n)

    assert volume(report.box_mesh((1, 1, 1), (2, 3, 4))) == pytest.approx(6)
    assert volume(report.cylinder_mesh((9, 8, 7), (0, 1, 1), 2, 5)) == pytest.approx(5 * polygon(2, 48))
    tube = report.tube_mesh((9, 8, 7), (1, 0, 0), 3, 2, 4)
    assert volume(tube) == pytest.approx(4 * (polygon(3, 48) - polygon(2, 48)))
    assert volume(report.cone_mesh((0, 0, 1), (0, 0, 1), 2, 3)) == pytest.approx(polygon(2, 48))  # A h / 3
    assert volume(report.sphere_mesh((5, 5, 5), 2, n=96)) == pytest.approx(4 / 3 * math.pi * 8, rel=2e-3)
    torus = report.torus_mesh((0, 0, 0), (0, 0, 1), 5, 1, n=192)
    assert volume(torus) == pytest.approx(2 * math.pi**2 * 5, rel=2e-3)


def test_open_meshes_face_the_right_way() -> None:
    v, f = report.cylinder_mesh((0, 0, 0), (0, 0, 1), 2, 5, inside=True)
    normal = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    assert (np.einsum("ij,ij->i", normal[:, :2], v[f].mean(axis=1)[:, :2]) < 0).all()
    for axis in ((0, 0, 1), (0, -1, 0), (1, 0, 0), (1, 1, 1)):
        v, f = report.plane_mesh((1, 2, 3), axis, 4, 2)
        assert np.cross(v[1] - v[0], v[2] - v[0]) == pytest.approx(8 * np.array(axis) / np.linalg.norm(axis))
    v, f = report.disc_mesh((0, 0, 1), (0, 0, -1), 1.0)
    assert (np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])[:, 2] < 0).all()
    with pytest.raises(UsageError, match="lo < hi"):
        report.box_mesh((0, 0, 0), (1, 0, 1))
    with pytest.raises(UsageError, match="no direction"):
        report.disc_mesh((0, 0, 0), (0, 0, 0), 1)
