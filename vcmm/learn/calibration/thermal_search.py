"""The search behind a thermal model: amounts, lags, and how many terms (see vcmm.learn.calibration.thermal)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.calibration.solve import nuisance_basis
from vcmm.learn.calibration.thermal_terms import BLOCKS, SHORTEST, Term, WarmReadings

LAGS = (0.0, 60.0, 300.0, 1200.0, 4800.0, 19_200.0)  # s: where a search begins
SURE = 2.0  # amounts below so many u are not known
MOST_TERMS = 5  # terms
TWO = 1.5  # ratio from which on two lags of one sensor are two; nearer, their difference is a rate of change
STEP = 1e-3  # of ln tau, for slopes


@dataclass(frozen=True, eq=False)
class ThermalFit:
    """The readings, terms chosen so far, and their lags (s)."""

    parts: Sequence[WarmReadings]
    terms: tuple[Term, ...]
    lags: Array

    @property
    def longest(self) -> float:
        """Longest lag in s: three times the longest recording; a longer lag cannot be distinguished from a drift."""
        return 3 * max(float(np.ptp(p.observer.run.column("time_s"))) for p in self.parts)

    @property
    def numbers(self) -> int:
        """Number of amounts and lags."""
        return sum(1 + t.lag for t in self.terms)

    def mean_square(self) -> float:
        """Return the residual mean square of the terms, mm^2."""
        left, weight = self.solve(self.lags, self.weights())[1], self.weights()
        return sum(float(w @ e**2) for w, e in zip(weight, left)) / sum(float(w.sum()) for w in weight)

    def is_determined(self) -> bool:
        """Return whether every amount is beyond twice its u, and two lags of one sensor are distinct."""
        for i, term in enumerate(self.terms):
            for j in range(i):
                if self.terms[j].where == term.where and max(self.lags[i], self.lags[j]) < TWO * min(
                    self.lags[i], self.lags[j]
                ):
                    return False
        weight = self.weights()
        amounts, left = self.solve(self.lags, weight)
        spread = np.diag(self.covariance(amounts, left, weight))[: len(amounts)] * repeating(
            ordinary(self, left)
        )
        return bool((np.abs(amounts) > SURE * np.sqrt(np.maximum(spread, 0.0))).all())

    def columns(self, lags: Array) -> list[Array]:
        """Return the columns per recording (m, t)."""
        return [
            np.stack([p.column(t, float(tau)) for t, tau in zip(self.terms, lags)], axis=1)
            if self.terms
            else np.zeros((len(p.value), 0))
            for p in self.parts
        ]

    def solve(self, lags: Array, weight: Sequence[Array] | None = None) -> tuple[Array, list[Array]]:
        """Return amounts (t,), residuals per recording: weighted least squares, nuisance projected out."""
        weight = weight or [np.ones(len(p.value)) for p in self.parts]
        columns = self.columns(lags)
        x, y = _project_nuisance(self.parts, columns, weight)
        amounts = np.asarray(np.linalg.lstsq(x, y, rcond=1e-10)[0], dtype=np.float64)
        left = [
            _without(p.value - c @ amounts, p.nuisance, w) for p, c, w in zip(self.parts, columns, weight)
        ]
        return amounts, left

    def weights(self) -> list[Array]:
        """Return weights per recording (m,): 0 for single outlying readings."""
        return [p.weight for p in self.parts]

    def refine_lags(self) -> ThermalFit:
        """Return the same terms with their best lags."""
        from scipy.optimize import least_squares

        free = [i for i, t in enumerate(self.terms) if t.lag]
        if not free:
            return self
        weight = self.weights()

        def residual(logs: Array) -> Array:
            lags = self.lags.copy()
            lags[free] = np.exp(logs)
            x, y = _project_nuisance(self.parts, self.columns(lags), weight)
            return np.asarray(y - x @ np.linalg.lstsq(x, y, rcond=1e-10)[0])

        start = np.log(np.clip(self.lags[free], 2 * SHORTEST, self.longest / 1.1))
        optimum = least_squares(
            residual,
            start,
            bounds=(np.log(SHORTEST), np.log(self.longest)),
            diff_step=np.full(len(free), STEP),
            max_nfev=25,
        )
        lags = self.lags.copy()
        lags[free] = np.exp(optimum.x)
        return replace(self, lags=lags)

    def held_out(self) -> list[Array]:
        """Return the errors of every block of time as predicted from the others (lags unchanged)."""
        weight, columns = self.weights(), self.columns(self.lags)
        out = []
        for block in range(BLOCKS):
            kept = [w * (p.block != block) for w, p in zip(weight, self.parts)]
            x, y = _project_nuisance(self.parts, columns, kept)
            amounts = np.linalg.lstsq(x, y, rcond=1e-10)[0]
            rest = [
                _without(p.value - c @ amounts, p.nuisance, w)[(p.block == block) & (p.weight > 0)]
                for p, c, w in zip(self.parts, columns, kept)
            ]
            out.append(np.concatenate(rest))
        return out

    def covariance(self, amounts: Array, left: Sequence[Array], weight: Sequence[Array]) -> Array:
        columns, slopes = self.columns(self.lags), []
        for i, term in enumerate(self.terms):
            step = STEP * max(float(self.lags[i]), SHORTEST) * float(term.lag)
            moved = self.lags + step * (np.arange(len(self.lags)) == i)
            slopes.append(
                [
                    (b[:, i] - a[:, i]) * amounts[i] / (step or 1.0)
                    for a, b in zip(columns, self.columns(moved))
                ]
            )
        full = [np.column_stack([c, *(s[k] for s in slopes)]) for k, c in enumerate(columns)]
        x, _ = _project_nuisance(self.parts, full, weight)
        size = np.linalg.norm(x, axis=0)
        used = size > 0
        inverse = np.zeros((len(size), len(size)))
        inner = np.linalg.pinv((x[:, used] / size[used]).T @ (x[:, used] / size[used]), rcond=1e-12)
        inverse[np.ix_(used, used)] = inner / np.outer(size[used], size[used])
        e, w = np.concatenate(left), np.concatenate(weight)
        spare = max(len(e) - int(used.sum()) - sum(p.nuisance.shape[1] for p in self.parts), 1)
        return inverse * float((w * e**2).sum()) / spare


def select_terms(fit: ThermalFit, every: Sequence[Term]) -> ThermalFit:
    """Return, of all paths, the fit with the least Bayesian information criterion, n ln(mean square) + numbers ln n, n readings with
    new information: all of them over the repeats of the fit with the most independent residuals.

    Paths are made of every sensor by itself, and of all; a term that is not known (amount below twice its u) rules a fit out.
    """
    sensors = dict.fromkeys(t.sensor for t in every)
    ways = [[t for t in every if t.sensor in (sensor, "")] for sensor in sensors if len(sensors) > 1]
    fits = [f for way in [*ways, every] for f in _path(fit, way) if f.is_determined()]
    weight = fit.weights()
    least = min(repeating(ordinary(f, f.solve(f.lags, weight)[1])) for f in fits)
    n = sum(float(w.sum()) for w in weight) / least
    return min(fits, key=lambda f: n * np.log(f.mean_square() + 1e-300) + f.numbers * np.log(n))


def _path(fit: ThermalFit, every: Sequence[Term]) -> list[ThermalFit]:
    """Add term after term, each time the one with the smallest residual, and exchange terms while that pays."""
    path = [fit]
    while len(fit.terms) < MOST_TERMS:
        tried = [
            ThermalFit(fit.parts, (*fit.terms, t), np.append(fit.lags, tau))
            for t, tau in _candidate_terms(every, fit)
        ]
        if not tried:
            break
        fit = _exchange_terms(min(tried, key=ThermalFit.mean_square).refine_lags(), every)
        path.append(fit)
    return path


def _candidate_terms(every: Sequence[Term], fit: ThermalFit) -> list[tuple[Term, float]]:
    """Return the terms that may be added, with the initial lags: two per direction and sensor, one of the others."""
    return [
        (t, tau)
        for t in every
        if sum(t.where == o.where for o in fit.terms) < (2 if t.lag and len(t.where) == 2 else 1)
        for tau in (LAGS if t.lag else (0.0,))
        if tau < fit.longest
    ]


def _exchange_terms(fit: ThermalFit, every: Sequence[Term]) -> ThermalFit:
    """Return the fit with one term after the other exchanged for one with smaller residuals."""
    for i in range(len(fit.terms) - 1):
        rest = replace(fit, terms=(*fit.terms[:i], *fit.terms[i + 1 :]), lags=np.delete(fit.lags, i))
        tried = [
            replace(rest, terms=(*rest.terms, t), lags=np.append(rest.lags, tau))
            for t, tau in _candidate_terms(every, rest)
        ]
        new = min(tried, key=ThermalFit.mean_square).refine_lags()
        if new.mean_square() < fit.mean_square():
            fit = new
    return fit


def _project_nuisance(
    parts: Sequence[WarmReadings], columns: Sequence[Array], weight: Sequence[Array]
) -> tuple[Array, Array]:
    """Return all recordings whitened, nuisance projected out: (all m, t), (all m,)."""
    xs, ys = [], []
    for part, c, w in zip(parts, columns, weight):
        root = np.sqrt(w)
        basis = nuisance_basis(part.nuisance * root[:, None])
        x, y = c * root[:, None], part.value * root
        xs.append(x - basis @ (basis.T @ x))
        ys.append(y - basis @ (basis.T @ y))
    return np.concatenate(xs), np.concatenate(ys)


def _without(value: Array, nuisance: Array, weight: Array) -> Array:
    """Return the value (m,) less the nuisance as the weighted rows have it."""
    root = np.sqrt(weight)
    return np.asarray(
        value - nuisance @ np.linalg.lstsq(nuisance * root[:, None], value * root, rcond=1e-9)[0]
    )


def repeating(left: Sequence[Array]) -> float:
    """Return the number of readings with the same information: 1 + 2 sum of the correlations of the residuals, up to the first that is
    not positive."""
    total, counts = 0.0, 0
    for e in left:
        away = e - e.mean()
        power, time = float((away**2).sum()), 1.0
        for k in range(1, max(len(e) // 3, 1)):
            rho = float((away[k:] * away[:-k]).sum()) / max(power, 1e-300)
            if rho <= 0:
                break
            time += 2 * rho
        total, counts = total + time * len(e), counts + len(e)
    return total / counts


def ordinary(fit: ThermalFit, left: Sequence[Array]) -> list[Array]:
    """Return the residuals without those of outlying readings."""
    return [e[w > 0] for e, w in zip(left, fit.weights())]
