"""Ray against swept tool, compiled. Private; vcmm.cutting.envelope prepares the arrays, vcmm.cutting.twin checks them.

Everything stands in a frame whose Z is the tool axis. A tool is the convex function G(radius, height) of
vcmm.cutting.tools; a move is a path c(u), u in [0, 1]. A point x was removed when F(x) = min over u of G(x - c(u)) <= 0.
F grows by at most 1 per mm, so marching along a ray by F cannot jump over tool; along straight moves F is convex and
Newton's method from outside cannot either. Kept in one file since numba's cache does not see changes in imported functions.

Rows of `items`: 0:3 start, 3:6 end, 6:9 centre at the height of the start, 9:12 and 12:15 first and second direction of the
arc, 15 and 16 radius at start and end, 17 turn >= 0, 18:21 advance, 21 kind (0 line, 1 level circular arc, 2 other arc),
22 tool. `tools`: shape, R, r, radius of bottom, cosine, sine of half angle, length.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]
FLAT, BALL, BULL, CONE = 0, 1, 2, 3
# Nothing here makes an array, so nothing needs numba's count of references: without it the search takes half the time.
PLAIN: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
MOST_STEPS = 20000
GROWTH, COARSE = (
    1.3,
    1e-3,
)  # a ray that grazes a sweep walks with growing steps, at most so many mm: thinner gaps may be missed there
NONE, ROUND = 1e300, 2e-15
NEWTON, SURE = 12, 1e-13  # steps on ramps; mm within which an entry must be proven to be taken
EDGE = 1e-6  # fraction of an arc next to its ends
SMALL, THIN = (
    1e-5,
    1e-6,
)  # mm: from where Newton is trusted on arcs, and the thinnest stretch surely found on them


@njit(**PLAIN)
def implicit(rho: float, h: float, tool: Array) -> tuple[float, float, float]:
    """G and its derivatives by radius and height: the twin of vcmm.cutting.tools.implicit."""
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
    """G and its gradient for a point seen from the tip."""
    rho = math.sqrt(x * x + y * y)
    g, by_rho, by_h = implicit(rho, h, tool)
    if rho > 0.0:
        return g, by_rho * x / rho, by_rho * y / rho, by_h
    return g, 0.0, 0.0, by_h


@njit(**PLAIN)
def slope(item: Array, tool: Array, p: Array, u: float, out: Array) -> tuple[float, float]:
    """G of point p against the tool at u, and its derivative by u; out: gradient by the point."""
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
    """Least G and its u between ul, where G falls, and ur, where it rises; out: gradient across the valley.

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
    """F(p) and the u of its minimum; out: gradient."""
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
    """The same for arcs that are not level (at most a quarter turn each): every valley between 19 samples."""
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
def first_contact(
    item: Array, tool: Array, p: Array, n: Array, sign: float, s0: float, s1: float, out: Array, q: Array
) -> tuple[bool, float, float]:
    """First s in [s0, s1], walking along sign * n from s0 outside, where F = 0; out: gradient there. (found, s, u)."""
    convex = item[21] == 0.0
    s, bracket, u, good, kept, pace = s0, NONE, 0.0, s0, 0.0, 0.0
    scale = ROUND * (abs(p[0]) + abs(p[1]) + abs(p[2]) + abs(item[0]) + abs(item[1]) + abs(item[2]) + 1.0)
    thin = THIN
    for k in range(MOST_STEPS):
        for i in range(3):
            q[i] = p[i] + sign * s * n[i]
        f, u = nearest(item, tool, q, out)
        rate = sign * (out[0] * n[0] + out[1] * n[1] + out[2] * n[2])
        if f <= scale:
            if f >= -scale or convex or s == s0:
                return True, s, u
            bracket = min(bracket, s)
            s = good
            f, rate = kept, 0.0 if k > 40 else pace
        good, kept, pace = s, f, rate
        if convex:
            if rate >= 0.0:
                return False, s, u
            s -= f / rate
        elif bracket < NONE:
            if bracket - good <= 1e-15 * (1.0 + abs(good)):
                return True, bracket, u
            step = f / -rate if rate < 0.0 else NONE
            s = good + step if good + step < bracket else 0.5 * (good + bracket)
        else:
            thin = min(thin * GROWTH, COARSE) if f < thin else THIN
            s += 1.0001 * f / -rate if rate < -0.3 and f < SMALL else max(f, thin)
        if s > s1 and bracket == NONE:
            if convex or good >= s1:
                return False, s, u
            s = s1  # a longer step than F proves nothing beyond the end
        if s == good:
            return True, s, u
    return bracket < NONE, bracket, u


@njit(**PLAIN)
def capsule(item: Array, radius: float, p: Array, n: Array, out: Array) -> tuple[bool, float, float]:
    """First contact of the whole ray with a ball swept along a line, in closed form: (found, s, u); out: unit normal."""
    wx, wy, wz = p[0] - item[0], p[1] - item[1], p[2] - item[2] - radius
    dx, dy, dz = item[3] - item[0], item[4] - item[1], item[5] - item[2]
    dd = dx * dx + dy * dy + dz * dz
    wn = wx * n[0] + wy * n[1] + wz * n[2]
    u = 0.0
    if dd > 0.0:
        nd = n[0] * dx + n[1] * dy + n[2] * dz
        wd = wx * dx + wy * dy + wz * dz
        # the parts of n and w square to the line, without the cancellation of products
        k, j = nd / dd, wd / dd
        nx, ny, nz = n[0] - k * dx, n[1] - k * dy, n[2] - k * dz
        mx, my, mz = wx - j * dx, wy - j * dy, wz - j * dz
        a = nx * nx + ny * ny + nz * nz
        if a > 1e-20:
            b = nx * mx + ny * my + nz * mz
            ex, ey, ez = mx - b / a * nx, my - b / a * ny, mz - b / a * nz
            rest = radius * radius - ex * ex - ey * ey - ez * ez
            if rest < 0.0:
                return False, 0.0, 0.0
            s = -b / a - math.sqrt(rest / a)
            u = j + s * k
            if 0.0 <= u <= 1.0:
                out[0], out[1], out[2] = (
                    (mx + s * nx) / radius,
                    (my + s * ny) / radius,
                    (mz + s * nz) / radius,
                )
                return True, s, u
            u = 0.0 if u < 0.0 else 1.0
        else:
            u = 0.0 if nd > 0.0 else 1.0
    wx, wy, wz = wx - u * dx, wy - u * dy, wz - u * dz
    wn = wx * n[0] + wy * n[1] + wz * n[2]
    ex, ey, ez = wx - wn * n[0], wy - wn * n[1], wz - wn * n[2]
    rest = radius * radius - ex * ex - ey * ey - ez * ez
    if rest < 0.0:
        return False, 0.0, 0.0
    s = -wn - math.sqrt(rest)
    out[0], out[1], out[2] = (wx + s * n[0]) / radius, (wy + s * n[1]) / radius, (wz + s * n[2]) / radius
    return True, s, u


@njit(**PLAIN)
def inside_at(item: Array, tool: Array, p: Array, n: Array, s: float, out: Array, q: Array) -> float:
    """F at p + s n."""
    for i in range(3):
        q[i] = p[i] + s * n[i]
    return nearest(item, tool, q, out)[0]


@njit(**PLAIN)
def at_line(item: Array, tool: Array, p: Array, u: float) -> float:
    """G of p against the tool at u of a straight move."""
    x, y = p[0] - item[0] - u * (item[3] - item[0]), p[1] - item[1] - u * (item[4] - item[1])
    return implicit(math.sqrt(x * x + y * y), p[2] - item[2] - u * (item[5] - item[2]), tool)[0]


@njit(**PLAIN)
def lower_end(
    item: Array, tool: Array, p: Array, n: Array, s: float, depth: float, out: Array, q: Array
) -> tuple[float, float]:
    """Lower end (s, u) of the removed stretch of the ray around s, for any path; -depth if it reaches that far."""
    top, thin = s, 1e-7
    while s > -depth:
        f = inside_at(item, tool, p, n, s, out, q)
        if f > 0.0:
            _, a, u = first_contact(item, tool, p, n, 1.0, s, top, out, q)
            return a, u
        thin = min(thin * GROWTH, COARSE) if -f < thin else 1e-7
        s -= max(-f, thin)
    for i in range(3):
        q[i] = p[i] - depth * n[i]
    f, u = nearest(item, tool, q, out)
    if f > 0.0:
        _, a, u = first_contact(item, tool, p, n, 1.0, -depth, top, out, q)
        return a, u
    return -depth, u


@njit(**PLAIN)
def steep(
    item: Array, tool: Array, p: Array, n: Array, s: float, cut: float, out: Array
) -> tuple[int, float, float]:
    """Entry of a ray into a tool swept along a line, from s outside, by Newton's method for s and u at once.

    H(s, u) = G(p + s n - c(u)) is convex in both, so each tangent plane lies below it: the plane says how low the entry can
    be at best, and where that agrees with the place found, the place is proven. Every step stays on the plane and thus
    outside. Returns (0: no entry up to cut, 1: entry found, 2: not decided), s, u; out: gradient.
    """
    vx, vy, vz = item[3] - item[0], item[4] - item[1], item[5] - item[2]
    scale = ROUND * (abs(p[0]) + abs(p[1]) + abs(p[2]) + abs(item[0]) + abs(item[1]) + abs(item[2]) + 1.0)
    u = 0.5
    for k in range(NEWTON):
        x, y = p[0] + s * n[0] - item[0] - u * vx, p[1] + s * n[1] - item[1] - u * vy
        h = p[2] + s * n[2] - item[2] - u * vz
        rho = math.sqrt(x * x + y * y)
        if rho == 0.0:
            return 2, s, u
        g, by_rho, by_h = implicit(rho, h, tool)
        ex, ey = x / rho, y / rho
        nr, vr = ex * n[0] + ey * n[1], ex * vx + ey * vy
        hs, hu = by_rho * nr + by_h * n[2], -by_rho * vr - by_h * vz
        if hs >= 0.0:
            return 2, s, u
        fall = hu * u if hu > 0.0 else -hu * (1.0 - u)  # most that H can still lose by u
        if g - fall - SURE > (s - cut) * hs:
            return 0, s, u
        if g <= scale and fall <= -hs * SURE:
            out[0], out[1], out[2] = by_rho * ex, by_rho * ey, by_h
            return (1 if g >= -scale else 2), s, u
        # second derivatives: round the axis, and round the corner
        nt, vt = ex * n[1] - ey * n[0], ex * vy - ey * vx
        huu, hus = by_rho * vt * vt / rho, -by_rho * nt * vt / rho
        if by_rho > 0.0 and by_h < 0.0 and tool[0] != CONE:
            ns, vs = n[2] * by_rho - nr * by_h, vz * by_rho - vr * by_h
            huu += vs * vs / (g + tool[2])
            hus -= ns * vs / (g + tool[2])
        det = hs * huu - hu * hus
        du = NONE if hu < 0.0 else -NONE
        if det < 0.0 and huu > 0.0:
            du = hs * (g * hus / hs - hu) / det
        elif hu == 0.0:
            du = 0.0
        after = u + du
        if after < 0.0:
            after = 0.0
        elif after > 1.0:
            after = 1.0
        s -= (g + hu * (after - u)) / hs
        u = after
    return 2, s, u


@njit(**PLAIN)
def straight(
    item: Array,
    tool: Array,
    p: Array,
    n: Array,
    depth: float,
    cut: float,
    grad: Array,
    other: Array,
    out: Array,
    q: Array,
) -> int:
    """Removed stretch of one straight move. 0 nothing, 1 main: out 0 and 2 hold lower end and u, grad the gradient.

    2: the whole stretch lies below nominal, out 3:6 hold lower end, upper end and u, other the gradient.
    """
    found = False
    if tool[0] == BALL:
        found, a, u = capsule(item, tool[1], p, n, grad)
        found = found and grad[2] <= 0.0 and tool[6] >= 2.0 * tool[1]
        if found and a > cut:
            return 0
    if not found:
        if item[2] != item[5]:
            answer, a, u = steep(item, tool, p, n, -depth, cut, grad)
            if answer == 0:
                return 0
            found = answer == 1 and a >= -depth  # an entry further down is none of this search
    if not found:
        found, a, u = first_contact(item, tool, p, n, 1.0, -depth, cut, grad, q)
        if not found:
            return 0
    out[0], out[1], out[2] = a, 0.0, u
    if a >= 0.0:
        return 1
    if at_line(item, tool, p, u) <= 1e-12:
        return 1
    if inside_at(item, tool, p, n, 0.0, other, q) <= 1e-12:
        return 1
    found, b, _ = first_contact(item, tool, p, n, -1.0, 0.0, 2.0 * depth, other, q)
    out[3], out[4], out[5] = a, -b, u
    for i in range(3):
        other[i] = grad[i]
    return 2 if found else 0


@njit(**PLAIN)
def beside(item: Array, tool: Array, p: Array, n: Array) -> bool:
    """Whether a ray along the tool axis passes outside of all that the tool sweeps on an arc, seen in plan."""
    if n[0] * n[0] + n[1] * n[1] > 1e-24:
        return False
    x, y = p[0] - item[6], p[1] - item[7]
    rho = math.sqrt(x * x + y * y)
    low, high = min(item[15], item[16]), max(item[15], item[16])
    return rho > high + tool[1] + 1e-9 or rho < low - tool[1] - 1e-9


@njit(**PLAIN)
def curved(
    item: Array,
    tool: Array,
    p: Array,
    n: Array,
    depth: float,
    cut: float,
    grad: Array,
    other: Array,
    out: Array,
    q: Array,
) -> int:
    """The same for an arc; 3: one stretch below nominal (in out 3:6, gradient of it in other) and one above it."""
    if beside(item, tool, p, n):
        return 0
    f = inside_at(item, tool, p, n, 0.0, grad, q)
    if f <= 1e-12:
        out[0], out[2] = lower_end(item, tool, p, n, 0.0, depth, grad, q)
        return 1
    result = 0
    if cut > 0.0:
        found, a, u = first_contact(item, tool, p, n, 1.0, 0.0, cut, grad, q)
        if found:
            out[0], out[1], out[2] = a, 0.0, u
            result = 1
    found, b, u = first_contact(item, tool, p, n, -1.0, 0.0, depth, other, q)
    if found:
        out[3], out[5] = lower_end(item, tool, p, n, -b - 1e-9, depth, other, q)
        out[4] = -b
        result += 2
    return result
