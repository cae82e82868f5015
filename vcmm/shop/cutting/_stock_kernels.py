"""Height map of a stock, cut move by move, compiled. Private; used by vcmm.shop.cutting.stock."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit
from vcmm.shop.cutting._envelope_kernels import BALL, CONE, capsule, first_contact

Array = NDArray[Any]
ANGLES = 72  # directions about the tool in which the material is looked at
JUST = 1e-6  # mm, material thinner than this is none


@njit(cache=True, nogil=True)
def level(item: Array) -> bool:
    """Return whether the tip stays at one height: a level line, or a level circular arc."""
    return item[21] == 1.0 or (item[21] == 0.0 and item[2] == item[5])


@njit(cache=True, nogil=True)
def aside(item: Array, x: float, y: float) -> float:
    """Return the smallest distance in plan from (x, y) to the path of a level move."""
    if item[21] == 0.0:
        dx, dy = item[3] - item[0], item[4] - item[1]
        wx, wy = x - item[0], y - item[1]
        dd = dx * dx + dy * dy
        u = min(max((wx * dx + wy * dy) / dd, 0.0), 1.0) if dd > 0.0 else 0.0
        return math.sqrt((wx - u * dx) ** 2 + (wy - u * dy) ** 2)
    wx, wy = x - item[6], y - item[7]
    along, across = wx * item[9] + wy * item[10], wx * item[12] + wy * item[13]
    turn = item[17]
    angle = math.atan2(across, along)
    if angle < 0.0:
        angle += 2.0 * math.pi
    if angle <= turn:
        return abs(math.sqrt(wx * wx + wy * wy) - item[15])
    c, s = math.cos(item[17]), math.sin(item[17])
    ex = item[15] * (c * item[9] + s * item[12])
    ey = item[15] * (c * item[10] + s * item[13])
    first = (along - item[15]) ** 2 + across**2
    return math.sqrt(min(first, (wx - ex) ** 2 + (wy - ey) ** 2))


@njit(cache=True, nogil=True)
def lift(tool: Array, d: float) -> float:
    """Return the height over the tip of the lowest point of the tool at the distance d from its axis; 1e300 outside."""
    if d > tool[1]:
        return 1e300
    if d <= tool[3]:
        return 0.0
    if tool[0] == CONE:
        return (d - tool[3]) * tool[4] / tool[5]
    out = d - tool[3]
    return tool[2] - math.sqrt(max(tool[2] * tool[2] - out * out, 0.0))


@njit(cache=True, nogil=True)
def floor_at(item: Array, tool: Array, low: float, p: Array, up: Array, out: Array, q: Array) -> float:
    """Return the lowest height over (p[0], p[1]) that the tool reaches on this move; 1e300 if it does not come there."""
    if level(item):
        h = lift(tool, aside(item, p[0], p[1]))
        return item[2] + h if h < 1e300 else h
    p[2] = low - 1.0
    if item[21] == 0.0 and tool[0] == BALL:
        is_hit, s, _ = capsule(item, tool[1], p, up, out)
    else:
        is_hit, s, _ = first_contact(item, tool, p, up, 1.0, 0.0, 1e6, out, q)
    return p[2] + s if is_hit else 1e300


@njit(cache=True, nogil=True)
def engagement(height: Array, grid: Array, item: Array, tool: Array, out: Array) -> None:
    """Measure the material on a half circle ahead of the tool before the move, halfway. out: mean depth, first and last angle, share.

    Angles as in vcmm.shop.cutting.force: 0 left of the feed, pi/2 ahead, pi right.
    """
    n0, n1 = height.shape
    cx, cy, cz = 0.5 * (item[0] + item[3]), 0.5 * (item[1] + item[4]), 0.5 * (item[2] + item[5])
    fx, fy = item[3] - item[0], item[4] - item[1]
    if item[21] != 0.0:
        c, s = math.cos(0.5 * item[17]), math.sin(0.5 * item[17])
        r = 0.5 * (item[15] + item[16])
        cx = item[6] + r * (c * item[9] + s * item[12]) + 0.5 * item[18]
        cy = item[7] + r * (c * item[10] + s * item[13]) + 0.5 * item[19]
        cz = item[8] + r * (c * item[11] + s * item[14]) + 0.5 * item[20]
        fx, fy = c * item[12] - s * item[9], c * item[13] - s * item[10]
    f = math.sqrt(fx * fx + fy * fy)
    out[0], out[1], out[2], out[3] = 0.0, 0.0, 0.0, 0.0
    if f == 0.0:
        return
    fx, fy = fx / f, fy / f
    met, depth, first, last = 0, 0.0, -1.0, -1.0
    for k in range(ANGLES):
        phi = (k + 0.5) * math.pi / ANGLES
        x = cx + tool[1] * (math.sin(phi) * fx - math.cos(phi) * fy)
        y = cy + tool[1] * (math.sin(phi) * fy + math.cos(phi) * fx)
        i, j = round((x - grid[0]) / grid[2]), round((y - grid[1]) / grid[2])
        if i < 0 or j < 0 or i >= n0 or j >= n1:
            continue
        over = height[i, j] - cz
        if over > JUST:
            met += 1
            depth += over
            if first < 0.0:
                first = k * math.pi / ANGLES
            last = (k + 1.0) * math.pi / ANGLES
    if met > 0:
        out[0], out[1], out[2], out[3] = depth / met, first, last, met / ANGLES


@njit(cache=True, nogil=True)
def cut_all(
    height: Array,
    grid: Array,
    items: Array,
    boxes: Array,
    tools: Array,
    row: Array,
    rapid: Array,
    bottom: float,
    volume: Array,
    deepest: Array,
    engaged: Array,
) -> None:
    """Cut all pieces in order. grid: x0, y0, cell. Rapids cut nothing: `deepest` then says how deep they ran in material.

    volume, deepest (rows,): material removed and its greatest height; engaged (pieces, 4): see `engagement`.
    """
    n0, n1 = height.shape
    up, p, out, q = np.array([0.0, 0.0, 1.0]), np.empty(3), np.empty(3), np.empty(3)
    x0, y0, cell = grid[0], grid[1], grid[2]
    for k in range(items.shape[0]):
        item, tool = items[k], tools[int(items[k, 22])]
        reach, low = tool[1], boxes[k, 2]
        i0, i1 = (
            max(math.ceil((boxes[k, 0] - reach - x0) / cell), 0),
            min(int((boxes[k, 3] + reach - x0) / cell), n0 - 1),
        )
        j0, j1 = (
            max(math.ceil((boxes[k, 1] - reach - y0) / cell), 0),
            min(int((boxes[k, 4] + reach - y0) / cell), n1 - 1),
        )
        if not rapid[row[k]]:
            engagement(height, grid, item, tool, engaged[k])
        total, most = 0.0, 0.0
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                if height[i, j] <= low:
                    continue
                p[0], p[1] = x0 + i * cell, y0 + j * cell
                z = max(floor_at(item, tool, low, p, up, out, q), bottom)
                if z < height[i, j]:
                    most = max(most, height[i, j] - z)
                    if not rapid[row[k]]:
                        total += height[i, j] - z
                        height[i, j] = z
        volume[row[k]] += total * cell * cell
        deepest[row[k]] = max(deepest[row[k]], most)
