"""The lines of a triangle mesh that a reader expects: rims and creases."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
CREASE = float(np.cos(np.radians(30.0)))


def weld(vertices: Array) -> Ints:
    """Return for each vertex the first vertex at the same place (to 1e-7 of the size)."""
    if not len(vertices):
        return np.zeros(0, dtype=np.int64)
    grain = 1e-7 * max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    _, first, inverse = np.unique(np.round(vertices / grain), axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[inverse.ravel()], dtype=np.int64)


def edge_faces(faces: Ints) -> tuple[Ints, Ints]:
    """Return the undirected edges (e, 2) and the two faces at each (e, 2); -1 where there is no second, or more than two."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    edge, inverse, count = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    by_edge = owner[np.argsort(inverse.ravel(), kind="stable")]
    start = np.cumsum(count) - count
    second = np.where(count == 2, by_edge[np.minimum(start + 1, len(by_edge) - 1)], -1)
    return edge, np.stack([by_edge[start], second], axis=1)


def normals(vertices: Array, faces: Ints) -> Array:
    """Return the unit normals (f, 3); zero for a face without area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    length = np.linalg.norm(n, axis=1, keepdims=True)
    return np.divide(n, length, out=np.zeros_like(n), where=length > 0)


def creases(vertices: Array, faces: Ints) -> Array:
    """Return the segments (n, 2, 3): borders, and edges between faces that turn by more than 30 degrees."""
    if not len(faces):
        return np.zeros((0, 2, 3))
    welded = weld(vertices)[faces]
    edge, pair = edge_faces(welded)
    n = normals(vertices, welded)
    turn = np.einsum("ij,ij->i", n[pair[:, 0]], n[pair[:, 1]])
    return np.asarray(vertices[edge[(pair[:, 1] < 0) | (np.abs(turn) < CREASE)]])
