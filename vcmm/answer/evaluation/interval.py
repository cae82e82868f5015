"""Exact distribution of a linear output y = mean + sum_j g_j x_j of independent inputs, without sampling.

The characteristic function of y is the product of those of its terms; Gil-Pelaez' formula turns it into

    P(Y <= y) = 1/2 - 1/pi * integral_0^inf Im[exp(-i t x) phi(t)] / t dt,      x = y - mean

(V. Witkovsky, Numerical inversion of a characteristic function: an alternative tool to form the probability
distribution of output quantity in linear measurement models, Acta IMEKO 5(3), 2016). He sums at equal steps,
which wraps heavy tails around; here Gauss-Legendre panels that shrink towards t = 0 take their place, so that
t-laws of any degrees of freedom, also those without a standard deviation, come out to about 1e-8 in
probability. Normal terms are merged; a sum of normals and a single term use the law itself.
Coverage intervals: JCGM 101:2008, 5.3 and 7.7.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.laws import Array, Law, Normal, Samples, StudentT

INTERVAL_KINDS = ("symmetric", "shortest")
_TAIL_SCALES = 200.0  # scales from the middle, beyond which the tails of the single terms add up
_LONGEST = 5e3  # upper end of the integral, in 1 / scale


def check_interval(p: float, kind: str, kinds: Sequence[str] = INTERVAL_KINDS) -> None:
    """Refuse a coverage probability outside (0, 1) and an unknown kind of interval (UsageError)."""
    if not 0 < p < 1:
        raise UsageError(f"Coverage probability p = {p} must lie between 0 and 1, for example 0.95.")
    if kind not in kinds:
        raise UsageError(f'Unknown kind of coverage interval "{kind}".{choose_from(kind, kinds)}')


@dataclass(frozen=True, eq=False)
class Linear:
    """y = mean + sum of gain * x over independent inputs x; `gains` pairs a scalar law with its gains (L,).

    Each gain has its own independent input of that law. `mean` is the estimate of y (laws are about zero).
    """

    mean: float
    gains: Sequence[tuple[Law, Array]]

    def reflect(self, about: float) -> Linear:
        """Return the law of about - y, mirrored."""
        return Linear(about - self.mean, [(law, -np.asarray(gain, float)) for law, gain in self.gains])

    @cached_property
    def u(self) -> float:
        """Standard uncertainty sqrt(sum (g u)^2); math.inf if a t-term has nu <= 2 (JCGM 100, 5.1.2)."""
        terms = [(law.u, g[g != 0]) for law, g in ((law, np.ravel(gain)) for law, gain in self.gains)]
        return math.sqrt(sum(u * u * float(g @ g) for u, g in terms if g.size))

    @cached_property
    def centre(self) -> float:
        """Mean of y: differs from `mean` when samples among the laws have a mean."""
        return self.mean + sum(law.mean * float(np.sum(gain)) for law, gain in self.gains)

    @cached_property
    def _groups(self) -> dict[Law, Array]:
        """Gains times scales of each standard shape; normal terms merged, zeros dropped."""
        groups: dict[Law, list[Array]] = {}
        for law, gain in self.gains:
            scaled = np.ravel(np.asarray(gain, float)) * law.scale
            groups.setdefault(law.shape, []).append(scaled[scaled != 0])
        merged = {shape: np.concatenate(parts) for shape, parts in groups.items()}
        if Normal(1.0) in merged:
            merged[Normal(1.0)] = np.array([np.linalg.norm(merged[Normal(1.0)])])
        return {shape: g for shape, g in merged.items() if g.any()}

    @cached_property
    def _single(self) -> tuple[Law, float] | None:
        """Standard law and factor when the sum has one term (or none): y - mean = factor * x."""
        count = sum(len(g) for g in self._groups.values())
        if count > 1:
            return None
        for shape, g in self._groups.items():
            return (
                (Samples(shape.values * g[0]), 1.0)
                if isinstance(shape, Samples)
                else (shape, abs(float(g[0])))
            )
        return Normal(0.0), 1.0

    @cached_property
    def scale(self) -> float:
        """A width that always exists: 1 / t where |cf(t)| falls to exp(-1/2), to 3 %; close to u."""
        widths = {shape: 1.0 if isinstance(shape, StudentT) else shape.u for shape in self._groups}
        start = math.sqrt(sum(float(g @ g) * widths[shape] ** 2 for shape, g in self._groups.items()))
        if start == 0:
            return 0.0
        t = np.geomspace(1e-3, 1e2, 400) / start
        return float(1 / t[np.argmax(np.abs(self.cf(t)) < math.exp(-0.5))])

    def cf(self, t: ArrayLike) -> Array:
        """Return the characteristic function of y - mean, elementwise; complex if samples are among the terms."""
        t = np.asarray(t, float)
        product: Array = np.ones(t.shape)
        for shape, g in self._groups.items():
            product = product * _group_cf(shape, g, t)
        return product

    @cached_property
    def _end(self) -> float:
        """Upper end of the integral (1/scale): |cf| / t below 1e-10, or 5e3."""
        t = np.geomspace(1.0, _LONGEST, 300)
        bound = np.ones(len(t))
        for shape, g in self._groups.items():
            by_table = isinstance(shape, StudentT)
            bound *= (
                _group_cf(shape, g, t / self.scale) if by_table else _product(shape.bound, g, t / self.scale)
            )
        done = bound / t < 1e-10
        return float(t[np.argmax(done)]) if done.any() else _LONGEST

    @cached_property
    def _memo(self) -> dict[float, tuple[Array, Array, Array]]:
        return {}

    def _nodes(self, reach: float) -> tuple[Array, Array, Array]:
        """Return t and weight * cf, both in units of the scale, fine enough for |x| <= reach scales; cached per reach."""
        if reach not in self._memo:
            finite = [shape for shape in self._groups if math.isfinite(shape.reach)]
            bounded = sum(shape.reach * float(np.abs(self._groups[shape]).sum()) for shape in finite)
            t, weight = _panels(self._end, min(2.0, 12.0 / (reach + bounded / self.scale)))
            phi = weight * self.cf(t / self.scale) / math.pi
            self._memo[reach] = t, phi.real.copy(), phi.imag.copy()
        return self._memo[reach]

    def _integrate(self, x: Array) -> tuple[Array, Array]:
        """Integrate: return P(X <= x) and its density, for x (n,) in scales from `mean`."""
        t, real, imaginary = self._nodes(_reach(x))
        below, density = np.empty(len(x)), np.empty(len(x))
        for s in np.array_split(np.arange(len(x)), len(x) * len(t) // 2_000_000 + 1):
            phase = np.multiply.outer(x[s], t)
            cosine, sine = np.cos(phase), np.sin(phase)
            below[s] = 0.5 + sine @ (real / t) - cosine @ (imaginary / t)
            density[s] = cosine @ real + sine @ imaginary
        return below, density

    def _tails(self, x: Array) -> Array:
        """Return P(X <= x) far out, where one term alone makes the deviation: the sum of the terms' tails."""
        lower = np.zeros(len(x))
        for shape, g in self._groups.items():
            ratio = np.abs(x)[:, None] / np.abs(g)
            same_side = np.sign(x)[:, None] * np.sign(g) > 0
            lower += np.where(same_side, 1 - shape.cdf(ratio), shape.cdf(-ratio)).sum(axis=1)
        return np.where(x > 0, 1 - lower, lower)

    def cdf(self, y: ArrayLike) -> Array:
        """Return P(Y <= y), elementwise, to about 1e-8 (1e-6 when every term has a bounded law)."""
        y = np.asarray(y, float)
        if self._single:
            law, factor = self._single
            return law.cdf((y - self.mean) / factor)
        x = (y.ravel() - self.mean) / self.scale
        out = np.empty(x.shape)
        near = np.abs(x) <= self._near
        if near.any():
            out[near] = self._integrate(x[near])[0]
        if not near.all():
            out[~near] = self._tails(x[~near] * self.scale)
        return np.clip(out, 0.0, 1.0).reshape(y.shape)

    @cached_property
    def _near(self) -> float:
        """Largest |x| in scales for which the integral serves; beyond, the tails of the single terms do."""
        largest = sum(shape.reach * float(np.abs(g).sum()) for shape, g in self._groups.items())
        return min(_TAIL_SCALES, largest / self.scale)

    def quantile(self, p: float) -> float:
        """Return the value of y that is not exceeded with probability p, 0 < p < 1."""
        check_interval(p, "symmetric")
        if self._single:
            law, factor = self._single
            return float(self.mean + factor * law.quantile(p))
        middle = (self.centre - self.mean) / self.scale
        low, high, width = middle - 4.0, middle + 4.0, 4.0
        while self._at(low) > p:
            low, width = low - width, 2 * width
        while self._at(high) < p:
            high, width = high + width, 2 * width
        return float(self.mean + self.scale * self._root(p, low, high))

    def _at(self, x: float) -> float:
        return float(self.cdf(self.mean + self.scale * x))

    def _root(self, p: float, low: float, high: float) -> float:
        """Solve for x in scales with P(X <= x) = p between two bounds: Newton, halving where that leaves them."""
        x = (low + high) / 2
        for _ in range(100):
            near = abs(x) <= self._near
            below, density = (
                self._integrate(np.array([x])) if near else (np.array([self._at(x)]), np.zeros(1))
            )
            miss = float(below[0]) - p
            low, high = (low, x) if miss > 0 else (x, high)
            step = miss / float(density[0]) if density[0] > 0 else math.inf
            if abs(step) < 1e-9 * max(1.0, abs(x)) or high - low < 1e-10 * max(1.0, abs(x)):
                return x
            x = x - step if low < x - step < high else (low + high) / 2
        return x

    def interval(self, p: float = 0.95, kind: str = "symmetric") -> tuple[float, float]:
        """Return the coverage interval for probability p: symmetric in probability, or the shortest (JCGM 101, 5.3)."""
        check_interval(p, kind)
        if kind == "shortest" and not all(shape.unimodal for shape in self._groups):
            return self._shortest(p)
        high = self.quantile((1 + p) / 2)
        if any(isinstance(shape, Samples) for shape in self._groups):
            return self.quantile((1 - p) / 2), high
        return float(2 * self.mean - high), high  # all other laws are symmetric

    def _shortest(self, p: float) -> tuple[float, float]:
        """Search over the probability left below, on a table of quantiles; then the exact upper end."""
        below = np.linspace(0, 1 - p, 2001)
        if self._single:
            law, factor = self._single
            width = law.quantile(below + p) - law.quantile(below)
            k = int(np.argmin(width))
            start = float(self.mean + factor * law.quantile(below[k]))
            return start, start + factor * float(width[k])
        y, cumulative = self._grid()
        width = np.interp(below + p, cumulative, y) - np.interp(below, cumulative, y)
        low = float(np.interp(below[np.argmin(width)], cumulative, y))
        return low, self.quantile(min(float(self.cdf(low)) + p, 1 - 1e-7))

    def _grid(self) -> tuple[Array, Array]:
        """Return 1024 equidistant y (all but 1e-6 of each tail) and P(Y <= y): x = coarse + fine, a matrix product."""
        ends = (np.array([self.quantile(1e-6), self.quantile(1 - 1e-6)]) - self.mean) / self.scale
        step = (ends[1] - ends[0]) / 1023
        t, real, imaginary = self._nodes(_reach(ends))
        coarse = np.exp(-1j * np.multiply.outer(ends[0] + 32 * step * np.arange(32), t)) * (
            (real + 1j * imaginary) / t
        )
        below = 0.5 - (coarse @ np.exp(-1j * np.multiply.outer(t, step * np.arange(32)))).imag.ravel()
        y = self.mean + self.scale * (ends[0] + step * np.arange(1024))
        return y, np.maximum.accumulate(below)

    def probability(self, low: float = -math.inf, high: float = math.inf) -> float:
        """Return P(low <= Y <= high): the probability of conformity for tolerance limits (JCGM 106, 7)."""
        ends = [float(self.cdf(v)) if math.isfinite(v) else float(v > 0) for v in (low, high)]
        return min(max(ends[1] - ends[0], 0.0), 1.0)  # far out the inversion leaves rounding of either sign


def _reach(x: Array) -> float:
    """Return the largest |x|, at least 16, rounded up to a power of two, so that few node sets serve all x."""
    return float(2.0 ** math.ceil(math.log2(max(16.0, float(np.abs(x).max(initial=0.0))))))


@lru_cache(maxsize=1)
def _legendre() -> tuple[Array, Array]:
    return np.polynomial.legendre.leggauss(16)


def _panels(end: float, width: float) -> tuple[Array, Array]:
    """Return 16-point Gauss-Legendre nodes and weights on (0, end): panels of `width`, the first graded to 0."""
    graded = width * 4.0 ** np.arange(-14, 1)
    edges = np.concatenate([[0.0], graded, np.arange(2, math.ceil(end / width) + 1) * width])
    node, weight = _legendre()
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()


def _group_cf(shape: Law, g: Array, t: Array) -> Array:
    """Return the product of cf(g_j t) over the terms of one shape, for t (n,)."""
    if isinstance(shape, StudentT):
        return np.asarray(np.exp(_sum_log_cf(shape, np.abs(g), t)))
    return _product(shape.cf, g, t)


def _product(function: object, g: Array, t: Array) -> Array:
    """Return the product of function(g_j t) over j, in slices that fit the cache."""
    assert callable(function)
    result: Array = np.ones(t.shape)
    for part in np.array_split(g, len(g) * len(t) // 500_000 + 1):
        result = result * np.prod(function(np.multiply.outer(t, part)), axis=-1)
    return result


@lru_cache(maxsize=64)
def _log_cf_table(shape: StudentT) -> tuple[float, float, Array]:
    """Return ln(-ln cf) of a standard t at equal steps of ln t: straight at both ends, so it interpolates well."""
    grid = np.linspace(math.log(1e-6), math.log(1e4), 1024)
    return grid[0], grid[1] - grid[0], np.log(-shape.log_cf(np.exp(grid)))


def _sum_log_cf(shape: StudentT, g: Array, t: Array) -> Array:
    """Sum of ln cf(g_j t) over j, for t (n,) > 0: four-point interpolation, relative error below 1e-8."""
    start, step, value = _log_cf_table(shape)
    total = np.zeros(t.shape)
    for part in np.array_split(g, len(g) * t.size // 500_000 + 1):
        place = (np.add.outer(np.log(t), np.log(part)) - start) / step
        k = np.clip(place.astype(int), 1, len(value) - 3)
        a, b, c, d = place - k + 1, place - k, place - k - 1, place - k - 2
        near = b * (c * (a * value[k + 2] / 6 - d * value[k - 1] / 6))
        total -= np.exp(near + a * d * (c * value[k] / 2 - b * value[k + 1] / 2)).sum(axis=-1)
    return total
