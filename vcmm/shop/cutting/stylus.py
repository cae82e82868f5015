"""Rolling stylus: the reading of a probe ball that rests on the cusps of a cut surface (morphological closing).

The ball of radius r comes down along -n over the point p. It stops at the height

    s = max over offsets a square to n, |a| < r, of  z(a) + sqrt(r^2 - a^2) - r

z(a) = height of the cut surface over p + a, measured along n: rays parallel to n, exact each. So a stylus smaller than the
curvature of the valleys reaches their bottom, a larger one rests on the crests. The maximum is sampled on a grid of
offsets and refined by closer and closer grids about the three best local maxima. Source: ISO 16610-41 (morphological disc
filters); the probed surface is the closing, ISO 14406. The part is taken as rigid, the ball as perfect.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.envelope import UNCUT, surface_left
from vcmm.shop.cutting.index import Index, build
from vcmm.shop.cutting.sweeps import Sweep

GRID, ZOOM, ROUNDS, PEAKS = 25, 7, 9, 3
CHUNK = 200  # points at a time
WINDOW = 0.5, 2.0  # mm below and above a point in which the surface is looked for


@dataclass(frozen=True, eq=False)
class BallContacts:
    """Readings of n touches, as heights above the nominal point along n."""

    s: Array  # (n,) mm; nan where the surface under p itself was not cut
    offset: Array  # (n, 3) mm, from p to the foot of the contact, square to n
    beside_uncut: Array  # (n,) bool: rays within reach met nothing cut; they count as air
    at_reach: Array  # (n,) bool: the contact lies at the rim of the patch, so `relief` was too small


def roll_ball(
    points: Array,
    normals: Array,
    radius: float,
    sweep: Sweep | Index,
    relief: float = 0.05,
) -> BallContacts:
    """Return the contact height of a ball of `radius` (mm) at points (n, 3) along -normals (n, 3).

    relief (mm): cusps and form within the patch are assumed no higher than this above the surface at p, which bounds how far
    from p the ball can touch: sqrt(2 r relief).
    """
    if not (radius > 0.0 and relief > 0.0):
        raise UsageError("rolled: radius and relief must be positive, in mm")
    index = sweep if isinstance(sweep, Index) else build(sweep)
    p, n = np.atleast_2d(np.asarray(points, float)), np.atleast_2d(np.asarray(normals, float))
    parts = [
        _roll(p[i : i + CHUNK], n[i : i + CHUNK], radius, index, relief) for i in range(0, len(p), CHUNK)
    ]
    return BallContacts(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in BallContacts.__annotations__)
    )


def _roll(p: Array, n: Array, r: float, index: Index, relief: float) -> BallContacts:
    reach = float(np.sqrt(min(2.0 * r * relief, 0.999 * r * r)))
    first, second = _tangents(n)
    grid = np.linspace(-reach, reach, GRID)
    a, b = (g.ravel() for g in np.meshgrid(grid, grid, indexing="ij"))
    inside = a * a + b * b <= reach * reach * (1 + 1e-9)
    centre = len(a) // 2

    def heights(u: Array, v: Array) -> tuple[Array, Array]:
        """Return the lift of the ball (n, m) by the surface at offsets (n, m), and which rays met nothing cut."""
        at = p[:, None] + u[..., None] * first[:, None] + v[..., None] * second[:, None]
        along = np.broadcast_to(n[:, None], at.shape)
        left = surface_left(at.reshape(-1, 3), along.reshape(-1, 3), index, *WINDOW, candidates=1, band=0.0)
        void = (left.status == UNCUT).reshape(u.shape)
        square = u * u + v * v
        lift = np.where(void, -np.inf, left.s.reshape(u.shape)) - square / (
            r + np.sqrt(np.maximum(r * r - square, 0.0))
        )
        return np.where(square <= reach * reach * (1 + 1e-9), lift, -np.inf), void

    u, v = np.broadcast_to(a, (len(p), len(a))), np.broadcast_to(b, (len(p), len(b)))
    lift, void = heights(u, v)
    best, at_u, at_v = lift[:, centre].copy(), np.zeros(len(p)), np.zeros(len(p))
    for peak in _peaks(lift):
        high, uu, vv = _climb(heights, u, v, lift, peak, grid[1] - grid[0])
        better = high > best
        best, at_u, at_v = (
            np.where(better, high, best),
            np.where(better, uu, at_u),
            np.where(better, vv, at_v),
        )
    offset = at_u[:, None] * first + at_v[:, None] * second
    s = np.where(void[:, centre], np.nan, best)
    return BallContacts(
        s, offset, np.asarray(np.any(void & inside, axis=1)), np.hypot(at_u, at_v) > 0.99 * reach
    )


def _tangents(n: Array) -> tuple[Array, Array]:
    other = np.eye(3)[np.argmin(np.abs(n), axis=1)]
    first = np.cross(other, n)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(n, first)


def _peaks(lift: Array) -> list[Array]:
    """Return the indices (n,) of the highest local maxima on the grid."""
    square = lift.reshape(-1, GRID, GRID)
    padded = np.pad(square, ((0, 0), (1, 1), (1, 1)), constant_values=-np.inf)
    around = np.max(
        [padded[:, 1 + i : 1 + i + GRID, 1 + j : 1 + j + GRID] for i in (-1, 0, 1) for j in (-1, 0, 1)],
        axis=0,
    )
    peaks = np.where(square >= around, square, -np.inf).reshape(len(lift), -1)
    order = np.argpartition(-peaks, PEAKS, axis=1)[:, :PEAKS]
    return [order[:, k] for k in range(PEAKS)]


def _climb(heights, u: Array, v: Array, lift: Array, peak: Array, step: float) -> tuple[Array, Array, Array]:  # type: ignore[no-untyped-def]
    """Return the highest point near a peak, by grids that shrink about the best point so far."""
    rows = np.arange(len(u))
    high, uu, vv = lift[rows, peak], u[rows, peak], v[rows, peak]
    unit = np.linspace(-1.0, 1.0, ZOOM)
    da, db = (g.ravel() for g in np.meshgrid(unit, unit, indexing="ij"))
    for _ in range(ROUNDS):
        a, b = uu[:, None] + step * da, vv[:, None] + step * db
        new, _ = heights(a, b)
        k = np.argmax(new, axis=1)
        better = new[rows, k] > high
        high = np.where(better, new[rows, k], high)
        uu, vv = np.where(better, a[rows, k], uu), np.where(better, b[rows, k], vv)
        step *= 0.45
    return high, uu, vv
