"""A mesh as an obstacle: exact distance to its triangles, inside or outside by the winding number.

The winding number (Van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125; Jacobson et al., ACM Trans. Graph.
32 (2013) 33) also serves meshes with small holes; an open sheet has no inside, it is touched from both sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.pose import Array, dot, length
from vcmm.part.mesh import Mesh

BLOCK = 200_000  # pairs of point and triangle at a time in the numpy twin


@dataclass(frozen=True, eq=False)
class MeshSolid:
    """A solid bounded by triangles, faces counter-clockwise seen from outside."""

    mesh: Mesh

    def distance(self, points: Array) -> Array:
        from vcmm.placing._mesh_kernels import mesh_distance

        flat = np.ascontiguousarray(points.reshape(-1, 3))
        gap, winding = mesh_distance(flat, np.ascontiguousarray(self.mesh.triangles()))
        return np.asarray(np.where(winding > 0.5, -gap, gap).reshape(points.shape[:-1]))


def mesh_distance_numpy(points: Array, corners: Array) -> tuple[Array, Array]:
    """The twin of the kernel: distance (n,) and winding number (n,) of points (n, 3) for triangles (f, 3, 3)."""
    step = max(1, BLOCK // len(corners))
    parts = [_block(points[i : i + step], corners) for i in range(0, len(points), step)]
    return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])


def _block(points: Array, corners: Array) -> tuple[Array, Array]:
    p = points[:, None]
    on_edges = [_to_edge(p, corners[:, i], corners[:, (i + 1) % 3]) for i in range(3)]
    gap = np.minimum(np.min(on_edges, axis=0), _to_face(p, corners)).min(axis=1)
    x, y, z = (corners[None, :, i] - p for i in range(3))
    lx, ly, lz = length(x), length(y), length(z)
    below = lx * ly * lz + dot(x, y) * lz + dot(y, z) * lx + dot(z, x) * ly
    turn = np.arctan2(dot(x, np.cross(y, z)), below).sum(axis=1)
    return np.asarray(gap), np.asarray(turn / (2.0 * np.pi))


def _to_edge(p: Array, a: Array, b: Array) -> Array:
    edge = b - a
    share = np.clip(dot(p - a, edge) / np.maximum(dot(edge, edge), 1e-300), 0.0, 1.0)
    return length(p - a - share[..., None] * edge)


def _to_face(p: Array, corners: Array) -> Array:
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
