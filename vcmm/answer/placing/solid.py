"""Solids as distance functions: negative inside, positive outside, never larger than the true distance.

Every function changes by at most 1 mm per mm (Lipschitz), also after `Union` and `Without`, so that a tool
whose sampled distances are large enough is clear for certain. Near the edge where two faces meet the value may be
smaller than the true distance: a pose may be refused there that would just do, never the other way round.
Boxes and cylinders after Hart, Visual Computer 12 (1996) 527: sphere tracing. A mesh is the exact distance to its triangles, inside
or outside by the winding number (Van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125; Jacobson et al., ACM
Trans. Graph. 32 (2013) 33), which also serves meshes with small holes; an open sheet has no inside, it is touched from both
sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from vcmm.core.pose import Array, Pose, dot, length
from vcmm.part.mesh import Mesh, has_pyvista, surface_of

BEYOND_ALL_MM = 1e9
VTK_FROM = 100_000  # points times triangles (40 ms) from which VTK, which sorts the triangles first (3 to 9 ms), is quicker


class Solid(Protocol):
    """Signed distance (n,) mm of points (n, 3)."""

    def distance(self, points: Array) -> Array: ...


@dataclass(frozen=True, eq=False)
class Cuboid:
    """half (3,) sizes about the origin of the frame `pose` (outer_from_box)."""

    pose: Pose
    half: Array

    def distance(self, points: Array) -> Array:
        local = (points - self.pose.shift) @ self.pose.rotation  # inverse turn of row vectors
        beyond = np.abs(local) - self.half
        return np.asarray(length(np.maximum(beyond, 0.0)) + np.minimum(beyond.max(axis=-1), 0.0))


@dataclass(frozen=True, eq=False)
class Rod:
    """A cylinder along `axis` (unit) from `point` over `size` mm."""

    point: Array
    axis: Array
    radius: float
    size: float

    def distance(self, points: Array) -> Array:
        arm = points - self.point
        along = dot(arm, np.broadcast_to(self.axis, arm.shape))
        radial = length(arm - along[..., None] * self.axis) - self.radius
        ends = np.abs(along - 0.5 * self.size) - 0.5 * self.size
        outside = np.hypot(np.maximum(radial, 0.0), np.maximum(ends, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(radial, ends), 0.0))


@dataclass(frozen=True, eq=False)
class Frustum:
    """A cone along `axis` whose radius grows from `radius` at `point` with the half apex angle, over `size` mm.

    front, back: its ends go on as cylinders for so many mm.
    """

    point: Array
    axis: Array
    radius: float
    half: float
    size: float
    front: float = 0.0
    back: float = 0.0

    def distance(self, points: Array) -> Array:
        arm = points - self.point
        along = dot(arm, np.broadcast_to(self.axis, arm.shape))
        radial = length(arm - along[..., None] * self.axis)
        wide = self.radius + np.tan(self.half) * np.clip(along, 0.0, self.size)
        side = (radial - wide) * np.cos(self.half)
        return np.asarray(np.maximum(side, np.maximum(-self.front - along, along - self.size - self.back)))


@dataclass(frozen=True, eq=False)
class Ball:
    point: Array
    radius: float

    def distance(self, points: Array) -> Array:
        return length(points - self.point) - self.radius


@dataclass(frozen=True, eq=False)
class Tyre:
    """A torus."""

    point: Array
    axis: Array
    ring: float
    tube: float

    def distance(self, points: Array) -> Array:
        arm = points - self.point
        along = dot(arm, np.broadcast_to(self.axis, arm.shape))
        radial = length(arm - along[..., None] * self.axis)
        return np.asarray(np.hypot(radial - self.ring, along) - self.tube)


@dataclass(frozen=True, eq=False)
class Hull:
    """Common part of half-spaces normal . x <= offset."""

    normals: Array
    offsets: Array

    def distance(self, points: Array) -> Array:
        return np.asarray((points @ self.normals.T - self.offsets).max(axis=-1))


@dataclass(frozen=True, eq=False)
class Union:
    parts: tuple[Solid, ...]

    def distance(self, points: Array) -> Array:
        if not self.parts:
            return np.full(points.shape[:-1], BEYOND_ALL_MM)
        return np.asarray(np.min([p.distance(points) for p in self.parts], axis=0))


@dataclass(frozen=True, eq=False)
class Without:
    """body less the holes."""

    body: Solid
    holes: tuple[Solid, ...]

    def distance(self, points: Array) -> Array:
        out = self.body.distance(points)
        for hole in self.holes:
            out = np.maximum(out, -hole.distance(points))
        return out


@dataclass(frozen=True, eq=False)
class MeshSolid:
    """A solid bounded by triangles, faces counter-clockwise seen from outside.

    VTK, where it is installed, evaluates a closed surface in one piece (130 times faster at 20 000 triangles); other surfaces, and small
    numbers of points, are evaluated triangle by triangle.
    """

    mesh: Mesh

    @cached_property
    def _is_closed(self) -> bool:
        """Whether the side of the nearest triangle is the side of the solid: one piece without an edge of its own, every triangle
        turned like its neighbours (an edge is run through once each way), not inside out.
        """
        surface, faces = surface_of(self.mesh), self.mesh.faces
        ways = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        if len(np.unique(ways, axis=0)) < len(ways):
            return False
        a, b, c = np.moveaxis(self.mesh.triangles(), 1, 0)
        pieces = surface.connectivity("all")["RegionId"]
        return bool(surface.is_manifold and np.ptp(pieces) == 0 and dot(a, np.cross(b, c)).sum() > 0.0)

    def distance(self, points: Array) -> Array:
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        if len(flat) * len(self.mesh.faces) > VTK_FROM and has_pyvista() and self._is_closed:
            import pyvista

            distance: Any = pyvista.PolyData(flat).compute_implicit_distance(surface_of(self.mesh))
            distance = distance["implicit_distance"]
            return np.asarray(distance, dtype=np.float64).reshape(points.shape[:-1])
        from vcmm.answer.placing._mesh_kernels import mesh_distance

        gap, winding = mesh_distance(flat, np.ascontiguousarray(self.mesh.triangles()))
        return np.asarray(np.where(winding > 0.5, -gap, gap).reshape(points.shape[:-1]))


def cuboid(pose: Pose, size: Sequence[float]) -> Cuboid:
    """Return a block of three sides (mm) about the origin of the frame `pose`."""
    return Cuboid(pose, 0.5 * np.array(size))


def half_space(height: float, up: Array) -> Hull:
    """Return everything below `height` along `up`."""
    return Hull(np.asarray(up, dtype=float)[None], np.array([height]))


def hull_of(points: Array) -> Hull | None:
    """Return the convex hull of points (n, 3) as half-spaces; None where they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    if len(points) < 4:
        return None
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[2] < 1e-6 * max(spread[0], 1e-300):
        return None
    try:
        equations = ConvexHull(points).equations
    except QhullError:
        return None
    equations = np.unique(np.round(equations, 12), axis=0)
    return Hull(equations[:, :3], -equations[:, 3])
