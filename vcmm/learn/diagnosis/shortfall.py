"""Do the named terms deliver what they promise? Two tests against the simulator's own null, with no shape assumed.

folds    recordings with exactly the fitted terms and the noise found are simulated, and every fold predicts its held-out
         rows from the others; a fold of the real recording that gains far less than they do holds a wrong shape
scatter  the scatter left over, against that of null recordings of the stated noise; an excess that no finding about the
         noise names may be physics that no covariate shows
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, condition, log_density
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import CHANCE, FALSE_ALARM, FAR, LEAST_SPREAD, MISMATCH
from vcmm.learn.diagnosis.holdout import Fold, tells
from vcmm.learn.diagnosis.noise import Audit, chain_noise
from vcmm.learn.diagnosis.problem import Problem, generator
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.select import Selection

DRAWS = 400


def failing_fold(
    problem: Problem, parts: Sequence[Fold], selection: Selection, noise: Audit, u: Array, seed: int
) -> str:
    """The fold that falls short most, "" where the shortfall is within the 1 % of simulated recordings."""
    parts = [p for p in parts if any(tells(t, p) for t in selection.terms)]
    if not parts or selection.fit is None:
        return ""
    columns = np.concatenate([t.option.columns for t in selection.terms], axis=1)
    width = np.concatenate([np.full(t.white.shape[1], t.width) for t in selection.terms])
    sample = _simulate(problem, selection, columns, noise, u, seed)
    raw = np.column_stack([problem.residual, sample])
    gains = np.stack([_gains(p, columns, width, selection.fit.sigma, raw) for p in parts])
    drawn = gains[:, 1:]
    spread = np.maximum(drawn.std(axis=1), LEAST_SPREAD)[:, None]
    short = (gains - drawn.mean(axis=1)[:, None]) / spread
    short[:, 0] += _forgiven(selection) / spread[:, 0]
    limit = float(np.quantile(short[:, 1:].min(axis=0), FALSE_ALARM))
    worst = int(np.argmin(short[:, 0]))
    return parts[worst].name if short[worst, 0] < limit else ""


def _forgiven(selection: Selection) -> float:
    """Nats lost to templates that are never quite right, twice: a fold predicts from a part that has the error too."""
    return sum(0.5 * (2 * MISMATCH * selection.delta(i)) ** 2 for i in range(len(selection.terms)))


def _simulate(
    problem: Problem, selection: Selection, columns: Array, noise: Audit, u: Array, seed: int
) -> Array:
    """Recordings (m, DRAWS) of the fitted terms, the noise found and the calibration; the nuisance is projected out later."""
    assert selection.fit is not None
    rng = generator(seed, "shortfall")
    dof = noise.noise.dof
    e = rng.standard_normal((problem.m, DRAWS))
    if np.isfinite(dof):
        e = rng.standard_t(dof, (problem.m, DRAWS)) * np.sqrt((dof - 2) / dof)
    if noise.rho:
        e = chain_noise(e, problem.before, noise.rho)
    known = problem.calibration @ rng.standard_normal((problem.calibration.shape[1], DRAWS))
    out = (columns @ selection.fit.mean)[:, None] + known + selection.fit.sigma * u[:, None] * e
    return np.asarray(out)


def _gains(fold: Fold, columns: Array, width: Array, sigma: float, raw: Array) -> Array:
    """Log score (D,) that the terms win in the held-out rows of recordings raw (m, D), fitted on the other rows."""
    x, r = fold.fitted.apply(columns[~fold.test]), fold.fitted.apply(raw[~fold.test])
    told = condition(x.T @ x, x.T @ r, width)
    signal = x @ told.mean
    limited = signal + np.clip(r - signal, -FAR * sigma, FAR * sigma)
    mean = told.covariance @ (x.T @ limited)
    x, r = fold.predicted.apply(columns[fold.test]), fold.predicted.apply(raw[fold.test])
    before, rest = (np.clip(v, -FAR * sigma, FAR * sigma) / sigma for v in (r, r - x @ mean))
    return np.asarray(0.5 * (before**2).sum(axis=0) + log_density(rest, x, told.half))  # in units of sigma


def of_fold(fold: str) -> Unknown:
    """What a failing fold says: where the named terms do not hold."""
    word = fold[-1] if fold.startswith("far zone") else fold.replace("later ", "").split()[0]
    text = f"the named terms, fitted on the other rows, do not predict the rows of the fold '{fold}': their shape is not right"
    return Unknown((word,), text, 0.0)


def scatter_excess(selection: Selection, white: Whitener, noise: Audit, null: Array) -> str:
    """The finding about a scatter beyond the null's quantile that nothing names; null (m, M) prepared white residuals."""
    if any("times what was stated" not in text for text in noise.findings):
        return ""  # outliers, tails, correlation, speed: the scatter has a name
    usual = np.sqrt((null**2).sum(axis=0) / white.dof)
    sigma = selection.fit.sigma if selection.fit else float(np.sqrt(selection.y @ selection.y / white.dof))
    if sigma <= np.quantile(usual, CHANCE):
        return ""
    return (
        f"the scatter is {sigma / float(np.median(usual)):.2f} times what was stated, beyond what chance gives in"
        " 1 of 1000 recordings, and nothing found explains it: the noise is larger than stated, or there is physics that no"
        " column of the recording shows"
    )
