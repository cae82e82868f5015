"""The nose circle of a turning insert, in the meridian half plane: the material that its path removes, and the places of its circle.

The part turns, so in one meridian section the insert does not sweep: it is there once per turn, at the present place
of its path. Two questions are answered here, for moves held as a `Sweep` in the plane (radius, 0, z) whose tools are `insert`s
(vcmm.shop.cutting.turning; the tip of such a sweep is the point of the nose circle nearest to the axis):

    removed_by     which moves come near a point: circles swept along the moves (capsules), as if the feed were endless fine
    entry          where a ray meets one circle at rest, in closed form

Only the circle cuts, its flanks do not: a face then has the feed marks that a relieved edge leaves. Whittaker,
A Treatise on the Analytical Dynamics (ray and circle) needs no more than  s = -b - sqrt(b^2 - (o.o - r^2)),  b = o . n.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting.envelope import BEYOND, CUT, UNCUT, CutSurface
from vcmm.shop.cutting.sweeps import LINE, Sweep, pieces, position
from vcmm.shop.cutting.turning import OUTWARD

CHORD = 1e-3  # mm: arcs stand as chords of this height where only the place of a contact is looked for
AT_ONCE = 4_000_000  # pairs of point and move
Ints = np.typing.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Capsules:
    """m straight stretches of the centre of the nose, (m, 2) = (radius, z): start, end; r (m,); row of the sweep, t0, t1."""

    start: Array
    end: Array
    r: Array
    row: Ints
    t0: Array
    t1: Array


def noses(sweep: Sweep, row: Ints, t: Array) -> Array:
    """Return the centre of the nose (n, 2) = (radius, z) at fractions t (n,) of rows (n,)."""
    at = position(sweep.take(row), t) + nose_radius(sweep)[row][:, None] * OUTWARD
    return np.asarray(at[:, [0, 2]])


def nose_radius(sweep: Sweep) -> Array:
    """Return the nose radius of each row (m,), mm."""
    return np.array([tool.radius for tool in sweep.tools])[sweep.tool]


def capsules(sweep: Sweep, chord: float = CHORD) -> Capsules:
    """Return the rows of a sweep as straight stretches; arcs cut so that no chord is higher than `chord` mm."""
    arm = np.where((sweep.kind == LINE)[:, None], 0.0, sweep.start - sweep.centre)
    radius = np.hypot(arm[:, 0], arm[:, 2])
    step = 2 * np.arccos(np.clip(1.0 - chord / np.where(radius > 0, radius, 1.0), -1.0, 1.0))
    counts = np.where(sweep.kind == LINE, 1, np.ceil(np.abs(sweep.turn) / step)).astype(int)
    _, row, t0, t1 = pieces(sweep, np.maximum(counts, 1))
    start, end = noses(sweep, row, t0), noses(sweep, row, t1)
    return Capsules(start, end, nose_radius(sweep)[row], row.astype(np.intp), t0, t1)


def entry(o: Array, n: Array, r: Array) -> Array:
    """Return the lowest s (...) at which o + s n lies in a circle of radius r about the origin; o, n (..., 2); inf where it misses."""
    b = (o * n).sum(axis=-1)
    square = b * b - ((o * o).sum(axis=-1) - r * r)
    return np.where(square >= 0.0, -b - np.sqrt(np.maximum(square, 0.0)), np.inf)


def removed_by(
    points: Array, normals: Array, path: Capsules, depth: float, height: float, band: float, candidates: int
) -> CutSurface:
    """Compute `surface_left` for meridian points (n, 3) = (radius, 0, z): status, and the moves that come lowest, with their t.

    Places of contacts are good to the chord of the arcs. contact_s is that of the swept circle, without feed marks.
    """
    path = _near(path, points, max(depth, height))
    size = max(1, AT_ONCE // max(len(path.r), 1))
    parts = [
        _part(
            points[i : i + size],
            normals[i : i + size],
            path,
            depth=depth,
            height=height,
            band=band,
            candidates=candidates,
        )
        for i in range(0, len(points), size)
    ]
    s, which, t = (np.concatenate([p[k] for p in parts]) for k in range(3))
    is_cut = which >= 0
    status = np.where(is_cut[:, 0], np.where(s[:, 0] <= -depth, BEYOND, CUT), UNCUT)
    row = np.where(is_cut, path.row[np.maximum(which, 0)], -1)
    share = np.where(is_cut, path.t0[which] + t * (path.t1 - path.t0)[which], np.nan)
    normal = np.broadcast_to(-normals[:, None, :], (*row.shape, 3)).copy()
    tests = np.full(len(points), len(path.r))
    return CutSurface(
        points=points,
        normals=normals,
        status=status,
        contact_s=np.where(is_cut, s, np.nan),
        row=row,
        t=share,
        normal=normal,
        tests=tests,
    )


def _near(path: Capsules, points: Array, reach: float) -> Capsules:
    """Return the stretches that come within `reach` mm of the box around the points; one at least."""
    low, high = points[:, [0, 2]].min(axis=0) - reach, points[:, [0, 2]].max(axis=0) + reach
    r = path.r[:, None]
    first, last = np.minimum(path.start, path.end) - r, np.maximum(path.start, path.end) + r
    kept = np.flatnonzero(((last >= low) & (first <= high)).all(axis=1))
    kept = kept if len(kept) else np.array([0])
    return Capsules(*(getattr(path, name)[kept] for name in Capsules.__annotations__))


def _part(
    points: Array, normals: Array, path: Capsules, depth: float, height: float, band: float, candidates: int
) -> tuple[Array, Ints, Array]:
    """Return (s, stretch, t) (n, K) of the lowest stretches that bound the removed material around each point."""
    low, high, t = _stretches(points[:, [0, 2]], normals[:, [0, 2]], path)
    low = np.where(low > height, np.inf, low)
    bottom = _bottom(low, high, depth)
    # what bounds the surface starts at it or a little above, within the band
    near = np.where(low >= bottom[:, None] - 1e-9, low, np.inf)
    near = np.where(near <= bottom[:, None] + band, near, np.inf)
    count = min(candidates, near.shape[1])
    order = np.argpartition(near, count - 1, axis=1)[:, :count]
    order = np.take_along_axis(order, np.argsort(np.take_along_axis(near, order, 1), axis=1), 1)
    s = np.take_along_axis(near, order, 1)
    which = np.where(np.isfinite(s), order, -1)
    at = np.take_along_axis(t, order, 1)
    return s, which.astype(np.intp), at


def _bottom(low: Array, high: Array, depth: float) -> Array:
    """Return the lower end (n,) of the connected stretch removed around s = 0, else of the first one above; inf where there is none."""
    around = np.where((low <= 1e-12) & (high >= -1e-12), low, np.inf).min(axis=1)
    now = np.where(np.isfinite(around), around, np.where(low > 0.0, low, np.inf).min(axis=1))
    while True:
        touching = (low < now[:, None]) & (high >= now[:, None]) & (now > -depth)[:, None]
        lower = np.where(touching, low, np.inf).min(axis=1)
        if not (lower < now).any():
            return now
        now = np.minimum(now, lower)


def _stretches(p: Array, n: Array, path: Capsules) -> tuple[Array, Array, Array]:
    """Return (lowest s, highest s, fraction of the stretch at the lowest) (n, m) of rays through capsules; inf and -inf: missed."""
    along = path.end - path.start
    length = np.hypot(along[:, 0], along[:, 1])
    unit = along / np.where(length > 0, length, 1.0)[:, None]
    low, high, t = _disc(p, n, path.start, path.r, 0.0)
    for more in (_disc(p, n, path.end, path.r, 1.0), _slab(p, n, path, unit, length)):
        t = np.where(more[0] < low, more[2], t)
        low, high = np.minimum(low, more[0]), np.maximum(high, more[1])
    return low, high, t


def _disc(p: Array, n: Array, centre: Array, r: Array, t: float) -> tuple[Array, Array, Array]:
    o0, o1 = p[:, 0:1] - centre[:, 0], p[:, 1:2] - centre[:, 1]
    b = o0 * n[:, 0:1] + o1 * n[:, 1:2]
    square = b * b - (o0 * o0 + o1 * o1 - r * r)
    root = np.sqrt(np.maximum(square, 0.0))
    hit = square >= 0.0
    return np.where(hit, -b - root, np.inf), np.where(hit, -b + root, -np.inf), np.full(b.shape, t)


def _slab(p: Array, n: Array, path: Capsules, unit: Array, length: Array) -> tuple[Array, Array, Array]:
    """Return the rectangle between the two end circles."""
    o0, o1 = p[:, 0:1] - path.start[:, 0], p[:, 1:2] - path.start[:, 1]
    a, va = o0 * unit[:, 0] + o1 * unit[:, 1], n[:, 0:1] * unit[:, 0] + n[:, 1:2] * unit[:, 1]
    c, vc = o1 * unit[:, 0] - o0 * unit[:, 1], n[:, 1:2] * unit[:, 0] - n[:, 0:1] * unit[:, 1]
    low, high = np.full(a.shape, -np.inf), np.full(a.shape, np.inf)
    for at, rate, least, most in ((a, va, np.zeros_like(length), length), (c, vc, -path.r, path.r)):
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (least - at) / rate, (most - at) / rate
        level = np.abs(rate) < 1e-15
        inside = (at >= least) & (at <= most)
        low = np.maximum(low, np.where(level, np.where(inside, -np.inf, np.inf), np.fmin(first, second)))
        high = np.minimum(high, np.where(level, np.where(inside, np.inf, -np.inf), np.fmax(first, second)))
    hit = (low <= high) & (length > 0)
    low = np.where(hit, low, np.inf)
    t = np.clip((a + np.where(hit, low, 0.0) * va) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    return low, np.where(hit, high, -np.inf), t
