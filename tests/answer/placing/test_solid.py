"""Solids as distance functions: numbers by hand; a mesh against its twin in numpy and against a box."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.placing.solid import VTK_FROM, Cuboid, Frustum, MeshSolid, Rod
from vcmm.core.pose import Array, Pose, dot, length
from vcmm.part.mesh import Mesh

Z = np.array([0.0, 0.0, 1.0])


CUBE = Cuboid(Pose.identity(), np.array([10.0, 10.0, 10.0]))


def test_distances_by_hand():
    p = np.array([[13.0, 14.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 12.0]])
    # corner edge: hypot(3, 4) = 5; inside 6 mm from the wall; 2 mm above
    assert np.allclose(CUBE.distance(p), [5.0, -6.0, 2.0])
    rod = Rod(np.zeros(3), Z, 5.0, 20.0)
    # beside: 8 - 5 = 3; over the rim: hypot(8 - 5, 24 - 20) = 5; on the axis at half height: -5
    assert np.allclose(rod.distance(np.array([[8.0, 0, 10], [0, 8.0, 24.0], [0, 0, 10.0]])), [3.0, 5.0, -5.0])
    cone = Frustum(np.zeros(3), Z, 10.0, np.radians(45.0), 10.0)
    # at z = 5 the radius is 15; a point at 17 is 2 cos 45 deg = 1.41421 from the side
    assert np.allclose(cone.distance(np.array([[17.0, 0.0, 5.0]])), 2.0 * np.cos(np.radians(45)))


def test_mesh_kernel_and_its_twin_and_the_box():
    mesh = cube_mesh()
    p = np.random.default_rng(3).uniform(-20, 20, (500, 3))
    from vcmm.answer.placing._mesh_kernels import mesh_distance

    fast, slow = mesh_distance(p, mesh.triangles().copy()), by_numpy(p, mesh.triangles())
    assert np.allclose(fast[0], slow[0], atol=1e-12)
    assert np.allclose(fast[1], slow[1], atol=1e-12)
    assert np.allclose(MeshSolid(mesh).distance(p), CUBE.distance(p), atol=1e-9)


def cube_mesh() -> Mesh:
    v = np.array([[x, y, z] for x in (-10, 10) for y in (-10, 10) for z in (-10, 10)], dtype=float)
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    return Mesh(v, np.array(faces))


def by_numpy(points: Array, corners: Array) -> tuple[Array, Array]:
    """distance (n,) and winding number (n,) of points (n, 3) for triangles (f, 3, 3)."""
    p = points[:, None]
    on_edges = [to_edge(p, corners[:, i], corners[:, (i + 1) % 3]) for i in range(3)]
    gap = np.minimum(np.min(on_edges, axis=0), to_face(p, corners)).min(axis=1)
    x, y, z = (corners[None, :, i] - p for i in range(3))
    lx, ly, lz = length(x), length(y), length(z)
    below = lx * ly * lz + dot(x, y) * lz + dot(y, z) * lx + dot(z, x) * ly
    turn = np.arctan2(dot(x, np.cross(y, z)), below).sum(axis=1)
    return np.asarray(gap), np.asarray(turn / (2.0 * np.pi))


def to_edge(p: Array, a: Array, b: Array) -> Array:
    edge = b - a
    share = np.clip(dot(p - a, edge) / np.maximum(dot(edge, edge), 1e-300), 0.0, 1.0)
    return length(p - a - share[..., None] * edge)


def to_face(p: Array, corners: Array) -> Array:
    """Distance to the plane of the triangle where the foot lies inside it, else inf."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    raw = np.cross(b - a, c - a)
    size = length(raw)
    normal = raw / np.maximum(size, 1e-300)[:, None]
    height = dot(p - a, normal)
    foot = p - height[..., None] * normal
    inside = np.broadcast_to(size > 0.0, height.shape).copy()
    for one, other in ((a, b), (b, c), (c, a)):
        inside &= dot(np.cross(other - one, foot - one), normal) >= 0.0
    return np.where(inside, np.abs(height), np.inf)


def ball(count: int) -> Mesh:
    """A sphere of radius 10 mm as 2 count^2 triangles, closed."""
    import trimesh

    made = trimesh.creation.uv_sphere(10.0, count=[count, count])
    return Mesh(np.asarray(made.vertices), np.asarray(made.faces))


def both(mesh: Mesh, p: Array) -> tuple[Array, Array]:
    """Distances as asked, and by every triangle with the winding number."""
    from vcmm.answer.placing._mesh_kernels import mesh_distance

    gap, winding = mesh_distance(p, np.ascontiguousarray(mesh.triangles()))
    return MeshSolid(mesh).distance(p), np.where(winding > 0.5, -gap, gap)


@pytest.mark.thorough
def test_a_large_closed_mesh_is_asked_otherwise_and_says_the_same():
    mesh, p = ball(16), np.random.default_rng(4).uniform(-15, 15, (400, 3))
    assert len(p) * len(mesh.faces) > VTK_FROM
    assert MeshSolid(mesh)._is_closed
    found, wanted = both(mesh, p)
    assert np.allclose(found, wanted, atol=1e-12)
    assert (found < 0).any()


@pytest.mark.thorough
def test_holes_overlapping_bodies_and_a_mesh_inside_out_keep_their_winding_number():
    one, p = ball(16), np.random.default_rng(5).uniform(-15, 15, (400, 3))
    other = Mesh(
        np.vstack([one.vertices, one.vertices + 6.0]), np.vstack([one.faces, one.faces + len(one.vertices)])
    )
    some_turned = np.where(np.arange(len(one.faces))[:, None] < 30, one.faces[:, ::-1], one.faces)
    for mesh in (
        Mesh(one.vertices, one.faces[3:]),
        other,
        Mesh(one.vertices, one.faces[:, ::-1]),
        Mesh(one.vertices, some_turned),  # the nearest triangle alone would take a whole cone for outside
    ):
        assert not MeshSolid(mesh)._is_closed
        found, wanted = both(mesh, p)
        assert np.array_equal(found, wanted)
