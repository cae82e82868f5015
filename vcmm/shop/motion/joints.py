"""Joints between two moves of a program, where the control stops, waits, rounds the corner or runs through.

It stops: before and after a rapid (`rapid_stop`), at an exact stop, a dwell, a tool change, a new tool length, where a
thread begins or ends, where the path turns back, where rotary axes alone take over, and at a corner that must not be
rounded (tolerance 0).

A corner is rounded, or the axes stop there, whichever takes less time. To run round a corner within a small tolerance the axes must have braked to a low steady speed before it and may speed up only behind
it; with limited jerk that may take longer than to brake to rest and start again. A control that looks ahead takes the faster
of the two. Both are compared over the halves of the two ways beside the corner, from speed limit to speed limit:

    stop    half of an S-curve from rest to rest over the whole way
    round   half of an S-curve from v to v over the way less the two roundings, and d / v on either rounding

v: the steady speed of the rounding, q'' <= 3/4 |u| / d with 0.6 of the acceleration and q''' <= 3/2 |u| / d^2 with half of the jerk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.program.limits import LEAST_PAUSE, Control, Limits
from vcmm.program.moves import Move
from vcmm.shop.motion.blend import (
    STRAIGHT,
    direction_jump,
    needed_reach,
    reach_of_blends,
    turns_back,
)
from vcmm.shop.motion.curves import LEAST_MOVE_MM, Curves, Ints
from vcmm.shop.motion.smoothing import PathWishes, Pieces, crowded_joints, no_pieces, smooth_pieces

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
    """Return the time (k,) s from speed v up towards `top` and back to v over a length, by S-curves (vcmm.shop.motion.elements)."""
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


GAP = 1e-6  # mm or rad between the end of a move and the start of the next: something moved the axes unseen
Bools = np.typing.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Joints:
    """For n moving moves: pause (n+1,) s before, between and after them; for the joints between them (n-1,):

    reach: mm, how far the rounding of a corner reaches into either move, 0 for none.   stop: where the motion comes to rest.
    is_ordered: stops that do not depend on how corners are taken.   is_rounded: corners that are rounded, no tangent joints.
    is_held: corners at which a stop is faster.   is_overlapped: those of them at which the next move starts before the one before
    has ended; these are no stops.   tolerance: mm.   smooth: rows of short lines.
    """

    reach: Array
    smooth: Pieces
    stop: Bools
    pause: Array
    tool_changes: int
    is_ordered: Bools
    is_rounded: Bools
    is_held: Bools
    is_overlapped: Bools
    tolerance: Array


@dataclass(frozen=True, eq=False)
class Wish:
    """Trial values of a plan, for the joints (n-1,): corners at which to stop, tolerances to keep below, further stops. None: no change."""

    halt: Bools | None = None
    below: Array | None = None
    stop: Bools | None = None
    kernel: bool = True


def joints_of(
    moves: Sequence[Move], moving: Ints, curves: Curves, control: Control, limits: Limits, wish: Wish = Wish()
) -> Joints:
    """Return the joints. curves: those of the moving moves only, in order.

    No corner is rounded more than its feed requires, and none where stopping is faster.
    """
    pause, changes, apart = _pauses(moves, moving, control)
    between = pause[1:-1] if len(moving) else np.zeros(0)
    first, second = np.arange(len(moving) - 1), np.arange(1, len(moving))
    if len(moving) < 2:
        no = np.zeros(0, dtype=bool)
        return Joints(
            reach=np.zeros(0), smooth=no_pieces(len(moving)), stop=no, pause=pause, tool_changes=changes, is_ordered=no,
            is_rounded=no, is_held=no, is_overlapped=no, tolerance=np.zeros(0),
        )  # fmt: skip
    kept = [moves[i] for i in moving]
    stop = _ordered_stops(kept, control) | (between > 0) | apart[1:-1]
    stop |= _rotary_takes_over(curves, first, second) | turns_back(curves, first, second)
    apart_in_space = _gaps(curves, first, second) > GAP
    pause[1:-1] += np.where(apart_in_space & (between == 0), LEAST_PAUSE, 0.0)
    stop |= apart_in_space
    tolerance = np.array(
        [control.tolerance if m.tolerance is None else m.tolerance for m in kept[:-1]], dtype=float
    )
    if wish.stop is not None:
        stop |= wish.stop
    if wish.below is not None:
        tolerance = np.minimum(tolerance, wish.below)
    reach = reach_of_blends(curves, first, second, np.where(stop, 0.0, tolerance))
    turn, bend = direction_jump(curves, first, second)
    feed = _feed(kept)
    reach = np.minimum(reach, needed_reach(turn, bend, np.minimum(feed[:-1], feed[1:]), limits))
    straight = (np.abs(turn).max(axis=1) < STRAIGHT) & (np.abs(bend).max(axis=1) < STRAIGHT)
    stop |= ~straight & (reach < LEAST_MOVE_MM)
    reach = np.where(stop, 0.0, reach)
    chosen = crowded_joints(curves, reach, tolerance, stop)
    speed, alone = np.minimum(feed, _fastest(curves, limits)), np.where(chosen, 0.0, reach)
    corner = is_corner(turn, alone)
    is_held = corner & wish.halt if wish.halt is not None else np.zeros_like(stop)
    is_held |= stops_that_pay(curves, turn, alone, stop | (alone > 0), speed, limits)
    ordered = stop
    stop, alone = stop | is_held, np.where(is_held, 0.0, alone)
    stops = np.concatenate([[0.0], np.cumsum(curves.length)[:-1][stop], [curves.length.sum()]])
    narrow, jerk = _per_line(np.where(chosen, tolerance, np.inf)), path_limits(curves, limits)[1]
    smooth = smooth_pieces(curves, chosen, alone, PathWishes(speed, narrow, jerk, stops, limits, wish.kernel))
    return Joints(
        reach=alone, smooth=smooth, stop=stop, pause=pause, tool_changes=changes, is_ordered=ordered,
        is_rounded=corner & ~is_held, is_held=is_held, is_overlapped=np.zeros_like(is_held), tolerance=tolerance,
    )  # fmt: skip


def _feed(moves: Sequence[Move]) -> Array:
    """Return the feed (n,) mm/s, infinite for rapids."""
    return np.array([np.inf if m.feed is None else m.feed / 60.0 for m in moves])


def _fastest(curves: Curves, limits: Limits) -> Array:
    """Return the speed (n,) mm/s that the axes allow at the start of each curve."""
    direction = np.abs(curves.at(np.arange(curves.n), np.zeros(curves.n), 1))
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / (direction / limits.speed).max(axis=1))


def _per_line(tolerance: Array) -> Array:
    """Return the smaller tolerance (n,) of the joints (n-1,) at both ends of a move; infinite where neither is smoothed."""
    return np.minimum(np.append(tolerance, np.inf), np.insert(tolerance, 0, np.inf))


def _pauses(moves: Sequence[Move], moving: Ints, control: Control) -> tuple[Array, int, Bools]:
    """Return (pause (n+1,), tool changes, stops required by moves without motion (n+1,))."""
    place = np.searchsorted(moving, np.arange(len(moves)), side="left")  # moving moves before each move
    pause, changes = np.zeros(len(moving) + 1), 0
    apart = np.zeros(len(moving) + 1, dtype=bool)
    is_moving = np.zeros(len(moves), dtype=bool)
    is_moving[moving] = True
    for i, move in enumerate(moves):
        if move.kind == "dwell":
            pause[place[i]] += move.seconds
        if not is_moving[i]:
            apart[place[i]] |= move.exact_stop or move.kind == "dwell"
        if i == 0:
            continue
        if move.tool != moves[i - 1].tool:
            pause[place[i]] += max(control.tool_change, LEAST_PAUSE)
            changes += 1
        elif move.tool_offset != moves[i - 1].tool_offset:
            pause[place[i]] += LEAST_PAUSE
    return pause, changes, apart


def _ordered_stops(moves: Sequence[Move], control: Control) -> Bools:
    """Return the stops that follow from the kinds of two neighbours."""
    rapid = np.array([m.kind == "rapid" for m in moves])
    thread = np.array([m.kind == "thread" for m in moves])
    stop = np.array([m.exact_stop for m in moves[:-1]]) | (thread[1:] != thread[:-1])
    return stop | (rapid[1:] | rapid[:-1]) if control.rapid_stop else stop


def _rotary_takes_over(curves: Curves, first: Ints, second: Ints) -> Bools:
    """Return where s changes between mm and degrees."""
    linear = np.abs(curves.at(np.arange(curves.n), np.zeros(curves.n), 1)[:, :3]).max(axis=1) > 0
    return linear[first] != linear[second]


def _gaps(curves: Curves, first: Ints, second: Ints) -> Array:
    """Return the distance between the end of one move and the start of the next."""
    gap = curves.at(second, np.zeros(len(second))) - curves.at(first, curves.length[first])
    return np.abs(gap).max(axis=1)
