"""Figures of acceptance tests from deviations, whatever the deviations come from (recorded, or drawn from a machine).

    ISO 230-2:2014   A, R, B, E, M of an axis, from runs in both directions
    ISO 230-4:2005   G, F, H of circles
    ISO 230-6:2002   E of diagonals
    ISO 10360-2:2009 E0, R0 of lengths

Every function takes deviations with any number of leading axes (trials) and reduces the last ones.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array


def positioning(up: Array, down: Array) -> dict[str, Array]:
    """ISO 230-2:2014, clause 5: up, down (..., positions, runs) actual - target, mm, approached in + and in -.

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


def circular(angle: Array, forward: Array, backward: Array) -> dict[str, Array]:
    """ISO 230-4, clause 3: radial deviations (..., points) mm at angles (points,) rad, counter-clockwise and clockwise.

    The centre is that of the least-squares circle of both directions together, as far as the points are a full circle.
    G: range of the radii per direction, F: extremes from the nominal radius, H: largest difference of the directions.
    """
    columns = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    both = (forward + backward) / 2
    centre = np.linalg.lstsq(
        np.column_stack([columns, np.ones(len(angle))]),
        np.moveaxis(both, -1, 0).reshape(len(angle), -1),
        rcond=None,
    )[0][:2]
    moved = np.moveaxis((columns @ centre).reshape(len(angle), *both.shape[:-1]), 0, -1)
    ahead, back = forward - moved, backward - moved
    return {
        "G+": np.ptp(ahead, axis=-1),
        "G-": np.ptp(back, axis=-1),
        "F max": np.maximum(ahead.max(axis=-1), back.max(axis=-1)),
        "F min": np.minimum(ahead.min(axis=-1), back.min(axis=-1)),
        "H": np.abs(ahead - back).max(axis=-1),
    }


def diagonal(up: Array, down: Array) -> dict[str, Array]:
    """ISO 230-6:2002: E and B of one diagonal, up, down (..., positions, runs) mm along it."""
    found = positioning(up, down)
    return {name: found[name] for name in ("E", "B", "R")}


def lengths(errors: Array) -> dict[str, Array]:
    """ISO 10360-2:2009: errors (..., lengths, repeats) mm, indicated - calibrated. E0: largest; R0: range of repeats."""
    return {"E0": np.abs(errors).max(axis=(-1, -2)), "R0": np.ptp(errors, axis=-1).max(axis=-1)}
