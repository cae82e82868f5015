"""Minimax, circumscribed and inscribed elements by a sequence of linear programs (scipy HiGHS): the plain way.

Shares no code with vcmm.part.fit: distances written out, derivatives by differences, a trust region around each program.
What the exchange of contacts is compared with, in the tests and in benchmarks/bench_criteria.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

Array = NDArray[np.float64]


def distances(kind: str, p: Array, points: Array) -> Array:
    """Signed distances (n,) of points (n, 3) from the element p = point 3, direction 3 (any length), sizes."""
    axis = p[3:6] / np.sqrt(p[3:6] @ p[3:6])
    arm = points - p[:3]
    along = arm @ axis
    rho = np.sqrt(np.maximum(np.sum(arm * arm, axis=1) - along**2, 1e-300))
    if kind == "plane":
        return along
    if kind == "sphere":
        return np.sqrt(np.sum(arm * arm, axis=1)) - p[6]
    if kind == "cone":
        return np.cos(p[7]) * (rho - p[6]) - np.sin(p[7]) * along
    if kind == "torus":
        return np.hypot(rho - p[6], along) - p[7]
    return rho - (p[6] if kind != "line" else 0.0)


def _directions(kind: str, p: Array, axis_is_fixed: bool, sized: bool) -> Array:
    """Orthonormal columns of what may change in p."""
    axis = p[3:6] / np.linalg.norm(p[3:6])
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    zero = np.zeros(3)
    shifts = {"plane": [axis], "sphere": list(np.eye(3)), "torus": [u, v, axis]}.get(kind, [u, v])
    tilts = [] if axis_is_fixed or kind == "sphere" else [u, v]
    sizes = np.eye(len(p) - 6) if sized else []
    rows = [np.concatenate([s, zero, np.zeros(len(p) - 6)]) for s in shifts]
    rows += [np.concatenate([zero, t, np.zeros(len(p) - 6)]) for t in tilts]
    rows += [np.concatenate([zero, zero, s]) for s in sizes]
    return np.array(rows).T


def sequential_lp(
    kind: str, criterion: str, points: Array, start: Array, axis_is_fixed: bool = False, trust: float = 1.0
) -> tuple[Array, float, int]:
    """Element p by C, N or X (its radius included), the level, and the number of linear programs."""
    p, sized = np.array(start, dtype=float), criterion == "C" and kind != "line"
    sign = -1.0 if criterion == "X" else 1.0

    def top(q: Array) -> float:
        d = distances(kind, q, points)
        return float(np.max(np.abs(d)) if sized else np.max(sign * d))

    count = 0
    while trust > 1e-12 and count < 200:
        d, free = distances(kind, p, points), _directions(kind, p, axis_is_fixed, sized)
        step = 1e-6
        jac = np.stack(
            [
                (distances(kind, p + step * c, points) - distances(kind, p - step * c, points)) / (2 * step)
                for c in free.T
            ],
            axis=1,
        )
        ones = np.ones((len(d), 1))
        sides = [1.0, -1.0] if sized else [sign]
        a = np.concatenate([np.hstack([s * jac, -ones]) for s in sides])
        b = np.concatenate([-s * d for s in sides])
        bounds = [(-trust, trust)] * free.shape[1] + [(None, None)]
        found = linprog([0.0] * free.shape[1] + [1.0], a, b, bounds=bounds, method="highs")
        count += 1
        trial = p + free @ found.x[:-1]
        if top(trial) < top(p) - 1e-14:
            p = trial
            p[3:6] /= np.linalg.norm(p[3:6])
        else:
            trust = min(trust, float(np.abs(found.x[:-1]).max())) / 8.0
    level = top(p)
    if not sized and kind != "line":
        p[6] += sign * level
    return p, level, count
