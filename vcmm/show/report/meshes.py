"""Triangle meshes of simple solids for pictures: vertices (v, 3) in mm, faces (f, 3), counter-clockwise from outside; their rims and creases.

Pictures only: measuring uses the analytic features (a 48-sided bore is 2 um per mm of radius too small).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError

Array = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]
Solid = tuple[Array, Faces]


def frame(axis: npt.ArrayLike) -> Array:
    """Return right-handed rows (u, v, w) with w along `axis`. UsageError: the axis has no direction."""
    w = np.asarray(axis, dtype=np.float64)
    length = float(np.linalg.norm(w))
    if not (np.isfinite(length) and length > 0):
        raise UsageError(f"The axis {w.tolist()} has no direction: give a vector such as [0, 0, 1].")
    w = w / length
    helper = np.eye(3)[int(np.argmin(np.abs(w)))]
    u = np.cross(helper, w)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(w, u), w])


def _ring(n: int) -> Array:
    """Return cosines and sines (n, 2)."""
    angle = 2 * np.pi * np.arange(n) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _sweep(profile: Array, n: int, wrap: bool = False) -> Solid:
    """Return the surface of revolution about z of a profile (m, 2) of (radius, z), outward if the profile climbs."""
    m, ring = len(profile), _ring(n)
    xy = profile[:, None, :1] * ring[None]
    z = np.broadcast_to(profile[:, None, 1:], (m, n, 1))
    vertices = np.concatenate([xy, z], axis=2).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(m if wrap else m - 1), np.arange(n), indexing="ij")
    a, b = i * n + j, i * n + (j + 1) % n
    c, d = (i + 1) % m * n + (j + 1) % n, (i + 1) % m * n + j
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return vertices, _without_slivers(vertices, faces)


def _without_slivers(vertices: Array, faces: Faces) -> Faces:
    """Return faces with an area (a pole or a tip collapses one side of a square)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return faces[area > 1e-12 * max(float(area.max()), 1e-300)]


def _place_solid(solid: Solid, point: npt.ArrayLike, axis: npt.ArrayLike) -> Solid:
    vertices, faces = solid
    return np.asarray(point, dtype=np.float64) + vertices @ frame(axis), faces


def cylinder_mesh(
    point: npt.ArrayLike, axis: npt.ArrayLike, radius: float, length: float, n: int = 48, inside: bool = False
) -> Solid:
    """Return a cylinder centred on `point`. Solid with end discs; `inside=True`: the open wall of a bore, facing the axis."""
    h = length / 2
    if inside:
        vertices, faces = _sweep(np.array([[radius, -h], [radius, h]]), n)
        return _place_solid((vertices, faces[:, ::-1]), point, axis)
    return _place_solid(_sweep(np.array([[0, -h], [radius, -h], [radius, h], [0, h]]), n), point, axis)


def tube_mesh(
    point: npt.ArrayLike, axis: npt.ArrayLike, outer: float, inner: float, length: float, n: int = 48
) -> Solid:
    """Return a closed ring: outer wall, bore and two annular ends. UsageError: not 0 < inner < outer."""
    if not 0 < inner < outer:
        raise UsageError(f"A tube needs 0 < inner < outer, got inner {inner:g} and outer {outer:g}.")
    h = length / 2
    profile = np.array([[inner, -h], [outer, -h], [outer, h], [inner, h]])
    return _place_solid(_sweep(profile, n, wrap=True), point, axis)


def disc_mesh(point: npt.ArrayLike, normal: npt.ArrayLike, radius: float, n: int = 48) -> Solid:
    """Return a flat disc, facing along `normal`."""
    return _place_solid(_sweep(np.array([[radius, 0.0], [0.0, 0.0]]), n), point, normal)


def cone_mesh(
    point: npt.ArrayLike, axis: npt.ArrayLike, radius: float, length: float, top: float = 0.0, n: int = 48
) -> Solid:
    """Return a cone or frustum: base disc of `radius` at `point`, `length` along the axis to radius `top`."""
    profile = np.array([[0, 0], [radius, 0], [top, length], [0, length]], dtype=np.float64)
    return _place_solid(_sweep(profile[: 4 if top > 0 else 3], n), point, axis)


def sphere_mesh(point: npt.ArrayLike, radius: float, n: int = 32) -> Solid:
    """Return a sphere of n meridians and n / 2 bands."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, n // 2 + 1)
    profile = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    profile[[0, -1], 0] = 0.0
    return _place_solid(_sweep(profile, n), point, (0, 0, 1))


def torus_mesh(point: npt.ArrayLike, axis: npt.ArrayLike, radius: float, tube: float, n: int = 48) -> Solid:
    """Return a torus: circle of `radius` about the axis, tube radius `tube`."""
    angle = 2 * np.pi * np.arange(n // 2) / (n // 2)
    profile = np.stack([radius + tube * np.cos(angle), tube * np.sin(angle)], axis=1)
    return _place_solid(_sweep(profile, n, wrap=True), point, axis)


def plane_mesh(point: npt.ArrayLike, normal: npt.ArrayLike, u: float, v: float) -> Solid:
    """Return a rectangle u x v centred on `point`; for a normal along an axis its sides follow the other two axes."""
    corners = np.array([[-u, -v, 0], [u, -v, 0], [u, v, 0], [-u, v, 0]]) / 2
    w = np.asarray(normal, dtype=np.float64)
    rows = frame(w)
    k = int(np.argmax(np.abs(w)))
    if np.count_nonzero(w) == 1:
        first = np.eye(3)[1 if k == 0 else 0]
        rows = np.stack([first, np.cross(rows[2], first), rows[2]])
    return np.asarray(point, dtype=np.float64) + corners @ rows, np.array([[0, 1, 2], [0, 2, 3]])


def box_mesh(lo: npt.ArrayLike, hi: npt.ArrayLike) -> Solid:
    """Return an axis-aligned box between two corners. UsageError: a side is not positive."""
    low, high = np.asarray(lo, dtype=np.float64), np.asarray(hi, dtype=np.float64)
    if not (high > low).all():
        raise UsageError(f"A box needs lo < hi on every axis, got {low.tolist()} and {high.tolist()}.")
    corner = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return low + corner * (high - low), faces


CREASE = float(np.cos(np.radians(30.0)))


def weld(vertices: Array) -> Faces:
    """Return for each vertex the first vertex at the same place (to 1e-7 of the size)."""
    if not len(vertices):
        return np.zeros(0, dtype=np.int64)
    grain = 1e-7 * max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    _, first, inverse = np.unique(np.round(vertices / grain), axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[inverse.ravel()], dtype=np.int64)


def edge_faces(faces: Faces) -> tuple[Faces, Faces]:
    """Return the undirected edges (e, 2) and the two faces at each (e, 2); -1 where there is no second, or more than two."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    edge, inverse, count = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    by_edge = owner[np.argsort(inverse.ravel(), kind="stable")]
    start = np.cumsum(count) - count
    second = np.where(count == 2, by_edge[np.minimum(start + 1, len(by_edge) - 1)], -1)
    return edge, np.stack([by_edge[start], second], axis=1)


def normals(vertices: Array, faces: Faces) -> Array:
    """Return the unit normals (f, 3); zero for a face without area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    length = np.linalg.norm(n, axis=1, keepdims=True)
    return np.divide(n, length, out=np.zeros_like(n), where=length > 0)


def creases(vertices: Array, faces: Faces) -> Array:
    """Return the segments (n, 2, 3): borders, and edges between faces that turn by more than 30 degrees."""
    if not len(faces):
        return np.zeros((0, 2, 3))
    welded = weld(vertices)[faces]
    edge, pair = edge_faces(welded)
    n = normals(vertices, welded)
    turn = np.einsum("ij,ij->i", n[pair[:, 0]], n[pair[:, 1]])
    return np.asarray(vertices[edge[(pair[:, 1] < 0) | (np.abs(turn) < CREASE)]])
