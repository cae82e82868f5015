"""Hold-out gate: test whether a term predicts rows it has not seen, where the conditions go beyond those of the fit.

Folds extrapolate: another pose, the later time, the warmer rows, another speed, the far zone. Nuisance of the held-out
rows (their own pose) is fitted on them, which no method can avoid. A term must gain log score in most folds that excite
it, and never lose much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, log_density, posterior, whitener
from vcmm.core.axes import axis_of, is_rotary
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import (
    BLOCKS,
    EXCITATION_DELTA,
    FAR_SIGMAS,
    FEWEST,
    FORGIVEN,
    LEAST_FRACTION,
    STRONG,
    VERY_STRONG,
)
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.select import SelectedTerm, Selection
from vcmm.physics import BY_NAME
from vcmm.task.response.folds import FAR_ZONE, Mask, fold_masks


@dataclass(frozen=True)
class HeldOut:
    """One fold. rms in mm (or rad); effect_energy_left = (SS after - noise) / (SS before - noise); gain in nats.

    worse: SS after less SS before, in standard deviations of the SS of noise alone, sigma^2 sqrt(2 dof).
    """

    fold: str
    rms_before: float
    rms_after: float
    effect_energy_left: float
    gain: float
    worse: float = 0.0


@dataclass(frozen=True, eq=False)
class Fold:
    """Rows held out (m,) and the whiteners of what is fitted and what is predicted."""

    name: str
    test: Mask
    fit_whitener: Whitener
    test_whitener: Whitener


def folds(problem: Problem, u: Array, rho: float) -> list[Fold]:
    """Return all extrapolating folds that the columns of the recording allow."""
    out = []
    for name, test in fold_masks(problem.run, problem.recording.row):
        if FEWEST <= test.sum() <= problem.m - FEWEST:
            try:
                out.append(make_fold(problem, u, rho, name, test))
            except ModelLimit:
                continue  # too few rows for their nuisance
    return out


def make_fold(problem: Problem, u: Array, rho: float, name: str, test: Mask) -> Fold:
    """Return the rows `test` held out. Raises ModelLimit where either part has too few rows for its nuisance."""
    return Fold(name, test, *(_part_whitener(problem, u, rho, k) for k in (~test, test)))


def _part_whitener(problem: Problem, u: Array, rho: float, rows: Mask) -> Whitener:
    number = np.cumsum(rows) - 1
    before = problem.before[rows]
    inside = (before >= 0) & rows[np.maximum(before, 0)]
    near = np.where(inside, number[np.maximum(before, 0)], -1)
    return whitener(u[rows], problem.nuisance[rows], problem.calibration[rows], near, rho)


def predict_fold(
    problem: Problem, fold: Fold, selection: Selection, terms: Sequence[SelectedTerm]
) -> HeldOut:
    """Fit `terms` on the other rows, predict the held-out ones. `problem.residual` is used without clipping back."""
    raw = problem.residual
    r_fit, r_test = fold.fit_whitener.apply(raw[~fold.test]), fold.test_whitener.apply(raw[fold.test])
    sigma = selection.fit.sigma if selection.fit else 1.0
    before = float(r_test @ r_test)
    if not terms:
        return HeldOut(fold.name, 0.0, 0.0, 1.0, 0.0)
    columns = np.concatenate([t.option.columns for t in terms], axis=1)
    x_fit, x_test = fold.fit_whitener.apply(columns[~fold.test]), fold.test_whitener.apply(columns[fold.test])
    width = np.concatenate([np.full(t.white.shape[1], t.width) for t in terms])
    limited = _limit_outliers(x_fit, r_fit, fold.fit_whitener.dof, width, sigma)
    fit = posterior(x_fit, limited, fold.fit_whitener.dof, width)
    rest = r_test - x_test @ fit.mean
    after = float(rest @ rest)
    noise = fold.test_whitener.dof * sigma**2
    unit = float(np.sqrt(np.mean(fold.test_whitener.weight**-2.0) / fold.test_whitener.dof))
    left = max(after - noise, 0.0) / max(before - noise, LEAST_FRACTION) if before > noise else float("nan")
    gain = _log_score(rest, x_test, fit.covariance, sigma) - _log_score(r_test, x_test[:, :0], None, sigma)
    worse = (after - before) / (sigma**2 * float(np.sqrt(2.0 * fold.test_whitener.dof)))
    return HeldOut(fold.name, unit * before**0.5, unit * after**0.5, left, gain, worse)


def worsened_folds(
    problem: Problem, parts: Sequence[Fold], selection: Selection, noise: tuple[Array, float] | None = None
) -> tuple[str, ...]:
    """Return the folds that the terms make worse, beyond the noise of a fold; a free curve is not tested beyond its own zone.

    noise: u (m,) and correlation, where the far zone of an axis is not to decide alone (see `predicts_blocks`).
    """
    out = []
    for part in parts:
        terms = [t for t in selection.terms if not is_own_zone(t, part)]
        if terms and predict_fold(problem, part, selection, terms).worse > FAR_SIGMAS:
            axis = part.name.removeprefix(FAR_ZONE) if part.name.startswith(FAR_ZONE) else ""
            if axis and noise is not None and predicts_blocks(problem, noise, selection, axis):
                continue
            out.append(part.name)
    return tuple(out)


def predicts_blocks(problem: Problem, noise: tuple[Array, float], selection: Selection, axis: str) -> bool:
    """Return whether the terms predict blocks along an axis from their neighbours, both ways and by more than STRONG nats.

    Of the far zone of an axis the other rows say nothing but what a shape says beyond its ends, and several that are right together
    may go astray there. A file is used where rows were: so BLOCKS blocks of as many rows, every second one held out, decide.
    """
    place = problem.run.position[axis][problem.recording.row]
    edges = np.quantile(place, np.arange(1, BLOCKS) / BLOCKS)
    odd = np.searchsorted(edges, place, side="right") % 2 == 1
    if min(odd.sum(), (~odd).sum()) < FEWEST:
        return False
    try:
        halves = [make_fold(problem, *noise, f"blocks of {axis}", rows) for rows in (odd, ~odd)]
    except ModelLimit:
        return False
    halves_held = [predict_fold(problem, fold, selection, selection.terms) for fold in halves]
    return (
        all(h.gain > 0.0 and h.worse < 0.0 for h in halves_held) and sum(h.gain for h in halves_held) > STRONG
    )


def _limit_outliers(x: Array, r: Array, dof: int, width: Array, sigma: float) -> Array:
    """Return the residuals with outliers pulled to 3 sigma of a first fit."""
    signal = x @ posterior(x, r, dof, width).mean
    return np.asarray(signal + np.clip(r - signal, -FAR_SIGMAS * sigma, FAR_SIGMAS * sigma))


def _log_score(rest: Array, x: Array, covariance: Array | None, sigma: float) -> float:
    """Return ln predictive density of white residuals, parameters' covariance included; outliers count as 3 sigma."""
    rest = np.clip(rest, -FAR_SIGMAS * sigma, FAR_SIGMAS * sigma)
    if covariance is None or x.shape[1] == 0:
        return -0.5 * float(rest @ rest) / sigma**2
    return float(log_density(rest / sigma, x / sigma, np.asarray(np.linalg.cholesky(covariance))))


def failing_terms(problem: Problem, parts: Sequence[Fold], selection: Selection) -> list[int]:
    """Return the numbers of the terms that fail: they lose much in a fold, or win in too few of the folds that excite them.

    The one that loses most comes first: terms that lean on one another are refused one at a time.
    """
    failed: list[tuple[float, int]] = []
    for i in range(len(selection.terms)):
        gains = _gains(problem, parts, selection, i)
        if len(gains) and _is_refused(gains):
            failed.append((float(gains.min()), i))
    return [i for _, i in sorted(failed)]


def wins_every_fold(problem: Problem, parts: Sequence[Fold], selection: Selection, i: int) -> bool:
    """Return whether term i gains in every fold that tests it, together more than VERY_STRONG nats."""
    gains = _gains(problem, parts, selection, i)
    return bool(len(gains)) and float(gains.min()) > 0.0 and float(gains.sum()) > VERY_STRONG


def _gains(problem: Problem, parts: Sequence[Fold], selection: Selection, i: int) -> Array:
    """Return the nats that term i wins beside the others in each fold that tests it."""
    term = selection.terms[i]
    others = [t for t in selection.terms if t is not term]
    gains = []
    for fold in parts:
        if _fitted_size(fold, selection, i) > EXCITATION_DELTA:
            with_it = predict_fold(problem, fold, selection, selection.terms).gain
            without = predict_fold(problem, fold, selection, others).gain
            is_told = _held_out_size(fold, selection, i) > EXCITATION_DELTA or abs(with_it - without) > STRONG
            if is_told and (with_it > without or not is_own_zone(term, fold)):
                gains.append(with_it - without)
    return np.array(gains)


def _is_refused(gains: Array) -> bool:
    """Return whether a term is refused: it loses overall, wins too seldom, or makes one kind of rows clearly worse: the log score knows
    the noise and how
    uncertain the term is there, so a large loss is a wrong shape. A part of what it wins elsewhere is forgiven, because
    no template is exact.
    """
    won = float(gains[gains > 0].sum())
    worst = float(gains.min())
    return (
        (worst < -STRONG and float(gains.sum()) < 0)
        or float(np.mean(gains > -0.5)) < 0.5
        or worst < -max(2.0 * STRONG, FORGIVEN * won)
    )


def is_free_curve(name: str) -> bool:
    return name in BY_NAME and BY_NAME[name].diagnosis.is_free_curve


def is_own_zone(term: SelectedTerm, fold: Fold) -> bool:
    """Return whether a fold is in the own zone of a free curve: a curve says nothing of a zone of its axis on which it was not fitted,
    nor do the harmonics of a turn of
    a part of the turn.
    """
    axis = axis_of(str(term.family.where.get("component", ""))) or str(term.family.where.get("axis", ""))
    effect = term.option.effect
    harmonics = effect is not None and effect.diagnosis.size_name == "amplitude" and is_rotary(axis)
    return (is_free_curve(term.family.name) or harmonics) and fold.name == f"{FAR_ZONE}{axis}"


def shows_any_term(fold: Fold, selection: Selection) -> bool:
    """Return whether any term is seen in the rows held out; otherwise no term predicts them, before and after."""
    sizes = [_held_out_size(fold, selection, i) for i in range(len(selection.terms))]
    return any(size > EXCITATION_DELTA for size in sizes)


def _fitted_size(fold: Fold, selection: Selection, i: int) -> float:
    """Return the size of term i in the rows fitted, in units of the noise: whether it is determined there."""
    return _size(fold.fit_whitener, ~fold.test, selection, i)


def _held_out_size(fold: Fold, selection: Selection, i: int) -> float:
    """Return the same in the rows held out. They may still determine a term that is not seen there: it changes the other
    terms, and so their predictions (a bed that is hot while the frame warms).
    """
    return _size(fold.test_whitener, fold.test, selection, i)


def _size(white: Whitener, rows: Mask, selection: Selection, i: int) -> float:
    assert selection.fit is not None
    signal = selection.terms[i].option.columns @ selection.fit.mean[selection.span(i)]
    return float(np.linalg.norm(white.apply(signal[rows]))) / selection.fit.sigma
