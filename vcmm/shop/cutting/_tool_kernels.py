"""Distance to a swept tool, compiled: the implicit function of a tool, and its least value over a move. Private.

Everything is in a frame whose Z is the tool axis. A tool is the convex function G(radius, height) of
vcmm.shop.cutting.tools; a move is a path c(u), u in [0, 1]. A point x was removed when F(x) = min over u of G(x - c(u)) <= 0.
F grows by at most 1 per mm, so marching along a ray by F cannot jump over tool; along straight moves F is convex and
Newton's method from outside cannot either.

Rows of `items`: 0:3 start, 3:6 end, 6:9 centre at the height of the start, 9:12 and 12:15 first and second direction of the
arc, 15 and 16 radius at start and end, 17 turn >= 0, 18:21 advance, 21 kind (0 line, 1 level circular arc, 2 other arc),
22 tool. `tools`: shape, R, r, radius of bottom, cosine, sine of half angle, length.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

Array = NDArray[Any]
FLAT, BALL, BULL, CONE = 0, 1, 2, 3
NONE = 1e300
EDGE = 1e-6  # fraction of an arc next to its ends
# Nothing here makes an array, so nothing needs numba's count of references: without it the search takes half the time.
PLAIN: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}


@njit(**PLAIN)
def implicit(rho: float, h: float, tool: Array) -> tuple[float, float, float]:
    """Return G and its derivatives by radius and height: the twin of vcmm.shop.cutting.tools.implicit."""
    g, by_rho, by_h = rho - tool[1], 1.0, 0.0
    if -h > g:
        g, by_rho, by_h = -h, 0.0, -1.0
    if tool[0] == CONE:
        flank = (rho - tool[3]) * tool[4] - h * tool[5]
        if flank > g:
            g, by_rho, by_h = flank, tool[4], -tool[5]
    elif tool[2] > 0.0:
        over, under = rho - tool[3], tool[2] - h
        if over > 0.0 and under > 0.0:
            d = math.sqrt(over * over + under * under)
            g, by_rho, by_h = d - tool[2], over / d, -under / d
    if h - tool[6] > g:
        g, by_rho, by_h = h - tool[6], 0.0, 1.0
    return g, by_rho, by_h


@njit(**PLAIN)
def at_pose(x: float, y: float, h: float, tool: Array) -> tuple[float, float, float, float]:
    """Return G and its gradient for a point seen from the tip."""
    rho = math.sqrt(x * x + y * y)
    g, by_rho, by_h = implicit(rho, h, tool)
    if rho > 0.0:
        return g, by_rho * x / rho, by_rho * y / rho, by_h
    return g, 0.0, 0.0, by_h


@njit(**PLAIN)
def slope(item: Array, tool: Array, p: Array, u: float, out: Array) -> tuple[float, float]:
    """Return G of point p against the tool at u, and its derivative by u; out: gradient by the point."""
    if item[21] == 0.0:
        vx, vy, vz = item[3] - item[0], item[4] - item[1], item[5] - item[2]
        cx, cy, cz = item[0] + u * vx, item[1] + u * vy, item[2] + u * vz
    else:
        c, s = math.cos(item[17] * u), math.sin(item[17] * u)
        dr = item[16] - item[15]
        r = item[15] + u * dr
        a, b = r * c, r * s
        da, db = dr * c - item[17] * b, dr * s + item[17] * a
        cx = item[6] + a * item[9] + b * item[12] + u * item[18]
        cy = item[7] + a * item[10] + b * item[13] + u * item[19]
        cz = item[8] + a * item[11] + b * item[14] + u * item[20]
        vx = da * item[9] + db * item[12] + item[18]
        vy = da * item[10] + db * item[13] + item[19]
        vz = da * item[11] + db * item[14] + item[20]
    g, gx, gy, gz = at_pose(p[0] - cx, p[1] - cy, p[2] - cz, tool)
    out[0], out[1], out[2] = gx, gy, gz
    return g, -(gx * vx + gy * vy + gz * vz)


@njit(**PLAIN)
def valley(item: Array, tool: Array, p: Array, ul: float, ur: float, out: Array) -> tuple[float, float]:
    """Return the least G and its u between ul, where G falls, and ur, where it rises; out: gradient across the valley.

    At a kink (the rim of a flat mill on a ramp) the gradient is the mixture of both sides that is square to the motion.
    """
    gl, dl = slope(item, tool, p, ul, out)
    lx, ly, lz = out[0], out[1], out[2]
    gr, dr = slope(item, tool, p, ur, out)
    rx, ry, rz = out[0], out[1], out[2]
    for k in range(200):
        if ur - ul <= 1e-15 or dl >= 0.0 or dr <= 0.0:
            break
        u = ul + (ur - ul) * dl / (dl - dr) if k % 3 else 0.5 * (ul + ur)
        if k % 3 == 2:  # step a little over the zero, so that both ends close in
            u += 1e-3 * (ur - ul) if u < 0.5 * (ul + ur) else -1e-3 * (ur - ul)
        if u <= ul or u >= ur:
            u = 0.5 * (ul + ur)
            if u <= ul or u >= ur:
                break
        g, d = slope(item, tool, p, u, out)
        if d == 0.0:
            return g, u
        if d < 0.0:
            ul, gl, dl = u, g, d
            lx, ly, lz = out[0], out[1], out[2]
        else:
            ur, gr, dr = u, g, d
            rx, ry, rz = out[0], out[1], out[2]
    w = dr / (dr - dl) if dr > dl else 0.5
    out[0], out[1], out[2] = w * lx + (1.0 - w) * rx, w * ly + (1.0 - w) * ry, w * lz + (1.0 - w) * rz
    if gl <= gr:
        return gl, ul
    return gr, ur


@njit(**PLAIN)
def nearest(item: Array, tool: Array, p: Array, out: Array) -> tuple[float, float]:
    """Return F(p) and the u of its minimum; out: gradient."""
    if item[21] == 0.0:
        dx, dy, dz = item[3] - item[0], item[4] - item[1], item[5] - item[2]
        if dz == 0.0:  # G grows with the radius: the nearest pose in the plane is the least
            dd = dx * dx + dy * dy
            u = ((p[0] - item[0]) * dx + (p[1] - item[1]) * dy) / dd if dd > 0.0 else 0.0
            u = min(max(u, 0.0), 1.0)
            g, out[0], out[1], out[2] = at_pose(
                p[0] - item[0] - u * dx, p[1] - item[1] - u * dy, p[2] - item[2], tool
            )
            return g, u
        g0, d0 = slope(item, tool, p, 0.0, out)
        if d0 >= 0.0:
            return g0, 0.0
        g1, d1 = slope(item, tool, p, 1.0, out)
        if d1 <= 0.0:
            return g1, 1.0
        return valley(item, tool, p, 0.0, 1.0, out)
    if item[21] == 1.0:
        a = (p[0] - item[6]) * item[9] + (p[1] - item[7]) * item[10]
        b = (p[0] - item[6]) * item[12] + (p[1] - item[7]) * item[13]
        angle = math.atan2(b, a)
        if angle < 0.0:
            angle += 2.0 * math.pi
        if angle <= item[17]:
            u = angle / item[17]
        else:
            u = 1.0 if angle - item[17] < 2.0 * math.pi - angle else 0.0
        g, _ = slope(item, tool, p, u, out)
        return g, u
    return nearest_general(item, tool, p, out)


@njit(**PLAIN)
def nearest_general(item: Array, tool: Array, p: Array, out: Array) -> tuple[float, float]:
    """Return the same for arcs that are not level (at most a quarter turn each): every valley between 19 samples."""
    best, at, n = NONE, 0.0, 16
    gx, gy, gz, before, last = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(-1, n + 2):
        # samples at the ends and just beside them: at an end the derivative may vanish, as at the pole of a sphere
        u = min(max(k / n, EDGE if k > -1 else 0.0), 1.0 - EDGE if k < n + 1 else 1.0)
        g, d = slope(item, tool, p, u, out)
        if g < best:
            best, at = g, u
            gx, gy, gz = out[0], out[1], out[2]
        if k > -1 and before < 0.0 and d > 0.0:
            low, v = valley(item, tool, p, last, u, out)
            if low <= best:
                best, at = low, v
                gx, gy, gz = out[0], out[1], out[2]
        before, last = d, u
    out[0], out[1], out[2] = gx, gy, gz
    return best, at


@njit(**PLAIN)
def inside_at(item: Array, tool: Array, p: Array, n: Array, s: float, out: Array, q: Array) -> float:
    """Return F at p + s n."""
    for i in range(3):
        q[i] = p[i] + s * n[i]
    return nearest(item, tool, q, out)[0]


@njit(**PLAIN)
def at_line(item: Array, tool: Array, p: Array, u: float) -> float:
    """Return G of p against the tool at u of a straight move."""
    x, y = p[0] - item[0] - u * (item[3] - item[0]), p[1] - item[1] - u * (item[4] - item[1])
    return implicit(math.sqrt(x * x + y * y), p[2] - item[2] - u * (item[5] - item[2]), tool)[0]
