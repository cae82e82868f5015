"""Compiled loops over triangles. Imported only when a mesh needs distances; tests/answer/placing/test_solid.py holds the same in numpy."""

from __future__ import annotations

import math

import numpy as np

from vcmm.core._compile_kernels import njit


@njit(cache=True, error_model="numpy")
def _square_to_triangle(p, a, b, c):  # type: ignore[no-untyped-def]
    """Return the square of the distance of p to the triangle a b c (Ericson, Real-Time Collision Detection (2005), 5.1.5)."""
    ab, ac, ap = b - a, c - a, p - a
    d1, d2 = ab @ ap, ac @ ap
    if d1 <= 0.0 and d2 <= 0.0:
        return ap @ ap
    bp = p - b
    d3, d4 = ab @ bp, ac @ bp
    if d3 >= 0.0 and d4 <= d3:
        return bp @ bp
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        r = ap - d1 / (d1 - d3) * ab
        return r @ r
    cp = p - c
    d5, d6 = ab @ cp, ac @ cp
    if d6 >= 0.0 and d5 <= d6:
        return cp @ cp
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        r = ap - d2 / (d2 - d6) * ac
        return r @ r
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        r = bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)
        return r @ r
    s = 1.0 / (va + vb + vc)
    r = ap - vb * s * ab - vc * s * ac
    return r @ r


@njit(cache=True, error_model="numpy")
def mesh_distance(points, corners):  # type: ignore[no-untyped-def]
    """Compute distance (n,) and winding number (n,) of points (n, 3) for triangles (f, 3, 3)."""
    n, f = points.shape[0], corners.shape[0]
    distance, winding = np.empty(n), np.empty(n)
    for i in range(n):
        p, least, turn = points[i], np.inf, 0.0
        for j in range(f):
            a, b, c = corners[j, 0], corners[j, 1], corners[j, 2]
            least = min(least, _square_to_triangle(p, a, b, c))
            x, y, z = a - p, b - p, c - p
            lx, ly, lz = math.sqrt(x @ x), math.sqrt(y @ y), math.sqrt(z @ z)
            triple = (
                x[0] * (y[1] * z[2] - y[2] * z[1])
                - x[1] * (y[0] * z[2] - y[2] * z[0])
                + x[2] * (y[0] * z[1] - y[1] * z[0])
            )
            turn += math.atan2(triple, lx * ly * lz + (x @ y) * lz + (y @ z) * lx + (z @ x) * ly)
        distance[i], winding[i] = math.sqrt(least), turn / (2.0 * math.pi)
    return distance, winding
