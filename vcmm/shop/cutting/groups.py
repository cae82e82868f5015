"""A tree over the trees of an index: in a program that turns its tool all the time, every motion has its own direction, and so its own tree.

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

import numpy as np

from vcmm.core.laws import Array

# centre 0:3, radius 3, axis 4:7, spread 7, radius of the tool 8 (negative: nothing there), 9: by how much a tip may lie below the point that is
# held, 10: 1 where all tools are balls
COLUMNS = 11
NO_NODE = -1.0


def tree_of_groups(
    frames: Array, boxes: Array, radius: Array, is_ball: Array, order: Array
) -> tuple[Array, Array]:
    """Return (tree (2 m, COLUMNS), leaves (m,)) of g groups, m the next power of two: node k has nodes 2k and 2k + 1, the leaves begin at m.

    frames (g, 3, 3): rows are the axes of each group, the tool's last; boxes (g, 6): of its tips there; radius (g,) mm; is_ball (g,): whole
    ball noses; order (g,): of neighbours. A leaf without a group is 0, its node NO_NODE.
    """
    count = 1 << max(len(order) - 1, 0).bit_length()
    tree, leaves = np.zeros((2 * count, COLUMNS)), np.zeros(count, np.int64)
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
    """Return nodes (k, COLUMNS) that hold both nodes of each pair; a missing right node leaves the left unchanged."""
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
