"""The joint posterior of all errors from all recordings, robust to outliers.

Least squares with weights w = information of each reading: for a Student law of nu degrees of freedom and scale s
(iteratively reweighted, Lange, Little & Taylor, J. Am. Stat. Assoc. 84 (1989) 881)

    estimate     w = (nu + 1) / (nu + (e/s)^2) / s^2
    covariance   w = (nu + 1) / (nu + 3) / s^2, the Fisher information

Nuisance is projected out recording by recording, so it has no prior; own errors of instruments have theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import lgamma

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.gaussian import condition, orthonormal
from vcmm.core.run import Array
from vcmm.learn.calibration.evidence import JointPosterior, NormalEquations, Smoothness, smoothness
from vcmm.learn.calibration.model import ErrorModel
from vcmm.learn.calibration.readings import Readings

DOFS = (3.0, 4.0, 6.0, 10.0)  # Student laws tried beside the normal law
PAYS = 4.0  # nats that tails must win
ROUNDS, STILL = 12, 1e-3
CHUNK = 4096  # readings
REFINE_ROUNDS = (0, 2, 4)  # rounds after which sizes and smoothness are chosen anew
FINEST = 1e-3  # of the readings: an unstated noise is never assumed smaller, even with few readings
SMALL_NOISE_RATIO = 0.45  # of the stated noise: half way (in ratio) to 1 / 4.848, arcsec taken for urad
EXCESS, CHANCE = (
    1.15,
    1e-3,
)  # a stated noise is raised where the residuals are larger by this and not by chance


@dataclass(frozen=True, eq=False)
class ReadingNoise:
    """Noise of one recording: scale times the stated u, dof of the law (inf: normal), outliers (m,) bool.

    quiet: the residuals over the stated u, where they are smaller than SMALL_NOISE_RATIO of it and not by chance; else 1.
    """

    scale: float
    dof: float
    outliers: npt.NDArray[np.bool_]
    quiet: float = 1.0

    @property
    def u(self) -> float:
        """Standard deviation over the stated u."""
        return self.scale * (np.sqrt(self.dof / (self.dof - 2)) if np.isfinite(self.dof) else 1.0)


@dataclass(frozen=True, eq=False)
class ErrorPosterior:
    """theta (size,), covariance (size, size) of the errors; instrument_errors (c,) of instruments in units of their u.

    residual: per recording (m,) mm or rad, after everything; noise per recording; information: NormalEquations with the weights of
    the covariance; numbers_used: numbers that the readings determine, together.
    """

    model: ErrorModel
    smooth: Smoothness
    theta: Array
    covariance: Array
    instrument_errors: Array
    instrument_names: tuple[str, ...]
    residual: tuple[Array, ...]
    noise: tuple[ReadingNoise, ...]
    information: NormalEquations
    numbers_used: float
    log_evidence: float


@dataclass(frozen=True, eq=False)
class WhitenedReadings:
    """A recording under weights: x = P root columns (m, size + c) and y = P root value (m,), P without the nuisance; gram = x' x.

    x is never made: of 10^5 readings it has as much as all that is known of them.
    """

    columns: Array
    basis: Array
    y: Array
    root: Array
    gram: Array

    @property
    def rank(self) -> int:
        return self.basis.shape[1]

    def predict(self, theta: Array) -> Array:
        """Return x theta, (m,)."""
        return self._without(self.root * (self.columns @ theta))

    def back_project(self, whitened: Array) -> Array:
        """Return x' of (m,), (size + c,)."""
        return np.asarray(self.columns.T @ (self.root * self._without(whitened)))

    def _without(self, whitened: Array) -> Array:
        return np.asarray(whitened - self.basis @ (self.basis.T @ whitened))

    def residual(self, mean: Array) -> Array:
        """Return the residual (m,) after errors, instrument and nuisance, mm or rad."""
        return np.asarray((self.y - self.predict(mean)) / self.root)

    def used_freedom(self, covariance: Array) -> float:
        """Return the degrees of freedom of the readings that the fit has used up."""
        return self.rank + float((self.gram * covariance).sum())


@dataclass(frozen=True, eq=False)
class Before:
    """Knowledge of theta before: factor (size, r) of its covariance; may_change (size,): 1 where it may have changed since."""

    factor: Array
    may_change: Array

    @staticmethod
    def nothing(model: ErrorModel) -> Before:
        return Before(np.zeros((model.size, 0)), np.ones(model.size))

    def lift(self, size: int) -> Array:
        """Return (theta, all numbers): theta = change + earlier knowledge; `size` numbers in all."""
        out = np.zeros((len(self.may_change), size))
        out[:, : len(self.may_change)] = np.diag(self.may_change)
        out[:, len(self.may_change) : len(self.may_change) + self.factor.shape[1]] = self.factor
        return out


def columns_of(parts: Sequence[Readings], before: Before) -> tuple[list[Array], tuple[str, ...]]:
    """Return per recording (m, size + r + c): change, earlier knowledge, own errors of all instruments; and the names of the own errors.

    Recordings that have an own error of the same name share it.
    """
    width = {name: c.shape[1] for p in parts for name, c in p.instrument_errors}
    start = dict(zip(width, np.cumsum([0, *width.values()])))
    out = []
    plain = not width and not before.factor.shape[1] and bool((before.may_change == 1).all())
    for part in parts if not plain else ():
        unknowns = np.zeros((part.m, sum(width.values())))
        for name, columns in part.instrument_errors:
            unknowns[:, start[name] : start[name] + width[name]] = columns
        out.append(
            np.concatenate([part.errors * before.may_change, part.errors @ before.factor, unknowns], axis=1)
        )
    names = (f"{n} {k + 1}" if count > 1 else n for n, count in width.items() for k in range(count))
    return ([p.errors for p in parts] if plain else out), tuple(names)


def project(part: Readings, columns: Array, weight: Array) -> WhitenedReadings:
    """Whiten by the root of the weights (m,) and take the nuisance out; gram by CHUNK readings at a time."""
    root = np.sqrt(weight)
    y = part.value * root
    basis = nuisance_basis(part.nuisance * root[:, None])
    parts = [slice(i, i + CHUNK) for i in range(0, part.m, CHUNK)]
    taken = np.sum([(basis[i] * root[i, None]).T @ columns[i] for i in parts], axis=0)
    gram = np.zeros((columns.shape[1], columns.shape[1]))
    for i in parts:
        x = columns[i] * root[i, None] - basis[i] @ taken
        gram += x.T @ x
    return WhitenedReadings(columns, basis, y - basis @ (basis.T @ y), root, gram)


def nuisance_basis(nuisance: Array) -> Array:
    """Return orthonormal columns that span the nuisance, (m, rank)."""
    return orthonormal(nuisance)


def normal_equations(whitened: Sequence[WhitenedReadings], model: ErrorModel) -> NormalEquations:
    """Return A and b of all recordings together."""
    a = np.sum([w.gram for w in whitened], axis=0)
    return NormalEquations(a, np.sum([w.back_project(w.y) for w in whitened], axis=0), model)


def solve(parts: Sequence[Readings], model: ErrorModel, earlier: Before | None = None) -> ErrorPosterior:
    """Compute the joint posterior. The parts' columns belong to this model; theta is the departure from the numbers known before."""
    earlier = earlier or Before.nothing(model)
    columns, names = columns_of(parts, earlier)
    noise = [ReadingNoise(1.0, np.inf if p.dof is None else p.dof, np.zeros(p.m, dtype=bool)) for p in parts]
    weights = [1.0 / p.u**2 for p in parts]
    smooth: Smoothness | None = None
    before: Array | None = None
    for turn in range(ROUNDS):
        white = [project(p, c, w) for p, c, w in zip(parts, columns, weights)]
        equations = normal_equations(white, model)
        if turn in REFINE_ROUNDS:
            smooth = smoothness(equations, smooth)
        assert smooth is not None
        mean, covariance = posterior(equations, smooth)
        residual = [w.residual(mean) for w in white]
        noise = [_noise(p, e, w.used_freedom(covariance)) for p, e, w in zip(parts, residual, white)]
        weights = [_weights(p, e, n) for p, e, n in zip(parts, residual, noise)]
        plain = all(np.isinf(n.dof) and n.scale == 1.0 for n in noise)
        still = before is not None and _change(mean, before, covariance) < STILL and turn > max(REFINE_ROUNDS)
        before = mean
        if still or plain:
            break
    assert smooth is not None
    fisher = [project(p, c, _information(p, n)) for p, c, n in zip(parts, columns, noise)]
    equations = replace(normal_equations(fisher, model), b=equations.b)
    _, covariance = posterior(equations, smooth)
    lift, size = earlier.lift(len(mean)), model.size + earlier.factor.shape[1]
    used = float((equations.a * covariance).sum())
    shared = sum(float(np.log(w.root).sum()) - float(w.y @ w.y) / 2 for w in white)
    return ErrorPosterior(
        model=model,
        smooth=smooth,
        theta=lift @ mean,
        covariance=lift @ covariance @ lift.T,
        instrument_errors=mean[size:],
        instrument_names=names,
        residual=tuple(residual),
        noise=tuple(noise),
        information=equations,
        numbers_used=used,
        log_evidence=smooth.log_evidence + shared,
    )


def posterior(information: NormalEquations, smooth: Smoothness) -> tuple[Array, Array]:
    """Return mean and covariance of theta and the numbers behind it."""
    return JointPosterior(information, smooth.sites).posterior()


def condition_on_prior(information: NormalEquations, factor: Array) -> tuple[Array, Array]:
    """Return mean and covariance under the prior factor @ factor.T."""
    mean, half = conditioned_factor(information, factor)
    return mean, half @ half.T


def conditioned_factor(information: NormalEquations, factor: Array) -> tuple[Array, Array]:
    """Return the mean, and a factor (p, r) of the covariance, under the prior factor @ factor.T."""
    conditioned = condition(information.a, information.b, factor)
    return conditioned.mean, conditioned.half


def _noise(part: Readings, residual: Array, spent: float) -> ReadingNoise:
    """Return scale and law of the residuals. A stated noise is kept unless the residuals contradict it."""
    e = residual / part.u * np.sqrt(part.m / max(part.m - spent, 1.0))
    left = max(part.m - spent, 1.0)
    dof = part.dof if part.dof is not None else _dof(e)
    scale = _t_scale(e, dof)
    if not part.stated:
        scale = max(scale, FINEST * float(np.sqrt((part.value**2).mean() / (part.u**2).mean())))
    if part.stated and not _too_large(scale, dof, part, left):
        scale = 1.0 if np.isinf(dof) or part.dof is not None else min(scale, 1.0)
    limit = 4.0 if np.isinf(dof) else 4.5
    return ReadingNoise(scale, dof, np.abs(e) > limit * scale, _quiet(e, part, left))


def _quiet(e: Array, part: Readings, left: float) -> float:
    """Return the rms of residuals (m,) in units of the stated u where it is small beyond chance (chi-squared with `left` dof), else 1."""
    from scipy.special import chdtr

    rms = float(np.sqrt((e**2).mean()))
    if not part.stated or rms > SMALL_NOISE_RATIO or chdtr(left, rms**2 * left) > CHANCE:
        return 1.0
    return rms


def _too_large(scale: float, dof: float, part: Readings, left: float) -> bool:
    """Return whether the residuals are larger than stated, beyond chance. For normal noise by chi-squared with `left` dof."""
    from scipy.special import chdtrc

    if scale < EXCESS:
        return False
    return bool(chdtrc(left, scale**2 * left) < CHANCE)


def _dof(e: Array) -> float:
    """Return the degrees of freedom of the law of the residuals (m,): the normal law unless tails win more than PAYS nats."""
    if len(e) < 20:
        return float(np.inf)
    best, most = float(np.inf), _likelihood(e, np.inf) + PAYS
    for dof in DOFS:
        value = _likelihood(e, dof)
        if value > most:
            best, most = dof, value
    return best


def _likelihood(e: Array, dof: float) -> float:
    """Return ln likelihood in nats of residuals (m,) by Student's law of the most likely scale; dof = inf: the normal law."""
    scale = max(_t_scale(e, dof), 1e-12)
    square = (e / scale) ** 2
    if np.isinf(dof):
        return float(-0.5 * square.sum() - len(e) * np.log(scale * np.sqrt(2 * np.pi)))
    top = lgamma((dof + 1) / 2) - lgamma(dof / 2) - np.log(scale * np.sqrt(dof * np.pi))
    return float(len(e) * top - (dof + 1) / 2 * np.log1p(square / dof).sum())


def _t_scale(e: Array, dof: float) -> float:
    """Return the maximum-likelihood scale of residuals (m,) for a law of `dof` (rms for the normal law)."""
    s2 = float((e**2).mean())
    if np.isinf(dof):
        return float(np.sqrt(s2))
    for _ in range(50):
        s2 = float(((dof + 1) * e**2 / (dof + e**2 / max(s2, 1e-300))).mean())
    return float(np.sqrt(s2))


def _weights(part: Readings, residual: Array, noise: ReadingNoise) -> Array:
    spread = noise.scale * part.u
    if np.isinf(noise.dof):
        return 1.0 / spread**2
    return np.asarray((noise.dof + 1) / (noise.dof + (residual / spread) ** 2) / spread**2)


def _information(part: Readings, noise: ReadingNoise) -> Array:
    share = 1.0 if np.isinf(noise.dof) else (noise.dof + 1) / (noise.dof + 3)
    return share / (noise.scale * part.u) ** 2


def _change(new: Array, old: Array, covariance: Array) -> float:
    """Return the largest change of a number in units of its u."""
    u = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return float((np.abs(new - old) / np.maximum(u, 1e-15)).max())
