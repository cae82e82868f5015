"""Compute the surface after the cut along the nominal normal of each inspection point, to rounding.

For a point p with outward unit normal n the ray is p + s n. Each move removes stretches of it. If p lies in a removed
stretch, the surface is the lower end of the connected removed stretch around p (s <= 0: gouge, or exact); otherwise it is
the lower end of the first removed stretch above p (s > 0: material was left). So s = actual - nominal, along n.

A point of which nothing between p and `height` above it was removed is UNCUT: its s is nan and its status says so. A point
at which material is missing further down than `depth` is BEYOND: the gouge is at least as deep as the s given.
Sources: moves as in vcmm.shop.cutting.sweeps; N-rays are the discrete normal vectors of Jerard, Drysdale et al.,
IEEE Computer Graphics and Applications 9 (1989) 28, here against exact swept volumes in place of a mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.index import Index, build
from vcmm.shop.cutting.sweeps import Sweep, position

CUT, UNCUT, BEYOND = 0, 1, 2
STATUS = ("cut", "uncut", "gouge beyond the search depth")
CHUNK = 16384  # points per call of the kernel and thread


@dataclass(frozen=True, eq=False)
class CutSurface:
    """Result for n points, with the K lowest contacts of each; contacts that do not exist have row -1 and s nan.

    normal points out of the tool, into the material: n . normal < 0. t is the fraction of the row of the sweep.
    """

    points: Array  # (n, 3)
    normals: Array  # (n, 3)
    status: Array  # (n,) CUT, UNCUT or BEYOND
    contact_s: Array  # (n, K) mm, ascending
    row: Array  # (n, K)
    t: Array  # (n, K)
    normal: Array  # (n, K, 3)
    tests: Array  # (n,) moves looked at exactly

    @property
    def s(self) -> Array:
        """Deviation (n,) mm of the surface along n; nan where status is UNCUT."""
        return self.contact_s[:, 0]

    def take(self, rows: Array) -> Self:
        """Return some of the points."""
        return replace(self, **{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    def counts(self) -> dict[str, int]:
        """Return how many points have which status."""
        return {name: int(np.sum(self.status == k)) for k, name in enumerate(STATUS)}


def surface_left(
    points: Array,
    normals: Array,
    sweep: Sweep | Index,
    depth: float = 0.5,
    height: float = 2.0,
    band: float = 0.1,
    candidates: int = 4,
    threads: int = 1,
) -> CutSurface:
    """Compute the surface at points (n, 3) with outward unit normals (n, 3).

    depth, height (mm): how far below and above nominal the surface is searched. band (mm): a contact is kept as candidate
    only if it lies no further above the surface; it must exceed the displacements that the contact map will be asked for.
    """
    p, n = _rays(points, normals)
    if not (depth > 0.0 and height > 0.0 and band >= 0.0 and candidates >= 1):
        raise UsageError(
            "surface_left: depth and height must be positive, band not negative, candidates at least 1"
        )
    index = sweep if isinstance(sweep, Index) else build(sweep)
    shape = (len(p), candidates)
    s, which = np.full(shape, np.inf), np.full(shape, -1, np.int64)
    t, contact, tests = np.zeros(shape), np.full((*shape, 3), np.nan), np.zeros(len(p), np.int64)
    over = _search(index, p, n, np.array([depth, height, band]), (s, which, t, contact, tests), threads)
    if over:
        raise ModelLimit(
            f"surface_left: at {over} points more than 64 moves pass below the surface within the depth of {depth} mm; "
            "ask with a smaller depth"
        )
    return _answer(
        index=index,
        p=p,
        n=n,
        depth=depth,
        height=height,
        band=band,
        s=s,
        which=which,
        t=t,
        contact=contact,
        tests=tests,
    )


def _rays(points: Array, normals: Array) -> tuple[Array, Array]:
    p, n = (np.ascontiguousarray(np.atleast_2d(np.asarray(a, float))) for a in (points, normals))
    if p.shape != n.shape or p.shape[1] != 3:
        raise UsageError(
            f"surface_left: points {p.shape} and normals {n.shape} must both have the shape (n, 3)"
        )
    bad = np.flatnonzero(~(np.abs(np.linalg.norm(n, axis=1) - 1.0) < 1e-9) | ~np.isfinite(p).all(axis=1))
    if len(bad):
        raise UsageError(
            f"surface_left: point {bad[0]} has no unit normal or is not finite: {p[bad[0]]}, {n[bad[0]]}"
        )
    return p, n


def _search(index: Index, p: Array, n: Array, limits: Array, out: tuple[Array, ...], threads: int) -> int:
    from concurrent.futures import ThreadPoolExecutor

    from vcmm.shop.cutting import _query_kernels as kernels

    order = _neighbours_together(p)
    p, n = p[order], n[order]
    ordered = tuple(a[order] for a in out)

    def part(at: int) -> int:
        rows = slice(at, at + CHUNK)
        fixed = (
            index.frames,
            index.roots,
            index.group_tool,
            index.boxes,
            index.child,
            index.items,
            index.tools,
            index.group,
            index.tree,
            index.leaves,
        )
        return int(kernels.search(p[rows], n[rows], *fixed, limits, *(a[rows] for a in ordered)))

    starts = range(0, len(p), CHUNK)
    if threads == 1:
        over = sum(part(at) for at in starts)
    else:
        with ThreadPoolExecutor(threads) as pool:
            over = sum(pool.map(part, starts))
    for whole, sorted_ in zip(out, ordered):
        whole[order] = sorted_
    return over


def _neighbours_together(p: Array) -> Array:
    """Return the order (n,) of points along a curve through cells of space (Morton), so that moves stay in the cache of the processor."""
    if len(p) < 2:
        return np.arange(len(p))
    size = np.ptp(p, axis=0).max()
    cell = ((p - p.min(axis=0)) * (1023.0 / size if size > 0.0 else 0.0)).astype(np.int64)
    code = np.zeros(len(p), np.int64)
    for axis in range(3):
        spread = cell[:, axis]
        for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
            spread = (spread | (spread << shift)) & mask
        code |= spread << axis
    return np.argsort(code, kind="stable")


def _answer(
    index: Index,
    p: Array,
    n: Array,
    depth: float,
    height: float,
    band: float,
    s: Array,
    which: Array,
    t: Array,
    contact: Array,
    tests: Array,
) -> CutSurface:
    is_cut = (which >= 0) & (s <= np.minimum(s[:, :1] + band, height))
    status = np.full(len(p), CUT)
    status[~is_cut[:, 0]] = UNCUT
    status[is_cut[:, 0] & (s[:, 0] <= -depth)] = BEYOND
    item = np.where(is_cut, which, 0)
    frame = index.frames[index.group[item]]
    normal = np.einsum("nkij,nki->nkj", frame, contact)
    t = index.t0[item] + t * (index.t1 - index.t0)[item]
    row = np.where(is_cut, index.row[item], -1)
    void = ~is_cut
    s, t, normal = s.copy(), t.copy(), normal.copy()
    s[void], t[void], normal[void] = np.nan, np.nan, np.nan
    return CutSurface(
        points=p, normals=n, status=status, contact_s=s, row=row, t=t, normal=normal, tests=tests
    )


def tips(surface: CutSurface, sweep: Sweep) -> Array:
    """Return the tip positions (n, K, 3) at the moment of each contact; nan where there is none."""
    flat = surface.row.ravel()
    out = np.full((len(flat), 3), np.nan)
    cut = np.flatnonzero(flat >= 0)
    out[cut] = position(sweep.take(flat[cut]), surface.t.ravel()[cut])
    return out.reshape(*surface.row.shape, 3)
