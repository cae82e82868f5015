"""Material before a tool that comes from several sides, one direction after another, for forces with rotary axes off zero.

Seen along the tool a stock has no undercuts that matter to it, so for each stretch of the program with one direction of the tool the stock is a map of
heights in the frame of that tool: rays against its axis meet first the block as all moves before have left it. In it the moves of that stretch
cut as with three axes, and the engagement (depth, angles of entry and exit) is what forces need. Rays are `NODES` along the longer side
of the area that the stretch
covers. A tool that tilts while it cuts has as many directions as blocks: beyond `MOST_DIRECTIONS` there is no result.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.dexels import material_ends
from vcmm.shop.cutting.index import build
from vcmm.shop.cutting.stock import Removal, Stock, remove
from vcmm.shop.cutting.sweeps import LINE, UP, Sweep, frames_of, pieces, position

NODES = 300  # rays along the longer side of what one direction runs over
MOST_DIRECTIONS = 60  # directions one after another
SAME_DIRECTION = 1e-9  # of a unit vector
CHORD = 0.1  # rad: its sagitta at 10 mm is 0.0125 mm
FIELDS = ("volume", "axial", "radial", "enter", "leave")


def directions(axis: Array) -> Ints:
    """Return the number of the stretch of one direction that each row with its axis (rows, 3) belongs to, (rows,)."""
    turned = np.abs(np.diff(axis, axis=0)).max(axis=1, initial=0.0) > SAME_DIRECTION
    return np.concatenate([[0], np.cumsum(turned)]).astype(np.intp)


def indexed_removal(
    low: Array, high: Array, whole: Sweep, rapid: Array, stretches: tuple[Sweep, Ints]
) -> Removal | None:
    """Return the engagement of each stretch of a sweep with the block between two corners (3,), workpiece axes; None where the tool cuts
    in more than `MOST_DIRECTIONS` directions.

    whole, rapid (rows,): the sweep and its rows that cut nothing; stretches: its rows cut up, and the row of each. Of the answer only the
    columns count; its
    stock is that of the last direction.
    """
    sweep, row = stretches
    cuts = np.logical_not(rapid)
    straight, of = _chords(whole)
    feeds = np.flatnonzero(cuts[row])
    number = directions(sweep.axis[feeds]) if len(feeds) else np.zeros(0, dtype=np.intp)
    if number.max(initial=0) >= MOST_DIRECTIONS:
        return None
    columns = {name: np.zeros(len(sweep)) for name in FIELDS}
    last: Removal | None = None
    for k in range(int(number.max(initial=-1)) + 1):
        rows = feeds[number == k]
        before = np.flatnonzero(cuts[of] & (of < row[rows[0]]))
        frame = frames_of(sweep.axis[rows[:1]])[0]
        mine = _in_frame(sweep.take(rows), frame)
        stock = _stock_before(low, high, straight.take(before), mine, frame)
        if stock is None:
            continue
        last = remove(stock, mine)
        for name in FIELDS:
            columns[name][rows] = getattr(last, name)
    none = np.zeros(0, dtype=np.intp)
    if last is None:
        return None
    return Removal(last.stock, **columns, collisions=none, collision_depth=np.zeros(0), idle=none)


def _chords(sweep: Sweep) -> tuple[Sweep, Ints]:
    """Return the sweep with its arcs as chords, which rays along the axis of a tool leave at once, and the row of each (rows,)."""
    count = np.where(sweep.kind == LINE, 1, np.maximum(np.ceil(np.abs(sweep.turn) / CHORD), 1)).astype(
        np.intp
    )
    parts, row, _, _ = pieces(sweep, count)
    ends = position(parts, np.ones(len(parts)))
    nothing = np.full(parts.centre.shape, np.nan)
    plain = replace(
        parts,
        end=ends,
        centre=nothing,
        normal=nothing,
        turn=np.zeros(len(parts)),
        kind=np.full(len(parts), LINE),
        drift=None,
    )
    return plain, row.astype(np.intp)


def _in_frame(sweep: Sweep, frame: Array) -> Sweep:
    """Return the sweep in the frame of its tool (3, 3), axes as rows."""
    turned = {name: getattr(sweep, name) @ frame.T for name in ("start", "end", "centre", "normal")}
    drift = None if sweep.drift is None else sweep.drift @ frame.T
    return replace(
        sweep, **turned, drift=drift, axis=np.broadcast_to(UP, sweep.axis.shape).copy(), axis_end=None
    )


def _stock_before(low: Array, high: Array, before: Sweep, mine: Sweep, frame: Array) -> Stock | None:
    """Return heights in the frame of the tool of the block after `before` (workpiece axes), under the area of `mine`; None where it runs beside."""
    corners = (
        np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        @ frame.T
    )
    reach = np.array([t.radius for t in mine.tools])[mine.tool][:, None]
    about = np.abs(mine.turn)[:, None] > 0.0
    far = np.where(about, np.linalg.norm(mine.start - np.nan_to_num(mine.centre), axis=1)[:, None], 0.0)
    middle = np.where(about, np.nan_to_num(mine.centre), mine.start)
    first = np.minimum(np.minimum(mine.start, mine.end), middle - far)[:, :2] - reach
    second = np.maximum(np.maximum(mine.start, mine.end), middle + far)[:, :2] + reach
    a, b = (
        np.maximum(first.min(axis=0), corners[:, :2].min(axis=0)),
        np.minimum(second.max(axis=0), corners[:, :2].max(axis=0)),
    )
    if not (b > a).all():
        return None
    cell = float((b - a).max() / NODES)
    count = np.maximum(np.ceil((b - a) / cell - 1e-9).astype(int), 1)
    x, y = (a[i] + (np.arange(count[i]) + 0.5) * cell for i in (0, 1))
    top, bottom = float(corners[:, 2].max()), float(corners[:, 2].min())
    grid = np.stack([*np.meshgrid(x, y, indexing="ij"), np.full(tuple(count), top)], axis=-1).reshape(-1, 3)
    height = top - _first_met(grid @ frame, -frame[2], top - bottom, low, high, before)
    return Stock(np.maximum(height, bottom).reshape(tuple(count)), float(x[0]), float(y[0]), cell, bottom)


def _first_met(rays: Array, way: Array, length: float, low: Array, high: Array, before: Sweep) -> Array:
    """Return how far (k,) mm rays run along `way` until they meet the block after `before`; `length` where they meet nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        slabs = np.stack([(low - rays) / way, (high - rays) / way])
    flat = np.abs(way) < SAME_DIRECTION
    inside = ((rays >= low) & (rays <= high)) | ~flat
    enters = np.where(flat, -np.inf, slabs.min(axis=0)).max(axis=1)
    leaves = np.where(flat, np.inf, slabs.max(axis=0)).min(axis=1)
    meets = inside.all(axis=1) & (leaves > enters)
    enters = np.maximum(enters, 0.0)
    if not len(before):
        return np.where(meets, enters, length)
    ends = material_ends(build(before), rays, way, length)  # (k, ROOM, 2)
    begins = np.maximum(ends[..., 0], enters[:, None])
    there = begins < np.minimum(ends[..., 1], leaves[:, None])
    return np.where(meets, np.where(there, begins, length).min(axis=1), length)
