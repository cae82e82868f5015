"""The shape of physics that the catalogue does not hold: an additive Gaussian process over the localised covariates.

    d(z1, z2, z3) = f1(z1) + f2(z2) + f3(z3) + g(z1, z2), times one component of the sensitive direction

Each part has a squared-exponential kernel (periodic in an angle) in low rank: its principal functions on the rows. The
nuisance, the calibration and the named terms are projected out first, so the shape holds only what they cannot describe
(Plumlee, J. Am. Stat. Assoc. 112 (2017) 1274: orthogonal discrepancy). It describes the range of the rows and does not extrapolate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Posterior, Whitener, posterior, without_span
from vcmm.core.axes import is_rotary
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import LEAST_FRACTION
from vcmm.learn.diagnosis.locate import direction_factors, path_speed, without_unit
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.select import Selection

LENGTHS = (0.1, 0.25, 0.6)  # of the range of a covariate, tried
MOST_FUNCTIONS = 14  # principal functions of one part
GRID = 41
PAIR_GRID = 21
LEAST_VARIANCE = 1e-4  # of the variance of a kernel


@dataclass(frozen=True, eq=False)
class FittedShape:
    """names: one or two covariates; x (and y): grid; value, u on it (ny, nx for two), mm or rad; direction."""

    names: tuple[str, ...]
    direction: str
    x: Array
    y: Array | None
    value: Array
    u: Array


@dataclass(frozen=True, eq=False)
class KernelPart:
    """One kernel part over covariates: inducing places (k, d) in scaled units and its weights (k, r)."""

    covariates: tuple[int, ...]
    places: Array
    weights: Array
    length: float
    cyclic: tuple[bool, ...]

    def functions(self, z: Array) -> Array:
        """Return the principal functions (n, r) at scaled covariates z (n, all)."""
        return _kernel(z[:, list(self.covariates)], self.places, self.length, self.cyclic) @ self.weights


def covariate_values(problem: Problem, name: str) -> Array | None:
    """Return a covariate of the localisation by its name (m,): an axis, or a column without its unit."""
    run = problem.run
    if name in run.position:
        return problem.per_observation(run.position[name])
    for column, values in run.columns.items():
        if without_unit(column) == name:
            return problem.per_observation(values)
    speed = path_speed(run) if name == "speed" else None
    return None if speed is None else problem.per_observation(speed)


def is_angle(problem: Problem, name: str) -> bool:
    """Return whether the covariate is an angle, which is periodic."""
    return is_rotary(name) or any(
        without_unit(c) == name and c.endswith("_rad") and "since" not in c for c in problem.run.columns
    )


def fit_shape(
    problem: Problem,
    white: Whitener,
    selection: Selection,
    names: tuple[str, ...],
    direction: str,
    pair: bool,
    basis: Array,
) -> FittedShape | None:
    """Return the fitted discrepancy over the first covariate, or over the first two. basis: white span of the named terms."""
    values = [(n, v) for n in names if (v := covariate_values(problem, n)) is not None and np.ptp(v) > 0]
    if not values:
        return None
    scaled = np.stack([_scale_to(v, v) for _, v in values], axis=1)
    cyclic = tuple(is_angle(problem, n) for n, _ in values)
    turned = np.where(cyclic, np.stack([v for _, v in values], axis=1), scaled)
    modulator = direction_factors(problem).get(direction, np.ones(problem.m))
    size = float(np.median(problem.u))
    pair = pair and len(values) > 1
    best: tuple[Posterior, list[KernelPart]] | None = None
    for length in LENGTHS:
        parts = _parts(turned, cyclic, length, pair)
        columns = np.concatenate([p.functions(turned) for p in parts], axis=1) * modulator[:, None] * size
        x = without_span(white.apply(columns), basis)
        for s in SCALES:
            fit = posterior(x, selection.rest, white.dof, np.full(x.shape[1], s))
            if best is None or fit.log_evidence > best[0].log_evidence:
                best = fit, parts
    assert best is not None
    return _on_grid(best[0], best[1], turned, values, cyclic, direction, pair, size)


def _scale_to(v: Array, over: Array) -> Array:
    return np.asarray((v - over.min()) / max(float(np.ptp(over)), LEAST_FRACTION))


def _parts(z: Array, cyclic: tuple[bool, ...], length: float, pair: bool) -> list[KernelPart]:
    single = [_part(z, (i,), (cyclic[i],), length, GRID) for i in range(z.shape[1])]
    both = [_part(z, (0, 1), (cyclic[0], cyclic[1]), length, 9)] if pair else []
    return single + both


def _part(
    z: Array, which: tuple[int, ...], cyclic: tuple[bool, ...], length: float, count: int
) -> KernelPart:
    """Nystroem: eigenvectors of the kernel among inducing places (Rasmussen & Williams (2006), 8.1)."""
    ends = [(0.0, 2 * np.pi * (1 - 1 / count)) if c else (0.0, 1.0) for c in cyclic]
    mesh = np.meshgrid(*(np.linspace(a, b, count) for a, b in ends), indexing="ij")
    places = np.stack([m.ravel() for m in mesh], axis=1)
    value, vector = np.linalg.eigh(_kernel(places, places, length, cyclic))
    kept = np.argsort(-value)[: MOST_FUNCTIONS * len(which)]
    kept = kept[value[kept] > LEAST_VARIANCE * value.max()]
    return KernelPart(which, places, vector[:, kept] / np.sqrt(value[kept]), length, cyclic)


def _kernel(a: Array, b: Array, length: float, cyclic: tuple[bool, ...]) -> Array:
    """Return exp(-d^2 / 2 l^2); of an angle d = 2 sin(difference / 2) / (2 pi), MacKay's periodic kernel."""
    total = np.zeros((len(a), len(b)))
    for i, turns in enumerate(cyclic):
        gap = a[:, None, i] - b[None, :, i]
        total += (2 * np.sin(gap / 2) / (2 * np.pi) if turns else gap) ** 2
    return np.asarray(np.exp(-0.5 * total / length**2))


def _on_grid(
    fit: Posterior,
    parts: list[KernelPart],
    z: Array,
    values: list[tuple[str, Array]],
    cyclic: tuple[bool, ...],
    direction: str,
    pair: bool,
    size: float,
) -> FittedShape:
    """Return the fit along the first one or two covariates, the others held at their middle, about its mean."""
    shown_count = 2 if pair else 1
    count = PAIR_GRID if pair else GRID
    axes = [np.linspace(float(v.min()), float(v.max()), count) for _, v in values[:shown_count]]
    mesh = np.meshgrid(*axes, indexing="ij")
    at = np.tile(np.median(z, axis=0), (mesh[0].size, 1))
    for i in range(shown_count):
        at[:, i] = mesh[i].ravel() if cyclic[i] else _scale_to(mesh[i].ravel(), values[i][1])
    functions = np.concatenate([p.functions(at) for p in parts], axis=1) * size
    functions = functions - functions.mean(axis=0)
    value = functions @ fit.mean
    u = np.sqrt(np.maximum(np.einsum("nk,kl,nl->n", functions, fit.covariance, functions), 0.0))
    names = tuple(n for n, _ in values[:shown_count])
    if not pair:
        return FittedShape(names, direction, axes[0], None, value, u)
    form = (count, count)
    return FittedShape(names, direction, axes[0], axes[1], value.reshape(form).T, u.reshape(form).T)
