"""Rounded corners: where two moves meet, the path leaves the first d before the joint and joins the second d after it.

The rounding is the polynomial of fifth degree in the programmed distance s that has position, direction and curvature
of both moves at its ends, so that speed and acceleration of every axis are continuous at any speed. Between two lines
with directions u1, u2 it is

    q'(s) = u1 + (u2 - u1) h,  h = 3 t^2 - 2 t^3,  t = s / 2d,

which leaves the corner by 3/16 d |u2 - u1| (at most, at t = 1/2), with q'' at most 3/4 |u2 - u1| / d. Elsewhere the
deviation is the largest distance at the same s, which is never below the distance between the two curves.
A quarter turn with 10 um tolerance is left 38 um before the corner: 0.010 x 16 / (3 sqrt 2) = 0.0377 mm.

Rows of short lines are taken as one curve: `vcmm.shop.motion.smoothing`.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.program.limits import Limits
from vcmm.shop.motion.curves import Curves, Ints

ROTARY_ARM = 100.0  # mm: a rotary axis may deviate by the tolerance at this radius
CHECK_SHARES = np.array(
    [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]
)  # places of a rounding at which it is compared
STRAIGHT = 1e-9  # directions and curvatures that differ by less go on as one
BACK = -0.99  # cosine of the angle beyond which a corner is a reversal: the control stops there
WEIGHT = np.array([1.0, 1.0, 1.0, ROTARY_ARM, ROTARY_ARM, ROTARY_ARM])


def direction_jump(curves: Curves, first: Ints, second: Ints) -> tuple[Array, Array]:
    """Return (change of direction, change of curvature) (k, 6) from the end of `first` to the start of `second`."""
    begin = np.zeros(len(first))
    turn = curves.at(second, begin, 1) - curves.at(first, curves.length[first], 1)
    bend = curves.at(second, begin, 2) - curves.at(first, curves.length[first], 2)
    return turn, bend


def turns_back(curves: Curves, first: Ints, second: Ints) -> np.typing.NDArray[np.bool_]:
    """Return where the second move goes back against the first."""
    a = curves.at(first, curves.length[first], 1) * WEIGHT
    b = curves.at(second, np.zeros(len(second)), 1) * WEIGHT
    size = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    return np.einsum("ki,ki->k", a, b) < BACK * size


def widest_reach(angle: Array, tolerance: Array) -> Array:
    """Return d (k,) mm at which the rounding between two lines leaves the corner by the tolerance; angle: |u2 - u1|."""
    return np.asarray(16.0 * tolerance / (3.0 * np.maximum(angle, 1e-300)))


def reach_of_blends(curves: Curves, first: Ints, second: Ints, tolerance: Array) -> Array:
    """Return d (k,) mm for each joint: as large as the tolerance (k,) and half of either move allow; 0 where no rounding is needed."""
    turn, bend = direction_jump(curves, first, second)
    angle, curvature = np.linalg.norm(turn * WEIGHT, axis=1), np.linalg.norm(bend * WEIGHT, axis=1)
    room = 0.5 * np.minimum(_room(curves, first), _room(curves, second))
    straight = (angle < STRAIGHT) & (curvature < STRAIGHT)
    lines = (curves.arc[first] < 0) & (curves.arc[second] < 0)
    reach = np.minimum(room, widest_reach(angle, tolerance))
    curved = np.flatnonzero(~lines & ~straight & (tolerance > 0))
    reach[curved] = _fit_reach(curves, first[curved], second[curved], room[curved], tolerance[curved])
    return np.where(straight | (tolerance <= 0), 0.0, reach)


def needed_reach(turn: Array, bend: Array, speed: Array, limits: Limits) -> Array:
    """Return the d (k,) mm with which joints are passed at `speed` (k,) mm/s within acceleration and jerk; more would only cut corners.

    A change of direction u requires a second derivative of 3/4 u / d and a third of 3/2 u / d^2, a change of curvature c
    alone for a third of at most 3 c / 2d; speed^2 times the second may take 0.6 of the acceleration, speed^3 times the
    third half of the jerk (vcmm.shop.motion.timing).
    """
    v = np.where(np.isfinite(speed), speed, 1e9)[:, None]
    a, j = 0.6 * limits.acceleration, 0.5 * limits.jerk
    u, c = np.abs(turn), np.abs(bend)
    wanted = np.maximum(0.75 * u * v**2 / a, np.sqrt(1.5 * u * v**3 / j)) + 1.5 * c * v**3 / j
    return np.asarray(1.1 * wanted.max(axis=1))


def _room(curves: Curves, which: Ints) -> Array:
    """Return the length of a curve, of an arc no more than a quarter turn."""
    arc = curves.arc[which]
    sweep = np.where(arc >= 0, np.append(curves.sweep, 1.0)[arc], 1.0)
    return curves.length[which] * np.minimum(1.0, 0.5 * np.pi / sweep)


def _fit_reach(curves: Curves, first: Ints, second: Ints, room: Array, tolerance: Array) -> Array:
    """Return the reach at which the deviation meets the tolerance, from above; it grows with d (corner) or d^2 (tangent)."""
    reach, left = room.copy(), np.arange(len(room))
    for _ in range(60):
        deviation = deviations(curves, first[left], second[left], reach[left], reach[left])
        wide = deviation > tolerance[left]
        left = left[wide]
        if not len(left):
            break
        reach[left] *= np.minimum(0.98, 0.99 * np.sqrt(tolerance[left] / deviation[wide]))
    reach[left] = 0.0
    return reach


def deviations(curves: Curves, first: Ints, second: Ints, before: Array, after: Array) -> Array:
    """Return the largest distance (k,) mm between rounding and programmed path at the same s; rotary axes at their arm."""
    length = before + after
    blend = Curves(
        blend_coefficients(curves, first, second, before, after),
        length,
        np.full(len(length), -1, dtype=np.intp),
        curves.sweep,
        curves.cosine,
        curves.sine,
    )
    which, worst = np.arange(len(length)), np.zeros(len(length))
    for s in (before, *(length * place for place in CHECK_SHARES)):
        early = (s < before)[:, None]
        on_first = curves.at(first, curves.length[first] - np.maximum(before - s, 0.0))
        programmed = np.where(early, on_first, curves.at(second, np.maximum(s - before, 0.0)))
        gap = (blend.at(which, s) - programmed) * WEIGHT
        worst = np.maximum(worst, np.linalg.norm(gap, axis=1))
    return worst


def blend_coefficients(curves: Curves, first: Ints, second: Ints, before: Array, after: Array) -> Array:
    """Return the coefficients (k, 6, 6) of the roundings: Hermite interpolation of fifth degree from `before` to `after` the joint."""
    leave, join, h = curves.length[first] - before, after, (before + after)[:, None]
    p0, v0, a0 = (curves.at(first, leave, order) * h**order for order in range(3))
    p1, v1, a1 = (curves.at(second, join, order) * h**order for order in range(3))
    step = p1 - p0
    return np.stack(
        [
            p0,
            v0,
            0.5 * a0,
            10 * step - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
            -15 * step + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
            6 * step - 3 * (v0 + v1) - 0.5 * (a0 - a1),
        ],
        axis=1,
    )
