"""Triangle meshes: reading, closest point, and the exact first contact of a moving ball.

A mesh represents free-form surfaces. Coordinates are mm; faces turn counter-clockwise seen from outside.

Estimate how far a smooth surface lies off the facets of the mesh that was made of it.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError, Environment
from vcmm.core.pose import Array, dot, length, read_only_copy
from vcmm.core.text import read_head

FORMATS = (".stl", ".obj", ".ply")
_PAIRS = 200_000  # point-triangle pairs per block, about 50 MB of temporaries


@dataclass(frozen=True, eq=False)
class Mesh:
    """Vertices (v, 3) mm and faces (f, 3), three vertex numbers each. DataError when empty or not finite."""

    vertices: Array
    faces: npt.NDArray[np.intp]

    def __post_init__(self) -> None:
        faces = np.array(self.faces, dtype=np.intp)
        faces.setflags(write=False)
        object.__setattr__(self, "vertices", read_only_copy(self.vertices))
        object.__setattr__(self, "faces", faces)
        _check(self.vertices, self.faces)

    def triangles(self) -> Array:
        """Return the corner points (f, 3, 3)."""
        return self.vertices[self.faces]


def load_mesh(path: str | Path) -> Mesh:
    """Reads STL, OBJ or PLY; the file's numbers are taken as mm (these formats state no unit).

    DataError when the file is missing, of another format, unreadable, empty or not finite.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise DataError(f"{path}: a mesh is read from {', '.join(FORMATS)}; convert the file to one of them.")
    try:
        import trimesh
    except ImportError as error:
        raise Environment("Reading a mesh needs trimesh; install it with: pip install trimesh") from error
    read_head(path)
    try:
        loaded = trimesh.load_mesh(
            path, process=False, **({"skip_materials": True} if path.suffix.lower() == ".obj" else {})
        )
        _check(
            np.asarray(loaded.vertices), np.asarray(loaded.faces)
        )  # before trimesh leaves out what is not finite
        loaded.process()
    except DataError as error:
        raise DataError(f"{path}: {error}") from error
    except Exception as error:  # trimesh raises whatever its parsers raise
        raise DataError(f"{path}: not a readable mesh ({error}); export it again.") from error
    try:
        return Mesh(np.asarray(loaded.vertices), np.asarray(loaded.faces))
    except DataError as error:
        raise DataError(f"{path}: {error}") from error


def _check(vertices: Array, faces: npt.NDArray[np.intp]) -> None:
    if vertices.ndim != 2 or faces.ndim != 2 or vertices.shape[1:] != (3,) or faces.shape[1:] != (3,):
        raise DataError("A mesh needs vertices (v, 3) and faces (f, 3), both not empty; export triangles.")
    if len(vertices) == 0 or len(faces) == 0:
        raise DataError("The mesh is empty: it needs at least one triangle; export it again.")
    if not np.all(np.isfinite(vertices)):
        bad = int(np.argmax(~np.isfinite(vertices).all(axis=1)))
        raise DataError(f"Vertex {bad} of the mesh is not finite; export it again.")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise DataError(f"A face of the mesh names a vertex outside 0..{len(vertices) - 1}; export it again.")
    if not (face_normals(vertices[faces]) != 0.0).any():
        raise DataError("No triangle of the mesh has an area; export it again.")


def face_normals(triangles: Array) -> Array:
    """Return the unit normals (..., 3) of triangles (..., 3, 3); zero for a triangle without area."""
    raw = np.cross(triangles[..., 1, :] - triangles[..., 0, :], triangles[..., 2, :] - triangles[..., 0, :])
    size = length(raw)[..., None]
    return np.asarray(np.divide(raw, size, out=np.zeros_like(raw), where=size > 0.0))


def has_pyvista() -> bool:
    """Return whether pyvista, and with it VTK, is installed."""
    return importlib.util.find_spec("pyvista") is not None


def surface_of(mesh: Mesh) -> Any:
    """Return the mesh as PolyData of pyvista, for filters of VTK, which need no display. Environment: pyvista is not installed."""
    try:
        import pyvista
    except ModuleNotFoundError:
        raise Environment(
            'places on a mesh are found by VTK, which is not installed: pip install "vcmm[view]"'
        ) from None

    faces: Any = mesh.faces
    return pyvista.PolyData.from_regular_faces(mesh.vertices, faces)


def closest(mesh: Mesh, points: Array) -> tuple[Array, Array]:
    """Return the distance (n,) from points (n, 3) to the mesh, and the normal (n, 3) of the nearest triangle.

    Exact, by the cell locator of VTK (no rendering), also for a mesh that is open.
    """
    nearest, foot = surface_of(mesh).find_closest_cell(points, return_closest_point=True)
    return length(points - foot), face_normals(mesh.triangles()[np.atleast_1d(nearest)])


def _balls(triangles: Array) -> tuple[Array, Array]:
    """Return the centre (f, 3) and radius (f,) of a ball around each triangle."""
    centre = triangles.mean(axis=1)
    return centre, length(triangles - centre[:, None, :]).max(axis=1)


def _inside(triangles: Array, normals: Array, points: Array) -> npt.NDArray[np.bool_]:
    """Return which points (..., k, 3) in the planes of triangles (k, 3, 3) lie within them; none if without area."""
    inside = np.broadcast_to(length(normals) > 0.0, points.shape[:-1]).copy()
    for i in range(3):
        edge = triangles[:, (i + 1) % 3] - triangles[:, i]
        inside &= dot(np.cross(edge, points - triangles[:, i]), normals) >= 0.0
    return inside


def sweep(mesh: Mesh, start: Array, direction: Array, radius: float, search: float) -> Array:
    """Return the travel (m, n) to the first contact of balls that start at (m, n, 3) and move along direction (n, 3).

    inf: no contact within `search` mm; -inf: the ball overlaps the mesh at its start. Exact: the ball meets
    a triangle inside its face (a plane), on an edge (a cylinder) or at a corner (a sphere), in closed form.
    """
    triangles = mesh.triangles()
    centre, reach = _balls(triangles)
    travel = np.full(start.shape[:2], np.inf)
    for i, way in enumerate(direction):
        middle = start[:, i].mean(axis=0)
        spread = float(np.max(length(start[:, i] - middle)))
        along = np.clip(dot(centre - middle, way), 0.0, search)
        beside = length(centre - middle - along[:, None] * way)
        near = triangles[beside <= (reach + radius + spread) * (1.0 + 1e-12)]
        if len(near):
            travel[:, i] = _sweep_along(near, start[:, i], way, radius)
    return np.where(travel > search, np.inf, travel)


def _sweep_along(near: Array, start: Array, way: Array, radius: float) -> Array:
    """Return the travel (m,) of balls with one direction (3,), in blocks that fit into memory."""
    step = max(1, _PAIRS // len(near))
    blocks = [start[first : first + step] for first in range(0, len(start), step)]
    return np.concatenate([_sweep_block(near, block, way, radius) for block in blocks])


def _sweep_block(triangles: Array, start: Array, direction: Array, radius: float) -> Array:
    first = _sweep_faces(triangles, start, direction, radius).min(axis=1)
    for i in range(3):
        a, b = triangles[:, i], triangles[:, (i + 1) % 3]
        first = np.minimum(first, _sweep_edges(a, b, start, direction, radius).min(axis=1))
        first = np.minimum(first, _sweep_corners(a, start, direction, radius).min(axis=1))
    return first


def _sweep_faces(triangles: Array, start: Array, direction: Array, radius: float) -> Array:
    """Return the travel (m, k) to the inside of each face; both sides of a face count."""
    normals = face_normals(triangles)
    height = dot(start[:, None, :] - triangles[:, 0], normals)
    facing = np.where(height < 0.0, -1.0, 1.0)
    closing = -facing * dot(direction, normals)
    gap = np.abs(height) - radius
    travel = np.divide(gap, closing, out=np.full_like(gap, np.inf), where=closing > 0.0)
    travel[gap < 0.0] = 0.0  # looked at where it starts
    at = np.where(np.isfinite(travel), travel, 0.0)
    touch = start[:, None, :] + at[..., None] * direction
    foot = touch - dot(touch - triangles[:, 0], normals)[..., None] * normals
    travel[~_inside(triangles, normals, foot)] = np.inf
    return np.where((gap < 0.0) & np.isfinite(travel), -np.inf, travel)


def _sweep_edges(a: Array, b: Array, start: Array, direction: Array, radius: float) -> Array:
    """Return the travel (m, k) to the inside of each edge from a (k, 3) to b (k, 3)."""
    edge = b - a
    size = length(edge)
    along = np.divide(edge, size[:, None], out=np.zeros_like(edge), where=size[:, None] > 0.0)
    arm = start[:, None, :] - a
    square_arm = arm - dot(arm, along)[..., None] * along
    square_way = direction - dot(along, np.broadcast_to(direction, along.shape))[:, None] * along
    travel = _first_hit(square_arm, square_way, radius)
    at = np.where(np.isfinite(travel), travel, 0.0)
    place = dot(arm, along) + at * dot(along, np.broadcast_to(direction, along.shape))
    return np.where((place >= 0.0) & (place <= size) & (size > 0.0), travel, np.inf)


def _sweep_corners(corners: Array, start: Array, direction: Array, radius: float) -> Array:
    arm = start[:, None, :] - corners
    return _first_hit(arm, np.broadcast_to(direction, corners.shape), radius)


def _first_hit(arm: Array, way: Array, radius: float) -> Array:
    """Return the smallest t >= 0 with |arm + t way| = radius; -inf when |arm| < radius, inf when never."""
    square = dot(way, way)
    nearest = np.divide(-dot(arm, way), square, out=np.full(arm.shape[:-1], np.inf), where=square > 1e-24)
    reached = np.isfinite(nearest)
    beside = arm + np.where(reached, nearest, 0.0)[..., None] * way
    rest = radius**2 - dot(beside, beside)  # of the nearest place: no cancellation of large squares
    hit = reached & (rest >= 0.0) & (nearest >= 0.0)
    back = np.sqrt(np.where(hit, rest, 0.0) / np.where(hit, square, 1.0))
    travel = np.where(hit, nearest - back, np.inf)
    return np.where(dot(arm, arm) < radius**2 * (1.0 - 1e-12), -np.inf, travel)


SHARP = np.radians(20.0)
"""Two facets that turn by more are an edge of the part. Facets of one radius R turn by t over a chord R t: sag R t^2 / 8. At 20 deg
that is 1.5 % of R, 0.15 mm of R = 10 mm, more than a profile that is worth measuring; no such mesh is a nominal shape. It is also
the angle at which trimesh (graph.smooth_shade) tells facets from smooth surfaces."""


@lru_cache(maxsize=2)
def facet_sags(mesh: Mesh) -> Array:
    """Return the largest distance (f,) mm between each facet and the smooth surface on which its corners lie, estimated from the mesh.

    A chord c of a circle of radius R has the sag c^2 / 8 R, and neighbouring chords turn by t = c / R: sag = c t / 8. The chord
    across an edge is the altitude of the triangle upon it; of two unequal ones the shorter counts, for a mesher makes facets as
    long as the curvature lets it, so the longer one lies in a flatter place. Edges of a facet add, as the curvatures in two
    directions do: exact to second order on strips of a cylinder and on a square grid, halved by diagonals, of any surface; 9 / 8
    of it on equilateral triangles of a sphere (a^2 / 6 R). Convex and concave edges count apart, the larger sum is taken.
    """
    import trimesh

    of = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    of.merge_vertices()
    pair, turn = of.face_adjacency, of.face_adjacency_angles
    ends = of.vertices[of.face_adjacency_edges]
    edge = length(ends[:, 1] - ends[:, 0])
    chord = 2.0 * of.area_faces[pair].min(axis=1) / np.where(edge > 0.0, edge, np.inf)
    sag = np.where(turn < SHARP, chord * turn / 8.0, 0.0)
    out = np.zeros((2, len(mesh.faces)))
    for way, counts in enumerate((of.face_adjacency_convex, ~of.face_adjacency_convex)):
        np.add.at(out[way], pair[counts].ravel(), np.repeat(sag[counts], 2))
    return np.asarray(out.max(axis=0))


def sag_at(mesh: Mesh, points: Array) -> Array:
    """Return the sag (n,) mm of the facets nearest to points (n, 3)."""
    nearest = surface_of(mesh).find_closest_cell(points)
    return facet_sags(mesh)[np.atleast_1d(nearest)]
