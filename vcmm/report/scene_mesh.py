"""Triangle meshes made ready to draw: welded, oriented, coplanar pairs joined, cut at the borders of colour bands."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.report.colormap import Bands

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
CREASE = float(np.cos(np.radians(30.0)))


def weld(vertices: Array) -> Ints:
    """For each vertex the first vertex at the same place (to 1e-7 of the size)."""
    if not len(vertices):
        return np.zeros(0, dtype=np.int64)
    grain = 1e-7 * max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    _, first, inverse = np.unique(np.round(vertices / grain), axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[inverse.ravel()], dtype=np.int64)


def edge_faces(faces: Ints) -> tuple[Ints, Ints]:
    """Undirected edges (e, 2) and the two faces at each (e, 2); -1 where there is no second, or more than two."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    edge, inverse, count = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    by_edge = owner[np.argsort(inverse.ravel(), kind="stable")]
    start = np.cumsum(count) - count
    second = np.where(count == 2, by_edge[np.minimum(start + 1, len(by_edge) - 1)], -1)
    return edge, np.stack([by_edge[start], second], axis=1)


def volume(vertices: Array, faces: Ints) -> float:
    """Signed volume, positive if the faces of a closed mesh turn counter-clockwise seen from outside."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def normals(vertices: Array, faces: Ints) -> Array:
    """Unit normals (f, 3); zero for a face without area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    length = np.linalg.norm(n, axis=1, keepdims=True)
    return np.divide(n, length, out=np.zeros_like(n), where=length > 0)


def joined(vertices: Array, faces: Ints, edge: Ints, pair: Ints) -> list[list[int]]:
    """Faces grouped by two where two coplanar triangles form a convex quadrilateral, longest common edge first."""
    n = normals(vertices, faces)
    inner = np.flatnonzero(pair[:, 1] >= 0)
    flat = inner[np.einsum("ij,ij->i", n[pair[inner, 0]], n[pair[inner, 1]]) > 1 - 1e-9]
    length = np.linalg.norm(vertices[edge[flat, 0]] - vertices[edge[flat, 1]], axis=1)
    free = np.ones(len(faces), dtype=bool)
    groups: list[list[int]] = []
    for k in flat[np.argsort(-length, kind="stable")]:
        a, b = int(pair[k, 0]), int(pair[k, 1])
        if free[a] and free[b] and _convex(vertices[quad(faces[a], faces[b], edge[k])], n[a]):
            free[[a, b]] = False
            groups.append([a, b])
    return groups + [[int(i)] for i in np.flatnonzero(free)]


def quad(first: Ints, second: Ints, shared: Ints) -> list[int]:
    """The four corners, in order, of two triangles with a common edge."""
    i = next(k for k in range(3) if first[k] not in shared)
    tip = next(int(v) for v in second if v not in shared)
    return [int(first[i]), int(first[(i + 1) % 3]), tip, int(first[(i + 2) % 3])]


def _convex(p: Array, normal: Array) -> bool:
    side = np.roll(p, -1, axis=0) - p
    turn = np.cross(side, np.roll(side, -1, axis=0)) @ normal
    return bool((turn > 1e-12 * float((side**2).sum())).all())


def banded(points: Array, values: Array, scale: Bands) -> list[tuple[Array, int]]:
    """A triangle cut where the linear interpolation of its corner values (3,) crosses a band; (polygon, band) pairs.

    Without three finite values the whole triangle has band -1.
    """
    if not np.isfinite(values).all():
        return [(points, -1)]
    rest, out = np.column_stack([points, values]), []
    first, last = int(scale.index(values.min())), int(scale.index(values.max()))
    for band in range(first, last):
        low, rest = split(rest, rest[:, 3] - scale.levels[band + 1])
        out.append((low[:, :3], band))
    out.append((rest[:, :3], last))
    return [(p, band) for p, band in out if len(p) >= 3]


def split(rows: Array, distance: Array, closed: bool = True) -> tuple[Array, Array]:
    """A polygon (or an open path) with corners (n, m) divided where `distance` (n,) changes sign: negative, positive.

    Sutherland and Hodgman's clipping, both sides at once; every column of the rows is interpolated.
    """
    sides: tuple[list[Array], list[Array]] = ([], [])
    n = len(rows)
    for i in range(n):
        j = (i + 1) % n
        for side, keep in zip(sides, (distance[i] <= 0, distance[i] >= 0)):
            if keep:
                side.append(rows[i])
        if (closed or j) and distance[i] * distance[j] < 0:
            crossing = rows[i] + (rows[j] - rows[i]) * (distance[i] / (distance[i] - distance[j]))
            for side in sides:
                side.append(crossing)
    low, high = (np.array(side).reshape(-1, rows.shape[1]) for side in sides)
    return low, high
