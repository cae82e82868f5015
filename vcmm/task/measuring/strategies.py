"""Named point patterns for touching a feature, on the nominal surface, in the drawing frame.

    points, normals = plan_points(top, Grid(n=(3, 3), margin=5.0))
    points, normals = plan_points(bore, choose("cylinder", "levels")(at=(5.0, 15.0), n=8))

Every pattern is a small frozen dataclass. The metadata "dimension" of a field (length or angle, absent for
counts) tells file readers which unit it takes. `choose` finds the pattern of a kind of feature by name.
Angles count from `u` of the feature (part.frame), distances along a line, cylinder or cone from its `point`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.pose import Array, Pose, triad
from vcmm.part.fit.elements import MINIMUM_POINTS
from vcmm.part.part import Feature, normal, surface_point

GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
FULL = 2.0 * math.pi
MOST_POINTS = 1_000_000  # of one feature


def _length(default: Any = 0.0) -> Any:
    return field(default=default, metadata={"dimension": "length"})


def _angle(default: Any = 0.0) -> Any:
    return field(default=default, metadata={"dimension": "angle"})


@dataclass(frozen=True)
class Grid:
    """Plane: n = (along u, along v) points in rows run to and fro, `margin` mm inside the edges."""

    n: tuple[int, int]
    margin: float = _length()


@dataclass(frozen=True)
class Polar:
    """Plane: `rings` circles of n points about the middle, the largest `margin` mm inside the short side."""

    rings: int
    n: int
    margin: float = _length()
    start: float = _angle()
    middle: bool = True


@dataclass(frozen=True)
class Spread:
    """Plane: n points spread evenly without rows (Hammersley set, van der Corput base 2)."""

    n: int
    margin: float = _length()


@dataclass(frozen=True)
class Even:
    """Line: n points at equal distances, the first and last `margin` mm inside the ends."""

    n: int
    margin: float = _length()


@dataclass(frozen=True)
class Around:
    """Circle: n points from `start` over the arc `sweep`, both ends included unless it is a full turn."""

    n: int
    start: float = _angle()
    sweep: float = _angle(FULL)


@dataclass(frozen=True)
class Levels:
    """Cylinder, cone: n points on circles `at` mm along the axis; `stagger` turns each second half a step."""

    at: tuple[float, ...] = field(metadata={"dimension": "length"})
    n: int
    start: float = _angle()
    sweep: float = _angle(FULL)
    stagger: bool = False


@dataclass(frozen=True)
class Helix:
    """Cylinder, cone: n points on a thread of `turns` turns, `margin` mm inside the ends."""

    n: int
    turns: float
    margin: float = _length()
    start: float = _angle()


@dataclass(frozen=True)
class Birdcage:
    """Cylinder, cone: `levels` circles of n points and `lines` straight generatrices of `per_line` points."""

    levels: int
    n: int
    lines: int
    per_line: int
    margin: float = _length()
    start: float = _angle()


@dataclass(frozen=True)
class Latitudes:
    """Sphere: n points on circles `at` rad above the equator of `pole`, every second turned half a step."""

    at: tuple[float, ...] = field(metadata={"dimension": "angle"})
    n: int
    start: float = _angle()
    pole: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Iso10360:
    """Sphere: the 25 points of ISO 10360-5. The pole, then 4, 8, 4, 8 points at 22.5, 45, 67.5 and 90 deg
    from it, each circle turned by 22.5 deg against the one before.
    """

    start: float = _angle()
    pole: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Spiral:
    """Sphere: n points of equal area each (Fibonacci spiral) down to `reach` rad from the pole."""

    n: int
    reach: float = _angle(0.5 * math.pi)
    pole: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Ring:
    """Torus: n = (around the ring, around the tube); tube angle 0 is outermost, pi/2 towards +axis."""

    n: tuple[int, int]
    start: float = _angle()
    tube_start: float = _angle()
    tube_sweep: float = _angle(FULL)


@dataclass(frozen=True)
class Nominal:
    """Points: every `every`-th nominal point, in the order of their file; a point: itself."""

    every: int = 1


Pattern = (
    Nominal
    | Grid
    | Polar
    | Spread
    | Even
    | Around
    | Levels
    | Helix
    | Birdcage
    | Latitudes
    | Iso10360
    | Spiral
    | Ring
)

_ROUND: Mapping[str, type] = MappingProxyType({"levels": Levels, "helix": Helix, "birdcage": Birdcage})
PATTERNS: Mapping[str, Mapping[str, type]] = MappingProxyType(
    {
        "point": MappingProxyType({"nominal": Nominal}),
        "line": MappingProxyType({"even": Even}),
        "plane": MappingProxyType({"grid": Grid, "polar": Polar, "spread": Spread}),
        "circle": MappingProxyType({"even": Around}),
        "sphere": MappingProxyType({"levels": Latitudes, "iso10360": Iso10360, "spiral": Spiral}),
        "cylinder": _ROUND,
        "cone": _ROUND,
        "torus": MappingProxyType({"grid": Ring}),
        "mesh": MappingProxyType({}),
        "points": MappingProxyType({"nominal": Nominal}),
    }
)


def choose(kind: str, strategy: str) -> type:
    """Return the pattern class called `strategy` for a kind of feature; raises UsageError with the allowed names for another word."""
    allowed = PATTERNS[kind]
    if strategy in allowed:
        return allowed[strategy]
    if not allowed:
        raise UsageError(
            f'A {kind} has no strategy "{strategy}"; name a file of its points: points = "points.csv".'
        )
    raise UsageError(f'A {kind} has no strategy "{strategy}".{choose_from(strategy, allowed)}')


def plan_points(feature: Feature, pattern: Pattern) -> tuple[Array, Array]:
    """Return the points (n, 3) on the nominal surface, in measuring order, and normals (n, 3) out of the material, mm.

    UsageError when the pattern does not suit the feature, leaves it, or has too few points for its fit.
    """
    place = _PLACES.get(type(pattern))
    if place is None or type(pattern) not in PATTERNS[feature.kind].values():
        allowed = ", ".join(c.__name__ for c in PATTERNS[feature.kind].values()) or "explicit points only"
        raise UsageError(
            f"{feature_text(feature)}: {type(pattern).__name__} does not suit a {feature.kind}; use {allowed}."
        )
    _check_counts(feature, pattern)
    points = place(feature, pattern)
    check_enough(feature, len(points))
    return points, normal(feature, points)


def feature_text(feature: Feature) -> str:
    """Return the feature as messages name it."""
    return f'Feature "{feature.name}"'


def check_enough(feature: Feature, n: int) -> None:
    """Raise UsageError for fewer points than a fit needs."""
    least = MINIMUM_POINTS.get(feature.kind, 1)
    if n < least:
        raise UsageError(
            f"{feature_text(feature)}: a {feature.kind} needs at least {least} points, got {n}; add points."
        )


def _check_counts(feature: Feature, pattern: Pattern) -> None:
    total = len(getattr(pattern, "at", (0.0,)))
    for key in ("n", "every", "rings", "levels", "lines", "per_line"):
        counts = np.atleast_1d(getattr(pattern, key, 1))
        if not np.issubdtype(counts.dtype, np.integer) or np.any(counts < 1):
            raise UsageError(f"{feature_text(feature)}: {key} must be 1 or more, without a fraction.")
        total *= math.prod(int(c) for c in counts) if key != "every" else 1
    if isinstance(pattern, Birdcage):
        total = pattern.levels * pattern.n + pattern.lines * pattern.per_line
    if total > MOST_POINTS:
        raise UsageError(
            f"{feature_text(feature)}: {total:,} points, at most {MOST_POINTS:,} are planned; reduce n."
        )


def _inner(feature: Feature, size: float, margin: float) -> float:
    """Return the size that remains between two margins."""
    if margin < 0.0 or 2.0 * margin >= size:
        raise UsageError(
            f"{feature_text(feature)}: a margin of {margin:g} mm leaves nothing of {size:g} mm; reduce it."
        )
    return size - 2.0 * margin


def _space(size: float, n: int) -> Array:
    """Return n places from -size/2 to size/2; one place is the middle."""
    return np.linspace(-0.5 * size, 0.5 * size, n) if n > 1 else np.zeros(1)


def _angles(n: int, start: float, sweep: float) -> Array:
    """Return n angles over an arc: both ends of an arc, but a full turn only once."""
    closed = abs(sweep) >= FULL * (1.0 - 1e-12)
    return np.asarray(start + sweep * np.arange(n) / (n if closed else max(n - 1, 1)))


def _nominal(f: Feature, p: Nominal) -> Array:
    points = f.point[None] if f.nominal is None else f.nominal.points
    return np.asarray(points[:: p.every])


def _grid(f: Feature, p: Grid) -> Array:
    a, b = (_space(_inner(f, size, p.margin), n) for size, n in zip(f.extent, p.n))
    along = np.stack([a if row % 2 == 0 else a[::-1] for row in range(p.n[1])])
    return surface_point(f, along.ravel(), np.repeat(b, p.n[0]))


def _polar(f: Feature, p: Polar) -> Array:
    largest = 0.5 * _inner(f, min(f.extent), p.margin)
    radius = np.repeat(largest * np.arange(1, p.rings + 1) / p.rings, p.n)
    angle = np.tile(_angles(p.n, p.start, FULL), p.rings)
    ring = surface_point(f, radius * np.cos(angle), radius * np.sin(angle))
    return np.vstack([f.point, ring]) if p.middle else ring


def _spread(f: Feature, p: Spread) -> Array:
    a, b = (_inner(f, size, p.margin) for size in f.extent)
    index, bits = np.arange(p.n), (p.n - 1).bit_length()
    digits = np.zeros(p.n)
    for k in range(max(1, bits)):  # van der Corput: the binary digits mirrored at the point
        digits += ((index >> k) & 1) * 0.5 ** (k + 1)
    return surface_point(f, a * ((index + 0.5) / p.n - 0.5), b * (digits + 0.5 / 2**bits - 0.5))


def _even(f: Feature, p: Even) -> Array:
    return surface_point(f, 0.5 * f.extent[0] + _space(_inner(f, f.extent[0], p.margin), p.n))


def _around(f: Feature, p: Around) -> Array:
    return surface_point(f, _angles(p.n, p.start, p.sweep))


def _levels(f: Feature, p: Levels) -> Array:
    at = np.asarray(p.at, dtype=np.float64)
    if len(at) == 0 or np.any(at < 0.0) or np.any(at > f.extent[0]):
        raise UsageError(
            f"{feature_text(f)}: levels {list(p.at)} must lie between 0 and its length {f.extent[0]:g} mm."
        )
    angle = np.tile(_angles(p.n, p.start, p.sweep), len(at))
    if p.stagger:
        step = _angles(2, 0.0, p.sweep / p.n)[1]
        angle = angle + 0.5 * step * (np.repeat(np.arange(len(at)), p.n) % 2)
    return surface_point(f, angle, np.repeat(at, p.n))


def _helix(f: Feature, p: Helix) -> Array:
    share = np.arange(p.n) / max(p.n - 1, 1)
    along = p.margin + _inner(f, f.extent[0], p.margin) * share
    return surface_point(f, p.start + FULL * p.turns * share, along)


def _birdcage(f: Feature, p: Birdcage) -> Array:
    inner = _inner(f, f.extent[0], p.margin)
    at, rungs = (0.5 * f.extent[0] + _space(inner, count) for count in (p.levels, p.per_line))
    circles = surface_point(f, np.tile(_angles(p.n, p.start, FULL), p.levels), np.repeat(at, p.n))
    lines = surface_point(f, np.repeat(_angles(p.lines, p.start, FULL), p.per_line), np.tile(rungs, p.lines))
    return np.vstack([circles, lines])


def _about_pole(f: Feature, pole: tuple[float, float, float], longitude: Array, latitude: Array) -> Array:
    """Return the sphere points whose latitude counts from the equator of `pole`."""
    turned = Pose(triad(pole).T, np.zeros(3))
    at_origin = Feature(f.name, f.kind, np.zeros(3), f.axis, f.sizes, f.inside)
    return np.asarray(f.point + turned.apply(surface_point(at_origin, longitude, latitude)))


def _latitudes(f: Feature, p: Latitudes) -> Array:
    at = np.asarray(p.at, dtype=np.float64)
    if len(at) == 0 or np.any(np.abs(at) > 0.5 * math.pi):
        raise UsageError(
            f"{feature_text(f)}: levels of a sphere lie between -90 and 90 deg from its equator."
        )
    turn = math.pi / p.n * (np.repeat(np.arange(len(at)), p.n) % 2)
    return _about_pole(f, p.pole, np.tile(_angles(p.n, p.start, FULL), len(at)) + turn, np.repeat(at, p.n))


def _iso10360(f: Feature, p: Iso10360) -> Array:
    step = math.pi / 8.0
    rings = [(1, 0), (4, 1), (8, 2), (4, 3), (8, 4)]  # number of points, steps of 22.5 deg from the pole
    longitude = np.concatenate([_angles(n, p.start + max(k - 1, 0) * step, FULL) for n, k in rings])
    latitude = np.concatenate([np.full(n, 0.5 * math.pi - k * step) for n, k in rings])
    return _about_pole(f, p.pole, longitude, latitude)


def _spiral(f: Feature, p: Spiral) -> Array:
    if not 0.0 < p.reach <= math.pi:
        raise UsageError(f"{feature_text(f)}: reach lies between 0 and 180 deg from the pole.")
    height = 1.0 - (1.0 - math.cos(p.reach)) * (np.arange(p.n) + 0.5) / p.n
    return _about_pole(f, p.pole, GOLDEN * np.arange(p.n, dtype=np.float64), np.arcsin(height))


def _ring(f: Feature, p: Ring) -> Array:
    around, tube = _angles(p.n[0], p.start, FULL), _angles(p.n[1], p.tube_start, p.tube_sweep)
    return surface_point(f, np.repeat(around, p.n[1]), np.tile(tube, p.n[0]))


_PLACES: Mapping[type, Callable[[Feature, Any], Array]] = MappingProxyType(
    {
        Grid: _grid, Polar: _polar, Spread: _spread, Even: _even, Around: _around, Levels: _levels,
        Nominal: _nominal, Helix: _helix, Birdcage: _birdcage, Latitudes: _latitudes,
        Iso10360: _iso10360, Spiral: _spiral, Ring: _ring,
    }
)  # fmt: skip
