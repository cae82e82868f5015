"""Knots: places along the path at which the motion is recorded. They do not depend on one another's spacing.

Every start of an element and of a phase is a knot, every end of a move, and every place where an axis turns back, so that distances since
reversal are exact; between them the path is divided evenly by length and by the height of its chord.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.shop.motion.curves import Curves, Ints, largest_derivatives
from vcmm.shop.motion.timing import Timing

Bools = np.typing.NDArray[np.bool_]
SAME_KNOT = 1e-9  # s and mm: knots closer than this are one
MOST_KNOTS = 10_000_000  # rows of a path: about 4 GB with their columns
HALVINGS = 50
LOOKS = 8  # parts of a rounding that are searched for a change of sign, one in each


def knots_of(timing: Timing, step: float, chord: float) -> tuple[Array, Array, Ints]:
    """Return (s, time, stretch) of the knots, (n,), in order of time."""
    e = timing.elements
    if not len(timing.first):
        return np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.intp)
    count = _divisions(timing, step, chord)
    element = np.repeat(np.arange(len(count)), count)
    within = np.arange(len(element)) - np.repeat(np.cumsum(count) - count, count)
    length = np.diff(e.edge)
    even = e.edge[element] + length[element] * within / count[element]
    of_element = np.repeat(np.arange(len(timing.first)), timing.last - timing.first + 1)
    special = np.concatenate([_turns(timing), timing.ends])
    s = np.concatenate([even, timing.phase[:, 0], special])
    owner = np.concatenate([of_element[element], timing.stretch, _stretch_of(timing, special, of_element)])
    inside = (s > e.edge[timing.first][owner] + SAME_KNOT) & (s < e.edge[timing.last + 1][owner] - SAME_KNOT)
    s, owner = s[inside], owner[inside]
    order = np.lexsort((s, owner))
    s, owner = s[order], owner[order]
    time = times_at(timing, s)
    near = (np.diff(time) <= SAME_KNOT) | ((np.diff(s) <= SAME_KNOT) & (np.diff(owner) == 0))
    apart = np.ones(len(s), dtype=bool)
    apart[1:] = ~near
    return _with_ends(timing, s[apart], time[apart], owner[apart])


def _divisions(timing: Timing, step: float, chord: float) -> Ints:
    """Return the parts (n,) of each element: length / step, and sagitta of a part, q_ss part^2 / 8, within the chord error."""
    e = timing.elements
    bend = np.linalg.norm(largest_derivatives(timing.curves)[1][:, :3], axis=1)[e.curve]
    length = np.diff(e.edge)
    parts = np.maximum(length / step, length * np.sqrt(bend / (8 * chord)))
    if parts.sum() > MOST_KNOTS:
        raise ModelLimit(
            f"the path is {length.sum():.3g} mm long: {parts.sum():.3g} rows at every {step:g} mm, at most {MOST_KNOTS:g} "
            "are calculated; check units, tool lengths and repeats, or split the program"
        )
    rounded = (timing.curves.arc[e.curve] < 0) & (bend > 0)
    least = np.where(rounded, 2, 1)  # the acceleration peaks amid a rounding
    out: Ints = np.maximum(np.ceil(parts * (1 - 1e-12)), least).astype(np.intp)
    return out


def _turns(timing: Timing) -> Array:
    """Return s (k,) at which an axis turns back within an element: q_s = 0 on arcs (at quadrants) and on roundings."""
    e, c = timing.elements, timing.curves
    places = [_quadrants(timing)]
    rounded = np.flatnonzero(
        (c.arc[e.curve] < 0) & (np.abs(c.coefficients[e.curve, 2:]).max(axis=(1, 2)) > 0)
    )
    length = np.diff(e.edge)[rounded] / LOOKS
    which = e.curve[rounded]
    slopes = [c.at(which, e.offset[rounded] + k * length, 1) for k in range(LOOKS + 1)]
    for k in range(LOOKS):
        for axis in np.flatnonzero(((slopes[k] * slopes[k + 1]) < 0).any(axis=0)):
            turns = np.flatnonzero(slopes[k][:, axis] * slopes[k + 1][:, axis] < 0)
            at = e.offset[rounded[turns]] + k * length[turns]
            zero = _zero(c, which[turns], int(axis), at, length[turns])
            places.append(e.edge[rounded[turns]] + zero - e.offset[rounded[turns]])
    return np.concatenate(places)


def _zero(curves: Curves, which: Ints, axis: int, begin: Array, length: Array) -> Array:
    """Return the distance along curves of the sign change of q_s of an axis between begin and begin + length, by halving."""
    low, high = begin.copy(), begin + length
    sign = np.sign(curves.at(which, low, 1)[:, axis])
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = curves.at(which, middle, 1)[:, axis] * sign > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)


def _quadrants(timing: Timing) -> Array:
    """Return where the axes of an arc turn back: tan(sweep u) = Q / P for each axis of its plane."""
    e, c = timing.elements, timing.curves
    places = [np.zeros(0)]
    for element in np.flatnonzero(c.arc[e.curve] >= 0):
        arc, length = c.arc[e.curve[element]], c.length[e.curve[element]]
        sweep, begin = c.sweep[arc], e.offset[element]
        span = e.edge[element + 1] - e.edge[element]
        for axis in np.flatnonzero(np.hypot(c.cosine[arc], c.sine[arc])):
            angle = np.arctan2(c.sine[arc, axis], c.cosine[arc, axis])
            n = np.arange(np.ceil((0 - angle) / np.pi), np.floor((sweep - angle) / np.pi) + 1)
            along = (angle + n * np.pi) / sweep * length - begin
            places.append(e.edge[element] + along[(along > 0) & (along < span)])
    return np.concatenate(places)


def _stretch_of(timing: Timing, s: Array, of_element: Ints) -> Ints:
    edge = timing.elements.edge
    out: Ints = of_element[np.clip(np.searchsorted(edge, s, side="right") - 1, 0, len(edge) - 2)]
    return out


def times_at(timing: Timing, s: Array) -> Array:
    """Return the time at which the path reaches s (n,), strictly inside the stretches: cubic of its phase, by guarded Newton."""
    row = np.clip(np.searchsorted(timing.phase[:, 0], s, side="right") - 1, 0, len(timing.phase) - 1)
    s0, v0, a0, jerk, length = timing.phase[row].T
    low, high = np.zeros(len(s)), length.copy()
    t = 0.5 * high
    out: Array = timing.start[row] + t
    open_ = np.arange(len(s))  # each place is looked for until its own time stands
    for _ in range(80):
        miss = s0 - s + t * (v0 + t * (a0 / 2 + t * jerk / 6))
        low, high = np.where(miss < 0, t, low), np.where(miss > 0, t, high)
        rate = v0 + t * (a0 + t * jerk / 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            guess = t - miss / rate
        better = np.where((guess > low) & (guess < high), guess, 0.5 * (low + high))
        better = np.where(miss == 0, t, better)
        on = np.abs(better - t) >= 1e-14
        t = better
        out[open_] = timing.start[row[open_]] + t
        if not on.any():
            break
        open_, t, low, high, s = open_[on], t[on], low[on], high[on], s[on]
        s0, v0, a0, jerk = s0[on], v0[on], a0[on], jerk[on]
    return out


def _with_ends(timing: Timing, s: Array, time: Array, owner: Ints) -> tuple[Array, Array, Ints]:
    """Return the knots with the two rest points of each stretch."""
    edge, stretches = timing.elements.edge, np.arange(len(timing.first))
    all_s = np.concatenate([edge[timing.first], s, edge[timing.last + 1]])
    all_time = np.concatenate([timing.stretch_starts, time, timing.stretch_ends])
    all_owner = np.concatenate([stretches, owner, stretches])
    order = np.lexsort((all_time, all_owner))
    return all_s[order], all_time[order], all_owner[order]


def rest_points(owner: Ints) -> tuple[Bools, Bools]:
    """Return the (first, last) knot of each stretch, (n,) each: there the axes are at rest."""
    change = np.diff(owner) > 0
    first = np.ones(min(len(owner), 1), dtype=bool)
    return np.concatenate([first, change]), np.concatenate([change, first])
