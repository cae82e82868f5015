"""Index of a sweep: pieces in the frame of their tool, in trees of boxes, as the compiled search takes them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.laws import Array
from vcmm.shop.cutting.groups import tree_of_groups
from vcmm.shop.cutting.sweeps import LINE, Sweep, basis, frames_of, pieces
from vcmm.shop.cutting.tools import SHAPES, parameters

LEAF = 2  # pieces in a leaf of a tree
COLUMNS = 23  # of `items`, see vcmm/shop/cutting/_tool_kernels.py
QUARTER = np.pi / 2
_LEVEL_RISE_MM = 1e-12  # mm: rise below which a move is level


@dataclass(frozen=True, eq=False)
class Index:
    """Arrays of the search. One tree per tool and tool direction; `row`, `t0`, `t1` (items,) lead back to the sweep."""

    sweep: Sweep
    frames: Array  # (G, 3, 3)
    roots: Array  # (G,)
    group_tool: Array  # (G,)
    boxes: Array  # (nodes, 6)
    child: Array  # (nodes, 2)
    items: Array  # (items, COLUMNS)
    tools: Array  # (tools, 7)
    row: Array
    t0: Array
    t1: Array
    group: Array  # (items,)
    tree: Array  # (2 m, 11): of the trees
    leaves: Array  # (m,): tree of each leaf of it


def build(sweep: Sweep) -> Index:
    """Return the index of all moves of a sweep."""
    parts, row, t0, t1 = pieces(sweep, _counts(sweep))
    key = np.column_stack([parts.axis.round(12), parts.tool])
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    group = np.ravel(group)
    frames = frames_of(parts.axis[first])
    items = _items(parts, frames[group])
    order, roots, boxes, child = _forest(items, group, len(first))
    shapes = parameters(sweep.tools)
    tool_shapes = shapes[parts.tool[first]]
    is_ball = tool_shapes[:, 0] == SHAPES.index("ball")
    tree, leaves = tree_of_groups(
        frames, boxes[roots], tool_shapes[:, 1], is_ball, np.argsort(first, kind="stable")
    )
    return Index(
        sweep=sweep,
        frames=frames,
        roots=roots,
        group_tool=parts.tool[first].astype(np.int64),
        boxes=boxes,
        child=child,
        items=items[order],
        tools=shapes,
        row=row[order],
        t0=t0[order],
        t1=t1[order],
        group=group[order],
        tree=tree,
        leaves=leaves,
    )


def _counts(sweep: Sweep) -> Array:
    """Return the arcs in quarter turns; oblique lines so that no box is much wider than the tool."""
    span = np.sort(np.abs(sweep.end - sweep.start), axis=1)[:, 1]
    reach = np.array([t.radius for t in sweep.tools])[sweep.tool]
    lines = np.ceil(span / (4.0 * reach) - 1e-9)
    arcs = np.ceil(np.abs(sweep.turn) / QUARTER - 1e-9)
    return np.maximum(np.where(sweep.kind == LINE, lines, arcs), 1).astype(int)


def _items(parts: Sweep, frame: Array) -> Array:
    def in_frame(v: Array) -> Array:
        return np.einsum("mij,mj->mi", frame, v)

    out = np.zeros((len(parts), COLUMNS))
    drift = np.zeros_like(parts.start) if parts.drift is None else parts.drift
    out[:, 0:3], out[:, 3:6] = in_frame(parts.start), in_frame(parts.end + drift)
    level = np.abs(out[:, 5] - out[:, 2]) <= _LEVEL_RISE_MM
    out[level, 5] = out[level, 2]
    out[:, 22] = parts.tool
    rows = np.flatnonzero(parts.kind != LINE)
    if len(rows):
        arcs = parts.take(rows)
        first, second, r0, r1, rise = basis(replace(arcs, drift=None))
        height = np.einsum("mi,mi->m", arcs.start - arcs.centre, arcs.normal)[:, None] * arcs.normal
        sign = np.where(arcs.turn < 0.0, -1.0, 1.0)[:, None]
        f, advance = frame[rows], rise + drift[rows]
        out[rows, 6:9] = np.einsum("mij,mj->mi", f, arcs.centre + height)
        out[rows, 9:12] = np.einsum("mij,mj->mi", f, first)
        out[rows, 12:15] = np.einsum("mij,mj->mi", f, sign * second)
        out[rows, 15], out[rows, 16], out[rows, 17] = r0, r1, np.abs(arcs.turn)
        out[rows, 18:21] = np.einsum("mij,mj->mi", f, advance)
        upright = np.abs(out[rows, 11]) + np.abs(out[rows, 14]) <= 1e-14
        plain = upright & (np.abs(r1 - r0) <= 1e-12) & (np.abs(advance).max(axis=1) <= _LEVEL_RISE_MM)
        out[rows, 21] = np.where(plain, 1.0, 2.0)
    return out


def _item_boxes(items: Array) -> Array:
    """Return the boxes (items, 6) that hold the paths: of an arc, the triangle of its ends and the crossing of their tangents."""
    a, b = items[:, 0:3], items[:, 3:6]
    low, high = np.minimum(a, b), np.maximum(a, b)
    rows = np.flatnonzero(items[:, 21] > 0)
    if len(rows):
        arc = items[rows]
        half = arc[:, 17:18] / 2
        reach = np.maximum(arc[:, 15:16], arc[:, 16:17]) / np.cos(half)
        corner = arc[:, 6:9] + reach * (np.cos(half) * arc[:, 9:12] + np.sin(half) * arc[:, 12:15])
        pad = np.abs(arc[:, 15:16] - arc[:, 16:17])
        for end in (corner, corner + arc[:, 18:21], a[rows] + arc[:, 18:21], b[rows] - arc[:, 18:21]):
            low[rows], high[rows] = np.minimum(low[rows], end - pad), np.maximum(high[rows], end + pad)
    return np.hstack([low, high])


def _forest(items: Array, group: Array, groups: int) -> tuple[Array, Array, Array, Array]:
    """Order of the items, root of each tree, boxes and children of the nodes: halved at the median of the widest side."""
    limits = _item_boxes(items)
    middle = 0.5 * (limits[:, :3] + limits[:, 3:])
    order = np.argsort(group, kind="stable")
    edges = np.searchsorted(group[order], np.arange(groups + 1))
    size = np.diff(edges)
    small = np.flatnonzero(size <= LEAF)  # a leaf each
    ends = np.stack([edges[small], edges[small + 1]], axis=1).ravel()
    inside = limits[np.append(order, order[-1:])]
    few = np.hstack([
        np.minimum.reduceat(inside[:, :3], ends)[::2], np.maximum.reduceat(inside[:, 3:], ends)[::2]
    ]) if len(small) else np.zeros((0, 6))  # fmt: skip
    boxes: list[Array] = []
    child: list[tuple[int, int]] = []
    roots = np.zeros(groups, np.int64)
    roots[small] = np.arange(len(small))
    for g in np.flatnonzero(size > LEAF).tolist():
        roots[g] = len(small) + len(boxes)
        boxes.append(limits[0])
        child.append((0, 0))
        todo = [(len(boxes) - 1, int(edges[g]), int(edges[g + 1]))]
        while todo:
            node, lo, hi = todo.pop()
            inside = order[lo:hi]
            box = limits[inside]
            boxes[node] = np.concatenate([box[:, :3].min(axis=0), box[:, 3:].max(axis=0)])
            if hi - lo <= LEAF:
                child[node] = (-lo - 1, hi - lo)
                continue
            centres = middle[inside]
            side = int(np.argmax(np.ptp(centres, axis=0)))
            half = (hi - lo) // 2
            order[lo:hi] = inside[np.argpartition(centres[:, side], half)]
            after = len(small) + len(boxes)
            child[node] = (after, after + 1)
            todo += [(len(boxes), lo, lo + half), (len(boxes) + 1, lo + half, hi)]
            boxes += [box[0], box[0]]
            child += [(0, 0), (0, 0)]
    leaf = np.stack([-edges[small] - 1, size[small]], axis=1)
    return (
        order, roots, np.concatenate([few, np.array(boxes).reshape(-1, 6)]),
        np.concatenate([leaf, np.array(child, np.int64).reshape(-1, 2)]).astype(np.int64),
    )  # fmt: skip
