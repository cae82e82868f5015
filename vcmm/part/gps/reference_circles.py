"""Reference circles of a roundness profile (ISO 12181-1): least squares (LSC) and minimum zone (MZC), as deviations from the nominal circle.

A circle whose centre lies (x, y) off has the profile radius + x cos t + y sin t, exact to offset^2 / diameter: nanometres for profiles of
micrometres.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array


def least_squares_circle(angle: Array, deviation: Array) -> tuple[Array, float]:
    """Return ((radius, x, y), roundness) of deviations (n,) at angles (n,) rad; in the unit of the deviations."""
    columns = _columns(angle)
    solution: Array = np.asarray(np.linalg.lstsq(columns, deviation, rcond=None)[0], dtype=np.float64)
    return solution, float(np.ptp(deviation - columns @ solution))


def minimum_zone_circles(angle: Array, deviation: Array) -> tuple[Array, float]:
    """Return ((radius, x, y) of the middle of both circles, their distance): the least h with |deviation - circle| <= h / 2, a linear programme."""
    from scipy.optimize import linprog

    scale = float(np.ptp(deviation)) or 1.0
    columns, target = _columns(angle), deviation / scale
    ones = np.ones((len(angle), 1))
    sides = np.block([[columns, -ones], [-columns, -ones]])
    ends = np.concatenate([target, -target])
    solution = linprog([0.0, 0.0, 0.0, 1.0], A_ub=sides, b_ub=ends, bounds=[(None, None)] * 3 + [(0.0, None)])
    circle = np.asarray(solution.x, dtype=np.float64)[:3] * scale
    return circle, float(np.ptp(deviation - columns @ circle))


def _columns(angle: Array) -> Array:
    return np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
