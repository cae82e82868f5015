"""Figures of acceptance tests from deviations, for any source of the deviations (recorded, or simulated on a machine).

    ISO 230-2:2014   A, R, B, E, M of an axis, from runs in both directions
    ISO 230-4:2005   G, G(b), D, F, H of circles
    ISO 230-6:2002   E of diagonals
    ISO 10360-2:2009 E0, R0 of lengths

Every function takes deviations with any number of leading axes (trials) and reduces the last ones.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.core.run import Array

TURN, NEAR, EDGE = (
    2 * np.pi,
    np.radians(15.0),
    1e-6,
)  # rad; paths are compared between readings no further apart


def positioning(up: Array, down: Array) -> dict[str, Array]:
    """Return A, R, B, E, M of ISO 230-2:2014, clause 5: up, down (..., positions, runs) actual - target, mm, approached in + and in -.

    Raises UsageError for fewer than two runs: a standard deviation needs them.
    """
    if up.shape[-1] < 2 or down.shape[-1] < 2:
        raise UsageError("ISO 230-2 needs two runs or more in each direction (five are usual)")
    mean_up, mean_down = up.mean(axis=-1), down.mean(axis=-1)
    s_up, s_down = up.std(axis=-1, ddof=1), down.std(axis=-1, ddof=1)
    reversal = mean_up - mean_down
    middle = (mean_up + mean_down) / 2
    repeat = np.maximum(np.maximum(2 * s_up + 2 * s_down + np.abs(reversal), 4 * s_up), 4 * s_down)
    high = np.maximum((mean_up + 2 * s_up).max(axis=-1), (mean_down + 2 * s_down).max(axis=-1))
    low = np.minimum((mean_up - 2 * s_up).min(axis=-1), (mean_down - 2 * s_down).min(axis=-1))
    both_high = np.maximum(mean_up.max(axis=-1), mean_down.max(axis=-1))
    both_low = np.minimum(mean_up.min(axis=-1), mean_down.min(axis=-1))
    return {
        "A": high - low,
        "A+": (mean_up + 2 * s_up).max(axis=-1) - (mean_up - 2 * s_up).min(axis=-1),
        "A-": (mean_down + 2 * s_down).max(axis=-1) - (mean_down - 2 * s_down).min(axis=-1),
        "R": repeat.max(axis=-1),
        "R+": (4 * s_up).max(axis=-1),
        "R-": (4 * s_down).max(axis=-1),
        "B": np.abs(reversal).max(axis=-1),
        "E": both_high - both_low,
        "E+": np.ptp(mean_up, axis=-1),
        "E-": np.ptp(mean_down, axis=-1),
        "M": np.ptp(middle, axis=-1),
    }


def circular(
    angle: Array, forward: Array, backward: Array, back_angle: Array | None = None, centred: bool = True
) -> dict[str, Array]:
    """Return figures of ISO 230-4, clause 3: radial deviations (..., points) mm at angles (points,) rad, counter-clockwise and clockwise.

    back_angle: of the clockwise path, where it was read elsewhere. G+ and G- are about the least-squares centre of their own
    path, all others about that of both paths together (G(b) is bidirectional); centred = False leaves the centre where the instrument has it (arcs).
    G: range of the radii per direction, G(b) of both together, D: mean of both, F: extremes from the nominal radius, H:
    largest difference of the directions at one angle (the hysteresis of the edition of 1996).
    """
    back_angle = angle if back_angle is None else back_angle
    deviations = (
        [about_own_circle(angle, forward), about_own_circle(back_angle, backward)]
        if centred
        else [forward, backward]
    )
    if centred:
        forward, backward = about_common_circle(angle, forward, back_angle, backward)
    same, weights = _at_angles(angle, back_angle)
    largest = np.maximum(forward.max(axis=-1), backward.max(axis=-1))
    least = np.minimum(forward.min(axis=-1), backward.min(axis=-1))
    return {
        "G+": np.ptp(deviations[0], axis=-1),
        "G-": np.ptp(deviations[1], axis=-1),
        "G(b)": largest - least,
        "D": (forward.mean(axis=-1) + backward.mean(axis=-1)) / 2,
        "F max": largest,
        "F min": least,
        "H": np.abs(forward[..., same] - backward @ weights.T).max(axis=-1),
    }


def about_own_circle(angle: Array, radial: Array) -> Array:
    """Return one path about the centre of its own least-squares circle."""
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return radial - _centre(way, radial) @ way.T


def about_common_circle(
    angle: Array, forward: Array, back_angle: Array, backward: Array
) -> tuple[Array, Array]:
    """Return both paths about the centre of their common least-squares circle."""
    ways = [np.stack([np.cos(a), np.sin(a)], axis=1) for a in (angle, back_angle)]
    centre = _centre(np.concatenate(ways), np.concatenate([forward, backward], axis=-1))
    return forward - centre @ ways[0].T, backward - centre @ ways[1].T


def _centre(ways: Array, radial: Array) -> Array:
    """Return the centre (..., 2) of the least-squares circle of radial deviations (..., n) in the directions (n, 2)."""
    fit = np.linalg.pinv(np.column_stack([ways, np.ones(len(ways))]))[:2]
    return np.asarray(radial @ fit.T)


def _at_angles(angle: Array, other: Array) -> tuple[npt.NDArray[np.bool_], Array]:
    """Return (points,) bool: angles between two readings of the other path that are near; (points', other) weights to read it there."""
    order = np.argsort(other % TURN)
    nodes = (other % TURN)[order]
    around = np.concatenate([nodes[-1:] - TURN, nodes, nodes[:1] + TURN])
    numbers = np.concatenate([order[-1:], order, order[:1]])
    after = np.clip(np.searchsorted(around, angle % TURN, side="right"), 1, len(around) - 1)
    gap = around[after] - around[after - 1]
    share = (angle % TURN - around[after - 1]) / np.where(gap > 0, gap, 1.0)
    here = (gap < NEAR) | (share < EDGE) | (share > 1 - EDGE)
    weights = np.zeros((len(angle), len(other)))
    rows = np.arange(len(angle))
    np.add.at(weights, (rows, numbers[after - 1]), 1 - share)
    np.add.at(weights, (rows, numbers[after]), share)
    return here, weights[here]


def diagonal(up: Array, down: Array) -> dict[str, Array]:
    """Return E and B of one diagonal, ISO 230-6:2002: up, down (..., positions, runs) mm along it."""
    figures = positioning(up, down)
    return {name: figures[name] for name in ("E", "B", "R")}


def lengths(errors: Array) -> dict[str, Array]:
    """Return E0 and R0 of ISO 10360-2:2009: errors (..., lengths, repeats) mm, indicated - calibrated. E0: largest; R0: range of repeats."""
    return {"E0": np.abs(errors).max(axis=(-1, -2)), "R0": np.ptp(errors, axis=-1).max(axis=-1)}
