"""Corners: decide whether to round one or to stop there, whichever takes less time.

To run round a corner within a small tolerance the axes must have braked to a low steady speed before it and may speed up only behind
it; with limited jerk that may take longer than to brake to rest and start again. A control that looks ahead takes the faster
of the two. Both are compared over the halves of the two ways beside the corner, from speed limit to speed limit:

    stop    half of an S-curve from rest to rest over the whole way
    round   half of an S-curve from v to v over the way less the two roundings, and d / v on either rounding

v: the steady speed of the rounding, q'' <= 3/4 |u| / d with 0.6 of the acceleration and q''' <= 3/2 |u| / d^2 with half of the jerk.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.program.limits import Limits
from vcmm.shop.motion.curves import Curves

Bools = np.typing.NDArray[np.bool_]
HALVINGS = 60
CORNER = 1e-6  # a change of direction below is a tangent joint


def is_corner(turn: Array, reach: Array) -> Bools:
    """Return the joints (n-1,) that are rounded and change the direction."""
    return np.asarray((reach > 0) & (np.abs(turn).max(axis=1) > CORNER))


def stops_that_pay(
    curves: Curves, turn: Array, reach: Array, ends: Bools, speed: Array, limits: Limits
) -> Bools:
    """Return the rounded corners (n-1,) that are better stopped at.

    turn (n-1, 6): change of direction; reach (n-1,) mm, 0 where nothing is rounded; ends (n-1,): joints that part two ways;
    speed (n,) mm/s of each move.
    """
    corner = np.flatnonzero(is_corner(turn, reach))
    if not len(corner):
        return np.zeros(len(reach), dtype=bool)
    pace = np.minimum(
        _steady_speed(turn[corner], reach[corner], limits), np.minimum(speed[:-1], speed[1:])[corner]
    )
    way = np.cumsum(np.append(0, ends))
    length = np.bincount(way, weights=curves.length)[way]
    a, j = path_limits(curves, limits)
    gain = np.zeros(len(corner))
    for side in (corner, corner + 1):
        top, size = speed[side], length[side]
        room = np.maximum(size - 2 * reach[corner], 0.0)
        at_rest = _seconds(np.zeros(len(side)), top, size, a[side], j[side])
        rounding = _seconds(pace, top, room, a[side], j[side]) + 2 * reach[corner] / pace
        gain += 0.5 * (rounding - at_rest)
    out = np.zeros(len(reach), dtype=bool)
    out[corner[gain > 0]] = True
    return out


def _steady_speed(turn: Array, reach: Array, limits: Limits) -> Array:
    """Return the speed (k,) mm/s at which a rounding is run through."""
    u, d = np.abs(turn), reach[:, None]
    with np.errstate(divide="ignore"):
        bend = np.sqrt(0.6 / (0.75 * u / d / limits.acceleration).max(axis=1))
        return np.asarray(np.minimum(bend, np.cbrt(0.5 / (1.5 * u / d**2 / limits.jerk).max(axis=1))))


def path_limits(curves: Curves, limits: Limits) -> tuple[Array, Array]:
    """Return the acceleration and jerk (n,) along each curve, by its direction at its start."""
    direction = np.abs(curves.at(np.arange(curves.n), np.zeros(curves.n), 1))
    with np.errstate(divide="ignore"):
        return 1.0 / (direction / limits.acceleration).max(axis=1), 1.0 / (direction / limits.jerk).max(
            axis=1
        )


def _seconds(v: Array, top: Array, length: Array, a: Array, j: Array) -> Array:
    """Return the time (k,) s from speed v up towards `top` and back to v over a length, by S-curves (vcmm.shop.motion.profile)."""
    low, high = v.copy(), np.maximum(np.minimum(top, 1e9), v)
    fits = (high + v) * _change_seconds(high - v, a, j) <= length
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        short = (middle + v) * _change_seconds(middle - v, a, j) <= length
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    peak = np.where(fits, np.maximum(np.minimum(top, 1e9), v), low)
    change = _change_seconds(peak - v, a, j)
    steady = np.maximum(length - (peak + v) * change, 0.0)
    return np.asarray(2 * change + np.where(steady > 0, steady / np.maximum(peak, 1e-300), 0.0))


def _change_seconds(change: Array, a: Array, j: Array) -> Array:
    """Return the time (k,) s of an S-curve that changes the speed by that much."""
    return np.where(change * j > a * a, change / a + a / j, 2 * np.sqrt(np.maximum(change, 0.0) / j))
