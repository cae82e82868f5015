"""Triangles joined and cut at the borders of bands."""

from __future__ import annotations

import numpy as np

from tests.report.drawn import NAN
from vcmm import report
from vcmm.report.colormap import bands
from vcmm.report.scene_mesh import banded, edge_faces, joined


def test_coplanar_triangles_join_to_the_sides_of_a_box() -> None:
    v, f = report.box_mesh((0, 0, 0), (1, 2, 3))
    edge, pair = edge_faces(f)
    assert len(edge) == 18  # 12 edges and 6 diagonals
    assert sorted(len(g) for g in joined(v, f, edge, pair)) == [2] * 6


def test_band_borders_cut_triangles() -> None:
    # value = x on a triangle (0,0) (2,0) (0,2), bands 0..1..2: the part beyond x = 1 has a quarter of the area
    corners = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0]])
    parts = banded(corners, corners[:, 0], bands([0.0, 2.0], count=2))

    def area(p: np.ndarray) -> float:
        return abs(float(np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)[2])) / 2

    assert [(round(area(p), 12), k) for p, k in parts] == [(1.5, 0), (0.5, 1)]
    assert banded(corners, np.array([0.0, NAN, 1.0]), bands([0.0, 2.0]))[0][1] == -1
