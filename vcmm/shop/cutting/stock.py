"""Stock as a map of heights (z-dexels): picture, volume removed, engagement, collisions of rapids. Three axes, tool along +Z.

The height at a node is exact (the tool's sweep over that node, not a stamped picture); between nodes it is unknown, so
volumes and engagements carry an error of about the cell times the contour. This is for pictures and forces, which need a
few percent: deviations come from vcmm.shop.cutting.envelope. Source: z-map, e.g. Altintas & Lazoglu; exact capsule envelopes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.index import QUARTER, _item_boxes, _items
from vcmm.shop.cutting.sweeps import LINE, Sweep, lengths, pieces
from vcmm.shop.cutting.tools import parameters

MOST_NODES = 50_000_000
BLUR = 0.02  # of a cell: what the map does not see


@dataclass(frozen=True, eq=False)
class Stock:
    """Heights (nx, ny) mm over the nodes x0 + i cell, y0 + j cell; bottom = height of the underside, nothing is below."""

    height: Array
    x0: float
    y0: float
    cell: float
    bottom: float

    @property
    def volume(self) -> float:
        """Volume in mm3; each node represents one cell."""
        return float((self.height - self.bottom).sum() * self.cell**2)


@dataclass(frozen=True, eq=False)
class Removal:
    """Effect of the moves of a sweep on the stock; rows are those of the sweep."""

    stock: Stock  # afterwards
    volume: Array  # (m,) mm3
    axial: Array  # (m,) mm, mean height of material in front of the tool
    radial: Array  # (m,) mm, width of material in front of the tool
    enter: Array  # (m,) rad, angle at which the edge enters, see vcmm.shop.cutting.force
    leave: Array  # (m,) rad
    collisions: Array  # rows of rapids that ran through material
    collision_depth: Array  # mm, greatest height of material above the tool's path in each
    idle: Array  # rows of feed moves that touched no material


def block(low: Array, high: Array, cell: float) -> Stock:
    """Return a rectangular block from corner to corner (3,), nodes in the middle of square cells of `cell` mm."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    if not (cell > 0.0 and np.all(high > low)):
        raise UsageError(
            "block: the upper corner must lie above the lower one, and the cell must be positive"
        )
    count = np.maximum(np.round((high - low)[:2] / cell), 1).astype(int)
    if count.prod() > MOST_NODES:
        raise ModelLimit(
            f"block: {count[0]} x {count[1]} nodes are more than {MOST_NODES:.0e}; choose a cell of "
            f"{np.sqrt(np.prod((high - low)[:2]) / MOST_NODES):.2g} mm or more"
        )
    return Stock(np.full(tuple(count), high[2]), low[0] + cell / 2, low[1] + cell / 2, cell, float(low[2]))


def remove(stock: Stock, sweep: Sweep, rapid: Array | None = None, clearance: float = 1e-3) -> Removal:
    """Cut the stock with all moves in order. rapid (m,) bool marks moves that must not cut: they are only checked.

    clearance (mm): a rapid that runs no deeper than this in material is not called a collision.
    """
    if np.any(np.abs(sweep.axis - [0.0, 0.0, 1.0]).max(axis=1) > 1e-12):
        bad = int(np.argmax(np.abs(sweep.axis - [0.0, 0.0, 1.0]).max(axis=1)))
        raise ModelLimit(
            f"remove: move {sweep.move[bad]} has its tool axis off +Z; a map of heights holds three-axis work only. "
            "Use vcmm.shop.cutting.dexels for indexed work."
        )
    from vcmm.shop.cutting import _stock_kernels as kernels

    m = len(sweep)
    fast = np.zeros(m, bool) if rapid is None else np.asarray(rapid, bool)
    parts, row, _, _ = pieces(sweep, _counts(sweep))
    items = _as_circles(_items(parts, np.broadcast_to(np.eye(3), (len(parts), 3, 3))), BLUR * stock.cell)
    height, grid = stock.height.copy(), np.array([stock.x0, stock.y0, stock.cell])
    volume, deepest, engaged = np.zeros(m), np.zeros(m), np.zeros((len(items), 4))
    tools = parameters(sweep.tools)
    kernels.cut_all(
        height, grid, items, _item_boxes(items), tools, row, fast, stock.bottom, volume, deepest, engaged
    )
    left = Stock(height, stock.x0, stock.y0, stock.cell, stock.bottom)
    hit = np.flatnonzero(fast & (deepest > clearance))
    axial, radial, enter, leave = _per_row(engaged, row, lengths(parts), sweep)
    idle = np.flatnonzero(~fast & (volume == 0.0))
    return Removal(
        stock=left,
        volume=volume,
        axial=axial,
        radial=radial,
        enter=enter,
        leave=leave,
        collisions=hit,
        collision_depth=deepest[hit],
        idle=idle,
    )


def _as_circles(items: Array, most: float) -> Array:
    """Return level arcs whose rounded ends lie on two radii or heights, no more than `most` mm apart, as circles: the map has no finer cells,
    and a spiral is searched column by column."""
    out = items.copy()
    upright = np.abs(out[:, 11]) + np.abs(out[:, 14]) <= 1e-14
    near = (np.abs(out[:, 16] - out[:, 15]) <= most) & (
        np.abs(out[:, 18:21]).max(axis=1, initial=0.0) <= most
    )
    rows = np.flatnonzero((out[:, 21] == 2.0) & upright & near)
    out[rows, 16], out[rows, 5], out[rows, 18:21], out[rows, 21] = out[rows, 15], out[rows, 2], 0.0, 1.0
    return out


def _counts(sweep: Sweep) -> Array:
    """Return the number of pieces: arcs in quarter turns, lines in pieces of at most four tool radii, so that the engagement is sampled
    often enough."""
    reach = np.array([t.radius for t in sweep.tools])[sweep.tool]
    lines = np.ceil(np.linalg.norm(sweep.end - sweep.start, axis=1) / (4.0 * reach) - 1e-9)
    arcs = np.ceil(np.abs(sweep.turn) / QUARTER - 1e-9)
    return np.maximum(np.where(sweep.kind == LINE, lines, arcs), 1).astype(int)


def _per_row(engaged: Array, row: Array, length: Array, sweep: Sweep) -> tuple[Array, Array, Array, Array]:
    """Return the means over the pieces of each row that meet material, weighted with their length."""
    m = len(sweep)
    weight = length * (engaged[:, 3] > 0.0)
    total = np.bincount(row, weight, m)
    mean = [
        np.divide(np.bincount(row, weight * engaged[:, k], m), total, out=np.zeros(m), where=total > 0.0)
        for k in range(3)
    ]
    reach = np.array([t.radius for t in sweep.tools])[sweep.tool]
    radial = reach * (np.cos(mean[1]) - np.cos(mean[2]))
    return mean[0], radial, mean[1], mean[2]
