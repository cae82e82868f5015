"""Meshes: reading, closest point, first contact of a ball."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.part.mesh import Mesh, closest, face_normals, load_mesh, sweep

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
