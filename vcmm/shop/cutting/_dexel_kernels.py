"""Material left on long rays through a block, compiled. Private; used by vcmm.shop.cutting.dexels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit
from vcmm.shop.cutting._envelope_kernels import first_contact
from vcmm.shop.cutting._group_kernels import may_meet, nearer_child
from vcmm.shop.cutting._query_kernels import turn
from vcmm.shop.cutting._tool_kernels import inside_at

Array = NDArray[Any]
STEP = 1e-6  # mm, least step while a ray leaves the sweep of an arc
JOIN = 1e-9  # mm, material thinner than this is none
OFTEN, KEPT = 4, 4096  # new stretches after which they are merged, and room for those that are


@njit(cache=True, nogil=True)
def may_remove(
    box: Array, tool: Array, p: Array, n: Array, length: float, gone: Array, stretches: int
) -> bool:
    """Return whether a tool on the paths in the box may remove anything of the ray that is not removed yet. Slabs of the box grown by the tool."""
    lo, hi = 0.0, length
    for i in range(3):
        low = box[i] - tool[1] if i < 2 else box[2]
        high = box[3 + i] + tool[1] if i < 2 else box[5] + tool[6]
        if n[i] == 0.0:
            if p[i] < low or p[i] > high:
                return False
            continue
        a, b = (low - p[i]) / n[i], (high - p[i]) / n[i]
        lo, hi = max(lo, min(a, b)), min(hi, max(a, b))
    if lo > hi:
        return False
    for k in range(stretches):
        if gone[k, 0] > lo:
            return True
        if gone[k, 1] >= hi:
            return False
    return True


@njit(cache=True, nogil=True)
def merge_stretches(cuts: Array, count: int, spare: Array) -> int:
    """Merge stretches (count, 2) into their union, in order, in place; return their number. spare: room as large as cuts."""
    order = np.argsort(cuts[:count, 0])
    k = -1
    for j in range(count):
        a, b = cuts[order[j], 0], cuts[order[j], 1]
        if k >= 0 and a <= spare[k, 1] + JOIN:
            spare[k, 1] = max(spare[k, 1], b)
        else:
            k += 1
            spare[k, 0], spare[k, 1] = a, b
    for j in range(k + 1):
        cuts[j, 0], cuts[j, 1] = spare[j, 0], spare[j, 1]
    return k + 1


@njit(cache=True, nogil=True)
def left_between(cuts: Array, count: int, length: float) -> tuple[float, float]:
    """Return the lowest and highest place of [0, length] that may hold material, of merged stretches (count, 2)."""
    low, high = 0.0, length
    if count and cuts[0, 0] <= 0.0:
        low = cuts[0, 1]
    if count and cuts[count - 1, 1] >= length:
        high = cuts[count - 1, 0]
    return min(low, high), high


@njit(cache=True, nogil=True)
def removed_stretches(
    item: Array, tool: Array, p: Array, n: Array, length: float, cuts: Array, count: int, scratch: Array
) -> int:
    """Append the stretches of [0, length] that one move removes; return the new number, beyond the room if it ran over."""
    grad, q = scratch[0], scratch[1]
    s = 0.0
    while s < length:
        is_hit, a, _ = first_contact(item, tool, p, n, 1.0, s, length, grad, q)
        if not is_hit:
            return count
        if item[21] == 0.0:
            is_hit, b, _ = first_contact(item, tool, p, n, -1.0, -length, -a, grad, q)
            b = -b if is_hit else a
        else:
            inner, b = a, a + STEP
            while b < length:
                f = inside_at(item, tool, p, n, b, grad, q)
                if f > 0.0:
                    break
                inner = b
                b += max(-f, STEP)
            if b < length:
                is_hit, c, _ = first_contact(item, tool, p, n, -1.0, -b, -inner, grad, q)
                b = -c if is_hit else b
            b = min(b, length)
        if count < cuts.shape[0]:
            cuts[count, 0], cuts[count, 1] = a, b
        count += 1
        if item[21] == 0.0:
            return count
        s = b + STEP
    return count


@njit(cache=True, nogil=True)
def complement(cuts: Array, count: int, length: float, out: Array) -> int:
    """Find the material (k, 2) left on [0, length]; return k, which may exceed the room in out."""
    order = np.argsort(cuts[:count, 0])
    at, k = 0.0, 0
    for j in range(count):
        a, b = cuts[order[j], 0], cuts[order[j], 1]
        if a > at + JOIN:
            if k < out.shape[0]:
                out[k, 0], out[k, 1] = at, a
            k += 1
        at = max(at, b)
    if at < length - JOIN:
        if k < out.shape[0]:
            out[k, 0], out[k, 1] = at, length
        k += 1
    return k


@njit(cache=True, nogil=True)
def material(
    origins: Array,
    direction: Array,
    length: float,
    frames: Array,
    roots: Array,
    group_tool: Array,
    boxes: Array,
    child: Array,
    items: Array,
    tools: Array,
    tree: Array,
    leaves: Array,
    counts: Array,
    out: Array,
) -> int:
    """Collect material on rays (n, 3) of one direction into counts (n,) and out (n, M, 2); returns the most stretches kept of a ray.

    Removed stretches are merged as they grow, and moves that lie wholly in them are skipped. Nodes of the tree of groups that are nearer to
    the ray come first: they cut deepest, and leave least to look for.
    """
    stack, wait, scratch, most = np.empty(128, np.int64), np.empty(128, np.int64), np.empty((2, 3)), 0
    cuts, spare = np.empty((KEPT, 2)), np.empty((KEPT, 2))
    p, n = np.empty(3), np.empty(3)
    for row in range(origins.shape[0]):
        count, merged, low, high = 0, 0, 0.0, length
        wait[0], waiting = 1, 1
        while waiting > 0:
            waiting -= 1
            at = wait[waiting]
            if tree[at, 8] < 0.0 or not may_meet(tree[at], origins[row], direction, low, high):
                continue
            if at < leaves.shape[0]:
                nearer = nearer_child(tree, at, origins[row], direction, low, high)
                wait[waiting], wait[waiting + 1] = 4 * at + 1 - nearer, nearer
                waiting += 2
                continue
            group = leaves[at - leaves.shape[0]]
            turn(frames, group, origins[row], direction, p, n)
            tool = tools[group_tool[group]]
            stack[0], top = roots[group], 1
            while top > 0:
                top -= 1
                node = stack[top]
                if not may_remove(boxes[node], tool, p, n, length, cuts, merged):
                    continue
                if child[node, 0] < 0:
                    first = -child[node, 0] - 1
                    for i in range(first, first + child[node, 1]):
                        count = removed_stretches(items[i], tool, p, n, length, cuts, count, scratch)
                    if count - merged >= OFTEN:
                        count = merged = merge_stretches(cuts, min(count, KEPT), spare)
                        low, high = left_between(cuts, count, length)
                else:
                    stack[top], stack[top + 1] = child[node, 0], child[node, 1]
                    top += 2
        most = max(most, count)
        counts[row] = complement(cuts, min(count, KEPT), length, out[row])
    return most
