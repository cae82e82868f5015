"""Compress a recording to its information on the tracked numbers: a few rows with unit noise.

    value = C theta + N (nuisance) + K k (known here) + e,   cov e = diag(u^2)

Whitened by u^2 + K K', the nuisance projected out, and then turned by the left singular vectors of the columns: the remainder is the
scatter about the best fit, which shows the size of the noise. A stated noise is raised where that scatter is larger by a
share and beyond chance, by the rule of `vcmm calibrate`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.learn.calibration.solve import CHANCE, EXCESS, nuisance_basis
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.tracking.kalman import chance_beyond
from vcmm.learn.tracking.quantities import TrackedMachine
from vcmm.task.response.observe import missing_columns
from vcmm.task.response.recording import Recording

RANK = 1e-9  # of the largest singular value: below it a combination is not seen
CLIP = 4.5  # of the scatter: a reading farther off is pulled in


@dataclass(frozen=True, eq=False)
class SeenRecording:
    """columns (r, stated + g), value (r,): unit noise. noise: scale of the stated u that was used; rest: degrees of freedom left over.

    rows: observations; rms_before: of the residuals about the machine file, nuisance free, mm or rad; outliers: pulled in.
    """

    name: str
    when: float
    columns: Array
    value: Array
    noise: float
    rest: int
    rows: int
    rms_before: float
    outliers: int

    @property
    def rank(self) -> int:
        return len(self.value)


def see_recording(tracked: TrackedMachine, recording: Recording, name: str, when: float) -> SeenRecording:
    """name: its file; when: days. Raises ModelLimit for positions beyond the machine's tables or travels, naming the file."""
    try:
        problem = make_problem(recording, tracked.machine)
        columns = columns_of(tracked, problem)
    except ModelLimit as error:
        raise ModelLimit(f"{name}: {error}") from None
    root = _root(tracked, problem)
    basis = nuisance_basis(_divide(root, problem.nuisance))
    x, y = _divide(root, columns), _divide(root, problem.residual[:, None])[:, 0]
    x, y = x - basis @ (basis.T @ x), y - basis @ (basis.T @ y)
    left, size, right = np.linalg.svd(x, full_matrices=False)
    kept = size > RANK * max(float(size[0]) if len(size) else 0.0, 1e-300)
    left = left[:, kept]
    rest = len(y) - basis.shape[1] - left.shape[1]
    y, outliers = _pull_in(y, left, rest)
    value = left.T @ y
    noise = _noise(float(y @ y - value @ value), rest)
    before = float(np.sqrt(((y * problem.u) ** 2).mean()))
    return SeenRecording(
        name,
        when,
        size[kept, None] * right[kept] / noise,
        value / noise,
        noise,
        rest,
        len(y),
        before,
        outliers,
    )


def columns_of(tracked: TrackedMachine, problem: Problem) -> Array:
    """Return the change of every observation per unit of each number, (m, stated + g)."""
    rows = tracked.rows
    out = np.zeros((problem.m, tracked.factor.shape[0]))
    for q in tracked.quantities:
        if not missing_columns(q.effect, problem.run):
            out[:, rows[q.id]] = problem.observer.of_parameter(q.effect, q.parameter)
    return np.concatenate([out @ tracked.factor, out @ tracked.growth], axis=1)


def _root(tracked: TrackedMachine, problem: Problem) -> Array:
    """Return the root (m,) or lower (m, m) of the covariance of the noise and of the uncertainty of this recording alone."""
    columns_of_stated = [columns for name, columns in problem.stated if name not in tracked.input_ids]
    if not columns_of_stated:
        return problem.u
    stated = np.concatenate(columns_of_stated, axis=1)
    return np.asarray(np.linalg.cholesky(np.diag(problem.u**2) + stated @ stated.T), dtype=np.float64)


def _divide(root: Array, columns: Array) -> Array:
    if root.ndim == 1:
        return columns / root[:, None]
    from scipy.linalg import solve_triangular

    return np.asarray(solve_triangular(root, columns, lower=True))


def _pull_in(y: Array, left: Array, rest: int) -> tuple[Array, int]:
    """Pull readings far from the best fit to CLIP scatters (three rounds); return them and their number."""
    if rest < 10:
        return y, 0
    out, far = y, np.zeros(len(y), dtype=bool)
    for _ in range(3):
        fit = left @ (left.T @ out)
        away = y - fit
        scale = max(1.4826 * float(np.median(np.abs(away))) * np.sqrt(len(y) / rest), 1e-300)
        far = np.abs(away) > CLIP * scale
        if not far.any():
            break
        out = np.where(far, fit + np.sign(away) * CLIP * scale, y)
    return out, int(far.sum())


def _noise(square: float, rest: int) -> float:
    """Scale of the stated noise: 1 unless the scatter is larger by a share and beyond chance."""
    if rest < 1:
        return 1.0
    scale = float(np.sqrt(max(square, 0.0) / rest))
    return scale if scale > EXCESS and chance_beyond(rest, square) < CHANCE else 1.0


def turn_columns(recording: SeenRecording, ways: Array) -> SeenRecording:
    """Return the same with columns @ ways: fewer numbers, where the others are not seen."""
    return replace(recording, columns=recording.columns @ ways)
