"""Estimate size and smoothness of every error curve by evidence, and the addition of their uncertainty to the band.

With the readings reduced to A = G' W G and b = G' W y (nuisance projected out), one curve at a time, all others marginalised
under their present priors; then only its own few numbers remain, with the precision a and the vector b:

    theta = F z, z of unit variance     ln evidence = -1/2 ln det (1 + F' a F) + 1/2 b' F (1 + F' a F)^-1 F' b
    its slope in ln size                |z|^2 - (numbers - trace of the covariance of z)          MacKay, Neural Comp. 4 (1992) 415

A band that takes the best size and length for the truth is too narrow. So each curve is averaged over lengths and sizes, weighted
by their evidence, and the mean and covariance of this mixture stand for its prior (moment matching as in expectation
propagation, Minka 2001): `PriorSite`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from vcmm.answer.evaluation.gaussian import condition
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.learn.calibration.model import Curve, ErrorModel
from vcmm.learn.calibration.prior import SPREAD, line_factor, unit_factor, usual, widest_pairs

SHARES = (0.1, 0.13, 0.16, 0.2, 0.26, 0.34, 0.45, 0.65, 1.0, 1.6)  # correlation length in parts of the travel
SPAN, WIDE = 0.45, 0.8  # usual correlation length in parts of the travel; spread of its logarithm
ROUNDS, STEPS, ENOUGH = 6, 20, 0.05
NODES = (
    (-np.sqrt(3.0), 1 / 6),
    (0.0, 2 / 3),
    (np.sqrt(3.0), 1 / 6),
)  # Gauss-Hermite, three nodes of a normal law
EXTREMES = (1e-4, 1e2)  # of the usual size: smaller and larger ones are not looked at
ROUNDING = 1e-10  # of the precision of a curve: smaller differences of precisions are rounding
FAINT = 12.0  # nats below the best: no weight in the mixture


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """The readings as normal equations: a (p, p), b (p,), of theta and, behind it, numbers of unit variance (instruments)."""

    a: Array
    b: Array
    model: ErrorModel

    def project_onto(self, coarse: ErrorModel, lift: Array) -> NormalEquations:
        """Return the same readings for a model with fewer numbers, theta = lift @ fewer."""
        whole = append_identity(lift, len(self.b))
        return NormalEquations(whole.T @ self.a @ whole, whole.T @ self.b, coarse)


@dataclass(frozen=True, eq=False)
class PriorSite:
    """Replacement of the prior of one curve in its free coordinates: factor (g, r) of its covariance, precision times mean (g,)."""

    factor: Array
    shift: Array


@dataclass(frozen=True, eq=False)
class Smoothness:
    """lengths: component -> mm; sizes (curves,) mm or rad, the most probable; sites: with their uncertainty.

    log_evidence of the most probable ones in nats, without the part common to all models of the same readings.
    """

    lengths: Mapping[str, float]
    sizes: Array
    sites: tuple[PriorSite, ...]
    log_evidence: float


def append_identity(factor: Array, size: int) -> Array:
    """Return the factor of theta, with the identity for the numbers behind it."""
    others = size - len(factor)
    out = np.zeros((size, factor.shape[1] + others))
    out[: len(factor), : factor.shape[1]] = factor
    out[len(factor) :, factor.shape[1] :] = np.eye(others)
    return out


def smoothness(information: NormalEquations, start: Smoothness | None = None) -> Smoothness:
    """Find the most probable size and correlation length of every curve, and the sites; curve after curve until nothing gains."""
    model = information.model
    lengths = dict(start.lengths) if start else {c.component: SPAN * c.travel for c in model.curves}
    sizes = np.array(start.sizes if start else usual(model))
    for _ in range(ROUNDS):
        gain = 0.0
        joint = JointPosterior(
            information, [_plain(c, lengths[c.component], s) for c, s in zip(model.curves, sizes)]
        )
        for number, curve in enumerate(model.curves):
            local = OneCurve(curve, *joint.without(number))
            before = local.value(lengths[curve.component], float(sizes[number]))[0]
            length, size, value = local.best(lengths[curve.component], float(sizes[number]))
            if value > before + ENOUGH / 10:
                lengths[curve.component], sizes[number] = length, size
                joint.replace(number, _plain(curve, length, size))
                gain += value - before
        if gain < ENOUGH:
            break
    best = log_evidence(information, lengths, sizes)
    return Smoothness(lengths, sizes, _sites(information, lengths, sizes), best)


def _sites(equations: NormalEquations, lengths: Mapping[str, float], sizes: Array) -> tuple[PriorSite, ...]:
    """Return every curve averaged over lengths and sizes, the others at theirs; twice, the second time beside the first sites."""
    curves = equations.model.curves
    joint = JointPosterior(equations, [_plain(c, lengths[c.component], s) for c, s in zip(curves, sizes)])
    for _ in range(2):
        for number, curve in enumerate(curves):
            joint.replace(number, OneCurve(curve, *joint.without(number)).site(float(sizes[number])))
    return tuple(joint.sites)


def log_evidence(information: NormalEquations, lengths: Mapping[str, float], sizes: Array) -> float:
    """Return ln evidence in nats of sizes and lengths, without the part that all priors share."""
    factors = [_factor(c, lengths[c.component], s) for c, s in zip(information.model.curves, sizes)]
    spans = np.cumsum([0, *(f.shape[1] for f in factors)])
    size = len(information.b)
    factor = np.zeros((size, int(spans[-1]) + size - information.model.size + len(information.model.pairs)))
    for curve, factor_of_curve, (low, high) in zip(information.model.curves, factors, pairwise(spans)):
        factor[information.model.slices[curve.component], low:high] = curve.free @ factor_of_curve
    rest = np.arange(size - (factor.shape[1] - spans[-1]), size)
    ones = np.ones(size - information.model.size)
    factor[rest, np.arange(spans[-1], factor.shape[1])] = [*widest_pairs(information.model), *ones]
    return _evidence(factor.T @ information.a @ factor, factor.T @ information.b)[0]


def _factor(curve: Curve, length: float, size: float) -> Array:
    """Return the factor (g, r) in free coordinates: the smooth curve of that size, and the line of a scale error."""
    return np.concatenate([unit_factor(curve, length) * size, curve.coordinates @ line_factor(curve)], axis=1)


def _plain(curve: Curve, length: float, size: float) -> PriorSite:
    factor = _factor(curve, length, size)
    return PriorSite(factor, np.zeros(len(factor)))


class JointPosterior:
    """The posterior of all numbers in free coordinates (curves, then squareness and instruments), and of it without one prior.

    Every prior is a factor F of its covariance, never a precision: with theta = F z the matrix 1 + F' A F has no
    eigenvalue below 1, however small a curve is. A precision of a small smooth curve with a free line spans 20 decades.
    """

    def __init__(self, information: NormalEquations, sites: Sequence[PriorSite]) -> None:
        model = information.model
        spans = np.cumsum([0, *(c.free.shape[1] for c in model.curves)])
        self.sites, self.parts = list(sites), [slice(a, b) for a, b in pairwise(spans)]
        others = len(information.b) - sum(len(c.nodes) for c in model.curves)
        self.whole = np.zeros((len(information.b), int(spans[-1]) + others))
        for curve, part in zip(model.curves, self.parts):
            self.whole[model.slices[curve.component], part] = curve.free
        self.whole[len(information.b) - others :, int(spans[-1]) :] = np.eye(others)
        self.b = self.whole.T @ information.b
        self.a = self.whole.T @ information.a @ self.whole
        self.far = np.ones(others)
        self.far[: len(model.pairs)] = widest_pairs(model)

    def posterior(self) -> tuple[Array, Array]:
        """Return the mean and covariance of theta and the numbers behind it."""
        half, pull = self._solve(None, self.whole.T)
        return half.T @ pull, half.T @ half

    def without(self, number: int) -> tuple[Array, Array]:
        """Return precision (g, g) and precision times mean (g,) of one curve by the readings and all other priors."""
        part = self.parts[number]
        block = self.a[part, part]
        half, pull = self._solve(number, self.a[:, part])
        size, ways = np.linalg.eigh(block - half.T @ half)
        heard = size > ROUNDING * np.linalg.norm(block, 2)  # elsewhere the readings say nothing
        size, ways = size[heard], ways[:, heard]
        return (ways * size) @ ways.T, ways @ (ways.T @ (self.b[part] - half.T @ pull))

    def _solve(self, left_out: int | None, columns: Array) -> tuple[Array, Array]:
        """Return L^-1 F' columns and L^-1 F' (b + shift), L L' = 1 + F' A F, F of all curves but one."""
        from scipy.linalg import solve_triangular

        kept = [k for k in range(len(self.sites)) if k != left_out]
        blocks = [(self.parts[k], self.sites[k].factor) for k in kept]
        rest = slice(self.parts[-1].stop if self.parts else 0, len(self.b))
        blocks.append((rest, np.diag(self.far)))
        shifted = self.b.copy()
        for k in kept:
            shifted[self.parts[k]] += self.sites[k].shift
        right = np.concatenate([columns, shifted[:, None], self.a], axis=1)
        rows = np.concatenate([f.T @ right[at] for at, f in blocks])
        solved, gram = rows[:, : -len(self.b)], rows[:, -len(self.b) :]
        inner = np.concatenate([gram[:, at] @ f for at, f in blocks], axis=1)
        inner = (inner + inner.T) / 2
        inner.flat[:: len(inner) + 1] += 1.0
        out = solve_triangular(np.linalg.cholesky(inner), solved, lower=True)
        return out[:, :-1], out[:, -1]

    def replace(self, number: int, site: PriorSite) -> None:
        """Replace the prior of one curve."""
        self.sites[number] = site


def _eigen_floor(matrix: Array, least: float) -> tuple[Array, Array]:
    """Return eigenvalues, none below the least, and eigenvectors."""
    size, ways = np.linalg.eigh((matrix + matrix.T) / 2)
    return np.maximum(size, least), ways


@dataclass(frozen=True, eq=False)
class OneCurve:
    """Readings for one curve without its own prior: precision a (g, g), b (g,), free coordinates."""

    curve: Curve
    a: Array
    b: Array
    units: dict[float, tuple[Array, Array]] = field(default_factory=dict, init=False)

    def best(self, length: float, size: float) -> tuple[float, float, float]:
        """Return (length, size, value) of the best correlation length, each tried with its best size."""
        trials = []
        for tried in (length, *(s * self.curve.travel for s in SHARES)):
            size, value, _ = self.best_size(tried, size)
            trials.append((tried, size, value))
        return max(trials, key=lambda f: f[2])

    def best_size(self, length: float, size: float) -> tuple[float, float, float]:
        """Return the most probable size for a length, by Newton's steps in ln size, as (size, value, spread of ln size)."""
        value, slope, count = self.value(length, size)
        for _ in range(STEPS):
            step = float(np.clip(slope / (2 * count + 1 / SPREAD**2), -1.5, 1.5))
            step = float(np.clip(step, *(np.log(np.array(EXTREMES) * self.curve.usual / size))))
            new = self.value(length, size * np.exp(step))
            while new[0] < value - 1e-9 and abs(step) > 1e-3:
                step /= 2
                new = self.value(length, size * np.exp(step))
            if new[0] <= value:
                break
            size, gain, (value, slope, count) = size * float(np.exp(step)), new[0] - value, new
            if gain < ENOUGH / 10:
                break
        return size, value, float(1 / np.sqrt(2 * count + 1 / SPREAD**2))

    def value(self, length: float, size: float) -> tuple[float, float, float]:
        """Return (ln evidence and ln prior of size and length, slope in ln size, numbers that the readings determine)."""
        a, b = self._in_units(length)
        scale = np.ones(len(b))
        scale[: self.curve.free.shape[1]] = size
        value, mean, variance = _evidence(a * np.outer(scale, scale), b * scale)
        smooth = slice(0, self.curve.free.shape[1])
        used, count = float((mean[smooth] ** 2).sum()), float((1 - variance[smooth]).sum())
        away = np.log(size / self.curve.usual) / SPREAD
        far = np.log(length / (SPAN * self.curve.travel)) / WIDE
        return value - (away**2 + far**2) / 2, used - count - away / SPREAD, max(used, count)

    def _in_units(self, length: float) -> tuple[Array, Array]:
        """Return the precision and precision times mean of the numbers behind the curve, when its size is 1."""
        if length not in self.units:
            factor = _factor(self.curve, length, 1.0)
            self.units[length] = factor.T @ self.a @ factor, factor.T @ self.b
        return self.units[length]

    def site(self, size: float) -> PriorSite:
        """Return the mixture over correlation lengths and sizes by their evidence, as one site with its mean and covariance."""
        tried = []
        for share in SHARES:
            length = share * self.curve.travel
            size, value, spread = self.best_size(length, size)
            for at, weight in NODES:
                near = size * float(np.exp(at * spread))
                here = value if at == 0 else self.value(length, near)[0]
                tried.append((here + at**2 / 2 + np.log(weight * spread), length, near))
        top = max(t[0] for t in tried)
        if not np.isfinite(top) or top - FAINT >= top:
            raise ModelLimit(
                f"these readings cannot tell {self.curve.component} from the other errors: its evidence, exp({top:.3g}), has lost "
                "all its digits; record more positions, or name the errors to look for with --errors"
            )
        kept = [(float(np.exp(v - top)), length, near) for v, length, near in tried if v > top - FAINT]
        weights = np.array([w for w, _, _ in kept]) / sum(w for w, _, _ in kept)
        means, covariances = zip(*(self._posterior(length, near) for _, length, near in kept))
        mean = np.einsum("w,wi->i", weights, np.array(means))
        away = np.array(means) - mean
        covariance = np.einsum("w,wij->ij", weights, np.array(covariances))
        covariance += np.einsum("w,wi,wj->ij", weights, away, away)
        precision = np.linalg.inv(covariance)
        kept_size, ways = _eigen_floor(precision - self.a, 1e-9 * float(np.trace(precision)) / len(precision))
        in_site = (ways * kept_size) @ ways.T
        return PriorSite(ways / np.sqrt(kept_size), (in_site + self.a) @ mean - self.b)

    def _posterior(self, length: float, size: float) -> tuple[Array, Array]:
        factor = _factor(self.curve, length, size)
        posterior = condition(self.a, self.b, factor)
        return posterior.mean, posterior.covariance


def _evidence(a: Array, b: Array) -> tuple[float, Array, Array]:
    """Return (ln evidence, mean of z, variances of z) of numbers of unit variance, M = 1 + a."""
    posterior = condition(a, b, np.ones(len(b)))
    return float(posterior.gain) / 2 - posterior.log_det / 2, posterior.mean, (posterior.half**2).sum(axis=1)
