"""Curves of moves and rounded corners, as functions of the distance s along them.

    q(u) = c0 + c1 u + ... + c5 u^5  +  P cos(sweep u) + Q sin(sweep u),     u = s / length

for the six axes XYZABC at once (mm, rad). A line has c0 and c1, an arc also the turning part, a rounded corner is a
polynomial. An arc whose end lies off its circle (rounded numbers in the program) closes the gap evenly along its way.

s is the programmed distance: mm along X, Y and Z, rotary axes going along; degrees where only rotary axes move, which
is how RS274/NGC reads a feed there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.program.moves import PLANES, Move

LEAST_MOVE_MM = 1e-9  # mm: a move shorter than this is none
MANY = 5_000  # places from which polynomials are compiled
Ints = np.typing.NDArray[np.intp]
FACTORS = np.array(
    [[1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20], [0, 0, 0, 6, 24, 60]], dtype=float
)


@dataclass(frozen=True, eq=False)
class Curves:
    """n curves: coefficients (n, 6 powers, 6 axes), length (n,), arc (n,) row of the turning part or -1.

    spread (n, 2), where there is one: polynomials whose u is a time, s = d1 (1 - (1 - u)^3) + d2 u^3 with d1, d2 mm; else 0 and u = s / length.
    """

    coefficients: Array
    length: Array
    arc: Ints
    sweep: Array  # (m,) rad, positive
    cosine: Array  # (m, 6)
    sine: Array  # (m, 6), which holds the sense of the turn
    spread: Array | None = None

    @property
    def n(self) -> int:
        return len(self.length)

    def at(self, which: Ints, s: Array, order: int = 0) -> Array:
        """Return the derivative of q by s of that order (k, 6), at distances s (k,) along the curves `which` (k,)."""
        u, length = s / self.length[which], self.length[which]
        out = _sum_of_powers(self.coefficients, which, u, order)
        arc = self.arc[which]
        rows = np.flatnonzero(arc >= 0)
        if len(rows):
            out[rows] += self._turning(arc[rows], u[rows], order)
        out = out / length[:, None] ** order
        if self.spread is not None:
            timed = np.flatnonzero(self.spread[which].any(axis=1))
            out[timed] = self._derivative_in_time(which[timed], s[timed], order)
        return np.asarray(out)

    def _derivative_in_time(self, which: Ints, s: Array, order: int) -> Array:
        """Return the derivative by s where u is a time: q_u = q_s s_u and so on, solved for q_s, q_ss, q_sss."""
        assert self.spread is not None
        d = self.spread[which]
        u = _time_share(d, s)
        q = [_polynomial(self.coefficients[which], u, k) for k in range(order + 1)]
        if order == 0:
            return q[0]
        s1 = 3 * (d[:, 0] * (1 - u) ** 2 + d[:, 1] * u**2)[:, None]
        s2, s3 = 6 * (d[:, 1] * u - d[:, 0] * (1 - u))[:, None], 6 * d.sum(axis=1)[:, None]
        first = q[1] / s1
        if order == 1:
            return np.asarray(first)
        second = (q[2] - first * s2) / s1**2
        return np.asarray(second if order == 2 else (q[3] - 3 * second * s1 * s2 - first * s3) / s1**3)

    def _turning(self, arc: Ints, u: Array, order: int) -> Array:
        phase = self.sweep[arc] * u + order * np.pi / 2
        both = np.cos(phase)[:, None] * self.cosine[arc] + np.sin(phase)[:, None] * self.sine[arc]
        return both * self.sweep[arc][:, None] ** order

    def with_timed(self, coefficients: Array, spread: Array) -> Curves:
        """Return these curves followed by polynomials (k, 6, 6) in time; spread (k, 2)."""
        longer = self.with_polynomials(coefficients, spread.sum(axis=1))
        return replace(longer, spread=np.concatenate([np.zeros((self.n, 2)), spread]))

    def with_polynomials(self, coefficients: Array, length: Array) -> Curves:
        """Return these curves followed by polynomials."""
        return Curves(
            np.concatenate([self.coefficients, coefficients]),
            np.concatenate([self.length, length]),
            np.concatenate([self.arc, np.full(len(length), -1, dtype=np.intp)]),
            self.sweep,
            self.cosine,
            self.sine,
        )


def _sum_of_powers(coefficients: Array, which: Ints, u: Array, order: int) -> Array:
    """Return the derivative by u of that order (k, 6) of the polynomials `which` (k,) at u (k,), by Horner."""
    if len(u) >= MANY:
        from vcmm.shop.motion._curve_kernels import polynomials

        return np.asarray(polynomials(coefficients, FACTORS, which, u, order))
    out = np.zeros((len(u), 6))
    for power in range(5, order - 1, -1):
        out *= u[:, None]
        out += FACTORS[order, power] * coefficients[which, power]
    return out


def _polynomial(coefficients: Array, u: Array, order: int) -> Array:
    out = np.zeros((len(u), 6))
    for power in range(5, order - 1, -1):
        out = out * u[:, None] + FACTORS[order, power] * coefficients[:, power]
    return out


def _time_share(d: Array, s: Array) -> Array:
    """Return u (k,) at which d1 (1 - (1 - u)^3) + d2 u^3 = s, by Newton within halving brackets; it grows with u."""
    low, high = np.zeros(len(s)), np.ones(len(s))
    u = np.clip(s / d.sum(axis=1), 0.0, 1.0)
    for _ in range(60):
        miss = d[:, 0] * (1 - (1 - u) ** 3) + d[:, 1] * u**3 - s
        low, high = np.where(miss < 0, u, low), np.where(miss > 0, u, high)
        guess = u - miss / (3 * (d[:, 0] * (1 - u) ** 2 + d[:, 1] * u**2))
        better = np.where((guess >= low) & (guess <= high), guess, 0.5 * (low + high))
        change = np.abs(better - u).max(initial=0.0)
        u = np.where(miss == 0, u, better)
        if change < 1e-15:
            break
    return np.asarray(u)


def curves_of(moves: Sequence[Move]) -> Curves:
    """Return the curves of moves in axis positions: tip plus tool offset. A move without motion has length 0."""
    n = len(moves)
    start = _six([m.start for m in moves], [m.rotary_start for m in moves], [m.tool_offset for m in moves])
    end = _six([m.end for m in moves], [m.rotary_end for m in moves], [m.tool_offset for m in moves])
    coefficients = np.zeros((n, 6, 6))
    coefficients[:, 0], coefficients[:, 1] = start, end - start
    length = np.linalg.norm((end - start)[:, :3], axis=1)
    turning = np.linalg.norm(np.degrees((end - start)[:, 3:]), axis=1)
    length = np.where(length > LEAST_MOVE_MM, length, np.where(turning > LEAST_MOVE_MM, turning, 0.0))
    arc = np.full(n, -1, dtype=np.intp)
    rows = np.array([i for i, m in enumerate(moves) if m.centre is not None], dtype=np.intp)
    arc[rows] = np.arange(len(rows))
    sweep, cosine, sine, arc_length = _arcs([moves[i] for i in rows], rows, coefficients)
    length[rows] = arc_length
    return Curves(coefficients, length, arc, sweep, cosine, sine)


def _six(points: Sequence[object], rotary: Sequence[object], offsets: Sequence[object]) -> Array:
    out = np.zeros((len(points), 6))
    if len(points):
        out[:, :3] = np.array(points, dtype=float) + np.array(offsets, dtype=float)
        out[:, 3:] = np.array(rotary, dtype=float)
    return out


def _arcs(moves: Sequence[Move], rows: Ints, coefficients: Array) -> tuple[Array, Array, Array, Array]:
    """Return (sweep, cosine, sine, length) of arcs; writes centre and gap into their coefficients."""
    m = len(moves)
    planes = np.array([PLANES[move.plane] for move in moves], dtype=np.intp).reshape(m, 3)
    first, second, k = planes[:, 0], planes[:, 1], np.arange(m)
    offset = np.array([move.tool_offset for move in moves], dtype=float).reshape(m, 3)
    centre = np.array([move.centre for move in moves], dtype=float).reshape(m, 3) + offset
    begin, end = coefficients[rows, 0], coefficients[rows, 0] + coefficients[rows, 1]
    way = np.where([bool(move.clockwise) for move in moves], -1.0, 1.0)
    x0, y0 = begin[k, first] - centre[k, first], begin[k, second] - centre[k, second]
    x1, y1 = end[k, first] - centre[k, first], end[k, second] - centre[k, second]
    sweep = np.mod(way * (np.arctan2(y1, x1) - np.arctan2(y0, x0)), 2 * np.pi)
    sweep = np.where(sweep < 1e-8, sweep + 2 * np.pi, sweep)  # a full circle ends where it starts
    sweep = sweep + 2 * np.pi * (np.array([move.turns for move in moves], dtype=float) - 1)
    cosine, sine = np.zeros((m, 6)), np.zeros((m, 6))
    cosine[k, first], cosine[k, second] = x0, y0
    sine[k, first], sine[k, second] = -way * y0, way * x0
    c, s = np.cos(sweep), np.sin(sweep)
    for axis, from_centre in ((first, x1), (second, y1)):
        coefficients[rows, 0, axis] = centre[k, axis]
        coefficients[rows, 1, axis] = from_centre - cosine[k, axis] * c - sine[k, axis] * s
    rise = coefficients[rows, 1, planes[:, 2]]
    return sweep, cosine, sine, np.hypot(np.hypot(x0, y0) * sweep, rise)


def largest_derivatives(curves: Curves) -> tuple[Array, Array, Array]:
    """Return the largest |q'|, |q''|, |q'''| of each axis along each curve, (n, 6) each; for arcs the amplitude of the turn."""
    first, second, third = _polynomial_bounds(curves.coefficients)
    rows = np.flatnonzero(curves.arc >= 0)
    amplitude = np.hypot(curves.cosine, curves.sine)[curves.arc[rows]]
    sweep = curves.sweep[curves.arc[rows]][:, None]
    for bound, order in ((first, 1), (second, 2), (third, 3)):
        bound[rows] += amplitude * sweep**order
    length = np.where(curves.length > 0, curves.length, 1.0)[:, None]
    return first / length, second / length**2, third / length**3


def _polynomial_bounds(c: Array) -> tuple[Array, Array, Array]:
    """Return the largest |derivatives| by u over 0..1: the first by its Bezier polygon, the second and third exactly."""
    c1, c2, c3, c4, c5 = c[:, 1], 2 * c[:, 2], 3 * c[:, 3], 4 * c[:, 4], 5 * c[:, 5]
    polygon = np.stack(
        [c1, c1 + c2 / 4, c1 + c2 / 2 + c3 / 6, c1 + 3 * c2 / 4 + c3 / 2 + c4 / 4, c1 + c2 + c3 + c4 + c5]
    )
    first = np.abs(polygon).max(axis=0)
    a, b, g = 6 * c[:, 3], 24 * c[:, 4], 60 * c[:, 5]  # q''' = a + b u + g u^2
    third = np.maximum(np.abs(a), np.abs(a + b + g))
    vertex = _inside(-b, 2 * g)
    third = np.maximum(third, np.abs(a + b * vertex + g * vertex**2))
    second = np.maximum(np.abs(c2), np.abs(_second(c, np.ones_like(a))))
    bent = np.flatnonzero(
        c[:, 4:].any(axis=(1, 2))
    )  # up to cubics the second derivative is largest at an end
    if len(bent):
        a, b, g, c = a[bent], b[bent], g[bent], c[bent]
        second[bent] = np.maximum(second[bent], _largest_within(c, a, b, g))
    return first, second, third


def _largest_within(c: Array, a: Array, b: Array, g: Array) -> Array:
    """Return the largest |second derivative| (n, 6) where the third, a + b u + g u^2, vanishes within 0..1."""
    second, root = np.zeros_like(a), np.sqrt(np.maximum(b**2 - 4 * a * g, 0.0))
    for numerator, denominator in (
        (-b + root, 2 * g),
        (-b - root, 2 * g),
        (-a, b),
        (-2 * a, b + root),
        (-2 * a, b - root),
    ):
        second = np.maximum(second, np.abs(_second(c, _inside(numerator, denominator))))
    return second


def _second(c: Array, u: Array) -> Array:
    return 2 * c[:, 2] + u * (6 * c[:, 3] + u * (12 * c[:, 4] + u * 20 * c[:, 5]))


def _inside(numerator: Array, denominator: Array) -> Array:
    """Return the quotient, held within 0..1 (0 where it is not defined): any place of the interval does no harm."""
    safe = np.where(denominator == 0, 1.0, denominator)
    return np.clip(np.where(denominator == 0, 0.0, numerator / safe), 0.0, 1.0)
