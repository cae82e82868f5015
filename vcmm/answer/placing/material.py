"""The part as an obstacle: its mesh where it has one, else the material that its features imply.

Features are surfaces, not a solid. Without a mesh the material is taken to be

    the convex hull of planes and bores, less the room in front of every plane,
    with a layer of `wall` mm behind every plane and around every bore (open above the floor of a pocket),
    with bosses, balls, outside cones and tori as they are,
    less the bores. A bore is open at the end that lies nearer to the outside, and at both where both lie there.

So a block with holes, steps, pockets and bosses is right. What no feature bounds (a cast rib, a flange that is not
measured) is not known: give [part] mesh where it matters, then the mesh is the material and nothing is guessed.
"""

from __future__ import annotations

import numpy as np

from vcmm.answer.placing.solid import (
    Ball,
    Cuboid,
    Frustum,
    Hull,
    MeshSolid,
    Rod,
    Solid,
    Tyre,
    Union,
    Without,
    hull_of,
)
from vcmm.core.pose import Array, Pose
from vcmm.part.part import Feature, Part, frame, surface_point

OPEN = 1.0  # mm: an end of a bore this near to the outside is open
DEEP = 1e5  # mm: as good as endless
AROUND = 64  # points on a circle for the hull


def part_solid(part: Part, wall: float) -> Solid:
    """Return the material of the part, drawing frame."""
    if part.mesh is not None:
        return MeshSolid(part.mesh)
    return analytic_solid(part, wall)


def analytic_solid(part: Part, wall: float) -> Solid:
    """Return the material that the features imply; see the docstring of this module."""
    features = list(part.features.values())
    planes = [f for f in features if f.kind == "plane"]
    holes = [f for f in features if f.inside and f.kind in ("cylinder", "cone", "circle")]
    hull = hull_of(np.concatenate([outline(f) for f in planes + holes])) if planes + holes else None
    body: list[Solid] = [Without(hull, tuple(_room(f) for f in planes))] if hull is not None else []
    body += [_layer(f, planes, wall) for f in planes]
    body += [_sleeve(f, wall) for f in holes]
    body += [s for f in features if not f.inside and (s := _closed_solid(f)) is not None]
    cut = [_hole(f, hull) for f in holes]
    cut += [
        s
        for f in features
        if f.inside and f.kind in ("sphere", "torus") and (s := _closed_solid(f)) is not None
    ]
    return Without(Union(tuple(body)), tuple(cut))


def outline(feature: Feature) -> Array:
    """Return the points (n, 3) whose hull holds the feature (to the chord of a 64th of a turn)."""
    angle = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    if feature.kind == "plane":
        a, b = (0.5 * e for e in feature.extent)
        return surface_point(feature, np.array([-a, a, a, -a]), np.array([-b, -b, b, b]))
    if feature.kind in ("cylinder", "cone"):
        ends = [surface_point(feature, angle, z) for z in (0.0, feature.extent[0])]
        return np.concatenate(ends)
    if feature.kind == "circle":
        return surface_point(feature, angle)
    if feature.kind in ("sphere", "torus"):
        reach = float(feature.sizes.sum())
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        return feature.point + reach * signs
    if feature.kind == "line":
        return np.stack([feature.point, feature.point + feature.extent[0] * feature.axis])
    return feature.point[None]


def part_points(part: Part) -> Array:
    """Return the points (n, 3) whose bounding box holds the part, drawing frame."""
    if part.mesh is not None:
        return part.mesh.vertices
    return np.concatenate([outline(f) for f in part.features.values() if not f.free])


def _room(f: Feature) -> Cuboid:
    """Return the free room in front of a plane."""
    return _slab(f, 0.0, DEEP)


def _layer(f: Feature, planes: list[Feature], wall: float) -> Solid:
    """Return the material behind a plane, less the room in front of planes that look the same way (the floor of a pocket)."""
    deeper = [p for p in planes if p.axis @ f.axis > 0.5 and (p.point - f.point) @ f.axis < -1e-6]
    return Without(_slab(f, -wall, 0.0), tuple(_room(p) for p in deeper))


def _slab(f: Feature, low: float, high: float) -> Cuboid:
    u, v, w = frame(f)
    middle = f.point + 0.5 * (low + high) * w
    half = np.array([0.5 * f.extent[0], 0.5 * f.extent[1], 0.5 * (high - low)])
    return Cuboid(Pose(np.stack([u, v, w], axis=1), middle), half)


def _sleeve(f: Feature, wall: float) -> Solid:
    """Return the material around a bore; the bore itself is cut out with all others."""
    if f.kind == "cone":
        return Frustum(f.point, f.axis, f.sizes[0] + wall / np.cos(f.sizes[1]), f.sizes[1], f.extent[0])
    if f.kind == "circle":
        return Rod(f.point - 0.5 * wall * f.axis, f.axis, f.sizes[0] + wall, wall)
    return Rod(f.point, f.axis, f.sizes[0] + wall, f.extent[0])


def _closed_solid(f: Feature) -> Solid | None:
    """Return the solid inside a closed feature."""
    if f.kind == "sphere":
        return Ball(f.point, f.sizes[0])
    if f.kind == "torus":
        return Tyre(f.point, f.axis, f.sizes[0], f.sizes[1])
    if f.kind == "cylinder":
        return Rod(f.point, f.axis, f.sizes[0], f.extent[0])
    if f.kind == "cone":
        return Frustum(f.point, f.axis, f.sizes[0], f.sizes[1], f.extent[0])
    return None


def _hole(f: Feature, hull: Hull | None) -> Solid:
    """Return the room of a bore, lengthened at the ends where it is open."""
    size = f.extent[0] if f.extent else 0.0
    first, last = f.point, f.point + size * f.axis
    depth = [0.0, 0.0] if hull is None else [_way_out(hull, first, -f.axis), _way_out(hull, last, f.axis)]
    front, back = (DEEP * (d <= max(OPEN, min(depth))) for d in depth)
    if f.kind == "cone":
        return Frustum(first, f.axis, f.sizes[0], f.sizes[1], size, front=front, back=back)
    return Rod(first - front * f.axis, f.axis, f.sizes[0], size + front + back)


def _way_out(hull: Hull, point: Array, way: Array) -> float:
    """Return how far from a point along a direction the hull ends; 0 outside."""
    slope, gap = hull.normals @ way, hull.offsets - hull.normals @ point
    ahead = slope > 1e-9
    return float(max(0.0, np.min(gap[ahead] / slope[ahead], initial=DEEP)))
