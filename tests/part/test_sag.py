"""How far a smooth surface stands off its facets, against circles and spheres by hand."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from vcmm.part.mesh import Mesh
from vcmm.part.sag import facet_sags, sag_at


def prism(radius: float, sides: int) -> Mesh:
    turn = np.arange(sides) * 2 * np.pi / sides
    ring = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    corners = np.concatenate([np.insert(ring, 2, z, axis=1) for z in (0.0, 50.0)])
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    return Mesh(
        corners, np.concatenate([np.stack(t, 1) for t in ((i, j, sides + j), (i, sides + j, sides + i))])
    )


def of(mesh: trimesh.Trimesh) -> Mesh:
    return Mesh(mesh.vertices, mesh.faces)


def test_strips_of_a_cylinder_by_hand():
    # 24 strips of R = 20 mm: c = 40 sin 7.5 deg = 5.2210 mm, t = 15 deg = 0.26180; c t / 8 = 0.17086 mm; true R (1 - cos 7.5 deg) = 0.17110
    assert facet_sags(prism(20.0, 24)) == pytest.approx(0.17086, abs=1e-5)
    assert sag_at(prism(20.0, 24), np.array([[20.0, 0.5, 20.0]])) == pytest.approx([0.17086], abs=1e-5)


def test_a_square_grid_of_a_saddle_and_of_a_cup():
    # z = (x^2 + s y^2) / 200, squares of 2 mm halved by diagonals. Cup: a^2 / 4 R = 4 / 400 mm = 10 um in the middle of a square;
    # saddle: a^2 / 8 R = 5 um in the middle of a side, both ways
    x, y = (g.ravel() for g in np.meshgrid(*[np.arange(-6.0, 7.0, 2.0)] * 2))
    n = np.arange(49).reshape(7, 7)
    a, b, c, d = n[:-1, :-1].ravel(), n[:-1, 1:].ravel(), n[1:, 1:].ravel(), n[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    for sign, expected in ((1.0, 10.0), (-1.0, 5.0)):
        mesh = Mesh(np.stack([x, y, (x * x + sign * y * y) / 200], 1), faces)
        assert 1e3 * sag_at(mesh, np.array([[0.9, 0.5, 0.0]])) == pytest.approx([expected], rel=0.02)


def test_facets_of_a_sphere():
    # corners on R = 20 mm: the middle of a facet lies R - |middle| inside; an equilateral one, a^2 / 6 R, is estimated 9 / 8 of it
    ball = trimesh.creation.icosphere(subdivisions=3, radius=20.0)
    ratio = facet_sags(of(ball)) / (20.0 - np.linalg.norm(ball.triangles_center, axis=1))
    assert 0.85 < ratio.min() < 1.0 < ratio.max() < 1.25
    assert np.median(ratio) == pytest.approx(1.125, abs=0.03)  # sqrt(3) x 3 sqrt(3) / 8 = 9 / 8


def test_edges_of_the_part_and_long_faces_beside_a_radius_do_not_count():
    assert facet_sags(of(trimesh.creation.box((100, 20, 30)))).max() == pytest.approx(0.0, abs=1e-6)
    # 12 sides turn by 30 deg: edges; and a plane of 80 mm that ends in a strip of 1 mm which turns by 6 deg: 1 x 0.10472 / 8 = 0.01309 mm
    assert facet_sags(prism(20.0, 12)).max() == pytest.approx(0.0, abs=1e-6)
    turn = np.radians(6.0)
    corners = [[-80, 0, 0], [0, 0, 0], [0, 50, 0], [-80, 50, 0]]
    corners += [[np.cos(turn), 50 * k, -np.sin(turn)] for k in (0, 1)]
    beside = Mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]))
    assert facet_sags(beside).max() == pytest.approx(0.01309, abs=1e-5)
