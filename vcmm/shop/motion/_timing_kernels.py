"""Numba twin of vcmm.shop.motion.elements, and the recursion of the servo lag. Private; imported inside the calling functions.

Same formulas in the same order; the slowest element and the largest needs of a stretch come from a tree of minima and
maxima instead of slices.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

Array = NDArray[Any]
SAME_SPEED_SHARE = 1e-9
HALVINGS = 60


@njit(cache=True)
def _transition_length(v0: float, v1: float, a: float, j: float) -> float:
    change = abs(v1 - v0)
    seconds = change / a + a / j if change * j > a * a else 2.0 * math.sqrt(change / j)
    return 0.5 * (v0 + v1) * seconds


@njit(cache=True)
def _rates(need: Array, v: float) -> tuple[float, float]:
    spare = 1.0 - need[4] * v * v * v
    a = (1.0 - need[1] * v * v) / need[0]
    if need[3] * v * a > 0.5 * spare:
        a = 0.5 * spare / (need[3] * v)
    return a, (spare - need[3] * v * a) / need[2]


@njit(cache=True)
def _both_lengths(v0: float, top: float, v1: float, need: Array) -> float:
    a, j = _rates(need, top)
    return _transition_length(v0, top, a, j) + _transition_length(top, v1, a, j)


@njit(cache=True)
def _peak_speed(v0: float, v1: float, top: float, length: float, need: Array) -> float:
    low, high = max(v0, v1), top
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _both_lengths(v0, middle, v1, need) <= length:
            low = middle
        else:
            high = middle
    return low


@njit(cache=True)
def _transition(out: Array, n: int, s: float, v0: float, v1: float, a: float, j: float) -> int:
    change = abs(v1 - v0)
    if change == 0.0:
        return n
    way = 1.0 if v1 > v0 else -1.0
    ramp, flat = math.sqrt(change / j), 0.0
    if change * j > a * a:
        ramp, flat = a / j, change / a - a / j
    v, now = v0, 0.0
    for phase in range(3):
        jerk = 0.0 if phase == 1 else (way * j if phase == 0 else -way * j)
        seconds = flat if phase == 1 else ramp
        if seconds > 0.0:
            out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = s, v, now, jerk, seconds
            n += 1
            s += seconds * (v + seconds * (now / 2 + seconds * jerk / 6))
            v += seconds * (now + seconds * jerk / 2)
            now += seconds * jerk
    return n


@njit(cache=True)
def _steady(out: Array, n: int, s: float, v: float, seconds: float) -> int:
    out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = s, v, 0.0, 0.0, seconds
    return n + 1


@njit(cache=True)
def _arch(out: Array, n: int, s0: float, v0: float, s1: float, v1: float, top: float, need: Array) -> int:
    length = s1 - s0
    if _both_lengths(v0, top, v1, need) > length:
        top = _peak_speed(v0, v1, top, length, need)
    a, j = _rates(need, top)
    up, down = _transition_length(v0, top, a, j), _transition_length(top, v1, a, j)
    n = _transition(out, n, s0, v0, top, a, j)
    if length - up - down > 0.0:
        n = _steady(out, n, s0 + up, top, (length - up - down) / top)
    return _transition(out, n, s1 - down, top, v1, a, j)


@njit(cache=True)
def _tree(speed: Array, needs: Array) -> tuple[Array, Array, Array, int]:
    """Build heap-ordered trees: index of the slowest element, highest speed, largest needs; leaves from `size` on."""
    n, size = len(speed), 1
    while size < n:
        size *= 2
    low = np.full(2 * size, -1, dtype=np.int64)
    high, most = np.zeros(2 * size), np.zeros((2 * size, 5))
    for i in range(n):
        low[size + i], high[size + i] = i, speed[i]
        most[size + i] = needs[i]
    for k in range(size - 1, 0, -1):
        low[k] = _slower(speed, low[2 * k], low[2 * k + 1])
        high[k] = max(high[2 * k], high[2 * k + 1])
        for c in range(5):
            most[k, c] = max(most[2 * k, c], most[2 * k + 1, c])
    return low, high, most, size


@njit(cache=True)
def _slower(speed: Array, a: int, b: int) -> int:
    """Return the slower of two elements, the earlier one of equals; -1 is none."""
    if a < 0 or b < 0:
        return max(a, b)
    if speed[a] < speed[b]:
        return a
    if speed[b] < speed[a]:
        return b
    return min(a, b)


@njit(cache=True)
def _ask(
    speed: Array, low: Array, high: Array, most: Array, size: int, e0: int, e1: int, need: Array
) -> tuple[int, float]:
    """Return (slowest element, highest speed) of e0..e1; writes the largest needs."""
    slowest, fastest = -1, 0.0
    need[:] = 0.0
    i, k = e0 + size, e1 + size + 1
    while i < k:
        if i & 1:
            slowest, fastest = _slower(speed, slowest, low[i]), max(fastest, high[i])
            for c in range(5):
                need[c] = max(need[c], most[i, c])
            i += 1
        if k & 1:
            k -= 1
            slowest, fastest = _slower(speed, slowest, low[k]), max(fastest, high[k])
            for c in range(5):
                need[c] = max(need[c], most[k, c])
        i //= 2
        k //= 2
    return slowest, fastest


@njit(cache=True)
def _push(
    kinds: Array, spans: Array, rows: Array, n: int, kind: int, e0: int, e1: int,
    s0: float, v0: float, s1: float, v1: float, a: float, j: float,
) -> int:  # fmt: skip
    kinds[n], rows[n, 0], rows[n, 1] = kind, e0, e1
    spans[n, 0], spans[n, 1], spans[n, 2], spans[n, 3], spans[n, 4], spans[n, 5] = s0, v0, s1, v1, a, j
    return n + 1


@njit(cache=True)
def plan_stretches(
    edge: Array, speed: Array, needs: Array, firsts: Array, lasts: Array
) -> tuple[Array, Array]:
    """Return (phases (k, 5), stretch of each phase (k,)) of all stretches from rest to rest."""
    n = len(speed)
    low, high, most, size = _tree(speed, needs)
    out, whose = np.empty((14 * n + 14, 5)), np.empty(14 * n + 14, dtype=np.int64)
    kinds, rows = np.empty(4 * n + 16, dtype=np.int64), np.empty((4 * n + 16, 2), dtype=np.int64)
    spans, need = np.empty((4 * n + 16, 6)), np.zeros(5)
    count = 0
    for g in range(len(firsts)):
        begun = count
        m = _push(
            kinds, spans, rows, 0, 0, firsts[g], lasts[g], edge[firsts[g]], 0.0, edge[lasts[g] + 1], 0.0, 0.0, 0.0
        )  # fmt: skip
        while m > 0:
            m -= 1
            kind, e0, e1 = kinds[m], rows[m, 0], rows[m, 1]
            s0, v0, s1, v1, a, j = (
                spans[m, 0],
                spans[m, 1],
                spans[m, 2],
                spans[m, 3],
                spans[m, 4],
                spans[m, 5],
            )
            if kind == 1:
                count = _transition(out, count, s0, v0, v1, a, j)
            elif kind == 2:
                count = _steady(out, count, s0, v0, (s1 - s0) / v0)
            else:
                slow, fastest = _ask(speed, low, high, most, size, e0, e1, need)
                top = speed[slow]
                if fastest <= top * (1 + SAME_SPEED_SHARE) or _both_lengths(v0, top, v1, need) >= s1 - s0:
                    count = _arch(out, count, s0, v0, s1, v1, top, need)
                else:
                    m = _divide(kinds, spans, rows, m, edge, e0, e1, s0, v0, s1, v1, slow, top, need)
        whose[begun:count] = g
    return out[:count].copy(), whose[:count].copy()


@njit(cache=True)
def _divide(
    kinds: Array, spans: Array, rows: Array, m: int, edge: Array, e0: int, e1: int,
    s0: float, v0: float, s1: float, v1: float, low: int, top: float, need: Array,
) -> int:  # fmt: skip
    a, j = _rates(need, top)
    reached = s0 + _transition_length(v0, top, a, j)
    left = s1 - _transition_length(top, v1, a, j)
    begin, end = max(edge[low], s0), min(edge[low + 1], s1)
    if end <= reached:
        there = int(np.searchsorted(edge, reached, side="right")) - 1
        m = _push(kinds, spans, rows, m, 0, there, e1, reached, top, s1, v1, 0.0, 0.0)
        return _push(kinds, spans, rows, m, 1, e0, low, s0, v0, reached, top, a, j)
    if begin >= left:
        there = int(np.searchsorted(edge, left, side="left")) - 1
        m = _push(kinds, spans, rows, m, 1, low, e1, left, top, s1, v1, a, j)
        return _push(kinds, spans, rows, m, 0, e0, there, s0, v0, left, top, 0.0, 0.0)
    if end < left:
        m = _push(kinds, spans, rows, m, 0, low + 1, e1, end, top, s1, v1, 0.0, 0.0)
    else:
        m = _push(kinds, spans, rows, m, 1, low, e1, left, top, s1, v1, a, j)
    m = _push(kinds, spans, rows, m, 2, low, low, max(begin, reached), top, min(end, left), top, 0.0, 0.0)
    if begin > reached:
        return _push(kinds, spans, rows, m, 0, e0, low - 1, s0, v0, begin, top, 0.0, 0.0)
    return _push(kinds, spans, rows, m, 1, e0, low, s0, v0, reached, top, a, j)


@njit(cache=True)
def fading_sum(keep: Array, gain: Array) -> Array:
    """Return e (n + 1,) with e[0] = 0 and e[k + 1] = keep[k] e[k] + gain[k]."""
    out = np.zeros(len(keep) + 1)
    for k in range(len(keep)):
        out[k + 1] = keep[k] * out[k] + gain[k]
    return out
