"""Probability laws of the deviation of a quantity from its estimate, all about zero, in canonical units.

    law = scale x standard shape

A *shape* is the law of unit scale; tables of quantiles and of characteristic functions are made once per
shape, so 192 t-laws of 13 degrees of freedom with 192 scales cost one table. Every scalar law has

    u, mean, dof      standard deviation (inf where there is none), mean, degrees of freedom (inf where none)
    name, shape       the word for budgets; the hashable standard law
    cdf(x), isf(p)    P(X <= x); the value exceeded with probability p (accurate far into the tail)
    cf(t)             characteristic function E exp(i t X): real for symmetric laws, complex for `Samples`
    bound(t), reach   a falling bound on |cf|; a bound on |X| (inf where none)

The last line tells vcmm.answer.evaluation.interval how far and how finely to integrate.
Joint laws (`MultivariateNormal`, `MultivariateSamples`) describe k quantities at once.
Sources: JCGM 101:2008, table 1 and 6.4; characteristic function of t: see `StudentT`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from vcmm.core._bounded_laws import Arcsine, CurvilinearTrapezoidal, Trapezoidal, Triangular, Uniform
from vcmm.core._law import Array, Law, check_number
from vcmm.core.errors import UsageError

__all__ = [
    "Arcsine",
    "CurvilinearTrapezoidal",
    "Joint",
    "Law",
    "MultivariateNormal",
    "MultivariateSamples",
    "Normal",
    "Samples",
    "StudentT",
    "Trapezoidal",
    "Triangular",
    "Uniform",
    "row_factor",
]


@dataclass(frozen=True)
class Normal(Law):
    """Gaussian law of standard uncertainty u."""

    u: float = field()
    name = "normal"
    shape = property(lambda self: Normal(1.0))

    def __post_init__(self) -> None:
        check_number(self.name, "u", self.u)

    @property
    def scale(self) -> float:
        return self.u

    def _cdf(self, x: Array) -> Array:
        return np.asarray(np.vectorize(math.erfc, otypes=[float])(-x / math.sqrt(2.0)) / 2)

    def _isf(self, p: Array) -> Array:
        from statistics import NormalDist  # Wichura's AS 241: 1e-16, and no scipy to load

        return np.asarray(-np.vectorize(NormalDist().inv_cdf, otypes=[float])(p))

    def _cf(self, t: Array) -> Array:
        return np.asarray(np.exp(-(t**2) / 2))


@dataclass(frozen=True)
class StudentT(Law):
    """Scaled Student t (JCGM 101, 6.4.9): u = scale sqrt(nu / (nu - 2)), infinite for nu <= 2.

    t is a normal law whose variance is nu / chi2_nu, so its characteristic function is the mean of
    exp(-t^2 nu / (2 chi2_nu)). Taken over ln chi2 by the trapezoid rule, that mean converges exponentially
    and has positive terms only, so 1 - cf keeps its relative accuracy for small t. It equals
    K_a(z) z^a / (Gamma(a) 2^(a - 1)), a = nu / 2, z = sqrt(nu) t (Hurst 1995), which cancels for small t and
    overflows for large nu.
    """

    scale: float = field()
    dof: float = field()
    shape = property(lambda self: StudentT(1.0, self.dof))

    def __post_init__(self) -> None:
        check_number("t", "scale", self.scale)
        check_number("t", "dof", self.dof, 1.0)

    @property
    def name(self) -> str:
        return f"t, nu = {self.dof:g}"

    @property
    def u(self) -> float:
        return self.scale * math.sqrt(self.dof / (self.dof - 2)) if self.dof > 2 else math.inf

    def _cdf(self, x: Array) -> Array:
        from scipy.special import stdtr

        return np.asarray(stdtr(self.dof, x))

    def _isf(self, p: Array) -> Array:
        from scipy.special import stdtrit

        return np.asarray(-stdtrit(self.dof, p))

    def _mixture(self) -> tuple[Array, Array]:
        """Return the nodes nu / chi2 and weights of the mean over chi2_nu, (k,) each."""
        a = self.dof / 2
        width = 1 / math.sqrt(a)
        x = np.arange(-75.0 / a - 10 * width, min(6.0, 12 * width), min(0.2, 0.6 * width))  # ln(chi2 / nu)
        weight = np.exp(a * (x - np.expm1(x)))
        return np.exp(-x), weight / weight.sum()

    def log_cf(self, t: ArrayLike) -> Array:
        """Return ln of the characteristic function, elementwise: 1e-10 of its value while cf > 0.01; cf itself to 1e-14."""
        t = np.asarray(t, float)
        node, weight = self._mixture()
        half = (self.scale * t.ravel()) ** 2 / 2
        parts = [_log_mean_exp(h, node, weight) for h in np.array_split(half, t.size // 1024 + 1)]
        return np.concatenate(parts).reshape(t.shape)

    def _cf(self, t: Array) -> Array:
        return np.asarray(np.exp(StudentT(1.0, self.dof).log_cf(t)))


def _log_mean_exp(h: Array, node: Array, weight: Array) -> Array:
    """Return ln sum_k weight_k exp(-h node_k), (n,): by its distance from 1 where it is near 1."""
    exponent = np.multiply.outer(h, node)
    lost = -np.expm1(-exponent) @ weight
    kept = np.exp(-exponent) @ weight
    return np.where(lost < 0.5, np.log1p(-np.minimum(lost, 0.5)), np.log(np.maximum(kept, 1e-300)))


@dataclass(frozen=True, eq=False)
class Samples(Law):
    """Empirical law: each of the values (m,) is equally probable; sampled by index. May have a mean."""

    values: Array
    name = "samples"
    unimodal = False
    scale = 1.0
    shape = property(lambda self: self)

    def __post_init__(self) -> None:
        values = np.sort(np.array(self.values, float).ravel())
        if len(values) < 2 or not np.isfinite(values).all():
            raise UsageError(f"Law {self.name}: it needs at least 2 finite values, got {len(values)}.")
        object.__setattr__(
            self, "values", values
        )  # sorted, so that one word of random bits is monotone in value

    @cached_property
    def mean(self) -> float:
        return float(self.values.mean())

    @cached_property
    def u(self) -> float:
        return float(self.values.std())

    @property
    def reach(self) -> float:
        return float(np.abs(self.values).max())

    def cdf(self, x: ArrayLike) -> Array:
        return np.asarray(np.searchsorted(self.values, np.asarray(x, float), side="right") / len(self.values))

    def quantile(self, p: ArrayLike) -> Array:
        rank = np.ceil(np.asarray(p, float) * len(self.values) - 1e-9).astype(int) - 1
        return np.asarray(self.values[np.clip(rank, 0, len(self.values) - 1)])

    def isf(self, p: ArrayLike) -> Array:
        return self.quantile(1 - np.asarray(p, float))

    @cached_property
    def _bins(self) -> tuple[Array, Array, float]:
        """Centres, weights and width of bins of about u / 250; the mean is kept exactly, u to 1e-6."""
        low, span = self.values[0], self.values[-1] - self.values[0]
        n = int(np.clip(250 * span / max(self.u, 1e-300), 2, 16384))
        place = (self.values - low) / max(span, 1e-300) * (n - 1)
        k = np.minimum(place.astype(int), n - 2)
        weight = np.bincount(k, k + 1 - place, n) + np.bincount(k + 1, place - k, n)
        return low + span / (n - 1) * np.arange(n), weight / len(place), span / (n - 1)

    def cf(self, t: ArrayLike) -> Array:
        """Return the characteristic function (complex) of the values spread evenly over bins of about u / 250."""
        t = np.asarray(t, float)
        centre, weight, width = self._bins
        blocks = np.array_split(t.ravel(), t.size // 256 + 1)
        mean = np.concatenate([np.exp(1j * np.multiply.outer(b, centre)) @ weight for b in blocks])
        return mean.reshape(t.shape) * np.sinc(width * t / (2 * math.pi))

    def bound(self, t: ArrayLike) -> Array:
        return np.asarray(1 / np.maximum(1.0, self._bins[2] * np.abs(np.asarray(t, float)) / 2))


def row_factor(gain: Array, tolerance: float = 1e-10) -> Array:
    """Return the lower-trapezoidal factor F (K, r) with F F^T = gain gain^T, for gain (K, L); r = rank.

    Rows are made orthogonal one after another (Gram-Schmidt, twice, without squaring the gain). Row k of F
    depends on rows 0..k of `gain` only, so one more output changes nothing in those before it. A row whose
    new part is below `tolerance` times its length adds no column.
    """
    basis = np.zeros((min(gain.shape), gain.shape[1]))
    factor = np.zeros((len(gain), len(basis)))
    rank = 0
    for k, row in enumerate(gain):
        rest = row.astype(float)
        for _ in range(2):
            share = basis[:rank] @ rest
            rest = rest - share @ basis[:rank]
            factor[k, :rank] += share
        length = np.linalg.norm(rest)
        if rank < len(basis) and length > tolerance * np.linalg.norm(row):
            basis[rank], factor[k, rank] = rest / length, length
            rank += 1
    return factor[:, :rank]


MANY, SHARE, LEFT = 200, 4, 1e-13  # quantities; at most a quarter of them independent; variance left over


def _low_rank(correlation: Array) -> Array | None:
    """Return a factor (k, r) whose product with its transpose is the correlation matrix to 1e-12, r far below k; None where there is none.

    Cholesky with the largest remaining variance as the next pivot, k r^2 operations (Harbrecht, Peters and Schneider, Appl. Numer.
    Math. 62 (2012) 428): a smooth curve at a thousand nodes has some tens of directions. What remains is looked at, so that a
    matrix that is no correlation matrix is none here either.
    """
    left = np.diag(correlation).copy()
    gain = np.zeros((len(correlation), len(correlation) // SHARE))
    for r in range(gain.shape[1]):
        pivot = int(np.argmax(left))
        if left[pivot] <= LEFT:
            columns = gain[:, :r]
            return columns if np.abs(correlation - columns @ columns.T).max() <= 10 * LEFT else None
        gain[:, r] = (correlation[:, pivot] - gain[:, :r] @ gain[pivot, :r]) / math.sqrt(left[pivot])
        left -= gain[:, r] ** 2
    return None


@dataclass(frozen=True, eq=False)
class MultivariateNormal:
    """Jointly Gaussian deviations of k quantities with the given covariance (k, k).

    Raises UsageError when the covariance is not symmetric or has a negative eigenvalue.
    """

    covariance: Array
    name = "multivariate normal"

    def __post_init__(self) -> None:
        c = np.array(self.covariance, float)
        if c.ndim != 2 or c.shape[0] != c.shape[1] or not np.isfinite(c).all() or (np.diag(c) < 0).any():
            text = f"the covariance (shape {c.shape}) must be square, of finite numbers, with variances >= 0"
            raise UsageError(f"Law {self.name}: {text}.")
        u = np.sqrt(np.diag(c))
        if (np.abs(c - c.T) > 1e-9 * np.outer(u, u)).any():
            raise UsageError(f"Law {self.name}: the covariance must be symmetric.")
        object.__setattr__(self, "covariance", (c + c.T) / 2)
        _ = self.factor

    @cached_property
    def u(self) -> Array:
        """Standard uncertainties (k,)."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def factor(self) -> Array:
        """Lower trapezoidal factor (k, r): deviation = factor @ r standard normals; null directions dropped.

        Eigenvectors of the correlation matrix show the null directions (pivots do where there are many quantities and few
        directions); triangular form then makes the factor unique (eigenvectors are not), so that the same seed gives the same
        sample on every computer.
        """
        u = np.where(self.u > 0, self.u, 1.0)
        correlation = self.covariance / np.outer(u, u)
        few = _low_rank(correlation) if len(u) > MANY else None
        if few is not None:
            return row_factor(u[:, None] * few, 1e-6)
        value, vector = np.linalg.eigh(correlation)
        if value[0] < -1e-9 * max(value[-1], 1e-300):
            text = f"smallest eigenvalue of the correlation matrix {value[0]:.3g}"
            raise UsageError(f"Law {self.name}: the covariance is not positive semidefinite ({text}).")
        keep = value > 1e-13 * value[-1]
        return row_factor(u[:, None] * vector[:, keep] * np.sqrt(value[keep]), 1e-6)

    def project(self, gain: Array) -> Normal:
        """Return the law of the linear combination gain (k,) . deviation."""
        return Normal(float(np.linalg.norm(np.asarray(gain, float) @ self.factor)))


@dataclass(frozen=True, eq=False)
class MultivariateSamples:
    """Empirical joint law: the rows of values (m, k) are equally probable and sampled whole, by index."""

    values: Array
    name = "multivariate samples"

    def __post_init__(self) -> None:
        values = np.array(self.values, float)
        if values.ndim != 2 or len(values) < 2 or not np.isfinite(values).all():
            raise UsageError(
                f"Law {self.name}: values {values.shape} must be at least 2 rows of finite numbers."
            )
        object.__setattr__(self, "values", values)

    @cached_property
    def mean(self) -> Array:
        """Mean of each quantity (k,)."""
        return np.asarray(self.values.mean(axis=0))

    @cached_property
    def covariance(self) -> Array:
        """Covariance (k, k) of the rows taken as the whole population."""
        centred = self.values - self.mean
        return np.asarray(centred.T @ centred / len(centred))

    @cached_property
    def u(self) -> Array:
        """Standard uncertainties (k,)."""
        return np.sqrt(np.diag(self.covariance))

    def project(self, gain: Array) -> Samples:
        """Return the law of the linear combination gain (k,) . deviation."""
        return Samples(self.values @ np.asarray(gain, float))


Joint = MultivariateNormal | MultivariateSamples
