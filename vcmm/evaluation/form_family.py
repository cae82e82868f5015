"""How real surfaces depart from their nominal shape: families of forms, drawn at any points of a feature.

waves    a few waves around and along the feature, amplitudes falling with their number
         by a power that differs from part to part (drilled and turned holes have few lobes, milled and ground ones many).
lobes    one wave alone, as a chuck, a vice or an oval leaves it
edges    a family that it does not know: dents, bumps and cusped lobes. It serves to ask whether what was found with the
         first one also holds for parts of another kind.

The inverse knows `waves` and `lobes` (KNOWN). Departures count along the outward normal, in units of their root mean square over the points of the last set.
Undulations per revolution and their amplitudes: ISO 12181-2 (50 UPR at most for small holes; here 15, the rest is filtered).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.part.part import Feature, centre, frame, normal

Family = Callable[[np.random.Generator, Feature, Sequence[Array], int], list[Array]]
Ints = npt.NDArray[np.integer]
AROUND, ALONG, WAVES = 15, 5, 6  # most lobes, most half waves along a feature, waves of one part


def coordinates(feature: Feature, points: Array) -> tuple[Array, Array]:
    """Two surface coordinates (n,) of points (n, 3): the angle (or 0), and the place along, in half lengths from the middle."""
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


def waves(rng: np.random.Generator, feature: Feature, sets: Sequence[Array], count: int) -> list[Array]:
    """Departures (count, n) at every set of points (n, 3) of one feature."""
    round_ = feature.kind not in ("plane", "line")
    flat = feature.kind == "plane"
    first = (
        rng.integers(0, AROUND + 1, (count, WAVES))
        if round_
        else rng.integers(0, ALONG + 1, (count, WAVES)) * flat
    )
    along = rng.integers(0, ALONG + 1, (count, WAVES)) * (feature.kind != "circle")
    return _sum_of(rng, feature, sets, first, along)


def lobes(rng: np.random.Generator, feature: Feature, sets: Sequence[Array], count: int) -> list[Array]:
    """Departures (count, n) of one wave alone: 2 to 7 lobes around, or one to three half waves along."""
    if feature.kind in ("plane", "line"):
        first = rng.integers(0, 4, (count, 1)) * (feature.kind == "plane")
        along = rng.integers(1, 4, (count, 1))
        along = np.where(first + along < 2, 2, along)  # a half wave along is nearly a tilt
        return _sum_of(rng, feature, sets, first, along)
    return _sum_of(rng, feature, sets, rng.integers(2, 8, (count, 1)), np.zeros((count, 1), dtype=np.int64))


def _sum_of(
    rng: np.random.Generator, feature: Feature, sets: Sequence[Array], first: Ints, along: Ints
) -> list[Array]:
    """Waves of numbers first and along (count, w), of random phase, amplitudes falling with their number."""
    count, number = first.shape
    round_ = feature.kind not in ("plane", "line")
    power = rng.uniform(0.0, 2.0, (count, 1))
    size = rng.normal(size=(count, number)) * (1.0 + first + along) ** -power
    phase = rng.uniform(0.0, 2 * np.pi, (2, count, number))
    weights = np.zeros((count, 4, (AROUND + 1) * (ALONG + 1)))
    part = np.arange(count)[:, None], first * (ALONG + 1) + along
    signs = ((np.cos, np.cos, 1.0), (np.cos, np.sin, -1.0), (np.sin, np.cos, -1.0), (np.sin, np.sin, 1.0))
    for k, (one, other, sign) in enumerate(
        signs
    ):  # cos(m a + f) cos(l b + g) in products of cosines and sines
        np.add.at(weights[:, k], part, sign * size * one(phase[0]) * other(phase[1]))
    scale = 1.0 if round_ else np.pi / 2
    out = [weights.reshape(count, -1) @ _products(*coordinates(feature, p), scale) for p in sets]
    return _of_unit_size(feature, sets, out)


def _products(a: Array, b: Array, scale: float) -> Array:
    """(4 (AROUND + 1) (ALONG + 1), n): cos or sin of m a times cos or sin of l b."""
    first = np.arange(AROUND + 1)[:, None] * scale * a
    second = np.arange(ALONG + 1)[:, None] * (np.pi / 2) * b
    rows = [f(first)[:, None] * g(second)[None] for f in (np.cos, np.sin) for g in (np.cos, np.sin)]
    return np.concatenate([r.reshape(-1, len(a)) for r in rows])


def edges(rng: np.random.Generator, feature: Feature, sets: Sequence[Array], count: int) -> list[Array]:
    """Departures (count, n) of another kind: two bumps or dents of random place and width, and cusped lobes."""
    round_ = feature.kind not in ("plane", "line")
    at = (
        rng.uniform(-1.0, 1.0, (2, count, 2, 1))
        * np.array([np.pi if round_ else 1.0, 1.0])[:, None, None, None]
    )
    width, height = rng.uniform(0.15, 0.8, (count, 2, 1)), rng.normal(size=(count, 2, 1))
    lobes, phase = rng.integers(2, 8, (count, 1)), rng.uniform(0.0, 2 * np.pi, (count, 1))
    cusped = rng.uniform(-1.0, 1.0, (count, 1))
    out = []
    for points in sets:
        a, b = coordinates(feature, points)
        near = a - at[0]
        near = 2.0 * np.sin(near / 2) if round_ else near
        bumps = (height * np.exp(-0.5 * (near**2 + (b - at[1]) ** 2) / width**2)).sum(axis=1)
        out.append(bumps + cusped * np.abs(np.sin(lobes * (a if round_ else a + b) / 2 + phase)))
    return _of_unit_size(feature, sets, out)


FAMILIES: Mapping[str, Family] = {"waves": waves, "lobes": lobes, "edges": edges}
KNOWN, OTHER = ("waves", "lobes"), "edges"


def motions(feature: Feature, points: Array, normals: Array) -> Array:
    """(n, k): displacement of every point along its normal for unit motions of the feature and changes of its sizes.

    Three shifts (mm), three turns (rad) about the nominal centre, then the sizes (mm, rad).
    """
    arm = points - centre(feature)
    columns = [normals, np.cross(arm, normals)]
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
    """(n, n): what motions and sizes of the feature leave of displacements along the normals (least squares)."""
    columns = motions(feature, points, normals)
    columns = columns / np.maximum(np.abs(columns).max(axis=0), 1e-12)
    basis, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    basis = basis[:, sizes > 1e-9 * max(float(sizes[0]), 1e-12)]
    return np.eye(len(points)) - basis @ basis.T


def _of_unit_size(feature: Feature, sets: Sequence[Array], drawn: list[Array]) -> list[Array]:
    """Divided by the root mean square at the last set, the densest; position and size, which are no form, left out."""
    fitted = []
    last = motions(feature, sets[-1], normal(feature, sets[-1]))
    scale = np.maximum(np.abs(last).max(axis=0), 1e-12)
    part = np.linalg.lstsq(last / scale, drawn[-1].T, rcond=1e-9)[0]
    for points, values in zip(sets, drawn):
        fitted.append(values - (motions(feature, points, normal(feature, points)) / scale @ part).T)
    size = np.sqrt((fitted[-1] ** 2).mean(axis=1, keepdims=True))
    return [v / np.maximum(size, 1e-12) for v in fitted]
