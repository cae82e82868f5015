"""Ideal elements fitted to points: least squares by scipy, zones of least width by linear programs.

Zones are found by exchange: a linear program over few points, then the points outside its zone join it, until none
is outside. Round elements are linearised about the last answer; the program is repeated until it stands still.
Sources: ISO 1101:2017 (minimum zone), ISO 14405-1:2016 (GG), ISO 12181-1, ISO 12780-1, ISO 12781-1, ISO 12180-1;
Anthony et al., Precision Engineering 19 (1996) 28 (linear programs for Chebyshev elements).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, linprog

Array = NDArray[np.float64]


def chebyshev(design: Array, values: Array) -> tuple[Array, float]:
    """Coefficients x with the least largest |values - design x|, and that half width.

    Parameters
    ----------
    design : array, shape (n, m)
    values : array, shape (n,)
    """
    scale = np.abs(design).max(axis=0)
    scale[scale == 0] = 1.0
    design = design / scale
    unit = max(np.abs(values).max(), 1e-15)
    target = values / unit
    count, size = design.shape
    start = np.linalg.lstsq(design, target, rcond=None)[0]
    residual = target - design @ start
    edge = np.argsort(np.abs(residual))[-4 * size :]
    chosen = np.unique(np.concatenate([edge, np.linspace(0, count - 1, 4 * size).astype(int)]))
    cost = np.zeros(size + 1)
    cost[-1] = 1.0
    free = [(None, None)] * size + [(0, None)]
    for _ in range(60):
        rows, right = design[chosen], target[chosen]
        ones = np.ones((len(chosen), 1))
        left = np.block([[rows, -ones], [-rows, -ones]])
        answer = linprog(cost, A_ub=left, b_ub=np.concatenate([right, -right]), bounds=free, method="highs")
        if answer.x is None:
            raise ValueError("no zone was found: " + answer.message)
        residual = np.abs(target - design @ answer.x[:-1])
        if residual.max() <= answer.x[-1] + 1e-7:
            break
        worst = np.argsort(residual)[-3 * size :]
        chosen = np.union1d(chosen, worst[residual[worst] > answer.x[-1] + 1e-9])
    return answer.x[:-1] / scale * unit, float(residual.max() * unit)


def plane(points: Array, normal: Array) -> tuple[Array, Array]:
    """Least-squares plane: a point of it and its unit normal on the side of `normal`."""
    centre = points.mean(axis=0)
    direction = np.linalg.svd(points - centre, full_matrices=False)[2][2]
    return centre, direction * np.sign(direction @ normal)


def constrained_plane(points: Array, normal: Array, fixed: list[Array]) -> tuple[Array, Array]:
    """Least-squares plane whose normal is square to the directions `fixed` (secondary and tertiary datums, ISO 5459).

    One direction leaves one turn about it, two leave none.
    """
    centre = points.mean(axis=0)
    if len(fixed) == 1:
        axis = fixed[0] / np.linalg.norm(fixed[0])
        square = points - centre
        square = square - np.outer(square @ axis, axis)
        vectors = np.linalg.eigh(square.T @ square).eigenvectors
        candidates = [v for v in vectors.T if abs(v @ axis) < 0.5]
        direction = min(candidates, key=lambda v: v @ (square.T @ square) @ v)
    else:
        direction = np.cross(fixed[0], fixed[1])
    direction = direction / np.linalg.norm(direction)
    return centre, direction * np.sign(direction @ normal)


def flatness(points: Array, normal: Array, zone: bool) -> float:
    """Flatness about the least-squares plane, or (zone) the distance of the nearest two planes that hold all points."""
    centre, direction = plane(points, normal)
    height = (points - centre) @ direction
    if not zone:
        return float(np.ptp(height))
    across = np.linalg.svd(points - centre, full_matrices=False)[2][:2]
    flat = (points - centre) @ across.T
    coefficients, half = chebyshev(np.column_stack([np.ones(len(flat)), flat]), height)
    return 2 * half / float(np.sqrt(1 + np.sum(coefficients[1:] ** 2)))


def straightness(along: Array, height: Array, zone: bool) -> float:
    """Straightness of a profile in its plane."""
    design = np.column_stack([np.ones_like(along), along - along.mean()])
    if zone:
        coefficients, half = chebyshev(design, height)
        return 2 * half / float(np.hypot(1, coefficients[1]))
    coefficients = np.linalg.lstsq(design, height, rcond=None)[0]
    return float(np.ptp(height - design @ coefficients)) / float(np.hypot(1, coefficients[1]))


def circle(points: Array) -> tuple[Array, float]:
    """Least-squares circle (x, y) of orthogonal distances: centre and radius."""
    design = np.column_stack([2 * points, np.ones(len(points))])
    guess = np.linalg.lstsq(design, np.sum(points**2, axis=1), rcond=None)[0]
    radius = np.sqrt(guess[2] + guess[0] ** 2 + guess[1] ** 2)

    def distance(x: Array) -> Array:
        return np.hypot(points[:, 0] - x[0], points[:, 1] - x[1]) - x[2]

    found = least_squares(
        distance, [guess[0], guess[1], radius], xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale="jac"
    )
    return found.x[:2], float(found.x[2])


def roundness(points: Array, zone: bool) -> float:
    """Roundness about the least-squares circle, or (zone) of the two concentric circles nearest to each other."""
    centre, _ = circle(points)
    if not zone:
        return float(np.ptp(np.hypot(*(points - centre).T)))
    for _ in range(20):
        away = points - centre
        radius = np.hypot(*away.T)
        design = np.column_stack([np.ones(len(points)), away / radius[:, None]])
        coefficients, _ = chebyshev(design, radius - radius.mean())
        centre = centre + coefficients[1:]
        if np.abs(coefficients[1:]).max() < 1e-10:
            break
    return float(np.ptp(np.hypot(*(points - centre).T)))


def _radii(points: Array, x: Array) -> Array:
    """Distances from the axis through (x0, x1, 0) with direction (x2, x3, 1)."""
    direction = np.array([x[2], x[3], 1.0])
    direction /= np.linalg.norm(direction)
    away = points - np.array([x[0], x[1], 0.0])
    return np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)


def cylinder(points: Array) -> tuple[Array, Array, float]:
    """Least-squares cylinder about roughly z: the axis at z = 0, its direction (z part 1), radius."""
    centre, radius = circle(points[:, :2])

    def distance(x: Array) -> Array:
        return _radii(points, x) - x[4]

    start = np.array([*centre, 0.0, 0.0, radius])
    found = least_squares(
        distance, start, xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=[1, 1, 0.01, 0.01, 1]
    ).x
    return np.array([found[0], found[1], 0.0]), np.array([found[2], found[3], 1.0]), float(found[4])


def cylindricity(points: Array, zone: bool) -> float:
    """Cylindricity about the least-squares cylinder, or (zone) of the two coaxial cylinders nearest to each other."""
    point, direction, _ = cylinder(points)
    x = np.array([point[0], point[1], direction[0], direction[1]])
    if not zone:
        return float(np.ptp(_radii(points, x)))
    for _ in range(20):
        away = points[:, :2] - x[:2] - points[:, 2:] * x[2:]
        unit = away / np.linalg.norm(away, axis=1)[:, None]
        radius = _radii(points, x)
        design = np.column_stack([np.ones(len(points)), unit, unit * points[:, 2:]])
        coefficients, _ = chebyshev(design, radius - radius.mean())
        x = x + coefficients[1:]
        if np.abs(coefficients[1:3]).max() < 1e-10:
            break
    return float(np.ptp(_radii(points, x)))
