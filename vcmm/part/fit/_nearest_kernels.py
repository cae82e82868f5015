"""Nearest point of a polyhedron for whole batches: the dual active-set method (Goldfarb and Idnani, Math. Prog. 27
(1983) 1), and what vcmm.part.fit.exchange and vcmm.part.fit.uniqueness build on it.

Private; imported inside the functions that use it. A constraint joins when it is violated most and leaves when its
multiplier would turn negative, which is the exchange of contact points: the method needs about as many steps as
there are contacts, whatever the number of points. Compiled because the set of contacts differs from fit to fit, so
that a batch cannot share its steps in numpy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

Array = NDArray[Any]

DEPENDENT = 1e-13  # squared share of a normal below which it lies in the span of the active ones
MOST_STEPS = 400


@njit(cache=True, nogil=True, error_model="numpy")
def _orthogonal(normals: Array, first: int, q: int, basis: Array, upper: Array) -> None:
    """Apply modified Gram-Schmidt, twice, of columns first .. q - 1 of normals (m, m): normals = basis upper."""
    m = normals.shape[0]
    for j in range(first, q):
        for i in range(m):
            basis[i, j] = normals[i, j]
        for k in range(j):
            upper[k, j] = 0.0
        for _ in range(2):
            for k in range(j):
                share = 0.0
                for i in range(m):
                    share += basis[i, k] * basis[i, j]
                upper[k, j] += share
                for i in range(m):
                    basis[i, j] -= share * basis[i, k]
        size = 0.0
        for i in range(m):
            size += basis[i, j] ** 2
        upper[j, j] = np.sqrt(size)
        for i in range(m):
            basis[i, j] /= upper[j, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _worst(
    rows: Array, b: Array, two_sided: bool, x: Array, level: Any, which: Array
) -> tuple[float, int, float]:
    """Return the largest sign (rows_k . x + b_k) - level among k of `which`, its k and sign."""
    p = rows.shape[1]
    most, where, side = -np.inf, -1, 1.0
    for k in which:
        value = b[k]
        for i in range(p):
            value += rows[k, i] * x[i]
        if value - level > most:
            most, where, side = value - level, k, 1.0
        if two_sided and -value - level > most:
            most, where, side = -value - level, k, -1.0
    return most, where, side


@njit(cache=True, nogil=True, error_model="numpy")
def _beside(
    normal: Array, q: int, basis: Array, upper: Array, z: Array, shares: Array, r: Array
) -> tuple[float, float]:
    """Compute z (m,), the part of a normal beside the q active ones, its shares in their basis, and r in themselves. Returns
    the squares of z and of the normal.
    """
    m = normal.shape[0]
    length, free = 0.0, 0.0
    for i in range(m):
        z[i] = normal[i]
        length += normal[i] ** 2
    for j in range(q):
        shares[j] = 0.0
    for _ in range(2):
        for j in range(q):
            share = 0.0
            for i in range(m):
                share += basis[i, j] * z[i]
            shares[j] += share
            for i in range(m):
                z[i] -= share * basis[i, j]
    for j in range(q - 1, -1, -1):
        r[j] = shares[j]
        for i in range(j + 1, q):
            r[j] -= upper[j, i] * r[i]
        r[j] /= upper[j, j]
    for i in range(m):
        free += z[i] ** 2
    return free, length


@njit(cache=True, nogil=True, error_model="numpy")
def _join(normal: Array, q: int, normals: Array, basis: Array, upper: Array, z: Array, shares: Array) -> None:
    """Make the normal active as number q; z and shares as `_beside` left them."""
    size = 0.0
    for j in range(q):
        upper[j, q] = shares[j]
    for i in range(normal.shape[0]):
        size += z[i] ** 2
    upper[q, q] = np.sqrt(size)
    for i in range(normal.shape[0]):
        normals[i, q] = normal[i]
        basis[i, q] = z[i] / upper[q, q]


@njit(cache=True, nogil=True, error_model="numpy")
def _holds(at: Array, sides: Array, q: int, k: int, side: float) -> bool:
    """Return whether constraint k on this side is among the q active ones."""
    is_held = False
    for j in range(q):
        is_held = is_held or (at[j] == k and sides[j] == side)
    return is_held


@njit(cache=True, nogil=True, error_model="numpy")
def _first_to_leave(u: Array, r: Array, q: int) -> tuple[float, int]:
    """Return the step at which the first multiplier u - step r reaches 0, and its number; inf, -1 where none does."""
    partial, leaving = np.inf, -1
    for j in range(q):
        if r[j] > 1e-14 and u[j] / r[j] < partial:
            partial, leaving = u[j] / r[j], j
    return partial, leaving


@njit(cache=True, nogil=True, error_model="numpy")
def nearest(
    rows: Array,
    b: Array,
    two_sided: bool,
    levelled: bool,
    base: float,
    x: Array,
    weight: Array,
    rounding: float,
) -> bool:
    """Move x (m,) to the nearest point of the polyhedron sign (rows_k . x + b_k) <= base (+ x[p] when levelled).

    rows (n, p), b (n,); m = p, or p + 1 with the level as last component. weight (n,): the multipliers, with the
    sign of their side; those other than 0 on entry name constraints that are looked at first. False: too many
    steps.
    """
    p, m = rows.shape[1], x.shape[0]
    normals, basis, upper = np.zeros((m, m)), np.zeros((m, m)), np.zeros((m, m))
    at, sides, u = np.zeros(m, np.int64), np.zeros(m), np.zeros(m)
    normal, z, r, shares = np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m)
    everything, likely = np.arange(rows.shape[0]), np.flatnonzero(weight)
    weight[:] = 0.0
    q, k, side, added, is_held = 0, -1, 1.0, 0.0, True
    for _ in range(MOST_STEPS):
        level = base + x[p] if levelled else base
        if is_held:  # the last constraint is in: look for the next
            violation, k, side = _worst(rows, b, two_sided, x, level, likely)
            if violation <= rounding:
                violation, k, side = _worst(rows, b, two_sided, x, level, everything)
            if violation <= rounding or _holds(at, sides, q, k, side):
                weight[at[:q]] += sides[:q] * u[:q]
                return True
            added, is_held = 0.0, False
            normal[:p] = side * rows[k]
            normal[p:] = -1.0  # of the level
        else:
            violation = side * b[k] - level
            for i in range(p):
                violation += normal[i] * x[i]
        free, length = _beside(normal, q, basis, upper, z, shares, r)
        dependent = q == m or free <= DEPENDENT * length
        full = np.inf if dependent else violation / free
        partial, leaving = _first_to_leave(u, r, q)
        step = min(full, partial)
        if step == np.inf:
            return False  # no point fulfils all constraints
        if not dependent:
            x -= step * z
        u[:q] -= step * r[:q]
        added += step
        if full <= partial:
            at[q], sides[q], u[q] = k, side, added
            _join(normal, q, normals, basis, upper, z, shares)
            q, is_held = q + 1, True
        else:
            q -= 1
            for j in range(leaving, q):
                at[j], sides[j], u[j], normals[:, j] = at[j + 1], sides[j + 1], u[j + 1], normals[:, j + 1]
            _orthogonal(normals, leaving, q, basis, upper)
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _factor(metric: Array, factor: Array) -> None:
    """Lower Cholesky factor of a metric (p, p); a missing rank is lifted to rounding."""
    p = metric.shape[0]
    trace = 1e-300
    for i in range(p):
        trace += metric[i, i]
    for i in range(p):
        for j in range(i + 1):
            value = metric[i, j]
            for k in range(j):
                value -= factor[i, k] * factor[j, k]
            if i == j:
                factor[i, i] = np.sqrt(max(value, 1e-15 * trace))
            else:
                factor[i, j] = value / factor[j, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _whiten(jac: Array, factor: Array, rows: Array) -> None:
    """Compute rows (n, p) = (factor^-1 jac)', jac (p, n)."""
    p, n = jac.shape
    for k in range(n):
        for i in range(p):
            value = jac[i, k]
            for j in range(i):
                value -= factor[i, j] * rows[k, j]
            rows[k, i] = value / factor[i, i]


@njit(cache=True, nogil=True, error_model="numpy")
def minimax_steps(
    jac: Array,
    d: Array,
    two_sided: bool,
    metric: Array,
    rounding: Array,
    step: Array,
    level: Array,
    weight: Array,
) -> None:
    """Compute per member the step (B, p) that minimises level + level^2 / 2 + step' metric step / 2 under
    d_k + jac_k . step <= max d + level, and for two_sided its negative; weight (B, n) as in `nearest`.
    """
    batch, p, n = jac.shape
    factor, rows, x = np.zeros((p, p)), np.zeros((n, p)), np.zeros(p + 1)
    for b in range(batch):
        base = -np.inf
        for k in range(n):
            base = max(base, abs(d[b, k]) if two_sided else d[b, k])
        _factor(metric[b], factor)
        _whiten(jac[b], factor, rows)
        x[:] = 0.0
        x[p] = -1.0
        nearest(rows, d[b], two_sided, True, base, x, weight[b], rounding[b])
        _back(factor, x, step[b])
        level[b] = base + x[p]


@njit(cache=True, nogil=True, error_model="numpy")
def tangent_steps(jac: Array, d: Array, metric: Array, rounding: Array, step: Array, weight: Array) -> None:
    """Compute per member the step (B, p) that minimises sum (d + jac . step)^2 under d + jac . step <= 0.

    metric = jac jac' / n.
    """
    batch, p, n = jac.shape
    factor, rows, x = np.zeros((p, p)), np.zeros((n, p)), np.zeros(p)
    for b in range(batch):
        _factor(metric[b], factor)
        _whiten(jac[b], factor, rows)
        for i in range(p):
            x[i] = 0.0
            for k in range(n):
                x[i] -= rows[k, i] * d[b, k] / n
        nearest(rows, d[b], False, False, 0.0, x, weight[b], rounding[b])
        _back(factor, x, step[b])


@njit(cache=True, nogil=True, error_model="numpy")
def _back(factor: Array, x: Array, step: Array) -> None:
    """step (p,) = factor^-T x."""
    for i in range(step.shape[0] - 1, -1, -1):
        step[i] = x[i]
        for j in range(i + 1, step.shape[0]):
            step[i] -= factor[j, i] * step[j]
        step[i] /= factor[i, i]


@njit(cache=True, nogil=True, error_model="numpy")
def reaches(rows: Array, tight: Array, metric: Array, far: Array, out: Array) -> None:
    """Compute per member the largest |component| (B,) that the nearest points of {rows_k . y <= 1, k tight} to the points
    -far and +far on each axis have; rows (B, p, n) are whitened by the metric (B, p, p) first.
    """
    batch, p, n = rows.shape
    factor, white, x, weight = np.zeros((p, p)), np.zeros((n, p)), np.zeros(p), np.zeros(n)
    for b in range(batch):
        _factor(metric[b], factor)
        _whiten(rows[b], factor, white)
        count = 0
        for k in range(n):
            if tight[b, k]:
                for i in range(p):
                    white[count, i] = white[k, i]
                count += 1
        out[b] = 0.0
        for axis in range(p):
            for side in (-1.0, 1.0):
                x[:] = 0.0
                weight[:] = 0.0
                x[axis] = side * far[b]
                nearest(white[:count], -np.ones(count), False, False, 0.0, x, weight[:count], 1e-9)
                for i in range(p):
                    out[b] = max(out[b], abs(x[i]))
