"""Meshes: reading, closest point, first contact of a ball."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import trimesh

from vcmm.core.errors import DataError
from vcmm.part.mesh import Mesh, closest, face_normals, facet_sags, load_mesh, sag_at, sweep

# a right triangle in the plane z = 0, counter-clockwise from above
TRIANGLE = Mesh(np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0]]), np.array([[0, 1, 2]]))


def test_the_outward_normal_follows_the_order():
    assert face_normals(TRIANGLE.triangles()).tolist() == [[0.0, 0.0, 1.0]]
    assert face_normals(np.zeros((1, 3, 3))).tolist() == [[0.0, 0.0, 0.0]]


def test_closest_on_face_edge_and_corner():
    # above the face 2; beyond the hypotenuse 3 x + 4 y = 12 from (4, 3): 12 / 5; beyond the corner (0, 0): 5
    distance, normal = closest(TRIANGLE, np.array([[1.0, 1.0, 2.0], [4.0, 3.0, 0.0], [-3.0, -4.0, 0.0]]))
    assert distance == pytest.approx([2.0, 2.4, 5.0])
    assert normal.tolist() == [[0.0, 0.0, 1.0]] * 3


def test_a_ball_meets_face_and_edge():
    # from z = 10 downwards, radius 1: the face after 9; over the edge y = 0 at y = -0.6 the ball hangs 0.8 above: 9.2
    start = np.array([[[1.0, 1.0, 10.0], [1.0, -0.6, 10.0], [1.0, -2.0, 10.0]]])
    travel = sweep(TRIANGLE, start, np.tile([0.0, 0.0, -1.0], (3, 1)), 1.0, 100.0)
    assert travel[0, :2] == pytest.approx([9.0, 9.2])
    assert np.isinf(travel[0, 2])


def test_what_is_no_mesh(tmp_path):
    with pytest.raises(DataError, match="empty"):
        Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=int))
    with pytest.raises(DataError, match=r"Vertex 1 .* not finite"):
        Mesh(np.array([[0.0, 0, 0], [np.nan, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    with pytest.raises(DataError, match=r"outside 0\.\.2"):
        Mesh(TRIANGLE.vertices, np.array([[0, 1, 3]]))
    with pytest.raises(DataError, match="convert the file"):
        load_mesh(tmp_path / "a.step")
    with pytest.raises(DataError, match="does not exist"):
        load_mesh(tmp_path / "a.stl")


def test_a_file_with_a_triangle_that_is_none_is_refused(tmp_path):
    """A reader that leaves it out in silence would leave a hole in the material."""
    sound = "v 0 0 0\nv 4 0 0\nv 0 3 0\nv {} 0 1\nf 1 2 3\nf 2 3 4\n"
    path = tmp_path / "t.obj"
    path.write_text(sound.format(7))
    assert len(load_mesh(path).faces) == 2
    path.write_text(sound.format("nan"))
    with pytest.raises(DataError, match=r"t\.obj: Vertex \d of the mesh is not finite"):
        load_mesh(path)
    path.write_text("v 0 0 0\nv 4 0 0\nv 8 0 0\nf 1 2 3\n")
    with pytest.raises(DataError, match="No triangle of the mesh has an area"):
        load_mesh(path)


def test_a_written_triangle_is_read(tmp_path):
    path = tmp_path / "t.obj"
    path.write_text("v 0 0 0\nv 4 0 0\nv 0 3 0\nf 1 2 3\n")
    assert np.sort(load_mesh(path).vertices, axis=0).tolist() == np.sort(TRIANGLE.vertices, axis=0).tolist()


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [((3, 2), (1, 3)), ((3, 3), (1, 4)), ((3, 4), (1, 4)), ((9,), (1, 3)), ((3, 3), (3,))],
)
def test_vertices_and_faces_have_three_columns(vertices, faces):
    with pytest.raises(DataError, match=r"needs vertices \(v, 3\) and faces \(f, 3\)"):
        Mesh(np.zeros(vertices), np.zeros(faces, dtype=np.intp))


def test_without_pyvista_places_on_a_mesh_say_what_to_install(monkeypatch: pytest.MonkeyPatch):
    from vcmm.core.errors import Environment

    monkeypatch.setitem(sys.modules, "pyvista", None)
    one = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    with pytest.raises(Environment, match=r"pip install \"vcmm\[view\]\""):
        closest(one, np.zeros((1, 3)))


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
