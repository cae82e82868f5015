"""Ray against swept tool, compiled. Private; vcmm.shop.cutting.envelope prepares the arrays, tests/shop/cutting/numpy_twin.py checks them.

Uses the distance to a swept tool of vcmm/shop/cutting/_tool_kernels.py, where frames and columns are explained.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit
from vcmm.shop.cutting._tool_kernels import BALL, CONE, NONE, PLAIN, at_line, implicit, inside_at, nearest

Array = NDArray[Any]
MOST_STEPS = 20000
# a ray that grazes a sweep walks with growing steps, at most so many mm: thinner gaps may be missed there
GROWTH, COARSE = 1.3, 1e-3
ROUND = 2e-15
NEWTON, SURE = 12, 1e-13  # steps on ramps; mm within which an entry must be proven to be taken
# mm: from where Newton is trusted on arcs, and the thinnest stretch surely found on them
SMALL_EXCESS, THIN = 1e-5, 1e-6


@njit(**PLAIN)
def first_contact(
    item: Array, tool: Array, p: Array, n: Array, sign: float, s0: float, s1: float, out: Array, q: Array
) -> tuple[bool, float, float]:
    """Return the first s in [s0, s1], walking along sign * n from s0 outside, where F = 0; out: gradient there. (found, s, u)."""
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
            s += 1.0001 * f / -rate if rate < -0.3 and f < SMALL_EXCESS else max(f, thin)
        if s > s1 and bracket == NONE:
            if convex or good >= s1:
                return False, s, u
            s = s1  # a longer step than F proves nothing beyond the end
        if s == good:
            return True, s, u
    return bracket < NONE, bracket, u


@njit(**PLAIN)
def capsule(item: Array, radius: float, p: Array, n: Array, out: Array) -> tuple[bool, float, float]:
    """Return the first contact of the whole ray with a ball swept along a line, in closed form: (found, s, u); out: unit normal."""
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
def lower_end(
    item: Array, tool: Array, p: Array, n: Array, s: float, depth: float, out: Array, q: Array
) -> tuple[float, float]:
    """Return the lower end (s, u) of the removed stretch of the ray around s, for any path; -depth if it reaches that far."""
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
    """Find the entry of a ray into a tool swept along a line, from s outside, by Newton's method for s and u at once.

    H(s, u) = G(p + s n - c(u)) is convex in both, so each tangent plane lies below it: the plane says how low the entry can
    be at best, and where that agrees with the place found, the place is proven. Every step stays on the plane and thus
    outside. Returns (0: no entry up to cut, 1: entry found, 2: not decided), s, u; out: gradient.
    """
    vx, vy, vz = item[3] - item[0], item[4] - item[1], item[5] - item[2]
    scale = ROUND * (abs(p[0]) + abs(p[1]) + abs(p[2]) + abs(item[0]) + abs(item[1]) + abs(item[2]) + 1.0)
    u = 0.5
    for _ in range(NEWTON):
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
    """Find the removed stretch of one straight move. 0 nothing, 1 main: out 0 and 2 hold lower end and u, grad the gradient.

    2: the whole stretch lies below nominal, out 3:6 hold lower end, upper end and u, other the gradient.
    """
    is_hit = False
    if tool[0] == BALL:
        is_hit, a, u = capsule(item, tool[1], p, n, grad)
        is_hit = is_hit and grad[2] <= 0.0 and tool[6] >= 2.0 * tool[1]
        if is_hit and a > cut:
            return 0
    if not is_hit and item[2] != item[5]:
        answer, a, u = steep(item, tool, p, n, -depth, cut, grad)
        if answer == 0:
            return 0
        is_hit = answer == 1 and a >= -depth  # an entry further down is none of this search
    if not is_hit:
        is_hit, a, u = first_contact(item, tool, p, n, 1.0, -depth, cut, grad, q)
        if not is_hit:
            return 0
    out[0], out[1], out[2] = a, 0.0, u
    if a >= 0.0:
        return 1
    if at_line(item, tool, p, u) <= 1e-12:
        return 1
    if inside_at(item, tool, p, n, 0.0, other, q) <= 1e-12:
        return 1
    is_hit, b, _ = first_contact(item, tool, p, n, -1.0, 0.0, 2.0 * depth, other, q)
    out[3], out[4], out[5] = a, -b, u
    for i in range(3):
        other[i] = grad[i]
    return 2 if is_hit else 0


@njit(**PLAIN)
def beside(item: Array, tool: Array, p: Array, n: Array) -> bool:
    """Return whether a ray along the tool axis passes outside of all that the tool sweeps on an arc, seen in plan."""
    if n[0] * n[0] + n[1] * n[1] > 1e-24:
        return False
    x, y = p[0] - item[6], p[1] - item[7]
    rho = math.sqrt(x * x + y * y)
    low, high = min(item[15], item[16]), max(item[15], item[16])
    return rho > high + tool[1] + 1e-9 or rho < low - tool[1] - 1e-9


@njit(**PLAIN)
def arc_stretches(
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
    """Find the removed stretches of an arc; 3: one stretch below nominal (in out 3:6, gradient of it in other) and one above it."""
    if beside(item, tool, p, n):
        return 0
    f = inside_at(item, tool, p, n, 0.0, grad, q)
    if f <= 1e-12:
        out[0], out[2] = lower_end(item, tool, p, n, 0.0, depth, grad, q)
        return 1
    result = 0
    if cut > 0.0:
        is_hit, a, u = first_contact(item, tool, p, n, 1.0, 0.0, cut, grad, q)
        if is_hit:
            out[0], out[1], out[2] = a, 0.0, u
            result = 1
    is_hit, b, u = first_contact(item, tool, p, n, -1.0, 0.0, depth, other, q)
    if is_hit:
        out[3], out[5] = lower_end(item, tool, p, n, -b - 1e-9, depth, other, q)
        out[4] = -b
        result += 2
    return result
