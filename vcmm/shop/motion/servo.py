"""The nominal servo: each axis follows its command as a first-order position loop with speed feed-forward.

    y = G x,   G = (Kv + kff s) / (s + Kv)   or   y = x - (1 - kff) e,   lag e' + e = lag x',   lag = 1 / Kv.

On a circle of radius R at speed v the amplitude of both axes changes by |G(v/R)|; to second order the circle shrinks by
dR = R/2 (v / (R Kv))^2 (1 - kff^2). Between knots the speed is a cubic in time (speed and acceleration at both ends),
and the response to it is exact. The deviation is taken at the same point of the path, so that a delay that all axes
share does not count on a straight line. The control waits in position at every stop: each stretch starts settled.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.motion.curves import Ints
from vcmm.shop.motion.timing import Timing

STEPS = 12  # of Newton, to find when the axes are abreast of a point; a handful on a smooth path
WINDOW, THIRDS = 12, 30  # time constants that are scanned, narrowings: exp(-12) of a lag of 1 mm is 6 nm
LEAST_TIME = 1e-10  # s
FINE = 0.25  # time constants between the knots at which the lag is written down
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, eq=False)
class Following:
    """Lag e (n, 3) mm of the linear axes at the knots, and the data for values between them."""

    time: Array
    begins: np.typing.NDArray[np.bool_]  # knots at which a stretch starts
    speed: Array
    acceleration: Array
    error: Array
    lag: Array

    def at(self, times: Array, begin: Ints, end: Ints) -> Array:
        """Return e (k, 3) at times within or after the stretch whose first and last knots are begin, end (k,)."""
        knot = np.clip(np.searchsorted(self.time, times, side="right") - 1, begin, np.maximum(end - 1, begin))
        after = np.minimum(knot + 1, end)
        length = np.where(after > knot, self.time[after] - self.time[knot], 1.0)
        inside = np.clip(times - self.time[knot], 0.0, length)
        late = np.maximum(times - self.time[end], 0.0)
        keep, gain = _response(self, knot, after, inside, length)
        e = keep * self.error[knot] + gain
        with np.errstate(divide="ignore"):
            rate = np.where(self.lag > 0, 1.0 / self.lag, 0.0)
        out: Array = e * np.exp(-late[:, None] * rate)
        return out


def following(
    time: Array, begins: np.typing.NDArray[np.bool_], speed: Array, acceleration: Array, lag: Array
) -> Following:
    """Return the lag of each axis behind its command at knots (n,) with speeds and accelerations (n, 3); lag = 1/Kv (3,) s."""
    from vcmm.shop.motion._timing_kernels import fading_sum

    blank = Following(time, begins, speed, acceleration, np.zeros_like(speed), lag)
    n = len(time)
    if n < 2:
        return blank
    before, after = np.arange(n - 1), np.arange(1, n)
    length = np.where(np.diff(time) > 0, np.diff(time), 1.0)  # two stretches may meet at the same time
    keep, gain = _response(blank, before, after, length, length)
    keep[begins[1:]], gain[begins[1:]] = 0.0, 0.0
    error = np.stack([fading_sum(keep[:, a].copy(), gain[:, a].copy()) for a in range(3)], axis=1)
    return Following(time, begins, speed, acceleration, error, lag)


def _response(f: Following, before: Ints, after: Ints, since: Array, length: Array) -> tuple[Array, Array]:
    """Return (remaining share of e, addition by the speed) `since` seconds after the knot `before`, (k, 3) each.

    Added: integral of exp(-(since - t) / lag) v(t) dt, in closed form; up to 3 time constants by Gauss-Legendre with 8
    nodes instead (exact to rounding there), since the closed form subtracts large terms.
    """
    out_keep, out_gain = np.zeros((len(since), 3)), np.zeros((len(since), 3))
    for axis in range(3):
        tau = f.lag[axis]
        if tau == 0.0:
            continue
        c = _cubic(f.speed[:, axis], f.acceleration[:, axis], before, after, length)
        out_keep[:, axis] = np.exp(-since / tau)
        out_gain[:, axis] = np.where(
            since < 3.0 * tau, _by_quadrature(c, since, tau), _by_polynomial(c, since, tau)
        )
    return out_keep, out_gain


def _cubic(v: Array, a: Array, before: Ints, after: Ints, length: Array) -> tuple[Array, Array, Array, Array]:
    """Return the coefficients of the cubic with these values and slopes at both ends (Hermite)."""
    step = (v[after] - v[before]) / length
    c2 = (3 * step - 2 * a[before] - a[after]) / length
    c3 = (a[before] + a[after] - 2 * step) / length**2
    return v[before], a[before], c2, c3


def _by_quadrature(c: tuple[Array, Array, Array, Array], since: Array, tau: float) -> Array:
    total = np.zeros_like(since)
    for node, weight in zip(_NODES, _WEIGHTS):
        t = 0.5 * since * (1 + node)
        speed = c[0] + t * (c[1] + t * (c[2] + t * c[3]))
        total += 0.5 * weight * np.exp(-np.minimum(since - t, 50 * tau) / tau) * speed
    return total * since


def _by_polynomial(c: tuple[Array, Array, Array, Array], since: Array, tau: float) -> Array:
    """Evaluate tau (v - tau v' + tau^2 v'' - tau^3 v'''), which solves tau e' + e = tau v for a cubic v."""

    def steady(t: Array | float) -> Array:
        v = c[0] + t * (c[1] + t * (c[2] + t * c[3]))
        slope, bend = c[1] + t * (2 * c[2] + 3 * t * c[3]), 2 * c[2] + 6 * t * c[3]
        out: Array = tau * (v - tau * (slope - tau * (bend - tau * 6 * c[3])))
        return out

    return steady(since) - steady(0.0) * np.exp(-since / tau)


def contour_deviation(timing: Timing, s: Array, time: Array, stretch: Ints) -> Array:
    """Return followed path less commanded path at the same path point (n, 3) mm, for knots (n,) as of `knots_of`.

    The axes are abreast of a point x when (y(t) - x) · tangent = 0, found by Newton from the common delay. Where that
    leads nowhere (short moves at corners) the nearest point of the followed path counts.
    """
    share = 1.0 - timing.limits.feed_forward[:3]
    out = np.zeros((len(s), 3))
    if not (share * timing.limits.lag[:3]).any() or not len(s):
        return out
    f = _followed_timing(timing, time, stretch)
    rest = np.zeros(len(s))
    here = timing.state_on_path(s, np.ones(len(s)), rest, rest, stretch)
    tangent, point = _unit(here.speed[:, :3]), here.position[:, :3]
    begin = np.flatnonzero(f.begins)[stretch]
    end = np.append(np.flatnonzero(f.begins)[1:], len(f.time))[stretch] - 1
    settles = np.append(np.diff(stretch) > 0, True)  # at a stop the axes settle on the point
    rows = np.flatnonzero(~settles & (np.abs(tangent).max(axis=1) > 0))
    places = _Places(timing, f, point[rows], begin[rows], end[rows], share)
    guess = np.einsum("ka,a->k", tangent[rows] ** 2, share * f.lag)
    gap, done = _abreast(places, tangent[rows], time[rows] + guess)
    far = np.flatnonzero(~done)
    gap[far] = _nearest(places.take(far), time[rows[far]])
    out[rows] = gap
    return out


def _followed_timing(timing: Timing, time: Array, stretch: Ints) -> Following:
    """Return the lag along a whole program, from knots (n,) made denser until they resolve the shortest time constant."""
    lag = timing.limits.lag[:3]
    widest = FINE * lag[lag > 0].min()
    length = np.diff(time, append=time[-1])
    parts = np.maximum(np.ceil(length / widest), 1).astype(np.intp)
    parts[np.append(np.diff(stretch) > 0, True)] = 1
    knot = np.repeat(np.arange(len(time)), parts)
    within = np.arange(len(knot)) - np.repeat(np.cumsum(parts) - parts, parts)
    fine = time[knot] + length[knot] * within / parts[knot]
    fresh = (within == 0) & np.append(True, np.diff(stretch) > 0)[knot]
    settled = (within == 0) & np.append(np.diff(stretch) > 0, True)[knot]
    state = timing.state(fine)
    resting = (fresh | settled)[:, None]
    speed, acceleration = (np.where(resting, 0.0, x[:, :3]) for x in (state.speed, state.acceleration))
    return following(fine, fresh, speed, acceleration, lag)


@dataclass(frozen=True, eq=False)
class _Places:
    """Points (k, 3) of the path, each with the first and last knot of its stretch."""

    timing: Timing
    f: Following
    point: Array
    begin: Ints
    end: Ints
    share: Array

    def take(self, rows: Ints) -> _Places:
        return _Places(self.timing, self.f, self.point[rows], self.begin[rows], self.end[rows], self.share)

    def gap(self, t: Array) -> tuple[Array, Array]:
        """Return (followed position at t less the point, its speed), (k, 3) each."""
        y, rate = _follow(self.timing, self.f, t, self.begin, self.end, self.share)
        return y - self.point, rate


def _abreast(places: _Places, tangent: Array, start: Array) -> tuple[Array, np.typing.NDArray[np.bool_]]:
    """Return (gap (k, 3) when the axes are abreast of the points, whether that was found near the start)."""
    widest = float((places.share * places.f.lag).max())
    t, gap = start.copy(), np.zeros((len(start), 3))
    left = np.arange(len(start))
    for _ in range(STEPS):
        part = places.take(left)
        gap[left], rate = part.gap(t[left])
        along = np.einsum("ka,ka->k", rate, tangent[left])
        step = -np.einsum("ka,ka->k", gap[left], tangent[left]) / np.where(along > 0, along, np.inf)
        t[left] += np.clip(step, -widest, widest)
        near = (np.abs(t[left] - start[left]) < 2 * widest) & (along > 0)
        left = left[near & (np.abs(step) > LEAST_TIME)]
        if not len(left):
            break
    along = np.einsum("ka,ka->k", gap, tangent)
    size = np.linalg.norm(gap, axis=1)
    done = (np.abs(along) < 1e-6) & (np.abs(t - start) < 2 * widest) & (size < 1.0)
    return gap, done


def _nearest(places: _Places, time: Array) -> Array:
    """Return the gap (k, 3) to the nearest point of the followed path up to WINDOW time constants later: scan, then thirds."""
    if not len(time):
        return np.zeros((0, 3))
    widest = float(places.f.lag.max())
    tried = widest * np.linspace(0.0, WINDOW, 1 + 8 * WINDOW)
    distance = np.stack([np.linalg.norm(places.gap(time + late)[0], axis=1) for late in tried])
    best = time + tried[distance.argmin(axis=0)]
    low, high = np.maximum(best - tried[1], time), best + tried[1]
    for _ in range(THIRDS):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        nearer = np.linalg.norm(places.gap(a)[0], axis=1) < np.linalg.norm(places.gap(b)[0], axis=1)
        low, high = np.where(nearer, low, a), np.where(nearer, b, high)
    return places.gap(0.5 * (low + high))[0]


def _unit(vectors: Array) -> Array:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    out: Array = vectors / np.where(size > 0, size, 1.0)
    return out


def _follow(
    timing: Timing, f: Following, t: Array, begin: Ints, end: Ints, share: Array
) -> tuple[Array, Array]:
    """Return the position and speed (k, 3) of the axes that follow, at times t within or after their stretch."""
    commanded = timing.state(np.minimum(t, f.time[end]))
    e = f.at(t, begin, end)
    speed = np.where((t < f.time[end])[:, None], commanded.speed[:, :3], 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.where(f.lag > 0, speed - e / f.lag, 0.0)
    return commanded.position[:, :3] - share * e, speed - share * change
