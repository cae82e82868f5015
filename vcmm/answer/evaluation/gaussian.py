"""Gaussian linear models with unknown noise scale: whitening, evidence, posterior. Used by diagnose and calibrate.

    value = baseline + N a + C z + X b + sigma u e

    N a   nuisance (artefact pose, stylus offset): a is unknown (diffuse), N is projected out
    C z   uncertainty of the calibration: z are standard normals, C is a low-rank factor of that covariance
    X b   an effect under test, b has a normal prior of width `scale` in units of its typical amplitude
    u     standard uncertainty of each observation up to one common factor sigma, which is unknown

The whitener turns value - baseline and X into a space where the rest is white with unit variance; there the evidence
of an effect is a closed form (O'Hagan & Forster, Bayesian Inference (2004), 11.7-11.16).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array

Ints = npt.NDArray[np.intp]
SCALES = (0.25, 1.0, 4.0, 16.0, 64.0)  # prior widths in units of the typical amplitude
RANK = 1e-9  # columns shorter than this, relative to the longest, span nothing


@dataclass(frozen=True, eq=False)
class Whitener:
    """weight (m,) 1/u; nuisance (m, p) orthonormal; prior (m, r) orthonormal directions of what is known, with shrink (r,).

    before (m,): the preceding observation of the same series, -1 for none; rho: its correlation (AR(1) noise).
    """

    weight: Array
    nuisance: Array
    prior: Array
    shrink: Array
    before: Ints
    rho: float = 0.0

    @property
    def dof(self) -> int:
        """Degrees of freedom that remain after the nuisance."""
        return len(self.weight) - self.nuisance.shape[1]

    def scale(self, x: Array) -> Array:
        """Return x (m,) or (m, k) in units of the noise, with correlation of neighbours removed; nothing is projected."""
        x = (self.weight * x.T).T
        return innovations(x, self.before, self.rho)

    def apply(self, x: Array) -> Array:
        """Map (m,) or (m, k) to the white space; the nuisance is removed, calibrated directions are shrunk."""
        x = self.scale(x)
        x = x - self.nuisance @ (self.nuisance.T @ x)
        return x - self.prior @ ((self.shrink * (self.prior.T @ x).T).T)

    def adjoint(self, x: Array) -> Array:
        """Map (m,) or (m, k) of the white space to A' x of the observations, A = `apply`: (A f)' x = f' (A' x) for any f."""
        x = x - self.prior @ ((self.shrink * (self.prior.T @ x).T).T)
        x = x - self.nuisance @ (self.nuisance.T @ x)
        x = unchained_adjoint(x, self.before, self.rho)
        return np.asarray((self.weight * x.T).T)


def innovations(x: Array, before: Ints, rho: float) -> Array:
    """Return AR(1) innovations of unit variance: (x_t - rho x_before) / sqrt(1 - rho^2); the first of a series stays."""
    if rho == 0.0:
        return x
    inner = before >= 0
    out = x.copy()
    out[inner] = (x[inner] - rho * x[before[inner]]) / np.sqrt(1 - rho**2)
    return out


def unchained_adjoint(x: Array, before: Ints, rho: float) -> Array:
    """Apply the transpose of `innovations`."""
    if rho == 0.0:
        return x
    inner = before >= 0
    size = 1.0 / np.sqrt(1 - rho**2)
    out = x.copy()
    out[inner] *= size
    np.subtract.at(out, before[inner], rho * size * x[inner])
    return out


def whitener(
    u: Array, nuisance: Array, calibration: Array, before: Ints | None = None, rho: float = 0.0
) -> Whitener:
    """Return the whitener of observations with standard uncertainty u (m,), nuisance columns (m, p) and a calibration factor (m, r).

    Raises ModelLimit where u is not positive or the nuisance leaves fewer than three degrees of freedom.
    """
    bad = np.flatnonzero(~(u > 0))
    if len(bad):
        raise ModelLimit(
            f"observation {bad[0] + 1} has no standard uncertainty; give u_um, [noise] or the machine's [repeatability]"
        )
    before = np.full(len(u), -1, dtype=np.intp) if before is None else before
    bare = Whitener(1.0 / u, np.zeros((len(u), 0)), np.zeros((len(u), 0)), np.zeros(0), before, rho)
    q = orthonormal(bare.scale(nuisance))
    if len(u) - q.shape[1] < 3:
        raise ModelLimit(
            f"{len(u)} observations cannot carry {q.shape[1]} nuisance parameters; record more rows or drop a nuisance group"
        )
    left, gain = _principal(bare.scale(calibration), q)
    return Whitener(1.0 / u, q, left, 1.0 - 1.0 / np.sqrt(1.0 + gain**2), before, rho)


def orthonormal(columns: Array, floor: float = RANK) -> Array:
    """Return the orthonormal basis (m, rank) of the span; columns are scaled first so that mixed units do not decide the rank.

    Directions below `floor` of the longest are dropped.
    """
    length = np.linalg.norm(columns, axis=0)
    columns = columns[:, length > 0] / length[length > 0]
    if columns.shape[1] == 0:
        return columns
    left, size = thin_svd(columns)
    return left[:, size > floor * size[0]]


def thin_svd(x: Array) -> tuple[Array, Array]:
    """Return the left singular vectors (m, k) and singular values (k,) of x.

    The fast driver divides and conquers and now and then does not converge on a matrix of deficient rank; QR iteration
    does (Golub & Van Loan, Matrix Computations (2013), 8.6).
    """
    try:
        left, size, _ = np.linalg.svd(x, full_matrices=False)
    except np.linalg.LinAlgError:
        from scipy.linalg import svd

        left, size, _ = svd(x, full_matrices=False, lapack_driver="gesvd")
    return np.asarray(left), np.asarray(size)


def _principal(calibration: Array, q: Array) -> tuple[Array, Array]:
    """Return the left singular vectors and values of the calibration factor outside the nuisance."""
    rest = calibration - q @ (q.T @ calibration)
    if rest.shape[1] == 0 or not np.any(rest):
        return np.zeros((len(calibration), 0)), np.zeros(0)
    left, size = thin_svd(rest)
    keep = size > 1e-6 * max(1.0, float(size[0]))
    return left[:, keep], size[keep]


@dataclass(frozen=True, eq=False)
class ColumnBlocks:
    """Many groups of columns side by side: column (m, K), each group turned so that its Gram matrix is diagonal.

    size (K,): squared lengths; start (groups,): first column of each group.
    """

    column: Array
    size: Array
    start: Ints

    @property
    def groups(self) -> int:
        return len(self.start)

    def group(self, i: int) -> slice:
        stop = self.start[i + 1] if i + 1 < len(self.start) else self.column.shape[1]
        return slice(int(self.start[i]), int(stop))


def blocks(columns: Array, start: Ints) -> ColumnBlocks:
    """Turn every group to principal directions, groups of one width together."""
    widths = np.diff(np.append(start, columns.shape[1]))
    out, size = columns.copy(), np.empty(columns.shape[1])
    for width in np.unique(widths):
        which = start[widths == width][:, None] + np.arange(width)  # (groups, width)
        if width == 1:
            size[which[:, 0]] = (columns[:, which[:, 0]] ** 2).sum(axis=0)
            continue
        part = columns[:, which.ravel()].reshape(len(columns), -1, int(width)).transpose(1, 0, 2)
        value, vector = np.linalg.eigh(np.matmul(part.transpose(0, 2, 1), part))
        out[:, which.ravel()] = np.matmul(part, vector).transpose(1, 0, 2).reshape(len(columns), -1)
        size[which] = np.maximum(value, 0.0)
    return ColumnBlocks(out, size, start)


def without_span(columns: Array, basis: Array) -> Array:
    """Return columns (m, K) or (m,) with their part in the span of orthonormal `basis` (m, p) removed."""
    return columns - basis @ (basis.T @ columns) if basis.shape[1] else columns


def left_beside(signal: Array, columns: Array) -> Array:
    """Return the residual of a signal (m,) after least squares on columns (m, k)."""
    return np.asarray(signal - columns @ np.linalg.lstsq(columns, signal, rcond=RANK)[0])


def log_evidence(groups: ColumnBlocks, r: Array, dof: int, scales: Sequence[float] = SCALES) -> Array:
    """Return ln Bayes factor (groups, M) of each group against no effect, for white residuals r (m, M).

    ln BF = -1/2 ln|I + s^2 G| - dof/2 ln(1 - q/R), q = b^T (G + s^-2)^-1 b, b = X^T r, R = r^T r, averaged over the
    prior widths s; the noise scale is integrated out with the Jeffreys prior.
    """
    squared = (
        groups.column.T @ r
    ) ** 2  # in the precision of both: float32 where thousands of nulls are compared
    total = np.maximum((r * r).sum(axis=0), 1e-300)
    each = [_at_width(groups, squared, total, dof, s) for s in scales]
    top = np.max(each, axis=0)
    return np.asarray(top + np.log(np.mean([np.exp(logs - top) for logs in each], axis=0)))


def _at_width(groups: ColumnBlocks, squared: Array, total: Array, dof: int, s: float) -> Array:
    gain = s**2 / (1 + s**2 * groups.size)
    q = group_sums(groups.start, gain, squared)
    volume = np.add.reduceat(np.log1p(s**2 * groups.size), groups.start).astype(q.dtype)
    share = np.minimum(q / total, 1 - max(1e-12, np.finfo(q.dtype).eps))
    return np.asarray(-0.5 * volume[:, None] - 0.5 * dof * np.log1p(-share))


def group_sums(start: Ints, weight: Array, x: Array) -> Array:
    """Sum of weight (K,) times rows of x (K, M) within consecutive groups: (groups, M). A sparse product; reduceat is slow."""
    from scipy.sparse import csr_array

    k = len(weight)
    matrix = csr_array((weight.astype(x.dtype), np.arange(k), np.append(start, k)), shape=(len(start), k))
    return np.asarray(matrix @ x)


@dataclass(frozen=True, eq=False)
class Posterior:
    """mean (k,), covariance (k, k) (with the estimated noise), sigma: noise scale, log_evidence in nats."""

    mean: Array
    covariance: Array
    sigma: float
    log_evidence: float


@dataclass(frozen=True, eq=False)
class Conditioned:
    """Distribution of numbers F z, z unit normals, given readings of unit noise: x' x = G, x' y = b.

    lower: L L' = 1 + F' G F; factor: F (k, r), or (k,) of its diagonal; pull: L^-1 F' b. No eigenvalue of L L' is below 1, however
    small F is.
    """

    lower: Array
    factor: Array
    pull: Array

    @cached_property
    def half(self) -> Array:
        """Square root of the covariance (k, r): half half' is the covariance of the numbers."""
        from scipy.linalg import solve_triangular

        turned = np.diag(self.factor) if self.factor.ndim == 1 else self.factor.T
        return np.asarray(solve_triangular(self.lower, turned, lower=True, check_finite=False).T)

    @property
    def mean(self) -> Array:
        return np.asarray(self.half @ self.pull)

    @property
    def covariance(self) -> Array:
        return np.asarray(self.half @ self.half.T)

    @property
    def log_det(self) -> float:
        """ln |1 + F' G F|."""
        return 2.0 * float(np.log(np.diag(self.lower)).sum())

    @property
    def gain(self) -> Array:
        """Reduction of the sum of squares by the numbers, b' half half' b: of b (k,) one, of (k, M) M."""
        return np.asarray((self.pull**2).sum(axis=0))


def condition(gram: Array, b: Array, factor: Array) -> Conditioned:
    """Condition the numbers on gram (k, k) and b (k,) or (k, M), with the prior covariance F F': factor (k, r), or (k,) of its diagonal.

    Woodbury's identity, so that no matrix is as large as the readings are many, and no prior is inverted.
    """
    from scipy.linalg import solve_triangular

    diagonal = factor.ndim == 1
    inner = (gram * factor).T * factor if diagonal else factor.T @ gram @ factor
    inner = (inner + inner.T) / 2
    inner.flat[:: len(inner) + 1] += 1.0
    lower = np.linalg.cholesky(inner)
    turned = (factor * b.T).T if diagonal else factor.T @ b
    pull = solve_triangular(lower, turned, lower=True, check_finite=False)
    return Conditioned(np.asarray(lower), factor, np.asarray(pull))


def log_density(rest: Array, x: Array, factor: Array) -> Array:
    """Return ln density of white residuals (m,) or (m, M) of unit noise, less that at rest 0 without columns; the coefficients of x (m, k)
    have the covariance F F', factor (k, r).
    """
    numbers = condition(x.T @ x, x.T @ rest, factor)
    return np.asarray(-0.5 * ((rest**2).sum(axis=0) - numbers.gain + numbers.log_det))


def posterior(x: Array, r: Array, dof: int, width: Array) -> Posterior:
    """Return the posterior of the coefficients of white columns x (m, k), prior standard deviations width (k,) times sigma.

    sigma^2 = (R - q) / dof. A coefficient that the data do not see keeps its prior.
    """
    numbers, total = condition(x.T @ x, x.T @ r, width), float(r @ r)
    rest = _rest(numbers, total)
    sigma = float(np.sqrt(rest / dof))
    return Posterior(
        numbers.mean, sigma**2 * numbers.covariance, sigma, _log_evidence(numbers, rest, total, dof)
    )


def evidence_from(gram: Array, b: Array, total: float, dof: int, width: Array) -> float:
    """Return the log evidence of `posterior` from gram = X'X (k, k), b = X'r (k,) and total = r'r: many subsets share one product."""
    numbers = condition(gram, b, width)
    return _log_evidence(numbers, _rest(numbers, total), total, dof)


def _rest(numbers: Conditioned, total: float) -> float:
    return max(total - float(numbers.gain), 1e-12 * total, 1e-300)


def _log_evidence(numbers: Conditioned, rest: float, total: float, dof: int) -> float:
    return -0.5 * numbers.log_det - 0.5 * dof * float(np.log(rest / max(total, 1e-300)))


def best_width(x: Array, r: Array, dof: int, scales: Sequence[float] = SCALES) -> Posterior:
    """Return the posterior at the common prior width of highest evidence."""
    tried = [posterior(x, r, dof, np.full(x.shape[1], s)) for s in scales]
    return max(tried, key=lambda p: p.log_evidence)
