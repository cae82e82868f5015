"""Select the trees of an index that a ray may meet, compiled. Private; vcmm.shop.cutting.index makes the tree of them and says why this is safe."""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit
from vcmm.shop.cutting._tool_kernels import PLAIN

Array = NDArray[Any]
MARGIN = 1e-6  # mm, far above the rounding of all lengths here


@njit(**PLAIN)
def may_meet(ball: Array, p: Array, n: Array, low: float, high: float) -> bool:
    """Return whether a tool of the node may touch the ray p + s n, low <= s <= high. ball: a row of the tree."""
    vx, vy, vz = p[0] - ball[0], p[1] - ball[1], p[2] - ball[2]
    va = vx * ball[4] + vy * ball[5] + vz * ball[6]
    na = n[0] * ball[4] + n[1] * ball[5] + n[2] * ball[6]
    wx, wy, wz = vx - va * ball[4], vy - va * ball[5], vz - va * ball[6]
    mx, my, mz = n[0] - na * ball[4], n[1] - na * ball[5], n[2] - na * ball[6]
    vv = vx * vx + vy * vy + vz * vz
    vn = vx * n[0] + vy * n[1] + vz * n[2]
    far = math.sqrt(max(vv + 2.0 * low * vn + low * low, vv + 2.0 * high * vn + high * high, 0.0))
    loose = far * ball[7] + ball[3] + MARGIN
    beside, mm = loose + ball[8], mx * mx + my * my + mz * mz
    below = -loose - ball[9]  # no tool of the node reaches down further
    if ball[10] > 0.0:
        below = -loose
    first, last = part_above(va - below, na, low, high)
    if first <= last:
        s = first
        if mm > 0.0:
            s = min(max(-(wx * mx + wy * my + wz * mz) / mm, first), last)
        x, y, z = wx + s * mx, wy + s * my, wz + s * mz
        if x * x + y * y + z * z <= beside * beside:
            return True
    if ball[10] == 0.0:
        return False
    first, last = part_above(loose - va, -na, low, high)
    if first > last:
        return False
    s = min(max(-vn, first), last)  # n is a unit vector
    near = ball[3] + ball[8] + MARGIN
    return vv + s * (2.0 * vn + s) <= near * near


@njit(**PLAIN)
def part_above(height: float, rate: float, low: float, high: float) -> tuple[float, float]:
    """Return the part of low <= s <= high in which height + rate s >= 0; first > last where there is none."""
    if rate > 0.0:
        return max(low, -height / rate), high
    if rate < 0.0:
        return low, min(high, -height / rate)
    return (low, high) if height >= 0.0 else (1.0, 0.0)


@njit(**PLAIN)
def nearer_child(tree: Array, node: int, p: Array, n: Array, low: float, high: float) -> int:
    """Return the child of the two whose tips are nearer to the ray between low and high."""
    least, best = 1e300, 2 * node
    for k in range(2 * node, 2 * node + 2):
        if tree[k, 8] < 0.0:
            continue
        x, y, z = tree[k, 0] - p[0], tree[k, 1] - p[1], tree[k, 2] - p[2]
        s = min(max(x * n[0] + y * n[1] + z * n[2], low), high)
        x, y, z = x - s * n[0], y - s * n[1], z - s * n[2]
        gap = math.sqrt(x * x + y * y + z * z) - tree[k, 3]
        if gap < least:
            least, best = gap, k
    return best


@njit(**PLAIN)
def groups_met(
    tree: Array, leaves: Array, p: Array, n: Array, low: float, high: float, stack: Array, out: Array
) -> int:
    """Write the groups that the ray may meet between low and high into out, unordered; returns how many."""
    first, many, top = leaves.shape[0], 0, 1
    stack[0] = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if tree[node, 8] < 0.0 or not may_meet(tree[node], p, n, low, high):
            continue
        if node >= first:
            out[many] = leaves[node - first]
            many += 1
        else:
            stack[top], stack[top + 1] = 2 * node, 2 * node + 1
            top += 2
    return many
