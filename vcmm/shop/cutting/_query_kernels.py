"""Search of all moves for each inspection point, compiled: tree of boxes, K lowest contacts, connected stretches.

Private; used by vcmm.shop.cutting.envelope.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit
from vcmm.shop.cutting._envelope_kernels import arc_stretches, straight
from vcmm.shop.cutting._group_kernels import groups_met
from vcmm.shop.cutting._tool_kernels import NONE, PLAIN, implicit

Array = NDArray[Any]
BELOW = 64  # stretches below nominal that are kept for the question whether they connect
FIRST_WINDOW_MM = 0.05  # mm, half width of the window that is tried first
TOUCH = 1e-9  # mm, gap that still counts as connected
SLACK = 1e-12  # mm, for the rounding of bounds


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def least_entry(
    boxes: Array, node: int, tool: Array, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> float:
    """Return a lower bound of the way from a point along n to the first entry into any tool with its tip in a box; NONE: no entry.

    The tool swept through the whole box, and on upwards, is convex: its implicit function along the ray lies above its
    tangent at the point, so the ray cannot enter before the tangent does.
    """
    ex, ey = (
        x - boxes[node, 0],
        y - boxes[node, 1],
    )  # from the nearest place in the box; min() and max() are slow here
    if ex > 0.0:
        ex = x - boxes[node, 3]
        if ex < 0.0:
            ex = 0.0
    if ey > 0.0:
        ey = y - boxes[node, 4]
        if ey < 0.0:
            ey = 0.0
    rho = math.sqrt(ex * ex + ey * ey)
    g, by_rho, by_h = implicit(rho, z - boxes[node, 2], tool)
    if g <= SLACK:
        return 0.0
    rate = by_h * nz
    if rho > 0.0:
        rate += by_rho * (ex * nx + ey * ny) / rho
    return (g - SLACK) / -rate if rate < 0.0 else NONE


@njit(**PLAIN)
def reach(s: Array, height: float, band: float) -> float:
    """Return the height above which no contact counts any more."""
    cut, last = s[0] + band, s[s.shape[0] - 1]
    if last < cut:
        cut = last
    return height if height < cut else cut


@njit(**PLAIN)
def insert(a: float, item: int, u: float, g: Array, s: Array, which: Array, t: Array, normal: Array) -> None:
    """Put a contact into the sorted list of the K lowest."""
    k = s.shape[0] - 1
    if a >= s[k]:
        return
    while k > 0 and s[k - 1] > a:
        s[k], which[k], t[k] = s[k - 1], which[k - 1], t[k - 1]
        for i in range(3):
            normal[k, i] = normal[k - 1, i]
        k -= 1
    s[k], which[k], t[k] = a, item, u
    length = np.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
    for i in range(3):
        normal[k, i] = g[i] / length if length > 0.0 else np.nan


@njit(**PLAIN)
def is_listed(i: int, which: Array) -> bool:
    """Return whether a move is among the contacts already."""
    for k in range(which.shape[0]):  # noqa: SIM110 - numba compiles no any()
        if which[k] == i:
            return True
    return False


@njit(**PLAIN)
def test_item(
    i: int, items: Array, tool: Array, p: Array, n: Array, depth: float, cut: float,
    s: Array, which: Array, t: Array, normal: Array, below: Array, count: int,
    item: Array, grad: Array, other: Array, out: Array, q: Array,
) -> int:  # fmt: skip
    """Test one move against one ray; return the number of stretches found below so far.

    Arrays come one by one and the move is copied into `item`: views and tuples of arrays cost more here than the geometry,
    since each counts its references.
    """
    if items[i, 21] == 0.0:
        if is_listed(i, which):
            return count
        for j in range(6):
            item[j] = items[i, j]
        item[21] = 0.0
        kind = straight(item, tool, p, n, depth, cut, grad, other, out, q)
    else:
        for j in range(item.shape[0]):
            item[j] = items[i, j]
        kind = arc_stretches(item, tool, p, n, depth, cut, grad, other, out, q)
    if kind & 1 and out[0] <= cut and not is_listed(i, which):
        insert(out[0], i, out[2], grad, s, which, t, normal)
    if kind & 2:
        if count < BELOW:
            below[count, 0], below[count, 1], below[count, 2], below[count, 3] = out[3], out[4], i, out[5]
            below[count, 4], below[count, 5], below[count, 6] = other[0], other[1], other[2]
        count += 1
    return count


@njit(cache=True, nogil=True)
def connect(lists: tuple, below: Array, count: int) -> None:
    """Connect the stretches that overlap, from nominal, which lies in a removed stretch, downwards."""
    s, which, t, normal = lists
    low, again = s[0], True
    while again:
        again = False
        for j in range(count):
            if below[j, 1] >= low - TOUCH and below[j, 2] >= 0.0:
                insert(below[j, 0], int(below[j, 2]), below[j, 3], below[j, 4:7], s, which, t, normal)
                low, again = min(low, below[j, 0]), True
                below[j, 2] = -1.0


@njit(cache=True, nogil=True)
def begin_with(
    point: Array,
    normal: Array,
    first: Array,
    trees: tuple,
    depth: float,
    height: float,
    band: float,
    lists: tuple,
    work: tuple,
) -> None:
    """Begin with the moves that cut the point before: usually its neighbour, so that little remains to be searched."""
    frames, _, group_tool, _, _, items, tools, _, groups = trees
    s, which, t, normals = lists
    _, _, below, p, n, item, grad, other, out, q = work
    for k in range(first.shape[0]):
        if first[k] < 0 or is_listed(first[k], which):
            continue
        group = groups[first[k]]
        turn(frames, group, point, normal, p, n)
        cut, tool = reach(s, height, band), tools[group_tool[group]]
        test_item(
            first[k],
            items,
            tool,
            p,
            n,
            depth,
            cut,
            s,
            which,
            t,
            normals,
            below,
            BELOW,
            item,
            grad,
            other,
            out,
            q,
        )


@njit(**PLAIN)
def turn(frames: Array, group: int, point: Array, normal: Array, p: Array, n: Array) -> None:
    """Turn the ray into the frame of a tree."""
    for i in range(3):
        p[i] = (
            frames[group, i, 0] * point[0] + frames[group, i, 1] * point[1] + frames[group, i, 2] * point[2]
        )
        n[i] = (
            frames[group, i, 0] * normal[0]
            + frames[group, i, 1] * normal[1]
            + frames[group, i, 2] * normal[2]
        )


@njit(**PLAIN)
def search_ray(
    point: Array, normal: Array, trees: tuple, some: Array, depth: float, height: float, band: float, lists: tuple,
    work: tuple,
) -> tuple[int, int]:  # fmt: skip
    """Search the moves of the trees `some` that may meet one ray between -depth and height; return counts of stretches and exact tests.

    Nodes are taken in the order of the least entry that they allow, and left out when it lies above the contacts known.
    """
    frames, roots, group_tool, boxes, child, items, tools, shells, _ = trees
    s, which, t, normals = lists
    stack, least, below, p, n, item, grad, other, out, q = work
    count, tests = 0, 0
    for j in range(some.shape[0]):
        group = some[j]
        turn(frames, group, point, normal, p, n)
        tool, shell = tools[group_tool[group]], shells[group_tool[group]]
        x, y, z = p[0] - depth * n[0], p[1] - depth * n[1], p[2] - depth * n[2]
        stack[0], least[0], top = roots[group], -depth, 1
        while top > 0:
            top -= 1
            node, cut = stack[top], reach(s, height, band)
            if least[top] > cut or (n[2] > 0.0 and boxes[node, 2] - p[2] >= (s[-1] - 1e-12) * n[2]):
                continue  # the lowest tip is no lower than the contacts known
            left, right = child[node, 0], child[node, 1]
            if left < 0:
                for i in range(-left - 1, right - left - 1):
                    cut = reach(s, height, band)
                    count = test_item(
                        i,
                        items,
                        tool,
                        p,
                        n,
                        depth,
                        cut,
                        s,
                        which,
                        t,
                        normals,
                        below,
                        count,
                        item,
                        grad,
                        other,
                        out,
                        q,
                    )
                tests += right
                continue
            a = least_entry(boxes, left, shell, x, y, z, n[0], n[1], n[2]) - depth
            b = least_entry(boxes, right, shell, x, y, z, n[0], n[1], n[2]) - depth
            if a < b:
                left, right, a, b = right, left, b, a
            if a <= cut:
                stack[top], least[top] = left, a
                top += 1
            if b <= cut:
                stack[top], least[top] = right, b
                top += 1
    return count, tests


@njit(cache=True, nogil=True)
def search(
    points: Array, normals: Array, frames: Array, roots: Array, group_tool: Array, boxes: Array,
    child: Array, items: Array, tools: Array, groups: Array, tree: Array, leaves: Array, limits: Array, s: Array, which: Array, t: Array,
    contact: Array, tests: Array,
) -> int:  # fmt: skip
    """Fill s, which, t (n, K) and contact (n, K, 3) for rays (n, 3); returns how many lists of stretches ran over.

    frames (G, 3, 3): rows are the axes of the frame of each tree; child (nodes, 2): two nodes, or -first - 1 and count.
    limits: depth, height, band. tests (n,): exact tests made. A narrow window about nominal is tried first: where the
    surface and the band above it lie inside, a wider window cannot change the answer.
    """
    depth, height, band = limits[0], limits[1], limits[2]
    over = 0
    work = (
        np.empty(128, np.int64),
        np.empty(128),
        np.empty((BELOW, 7)),
        np.empty(3),
        np.empty(3),
        np.empty(items.shape[1]),
        np.empty(3),
        np.empty(3),
        np.empty(6),
        np.empty(3),
    )
    shells = tools.copy()
    shells[:, 6] = NONE
    trees = (frames, roots, group_tool, boxes, child, items, tools, shells, groups)
    first, met, stack = np.full(s.shape[1], -1), np.empty(roots.shape[0], np.int64), np.empty(128, np.int64)
    for row in range(points.shape[0]):
        lists = (s[row], which[row], t[row], contact[row])
        for stage in range(2):
            near, far = min(depth, FIRST_WINDOW_MM), min(height, band + FIRST_WINDOW_MM)
            if stage == 1:
                near, far = depth, height
            begin_with(points[row], normals[row], first, trees, near, far, band, lists, work)
            # a move may count as passing below down to twice the depth (`straight`)
            many = groups_met(tree, leaves, points[row], normals[row], -2.0 * near, far, stack, met)
            met[
                :many
            ].sort()  # in the order of the trees, whichever way they were found: where contacts tie, the first stays
            some = met[:many]
            count, done = search_ray(points[row], normals[row], trees, some, near, far, band, lists, work)
            tests[row] += done
            if s[row, 0] <= 0.0 and count > 0:
                connect(lists, work[2], min(count, BELOW))
            if stage == 1:
                over += 1 if count > BELOW else 0
            elif -near < s[row, 0] <= far - band and count <= BELOW:
                break
            else:
                s[row, :], which[row, :] = np.inf, -1
        first[:] = which[row]
    return over
