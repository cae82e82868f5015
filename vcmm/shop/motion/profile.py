"""Speed along a path: S-curves between the places that limit the speed. The readable twin of `_timing_kernels`.

A path is a row of elements with their own highest speed V. Along it the axes need, per unit of their limits,

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

import numpy as np

from vcmm.core.run import Array

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
