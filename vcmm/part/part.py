"""The workpiece as drawn: features with nominal geometry, characteristics with their limits, perhaps a mesh.

All numbers in the drawing frame, mm and rad. `inside = True` is a bore: the material is around it.
Normals point out of the material. Checks report every problem at once, as DataError.

The second in-plane direction of a feature is `u`: the direction of a plane's first size, where the angles of
round features count from, and for a line the outward normal of the surface on which it lies.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Protocol

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError, UsageError, choose_from, did_you_mean
from vcmm.core.pose import Array, Pose, dot, length, read_only_copy, triad, unit
from vcmm.part.characteristic import TYPES, Characteristic, members
from vcmm.part.mesh import Mesh, load_mesh
from vcmm.part.nominal import NominalPoints, distance_and_normal

__all__ = [
    "FEATURE_KINDS",
    "TYPES",
    "Characteristic",
    "Feature",
    "Mesh",
    "Part",
    "Shape",
    "centre",
    "ends",
    "feature_to_frame",
    "frame",
    "load_mesh",
    "members",
    "normal",
    "signed_distance",
    "surface_point",
]  # fmt: skip


@dataclass(frozen=True)
class Kind:
    """Numbers of a kind of feature; `direction`: whether it has an axis."""

    sizes: tuple[str, ...]
    extent: tuple[str, ...]
    direction: bool = True


FEATURE_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "point": Kind((), ()),
        "line": Kind((), ("length",)),
        "plane": Kind((), ("first size", "second size")),
        "circle": Kind(("radius",), ()),
        "sphere": Kind(("radius",), (), direction=False),
        "cylinder": Kind(("radius",), ("length",)),
        "cone": Kind(("radius at the point", "half apex angle"), ("length",)),
        "torus": Kind(("ring radius", "tube radius"), ()),
        "mesh": Kind((), (), direction=False),
        "points": Kind((), (), direction=False),
    }
)


FREE = ("mesh", "points")
WORDS_OF_KIND = {"points": "a surface of nominal points", "mesh": "a surface of a mesh"}


class Shape(Protocol):
    """Common part of a nominal and a fitted feature; a fitted one has leading axes, one per trial."""

    @property
    def point(self) -> Array: ...
    @property
    def axis(self) -> Array: ...
    @property
    def sizes(self) -> Array: ...


@dataclass(frozen=True, eq=False)
class Feature:
    """One nominal surface or element.

    `point` (3,): centre, point on a plane, or for line, cylinder and cone the end from which `axis` leads
    along the length. `axis` (3,): normal out of the material (plane, point), direction or axis; zeros for
    sphere, mesh and points.
    `sizes` as in FEATURE_KINDS: a cone's radius grows along its axis. `extent`: size along u and v, or the length.
    `u` (3,): see the head of this module; by default `triad` chooses it from the axis.
    `nominal`: the surface of kind points, next to which `point` is the middle.
    """

    name: str
    kind: str
    point: Array
    axis: Array
    sizes: Array
    inside: bool = False
    extent: tuple[float, ...] = ()
    u: Array | None = None
    nominal: NominalPoints | None = None

    def __post_init__(self) -> None:
        for field in ("point", "axis", "sizes"):
            object.__setattr__(self, field, read_only_copy(getattr(self, field)))
        object.__setattr__(self, "extent", tuple(float(value) for value in self.extent))
        if self.u is not None:
            object.__setattr__(self, "u", read_only_copy(self.u))
        problems = list(_feature_problems(self))
        if problems:
            raise DataError(f'Feature "{self.name}": {problem}' for problem in problems)
        if FEATURE_KINDS[self.kind].direction:
            object.__setattr__(self, "axis", read_only_copy(unit(self.axis)))

    @property
    def free(self) -> bool:
        """Whether the feature is a free-form surface: no element is fitted to it, only its profile is toleranced."""
        return self.kind in FREE


def _feature_problems(f: Feature) -> Iterable[str]:
    if f.kind not in FEATURE_KINDS:
        yield f'unknown type "{f.kind}".{choose_from(f.kind, FEATURE_KINDS)}'
        return
    kind = FEATURE_KINDS[f.kind]
    if (f.kind == "points") != (f.nominal is not None):
        yield "nominal points belong to the type points, and it needs them."
    for word, vector in (("point", f.point), ("axis", f.axis), ("u", f.u)):
        if vector is not None and (vector.shape != (3,) or not np.all(np.isfinite(vector))):
            yield f"{word} must be three finite numbers, not {vector.tolist()}."
            return
    if kind.direction and length(f.axis) == 0.0:
        yield "its direction is zero; give a vector with a length, for example [0, 0, 1]."
    elif f.u is not None and length(np.cross(f.axis, f.u)) <= 1e-9 * length(f.axis) * length(f.u):
        yield "u is parallel to the axis; give a direction square to it."
    yield from _number_problems(kind.sizes, f.sizes.reshape(-1).tolist())
    yield from _number_problems(kind.extent, list(f.extent))
    if f.kind == "cone" and f.sizes.shape == (2,) and not 0.0 < f.sizes[1] < 0.5 * math.pi:
        yield "the apex angle of a cone lies between 0 and 180 deg; let the axis point to the wide end."
    if f.kind == "torus" and f.sizes.shape == (2,) and f.sizes[1] >= f.sizes[0]:
        yield "the tube radius of a torus must be smaller than the ring radius."


def _number_problems(names: tuple[str, ...], values: list[float]) -> Iterable[str]:
    if len(names) != len(values):
        wanted = ", ".join(names) if names else "no such numbers"
        yield f"expected {wanted}; got {len(values)} number(s): {values}."
        return
    for name, value in zip(names, values):
        zero_allowed = name == "radius at the point"  # a cone may start at its apex
        if not math.isfinite(value) or value < 0.0 or (value == 0.0 and not zero_allowed):
            yield f"{name} must be positive and finite, not {value:g}; correct the number."


@dataclass(frozen=True, eq=False)
class Part:
    """Features by name, characteristics, thermal expansion (1/K) and perhaps a mesh in the drawing frame."""

    features: Mapping[str, Feature]
    characteristics: tuple[Characteristic, ...] = ()
    expansion: float = 0.0
    mesh: Mesh | None = None
    mass: float = 0.0  # kg, 0 = not known

    def __post_init__(self) -> None:
        object.__setattr__(self, "features", MappingProxyType(dict(self.features)))
        object.__setattr__(self, "characteristics", tuple(self.characteristics))
        problems = list(_part_problems(self))
        if problems:
            raise DataError(problems)


def _part_problems(part: Part) -> Iterable[str]:
    for key, feature in part.features.items():
        if key != feature.name:
            yield f'Feature "{feature.name}" is listed as "{key}"; use one name.'
        if feature.kind == "mesh" and part.mesh is None:
            yield f'Feature "{key}" lies on a mesh, but the part has none; give [part] mesh = "part.stl".'
    names: set[str] = set()
    for c in part.characteristics:
        if c.name in names:
            yield f'Two characteristics are named "{c.name}"; rename one.'
        names.add(c.name)
        for name in c.features:
            if name not in part.features:
                advice = f"Known features: {', '.join(part.features) or 'none'}."
                hint = did_you_mean(name, part.features)
                yield f'Characteristic "{c.name}" names the unknown feature "{name}".{hint} {advice}'
    if not math.isfinite(part.expansion):
        yield "The thermal expansion of the part is not finite; give a number such as 11.5e-6 1/K."


def frame(feature: Feature) -> Array:
    """Return orthonormal rows u, v, w (3, 3) of the feature, w = axis; the axes of the frame for sphere, mesh and points."""
    return triad(feature.axis, feature.u) if FEATURE_KINDS[feature.kind].direction else np.eye(3)


def feature_to_frame(feature: Feature, b_from_a: Pose) -> Feature:
    """Return the same feature in another frame (one pose, not a batch)."""
    u = b_from_a.turn(frame(feature)[0]) if FEATURE_KINDS[feature.kind].direction else None
    point, axis = b_from_a.apply(feature.point), b_from_a.turn(feature.axis)
    nominal = feature.nominal and feature.nominal.to_frame(b_from_a)
    return replace(feature, point=point, axis=axis, u=u, nominal=nominal)


def kind_text(kind: str) -> str:
    """Name a kind of feature as in a sentence: a plane, a surface of nominal points."""
    return WORDS_OF_KIND.get(kind, f"a {kind}")


def ends(feature: Feature) -> Array:
    """Return the two ends (2, 3) of a line, cylinder or cone on its nominal axis."""
    return np.stack([feature.point, feature.point + feature.extent[0] * feature.axis])


def centre(feature: Feature) -> Array:
    """Return the nominal centre (3,): the middle of the length of a line, cylinder or cone, else the feature's point."""
    return ends(feature).mean(axis=0) if feature.kind in ("line", "cylinder", "cone") else feature.point


def signed_distance(feature: Feature, points: npt.ArrayLike) -> Array:
    """Return the distance (...) of points (..., 3) from the nominal surface, positive outside the material, mm.

    The surface is unbounded: extents do not cut it. A circle counts as the cylinder through it, a point and
    a line as the plane on which they lie. UsageError for kind mesh (use vcmm.part.mesh.closest).
    """
    if feature.nominal is not None:
        return distance_and_normal(feature.nominal, np.asarray(points, dtype=np.float64))[0]
    side = -1.0 if feature.inside else 1.0
    arm = np.asarray(points, dtype=np.float64) - feature.point
    if feature.kind in ("point", "plane", "line"):
        return dot(arm, _outward(feature))
    if feature.kind == "sphere":
        return np.asarray(side * (length(arm) - feature.sizes[0]))
    along, square = _across(feature, arm)
    radial = length(square)
    if feature.kind in ("circle", "cylinder"):
        return np.asarray(side * (radial - feature.sizes[0]))
    if feature.kind == "cone":
        radius, half = feature.sizes
        return np.asarray(side * ((radial - radius) * math.cos(half) - along * math.sin(half)))
    return np.asarray(side * (np.hypot(radial - feature.sizes[0], along) - feature.sizes[1]))


def normal(feature: Feature, points: npt.ArrayLike) -> Array:
    """Return the unit normal out of the material (..., 3) where points (..., 3) lie nearest to the nominal surface.

    It is the gradient of `signed_distance`. On the axis and in the centre, where all directions fit, it is u.
    """
    if feature.nominal is not None:
        return distance_and_normal(feature.nominal, np.asarray(points, dtype=np.float64))[1]
    side = -1.0 if feature.inside else 1.0
    arm = np.asarray(points, dtype=np.float64) - feature.point
    if feature.kind in ("point", "plane", "line"):
        return np.broadcast_to(_outward(feature), arm.shape).copy()
    if feature.kind == "sphere":
        return side * _direction(arm, frame(feature)[0])
    along, square = _across(feature, arm)
    away = _direction(square, frame(feature)[0])
    if feature.kind in ("circle", "cylinder"):
        return side * away
    if feature.kind == "cone":
        half = feature.sizes[1]
        return np.asarray(side * (math.cos(half) * away - math.sin(half) * feature.axis))
    tube = (length(square) - feature.sizes[0])[..., None] * away + along[..., None] * feature.axis
    return side * _direction(tube, feature.axis)


def _outward(feature: Feature) -> Array:
    if feature.kind == "mesh":
        raise UsageError(f'Feature "{feature.name}" lies on a mesh: use vcmm.part.mesh.closest.')
    return np.asarray(frame(feature)[0]) if feature.kind == "line" else feature.axis


def _across(feature: Feature, arm: Array) -> tuple[Array, Array]:
    """Return the distance along the axis (...), and the vector from the axis, square to it (..., 3)."""
    if feature.kind == "mesh":
        _outward(feature)
    along = dot(arm, feature.axis)
    return along, arm - along[..., None] * feature.axis


def _direction(vectors: Array, otherwise: Array) -> Array:
    size = length(vectors)[..., None]
    return np.where(size > 0.0, vectors / np.where(size > 0.0, size, 1.0), otherwise)


def surface_point(feature: Feature, first: npt.ArrayLike, second: npt.ArrayLike = 0.0) -> Array:
    """Return the points (..., 3) on the nominal surface from two surface coordinates that broadcast.

    plane: mm along u, mm along v · line: mm along it · circle: angle from u · cylinder, cone: angle from u,
    mm along the axis from `point` · sphere: longitude from x, latitude · torus: angle around the ring, around
    the tube (0 = outermost, pi/2 = towards the axis direction). Angles in rad.
    """
    a, b = np.broadcast_arrays(np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64))
    u, v, w = frame(feature)
    around = np.cos(a)[..., None] * u + np.sin(a)[..., None] * v
    if feature.kind in ("plane", "point"):
        return np.asarray(feature.point + a[..., None] * u + b[..., None] * v)
    if feature.kind == "line":
        return np.asarray(feature.point + a[..., None] * w)
    if feature.kind == "sphere":
        out = np.cos(b)[..., None] * around + np.sin(b)[..., None] * w
        return np.asarray(feature.point + feature.sizes[0] * out)
    if feature.kind in ("circle", "cylinder", "cone"):
        slope = math.tan(feature.sizes[1]) if feature.kind == "cone" else 0.0
        along = np.zeros_like(b) if feature.kind == "circle" else b
        radius = (feature.sizes[0] + slope * along)[..., None]
        return np.asarray(feature.point + radius * around + along[..., None] * w)
    if feature.free:
        raise UsageError(f'Feature "{feature.name}" is a free-form surface: give points instead.')
    ring, tube = feature.sizes
    return np.asarray(
        feature.point + (ring + tube * np.cos(b))[..., None] * around + (tube * np.sin(b))[..., None] * w
    )
