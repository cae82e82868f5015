"""Tri-dexels: the material of a block on rays along X, Y and Z, for work with several tool directions and for pictures.

Every ray end is exact; between rays nothing is known. The three bundles share one grid of nodes in the middle of the
cells, so they can be joined to a closed surface (`surface`): one vertex per cell that the surface passes, in the mean of
the ray ends on its edges (surface nets: Gibson, MERL TR 98-18; edge crossings: dual contouring, Ju et al., SIGGRAPH 2002).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.index import Index, build
from vcmm.shop.cutting.sweeps import Sweep

STRETCHES_PER_RAY = 16  # stretches of material on one ray
MOST_CUTS_OF_RAY = 4096  # places in which one ray may be cut, as in the kernel


@dataclass(frozen=True, eq=False)
class Dexels:
    """Material of a block. ends[d] (na, nb, STRETCHES_PER_RAY, 2) mm along axis d from `low`, nan-filled; a, b = the other axes in order."""

    low: Array  # (3,)
    high: Array  # (3,)
    cell: Array  # (3,) mm, near the one asked for, so that cells fill the block
    nodes: Array  # (3,) int
    ends: tuple[Array, Array, Array]

    def volume(self, axis: int = 2) -> float:
        """Return the volume in mm3, by the rays along one axis."""
        other = [d for d in range(3) if d != axis]
        length = np.nansum(self.ends[axis][..., 1] - self.ends[axis][..., 0])
        return float(length * self.cell[other[0]] * self.cell[other[1]])


def carve(low: Array, high: Array, cell: float, sweep: Sweep | Index) -> Dexels:
    """Return the block between two corners (3,) after all moves of a sweep, with rays about `cell` mm apart."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    if not (cell > 0.0 and np.all(high > low)):
        raise UsageError(
            "carve: the upper corner must lie above the lower one, and the cell must be positive"
        )
    nodes = np.maximum(np.ceil((high - low) / cell - 1e-9), 2).astype(int)
    size = (high - low) / nodes
    if isinstance(sweep, Sweep) and not len(sweep):
        x, y, z = (_whole(high - low, nodes, d) for d in range(3))
        return Dexels(low, high, size, nodes, (x, y, z))
    index = sweep if isinstance(sweep, Index) else build(sweep)
    x, y, z = (_bundle(index, low, high, size, nodes, d) for d in range(3))
    return Dexels(low, high, size, nodes, (x, y, z))


def _whole(size: Array, nodes: Array, axis: int) -> Array:
    """Return rays that no tool has cut."""
    first, second = (d for d in range(3) if d != axis)
    out = np.full((int(nodes[first]), int(nodes[second]), STRETCHES_PER_RAY, 2), np.nan)
    out[:, :, 0] = 0.0, size[axis]
    return out


def _bundle(index: Index, low: Array, high: Array, size: Array, nodes: Array, axis: int) -> Array:
    first, second = (d for d in range(3) if d != axis)
    shape = (int(nodes[first]), int(nodes[second]))
    origins = np.empty((*shape, 3))
    origins[..., first] = (low[first] + (np.arange(shape[0]) + 0.5) * size[first])[:, None]
    origins[..., second] = low[second] + (np.arange(shape[1]) + 0.5) * size[second]
    origins[..., axis] = low[axis]
    return material_ends(
        index, origins.reshape(-1, 3), np.eye(3)[axis], float(high[axis] - low[axis])
    ).reshape(*shape, STRETCHES_PER_RAY, 2)


def material_ends(index: Index, rays: Array, way: Array, length: float) -> Array:
    """Return the stretches of rays (k, 3) along the unit vector `way`, `length` mm long, through which no tool passes: ends (k, STRETCHES_PER_RAY, 2)
    mm from their start, nan-filled."""
    from vcmm.shop.cutting import _dexel_kernels as kernels

    counts, out = np.zeros(len(rays), np.int64), np.full((len(rays), STRETCHES_PER_RAY, 2), np.nan)
    fixed = (
        index.frames, index.roots, index.group_tool, index.boxes, index.child, index.items, index.tools, index.tree, index.leaves,
    )  # fmt: skip
    most = kernels.material(
        np.ascontiguousarray(rays), np.ascontiguousarray(way), length, *fixed, counts, out
    )
    name = "XYZ"[int(np.argmax(np.abs(way)))]
    if most > MOST_CUTS_OF_RAY:
        raise ModelLimit(
            f"carve: a ray along {name} is cut in {most} places, more than {MOST_CUTS_OF_RAY}; carve the program in parts"
        )
    if counts.max(initial=0) > STRETCHES_PER_RAY:
        raise ModelLimit(
            f"carve: a ray along {name} has {counts.max()} pieces of material, more than {STRETCHES_PER_RAY}"
        )
    return out


def both(first: Dexels, other: Dexels) -> Dexels:
    """Return the material that is in both, of one block with the same rays. Raises ModelLimit where a ray has more pieces than `STRETCHES_PER_RAY`."""
    x, y, z = (_common(a, b) for a, b in zip(first.ends, other.ends))
    return Dexels(first.low, first.high, first.cell, first.nodes, (x, y, z))


def _common(first: Array, other: Array) -> Array:
    """Return the pieces (na, nb, STRETCHES_PER_RAY, 2) that two bundles of rays share."""
    used = [int(np.isfinite(e[..., 0]).sum(axis=2).max(initial=0)) for e in (first, other)]
    low = np.maximum(first[:, :, : used[0], None, 0], other[:, :, None, : used[1], 0])
    high = np.minimum(first[:, :, : used[0], None, 1], other[:, :, None, : used[1], 1])
    shape = (*first.shape[:2], used[0] * used[1])
    there = (high - low > 0.0).reshape(shape)
    pieces = np.where(there[..., None], np.stack([low, high], axis=-1).reshape(*shape, 2), np.nan)
    order = np.argsort(pieces[..., 0], axis=2)  # nan comes last
    pieces = np.take_along_axis(pieces, order[..., None], axis=2)
    if there.sum(axis=2).max(initial=0) > STRETCHES_PER_RAY:
        raise ModelLimit(f"carve: a ray has more than {STRETCHES_PER_RAY} pieces of material")
    out = np.full_like(first, np.nan)
    out[:, :, : min(STRETCHES_PER_RAY, shape[2])] = pieces[:, :, :STRETCHES_PER_RAY]
    return out


def sparser(dexels: Dexels, every: int) -> Dexels:
    """Return only the middle one of `every` rays (an odd number) in both directions, for pictures; the last strip may protrude."""
    if every == 1:
        return dexels
    nodes = -(-dexels.nodes // every)
    kept = [np.minimum(every * np.arange(n) + every // 2, old - 1) for n, old in zip(nodes, dexels.nodes)]
    size = dexels.cell * every
    x, y, z = (dexels.ends[d][np.ix_(*(kept[o] for o in range(3) if o != d))] for d in range(3))
    return Dexels(dexels.low, dexels.low + nodes * size, size, nodes, (x, y, z))


def nodes_in_material(dexels: Dexels) -> Array:
    """Return which nodes (nx, ny, nz) lie in material, by the rays along Z."""
    z = (np.arange(dexels.nodes[2]) + 0.5) * dexels.cell[2]
    is_inside = np.zeros(tuple(dexels.nodes), bool)
    for k in range(STRETCHES_PER_RAY):
        stretch = dexels.ends[2][:, :, k]
        is_inside |= (z >= stretch[..., :1]) & (z <= stretch[..., 1:])
    return is_inside


def surface(dexels: Dexels) -> tuple[Array, Array]:
    """Return the closed surface as vertices (v, 3) and triangles (f, 3), outward."""
    solid = np.pad(nodes_in_material(dexels), 1)
    total, number = np.zeros((*(s - 1 for s in solid.shape), 3)), np.zeros([s - 1 for s in solid.shape])
    quads = []
    for axis in range(3):
        left, right = _halves(solid, axis)
        edge = np.argwhere(left != right)  # padded index of the lower node
        rising = right[tuple(edge.T)]
        point = dexels.low + (edge - 0.5) * dexels.cell
        point[:, axis] = dexels.low[axis] + _crossing(dexels, edge, axis, rising)
        b, c = (axis + 1) % 3, (axis + 2) % 3
        corners = []
        for db, dc in (
            (-1, -1),
            (0, -1),
            (0, 0),
            (-1, 0),
        ):  # cells about the edge, right-handed about the axis
            cell = edge.copy()
            cell[:, b] += db
            cell[:, c] += dc
            np.add.at(total, tuple(cell.T), point)
            np.add.at(number, tuple(cell.T), 1.0)
            corners.append(np.ravel_multi_index(tuple(cell.T), number.shape))
        quad = np.stack(corners, axis=1)
        quads.append(np.where(rising[:, None], quad[:, ::-1], quad))
    used = np.flatnonzero(number.ravel())
    renumber = np.full(number.size, -1)
    renumber[used] = np.arange(len(used))
    quad = renumber[np.concatenate(quads)]
    vertices = total.reshape(-1, 3)[used] / number.ravel()[used, None]
    return vertices, np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])


def _halves(solid: Array, axis: int) -> tuple[Array, Array]:
    n = solid.shape[axis]
    return np.take(solid, np.arange(n - 1), axis), np.take(solid, np.arange(1, n), axis)


def _crossing(dexels: Dexels, edge: Array, axis: int, rising: Array) -> Array:
    """Return the distance from `low` along the axis at which the surface crosses each edge; its middle where the rays know of none."""
    first, second = (d for d in range(3) if d != axis)
    low = (edge[:, axis] - 0.5) * dexels.cell[axis]
    ends = dexels.ends[axis][edge[:, first] - 1, edge[:, second] - 1]  # (e, STRETCHES_PER_RAY, 2)
    wanted = np.where(rising[:, None], ends[..., 0], ends[..., 1])
    size = dexels.cell[axis]
    near = (wanted >= low[:, None] - 1e-9) & (wanted <= low[:, None] + size + 1e-9)
    pick = np.argmax(near, axis=1)
    rows = np.arange(len(edge))
    return np.where(near.any(axis=1), wanted[rows, pick], low + size / 2)
