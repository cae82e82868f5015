"""Entry of a ray into a tool at rest, in closed form."""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting.tools import Cutter


def entry(tool: Cutter, o: Array, n: Array) -> Array:
    """Return the lowest s (...) at which o + s n lies in a tool with its tip at the origin, axis +Z; inf where the ray misses."""
    lo, hi = _slab(o[..., 2], n[..., 2], 0.0, tool.length)
    lo, hi = _meet(lo, hi, *_quadric(o, n, tool.radius, 0.0))
    if tool.shape == "cone":
        slope = np.tan(tool.half_angle)
        lo, hi = _meet(lo, hi, *_quadric(o, n, tool.tip_radius, slope))
        lo = np.where(hi - lo >= 0.0, lo, np.inf)
    elif tool.corner > 0.0:
        return _enter_rounded(tool, o, n, lo, hi)
    return np.where(lo <= hi, lo, np.inf)


def _slab(z: Array, nz: Array, low: float, high: float) -> tuple[Array, Array]:
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - z) / nz, (high - z) / nz
    level = nz == 0.0
    inside = (z >= low) & (z <= high)
    lo = np.where(level, np.where(inside, -np.inf, np.inf), np.minimum(a, b))
    hi = np.where(level, np.where(inside, np.inf, -np.inf), np.maximum(a, b))
    return lo, hi


def _meet(lo: Array, hi: Array, a: Array, b: Array) -> tuple[Array, Array]:
    return np.maximum(lo, a), np.minimum(hi, b)


def _quadric(o: Array, n: Array, radius: float, slope: float) -> tuple[Array, Array]:
    """Return the stretch of the ray with distance from the axis <= radius + slope z >= 0 (cylinder or upper sheet of a cone)."""
    r0, rs = radius + slope * o[..., 2], slope * n[..., 2]
    a = n[..., 0] ** 2 + n[..., 1] ** 2 - rs**2
    b = o[..., 0] * n[..., 0] + o[..., 1] * n[..., 1] - r0 * rs
    c = o[..., 0] ** 2 + o[..., 1] ** 2 - r0**2
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        first, second = (-b - root) / a, (-b + root) / a
        lo, hi = np.minimum(first, second), np.maximum(first, second)
        if (
            slope > 0.0
        ):  # a < 0: the ray runs into the upper sheet and stays, or leaves it and has been inside for ever
            up = rs > 0.0
            upper = np.where(r0 + rs * first >= 0.0, first, second)
            upper = np.where(
                (r0 + rs * first >= 0.0) & (r0 + rs * second >= 0.0), np.where(up, hi, lo), upper
            )
            steep = a < 0.0
            lo, hi = (
                np.where(steep, np.where(up, upper, -np.inf), lo),
                np.where(steep, np.where(up, np.inf, upper), hi),
            )
            wrong = ~steep & (r0 + rs * 0.5 * (first + second) < 0.0)
            lo, hi = np.where(wrong, np.inf, lo), np.where(wrong, -np.inf, hi)
    parallel = a == 0.0
    lo = np.where(parallel, np.where(c <= 0.0, -np.inf, np.inf), lo)
    hi = np.where(parallel, np.where(c <= 0.0, np.inf, -np.inf), hi)
    return np.where(np.isnan(lo), np.inf, lo), np.where(np.isnan(hi), -np.inf, hi)


def _enter_rounded(tool: Cutter, o: Array, n: Array, lo: Array, hi: Array) -> Array:
    """Return the entry into a tool with rounded corner: the core grown by a ball. From `lo` Newton climbs to the first root."""
    s, core = lo.copy(), tool.radius - tool.corner
    alive = (lo <= hi) & np.isfinite(lo)
    for _ in range(60):
        x, y, z = (o[..., i] + np.where(alive, s, 0.0) * n[..., i] for i in range(3))
        rho = np.hypot(x, y)
        over, under = rho - core, tool.corner - z
        corner = (over > 0.0) & (under > 0.0)
        d = np.hypot(over, under)
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = (
                over * (x * n[..., 0] + y * n[..., 1]) / np.where(rho > 0, rho, 1.0) - under * n[..., 2]
            ) / d
            step = (d - tool.corner) / rate
        off = alive & corner & (d > tool.corner)
        alive &= ~(off & (rate >= 0.0))
        s = np.where(off & (rate < 0.0), s - step, s)
        if not np.any(off & (np.abs(step) > 1e-15)):
            break
    return np.where(alive & (s <= hi + 1e-12), s, np.inf)
