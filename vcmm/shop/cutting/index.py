"""Index of a sweep: pieces in the frame of their tool, in trees of boxes, as the compiled search takes them.

There is a tree over these trees: in a program that turns its tool all the time, every motion has its own direction, and so its own tree.

A node holds the tips of its tools in a ball (centre, radius) and their axes within `spread` of one axis a (length of the difference of
unit vectors). Seen from the centre, let v be a point of a ray. For a tip t and an axis b of the node

    distance of the point from the tool's axis >= distance of v from the line along a - |v| spread - radius
    height of the point over the tip           <= v . a + |v| spread + radius

since turning the axis from a to b moves the foot of v by at most |v| |b - a|, and moving the tip moves both by at most its way. Where the first
exceeds the tool's radius, or the second lies below zero, on all of the ray, no tool of the node touches it, however long the tool is.
Method: bounding volumes over positions and directions, Larsen, Gottschalk, Lin & Manocha, UNC TR99-018 (1999); the bounds are ours, by
the triangle inequality. Of ball-nosed tools the node holds the middles of the balls instead: where the point lies above that middle, along the
axis, the first bound holds, where it lies below, its distance from the middle is at least |v| - radius. Neighbours in the program are neighbours in the tree.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.laws import Array
from vcmm.shop.cutting.sweeps import LINE, Sweep, basis, frames_of, pieces
from vcmm.shop.cutting.tools import SHAPES, parameters

# centre 0:3, radius 3, axis 4:7, spread 7, radius of the tool 8 (negative: nothing there), 9: by how much a tip may lie below the point that is
# held, 10: 1 where all tools are balls
GROUP_COLUMNS = 11
NO_NODE = -1.0


def tree_of_groups(
    frames: Array, boxes: Array, radius: Array, is_ball: Array, order: Array
) -> tuple[Array, Array]:
    """Return (tree (2 m, GROUP_COLUMNS), leaves (m,)) of g groups, m the next power of two: node k has nodes 2k and 2k + 1, the leaves begin at m.

    frames (g, 3, 3): rows are the axes of each group, the tool's last; boxes (g, 6): of its tips there; radius (g,) mm; is_ball (g,): whole
    ball noses; order (g,): of neighbours. A leaf without a group is 0, its node NO_NODE.
    """
    count = 1 << max(len(order) - 1, 0).bit_length()
    tree, leaves = np.zeros((2 * count, GROUP_COLUMNS)), np.zeros(count, np.int64)
    tree[:, 8] = NO_NODE
    leaves[: len(order)] = order
    nodes = tree[count : count + len(order)]
    ball = is_ball[order].astype(float)
    low, high = boxes[order, :3], boxes[order, 3:]
    nodes[:, :3] = np.einsum("gji,gj->gi", frames[order], 0.5 * (low + high))
    nodes[:, :3] += (ball * radius[order])[:, None] * frames[order, 2]
    nodes[:, 3] = 0.5 * np.linalg.norm(high - low, axis=1)
    nodes[:, 4:7], nodes[:, 8], nodes[:, 9], nodes[:, 10] = (
        frames[order, 2],
        radius[order],
        ball * radius[order],
        ball,
    )
    at = count
    while at > 1:
        at //= 2
        tree[at : 2 * at] = _join(tree[2 * at : 4 * at : 2], tree[2 * at + 1 : 4 * at : 2])
    return tree, leaves


def _join(left: Array, right: Array) -> Array:
    """Return nodes (k, GROUP_COLUMNS) that hold both nodes of each pair; a missing right node leaves the left unchanged."""
    out = left.copy()
    both = right[:, 8] >= 0.0
    a, b = left[both], right[both]
    centre = 0.5 * (a[:, :3] + b[:, :3])
    middle = a[:, 4:7] + b[:, 4:7]
    size = np.linalg.norm(middle, axis=1, keepdims=True)
    axis = np.where(size > 1e-6, middle / np.maximum(size, 1e-6), a[:, 4:7])

    def reach(part: slice, at: Array, column: int) -> Array:
        return np.maximum(*(np.linalg.norm(c[:, part] - at, axis=1) + c[:, column] for c in (a, b)))

    out[both, :3], out[both, 3] = centre, reach(slice(0, 3), centre, 3)
    out[both, 4:7], out[both, 7] = axis, reach(slice(4, 7), axis, 7)
    out[both, 8:10], out[both, 10] = np.maximum(a[:, 8:10], b[:, 8:10]), np.minimum(a[:, 10], b[:, 10])
    return out


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
    """Return the order of the items, root of each tree, boxes and children of the nodes: halved at the median of the widest side."""
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
