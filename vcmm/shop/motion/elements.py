"""Elements: the path piece by piece, each with its highest speed and its demands on the axes; S-curves between the places that limit the speed.

`plan_stretch` is the readable twin of `_timing_kernels`. A path is a row of elements with their own highest speed V. Along it the axes need, per unit of their limits,

    acceleration   p1 a + p2 v^2           <= 1        jerk   r1 j + r2 v a + r3 v^3  <= 1,

with a, j along the path: q'' = q' a + q_ss v^2 and q''' = q' j + 3 q_ss v a + q_sss v^3 by the chain rule. `rates`
gives the a and j that a stretch allows up to a speed. From rest to rest the slowest element is found, the path is taken
up to its speed by an S-curve (jerk, constant acceleration, jerk), along it and down again, and what lies before and
after it is treated in the same way with higher ends: look-ahead over the whole program (method of Erkorkmaz & Altintas,
Int. J. Mach. Tools Manuf. 41 (2001) 1323, for the seven phases).
Each phase is a row (s, v, a, jerk, seconds) of its start.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.program.limits import Limits
from vcmm.program.moves import Move
from vcmm.shop.motion.blend import blend_coefficients
from vcmm.shop.motion.curves import LEAST_MOVE_MM, Curves, Ints, largest_derivatives
from vcmm.shop.motion.joints import Joints

Need = tuple[float, float, float, float, float]
Phase = tuple[float, float, float, float, float]
SAME_SPEED_SHARE = 1e-9  # relative difference of speeds that is none
HALVINGS = 60


def transition_length(v0: float, v1: float, a: float, j: float) -> float:
    """Return the distance of an S-curve between two speeds: mean speed x time; jerk alone limits it while |dv| < a^2 / j."""
    change = abs(v1 - v0)
    seconds = change / a + a / j if change * j > a * a else 2.0 * math.sqrt(change / j)
    return 0.5 * (v0 + v1) * seconds


def rates(need: Need, v: float) -> tuple[float, float]:
    """Return the acceleration and jerk along the path that the axes allow up to speed v; half of the jerk that v leaves is for a v."""
    p1, p2, r1, r2, r3 = need
    spare = 1.0 - r3 * v * v * v
    a = (1.0 - p2 * v * v) / p1
    if r2 * v * a > 0.5 * spare:
        a = 0.5 * spare / (r2 * v)
    return a, (spare - r2 * v * a) / r1


def both_lengths(v0: float, top: float, v1: float, need: Need) -> float:
    """Return the distance needed from v0 over `top` to v1."""
    a, j = rates(need, top)
    return transition_length(v0, top, a, j) + transition_length(top, v1, a, j)


def peak_speed(v0: float, v1: float, top: float, length: float, need: Need) -> float:
    """Return the highest speed up to `top` that can be reached between v0 and v1 on this length."""
    low, high = max(v0, v1), top
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if both_lengths(v0, middle, v1, need) <= length:
            low = middle
        else:
            high = middle
    return low


def transition(s: float, v0: float, v1: float, a: float, j: float) -> list[Phase]:
    """Return the phases of an S-curve."""
    change = abs(v1 - v0)
    if change == 0.0:
        return []
    way = 1.0 if v1 > v0 else -1.0
    ramp, flat = ((a / j), change / a - a / j) if change * j > a * a else (math.sqrt(change / j), 0.0)
    out: list[Phase] = []
    v, now = v0, 0.0
    for jerk, seconds in ((way * j, ramp), (0.0, flat), (-way * j, ramp)):
        if seconds > 0.0:
            out.append((s, v, now, jerk, seconds))
            s += seconds * (v + seconds * (now / 2 + seconds * jerk / 6))
            v += seconds * (now + seconds * jerk / 2)
            now += seconds * jerk
    return out


def arch(s0: float, v0: float, s1: float, v1: float, top: float, need: Need) -> list[Phase]:
    """Return phases up from v0, along, and down to v1: as fast as `top` and the length allow."""
    length = s1 - s0
    if both_lengths(v0, top, v1, need) > length:
        top = peak_speed(v0, v1, top, length, need)
    a, j = rates(need, top)
    up, down = transition_length(v0, top, a, j), transition_length(top, v1, a, j)
    out = transition(s0, v0, top, a, j)
    if length - up - down > 0.0:
        out.append((s0 + up, top, 0.0, 0.0, (length - up - down) / top))
    return out + transition(s1 - down, top, v1, a, j)


def plan_stretch(edge: Array, speed: Array, needs: Array, first: int, last: int) -> list[Phase]:
    """Return phases from rest to rest over the elements first..last: edge (n+1,) mm, speed (n,) mm/s, needs (n, 5)."""
    out: list[Phase] = []
    waiting: list[tuple[int, float, float, int, float, float, int, float, float]] = [
        (0, edge[first], 0.0, first, edge[last + 1], 0.0, last, 0.0, 0.0)
    ]
    while waiting:
        kind, s0, v0, e0, s1, v1, e1, a, j = waiting.pop()
        if kind == 1:
            out += transition(s0, v0, v1, a, j)
            continue
        if kind == 2:
            out.append((s0, v0, 0.0, 0.0, (s1 - s0) / v0))
            continue
        inside = speed[e0 : e1 + 1]
        low = e0 + int(inside.argmin())
        top, most = float(speed[low]), needs[e0 : e1 + 1].max(axis=0).tolist()
        need: Need = (most[0], most[1], most[2], most[3], most[4])
        whole = inside.max() <= top * (1 + SAME_SPEED_SHARE)
        if whole or both_lengths(v0, top, v1, need) >= s1 - s0:
            out += arch(s0, v0, s1, v1, top, need)
            continue
        waiting += _divide(edge, (s0, v0, e0, s1, v1, e1), low, top, need)
    return out


def _divide(
    edge: Array, span: tuple[float, float, int, float, float, int], low: int, top: float, need: Need
) -> list[tuple[int, float, float, int, float, float, int, float, float]]:
    """Divide a stretch at its slowest element, last part first: 0 to be planned, 1 an S-curve, 2 steady."""
    s0, v0, e0, s1, v1, e1 = span
    a, j = rates(need, top)
    reached = s0 + transition_length(v0, top, a, j)
    left = s1 - transition_length(top, v1, a, j)
    begin, end = max(float(edge[low]), s0), min(float(edge[low + 1]), s1)
    up = (1, s0, v0, e0, reached, top, low, a, j)
    down = (1, left, top, low, s1, v1, e1, a, j)
    if end <= reached:  # still speeding up where the slowest element ends
        there = int(np.searchsorted(edge, reached, side="right")) - 1
        return [(0, reached, top, there, s1, v1, e1, 0.0, 0.0), up]
    if begin >= left:
        there = int(np.searchsorted(edge, left, side="left")) - 1
        return [down, (0, s0, v0, e0, left, top, there, 0.0, 0.0)]
    before = (0, s0, v0, e0, begin, top, low - 1, 0.0, 0.0) if begin > reached else up
    after = (0, end, top, low + 1, s1, v1, e1, 0.0, 0.0) if end < left else down
    steady = (2, max(begin, reached), top, low, min(end, left), top, low, 0.0, 0.0)
    return [after, steady, before]


ON_CURVES = 0.6  # share of the acceleration that a bend may take; the rest is for speeding up and braking
ON_ARCS = 0.8  # on arcs both are at right angles: 0.8 sideways leaves 0.6 along, 0.8^2 + 0.6^2 = 1
JERK_ON_CURVES = 0.5


@dataclass(frozen=True, eq=False)
class Elements:
    """The path piece by piece, rounded corners among them. edge (n+1,) programmed distance; speed (n,) highest."""

    edge: Array
    curve: Ints
    offset: Array
    speed: Array
    needs: Array  # (n, 5), see above


def elements_of(
    moves: Sequence[Move], curves_of_moves: Curves, joints: Joints, limits: Limits
) -> tuple[Elements, Curves, Ints, Ints]:
    """Return (elements, curves with the roundings behind those of the moves, first and last element of each stretch)."""
    n, rounded, smooth = curves_of_moves.n, np.flatnonzero(joints.reach > 0), joints.smooth
    reach = joints.reach[rounded]
    curves = curves_of_moves.with_polynomials(
        blend_coefficients(curves_of_moves, rounded, rounded + 1, reach, reach), 2 * reach
    )
    curves = curves.with_polynomials(smooth.coefficients, smooth.length)
    lead = np.concatenate([np.zeros(min(n, 1)), joints.reach])
    begins = np.cumsum(curves_of_moves.length) - curves_of_moves.length
    straight = curves_of_moves.length - lead - np.concatenate([joints.reach, np.zeros(min(n, 1))])
    kept = np.flatnonzero((straight > LEAST_MOVE_MM) & ~smooth.whole)
    corners, pieces = len(rounded), len(smooth.begin)
    kind = np.repeat([0, 0, 1], [len(kept), pieces, corners])  # a rounding comes after its move
    owner = np.concatenate([kept, smooth.move, rounded])
    starts = np.concatenate([begins[kept] + lead[kept], smooth.begin, begins[rounded + 1] - reach])
    order = np.lexsort((starts, kind, owner))
    curve = np.concatenate([kept, n + corners + np.arange(pieces), n + np.arange(corners)])[order]
    offset = np.concatenate([lead[kept], np.zeros(pieces + corners)])[order]
    feed = np.array([np.inf if m.feed is None else m.feed / 60.0 for m in moves])
    corner_feed = np.minimum(feed[rounded], feed[rounded + 1])
    feeds = np.concatenate([feed[kept], feed[smooth.move], corner_feed])[order]
    starts, owner = starts[order], owner[order]
    stops = np.flatnonzero(joints.stop)
    later: Ints = np.searchsorted(owner, stops, side="right")
    first = np.concatenate([np.zeros(min(n, 1), dtype=np.intp), later])
    last = np.append(first[1:], len(curve))[: len(first)] - 1
    edge = np.append(starts, begins[-1] + curves_of_moves.length[-1]) if n else np.zeros(1)
    edge[first] = np.append(0.0, begins[stops + 1])[: len(first)]
    speed, needs = _ability(curves, curve, feeds, limits)
    return Elements(edge, curve, offset, speed, needs), curves, first, last.astype(np.intp)


def _ability(curves: Curves, curve: Ints, feed: Array, limits: Limits) -> tuple[Array, Array]:
    """Return the highest speed (n,) and needs (n, 5) of the elements: demands on the axes per unit of path motion."""
    q1, q2, q3 = largest_derivatives(curves)
    arc = curves.arc >= 0
    p1, p2 = (q1 / limits.acceleration).max(axis=1), (q2 / limits.acceleration).max(axis=1)
    r1, r2, r3 = ((factor * q / limits.jerk).max(axis=1) for factor, q in ((1.0, q1), (3.0, q2), (1.0, q3)))
    with np.errstate(divide="ignore"):
        fastest = 1.0 / (q1 / limits.speed).max(axis=1)
        bend = np.sqrt(np.where(arc, ON_ARCS, ON_CURVES) / p2)
        jerk = np.cbrt(JERK_ON_CURVES / r3)
    speed = np.minimum(np.minimum(fastest, bend), jerk)[curve]
    half = np.where(arc, 0.5, 1.0)  # sqrt(1 - x^2) >= 1 - x/2 up to x = 0.8
    needs = np.stack([p1, half * p2, r1, r2, r3], axis=1)[curve]
    return np.minimum(speed, feed), needs


def plan_stretches(elements: Elements, first: Ints, last: Ints, kernel: bool) -> tuple[Array, Ints]:
    """Return (phases (k, 5), stretch of each phase) of stretches first..last of elements."""
    if not len(first):
        return np.zeros((0, 5)), np.zeros(0, dtype=np.intp)
    if kernel:
        from vcmm.shop.motion._timing_kernels import plan_stretches

        phase, stretch = plan_stretches(elements.edge, elements.speed, elements.needs, first, last)
        return phase, stretch.astype(np.intp)
    rows = [plan_stretch(elements.edge, elements.speed, elements.needs, a, b) for a, b in zip(first, last)]
    counts = [len(r) for r in rows]
    return np.array([phase for r in rows for phase in r]), np.repeat(np.arange(len(rows)), counts)
