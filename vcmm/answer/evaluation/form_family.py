"""Families of form: departures of real surfaces from their nominal shape, sampled at any points of a feature.

waves    a few waves around and along the feature, amplitudes falling with their number
         by a power that differs from part to part (drilled and turned holes have few lobes, milled and ground ones many).
lobes    one wave alone, as a chuck, a vice or an oval leaves it
edges    a family that the inverse does not use: dents, bumps and cusped lobes. It tests whether results from the
first one also hold for parts of another kind.

The inverse knows `waves` and `lobes` (KNOWN). Departures count along the outward normal, in units of their root mean square over the points of the last set.
Undulations per revolution and their amplitudes: ISO 12181-2 (50 UPR at most for small holes; here 15, the rest is filtered).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.part.part import Feature, centre, frame, normal

Ints = npt.NDArray[np.integer]
AROUND, ALONG, WAVES = 15, 5, 6  # most lobes, most half waves along a feature, waves of one part
NO_POINT_MOTION = 1e-9  # mm per mm or rad: a motion that moves no point by more is none


@dataclass(frozen=True, eq=False)
class Ground:
    """Sets of points (n, 3) on a feature at which forms are sampled, the last one all over. Made once for all parts."""

    feature: Feature
    sets: tuple[Array, ...]

    @property
    def round(self) -> bool:
        return self.feature.kind not in ("plane", "line", "points")

    @cached_property
    def coordinates(self) -> tuple[tuple[Array, Array], ...]:
        return tuple(coordinates(self.feature, p) for p in self.sets)

    @cached_property
    def waves(self) -> tuple[Array, ...]:
        """Products of waves around and along at every set (4 (AROUND + 1) (ALONG + 1), n), motions and sizes left out."""
        scale = 1.0 if self.round else np.pi / 2
        products = [_products(a, b, scale) for a, b in self.coordinates]
        return tuple(products[k] - products[-1] @ self.motion_columns[k] for k in range(len(products)))

    @cached_property
    def motion_columns(self) -> tuple[Array, ...]:
        """Values (N, n) of motions and sizes, fitted to departures (N,) of the last set, at the points of every set."""
        moved = [motions(self.feature, p, normal(self.feature, p)) for p in self.sets]
        used = np.abs(moved[-1]).max(axis=0) > NO_POINT_MOTION
        scale = np.abs(moved[-1]).max(axis=0)[used]
        inverse = np.linalg.pinv(moved[-1][:, used] / scale, rcond=NO_POINT_MOTION)
        return tuple((inverse.T @ (m[:, used] / scale).T) for m in moved)

    def of_unit_size(self, drawn: list[Array]) -> list[Array]:
        """Divide forms by their root mean square over the last set."""
        size = np.sqrt((drawn[-1] ** 2).mean(axis=1, keepdims=True))
        return [d / np.maximum(size, 1e-12) for d in drawn]


Family = Callable[[np.random.Generator, Ground, int], list[Array]]


def coordinates(feature: Feature, points: Array) -> tuple[Array, Array]:
    """Return two surface coordinates (n,) of points (n, 3): the angle (or 0), and the place along, in half lengths from the middle."""
    if feature.nominal is not None:
        return _across(feature.nominal.points, points)
    u, v, w = frame(feature)
    arm = points - feature.point
    if feature.kind == "plane":
        return arm @ u / (feature.extent[0] / 2), arm @ v / (feature.extent[1] / 2)
    if feature.kind in ("line", "cylinder", "cone"):
        along = 2.0 * (arm @ w) / feature.extent[0] - 1.0
        return (np.zeros(len(points)) if feature.kind == "line" else np.arctan2(arm @ v, arm @ u)), along
    if feature.kind == "torus":
        return np.arctan2(arm @ v, arm @ u), arm @ w / feature.sizes[1]
    if feature.kind == "sphere":
        return np.arctan2(arm @ v, arm @ u), arm @ w / feature.sizes[0]
    if feature.kind == "circle":
        return np.arctan2(arm @ v, arm @ u), np.zeros(len(points))
    return np.zeros(len(points)), np.zeros(len(points))


def _across(nominal: Array, points: Array) -> tuple[Array, Array]:
    """Return places (n,) of points along the two longest directions of a free-form surface, -1 to 1 over its nominal points."""
    middle = nominal.mean(axis=0)
    ways = np.linalg.svd(nominal - middle, full_matrices=False)[2][:2].T
    half = np.maximum(np.abs((nominal - middle) @ ways).max(axis=0), NO_POINT_MOTION)
    a, b = ((points - middle) @ ways / half).T
    return a, b


def waves(rng: np.random.Generator, ground: Ground, count: int) -> list[Array]:
    """Sample departures (count, n) at every set of points of one feature."""
    flat = ground.feature.kind in ("plane", "points")
    first = (
        rng.integers(0, AROUND + 1, (count, WAVES))
        if ground.round
        else rng.integers(0, ALONG + 1, (count, WAVES)) * flat
    )
    along = rng.integers(0, ALONG + 1, (count, WAVES)) * (ground.feature.kind != "circle")
    return _sum_of(rng, ground, first, along)


def lobes(rng: np.random.Generator, ground: Ground, count: int) -> list[Array]:
    """Sample departures (count, n) of one wave alone: 2 to 7 lobes around, or one to three half waves along."""
    if not ground.round:
        first = rng.integers(0, 4, (count, 1)) * (ground.feature.kind in ("plane", "points"))
        along = rng.integers(1, 4, (count, 1))
        along = np.where(first + along < 2, 2, along)  # a half wave along is nearly a tilt
        return _sum_of(rng, ground, first, along)
    return _sum_of(rng, ground, rng.integers(2, 8, (count, 1)), np.zeros((count, 1), dtype=np.int64))


def _sum_of(rng: np.random.Generator, ground: Ground, first: Ints, along: Ints) -> list[Array]:
    """Sum waves of numbers first and along (count, w), of random phase, with amplitudes that fall with their number."""
    from scipy.sparse import csr_array

    count, number = first.shape
    power = rng.uniform(0.0, 2.0, (count, 1))
    size = rng.normal(size=(count, number)) * (1.0 + first + along) ** -power
    phase = rng.uniform(0.0, 2 * np.pi, (2, count, number))
    (c, d), (s, t) = np.cos(phase), np.sin(phase)
    # cos(m a + f) cos(l b + g) in products of cosines and sines, in the order of `_products`
    amounts = np.concatenate([size * x for x in (c * d, -c * t, -s * d, s * t)], axis=1)
    place = first * (ALONG + 1) + along
    block = (AROUND + 1) * (ALONG + 1)
    columns = np.concatenate([place + k * block for k in range(4)], axis=1)
    rows = np.arange(count + 1) * (4 * number)
    weights = csr_array((amounts.ravel(), columns.ravel(), rows), shape=(count, 4 * block))
    return ground.of_unit_size([weights @ w for w in ground.waves])


def _products(a: Array, b: Array, scale: float) -> Array:
    """Return cos or sin of m a times cos or sin of l b, (4 (AROUND + 1) (ALONG + 1), n)."""
    first = np.arange(AROUND + 1)[:, None] * scale * a
    second = np.arange(ALONG + 1)[:, None] * (np.pi / 2) * b
    rows = [f(first)[:, None] * g(second)[None] for f in (np.cos, np.sin) for g in (np.cos, np.sin)]
    return np.concatenate([r.reshape(-1, len(a)) for r in rows])


def bump(across: Array, along: Array, width: Array | float) -> Array:
    """Return a round hill of height 1: exp(-d^2 / (2 width^2)) at the distance d from its top."""
    return np.asarray(np.exp(-0.5 * (across**2 + along**2) / width**2))


def edges(rng: np.random.Generator, ground: Ground, count: int) -> list[Array]:
    """Sample departures (count, n) of another kind: two bumps or dents of random place and width, and cusped lobes."""
    at = (
        rng.uniform(-1.0, 1.0, (2, count, 2, 1))
        * np.array([np.pi if ground.round else 1.0, 1.0])[:, None, None, None]
    )
    width, height = rng.uniform(0.15, 0.8, (count, 2, 1)), rng.normal(size=(count, 2, 1))
    lobes, phase = rng.integers(2, 8, (count, 1)), rng.uniform(0.0, 2 * np.pi, (count, 1))
    cusped = rng.uniform(-1.0, 1.0, (count, 1))
    out = []
    for a, b in ground.coordinates:
        near = a - at[0]
        near = 2.0 * np.sin(near / 2) if ground.round else near
        bumps = (height * bump(near, b - at[1], width)).sum(axis=1)
        out.append(bumps + cusped * np.abs(np.sin(lobes * (a if ground.round else a + b) / 2 + phase)))
    return ground.of_unit_size([d - out[-1] @ fit for d, fit in zip(out, ground.motion_columns)])


FAMILIES: Mapping[str, Family] = {"waves": waves, "lobes": lobes, "edges": edges}
KNOWN, OTHER = ("waves", "lobes"), "edges"


def motions(feature: Feature, points: Array, normals: Array) -> Array:
    """Return the displacement of every point along its normal for unit motions of the feature and changes of its sizes, as (n, k).

    Three shifts (mm), three turns (rad) about the nominal centre (none of a circle, whose axis is that of the drawing), then
    the sizes (mm, rad).
    """
    arm = points - centre(feature)
    columns = [normals, np.cross(arm, normals) * (feature.kind != "circle")]
    side = -1.0 if feature.inside else 1.0
    if len(feature.sizes):
        columns.append(np.full((len(points), 1), side))
    if feature.kind == "cone":
        columns.append(side * ((points - feature.point) @ feature.axis)[:, None])
    if feature.kind == "torus":
        flat = points - feature.point - ((points - feature.point) @ feature.axis)[:, None] * feature.axis
        outward = flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
        columns.append((normals * outward).sum(axis=1, keepdims=True))
    return np.concatenate(columns, axis=1)


def left_over(feature: Feature, points: Array, normals: Array) -> Array:
    """Return the projection (n, n) that removes motions and sizes of the feature from displacements along the normals (least squares)."""
    columns = motions(feature, points, normals)
    largest = np.abs(columns).max(axis=0)
    columns = columns[:, largest > NO_POINT_MOTION] / largest[largest > NO_POINT_MOTION]
    basis, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    basis = basis[:, sizes > NO_POINT_MOTION * sizes[0]]
    return np.eye(len(points)) - basis @ basis.T
