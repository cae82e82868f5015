"""Deliver a diagnosis: exactly the terms that are written, fitted again to all rows without the others.

Where a term is an Input of the machine file (its squareness, stated with an uncertainty), the statement no longer holds once
the rows have contradicted it: the quantity is then free, and the rows alone determine its size.

A set of terms that makes its own rows worse, or rows held out beyond the chance of a fold, is not delivered: terms are removed until
it does neither. `reasons_withheld` says which and why.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import best_width, without_span
from vcmm.core.run import Array
from vcmm.learn.diagnosis.comparison import remove_nuisance
from vcmm.learn.diagnosis.constants import LEAST_FRACTION, STRUCTURE_CORRELATION
from vcmm.learn.diagnosis.holdout import Fold, folds, worsened_folds
from vcmm.learn.diagnosis.problem import FIELD, Problem
from vcmm.learn.diagnosis.search import Stage, setting_under
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, Setting, fit_jointly, refit, terms_basis

OWN_ROWS = "the rows to which it was fitted become worse with it"


@dataclass(frozen=True, eq=False)
class DeliveredTerms:
    """problem: without the statements that the terms replace; selection: the refit; parts: its folds.

    number: the terms by their numbers in the selection they came from; withheld: number -> why it is not delivered.
    """

    problem: Problem
    selection: Selection
    parts: Sequence[Fold]
    number: tuple[int, ...]
    reasons_withheld: Mapping[int, str]

    def term(self, i: int) -> int | None:
        """Return the place of term i in the refit; None where it is not delivered."""
        return self.number.index(i) if i in self.number else None


def deliver_terms(
    problem: Problem,
    stage: Stage,
    terms: Sequence[SelectedTerm],
    wanted: Sequence[int],
    ready_folds: Sequence[Fold] | None = None,
) -> DeliveredTerms:
    """Refit the terms with the numbers `wanted`, less those that make rows worse. ready_folds: the folds of the problem, where they
    were made already.
    """
    gone = replaced_inputs(problem, [terms[i] for i in wanted])
    moving = moves_together(stage)
    gone = (
        (*gone, FIELD) if moving else gone
    )  # a field beside the names takes most of what rows that move together show
    free = problem.without_statements(gone)
    setting = setting_for(free, stage)
    given_folds = ready_folds if not gone and not moving else None
    noise = noise_for_fit(free, stage)
    parts = folds(free, *noise) if given_folds is None else given_folds
    if moving:
        terms = _in_best_shapes(terms, wanted, setting)
    number, withheld = tuple(wanted), dict[int, str]()
    now = _refit(number, terms, setting)
    while number:
        trouble = _reasons_against(free, parts, now, noise)
        if not trouble:
            break
        rest = [tuple(k for k in number if k != i) for i in number]
        tried = [_refit(r, terms, setting) for r in rest]
        best = min(
            range(len(rest)),
            key=lambda j: (
                len(_reasons_against(free, parts, tried[j], noise)),
                rms_after_terms(free, tried[j]),
            ),
        )
        (worst,) = set(number) - set(rest[best])
        withheld[worst] = trouble[0]
        number, now = rest[best], tried[best]
    return DeliveredTerms(free, now, parts, number, withheld)


def replaced_inputs(problem: Problem, terms: Sequence[SelectedTerm]) -> tuple[str, ...]:
    """Return the ids of the Inputs on the effects that the terms are: those of one number, which the term is too."""
    effects = {t.option.effect.id for t in terms if t.option.effect is not None}
    return tuple(
        n for n, columns in problem.stated if columns.shape[1] == 1 and n.rsplit(".", 1)[0] in effects
    )


def setting_for(problem: Problem, stage: Stage) -> Setting:
    """Return the setting for a fit of given names under another calibration: every row as it is, outliers about the fit; the noise
    is not estimated again.

    Where neighbours are so similar that the residual is a movement and no scatter, innovations would weigh its jumps alone and the sizes would not be
    those that the rows show: the rows count as independent, and the covariance is that of a mean of such rows, (1 + rho) / (1 - rho) times as
    large (Priestley, Spectral Analysis and Time Series (1981), 5.3).
    """
    setting = setting_under(problem, stage, problem.whitener(*noise_for_fit(problem, stage)))
    spread = (1.0 + stage.noise.rho) / (1.0 - stage.noise.rho) if moves_together(stage) else 1.0
    return replace(setting, start=setting.raw, spread=spread)


def moves_together(stage: Stage) -> bool:
    """Return whether the residual of the names is a movement and no scatter."""
    return stage.noise.rho >= STRUCTURE_CORRELATION


def noise_for_fit(problem: Problem, stage: Stage) -> tuple[Array, float]:
    """Return u (m,) and correlation of neighbours for the fit of sizes; a movement has no scatter that depends on the speed."""
    return (problem.u, 0.0) if moves_together(stage) else (stage.u, stage.noise.rho)


def _in_best_shapes(
    terms: Sequence[SelectedTerm], wanted: Sequence[int], setting: Setting
) -> list[SelectedTerm]:
    """Return the terms, those wanted in the shape of their family that explains most of the rows as they are, one given the others."""
    out = list(terms)
    for i in wanted:
        others = fit_jointly(
            [replace(out[j], white=setting.white.apply(out[j].option.columns)) for j in wanted if j != i],
            setting,
        )
        y, basis = setting.raw, terms_basis(others.terms, len(setting.raw))
        rest = without_span(y, basis)
        best = max(
            out[i].family.options,
            key=lambda o: (
                best_width(
                    without_span(setting.white.apply(o.columns), basis), rest, setting.candidates.dof
                ).log_evidence
                + o.log_prior
            ),
        )
        out[i] = replace(out[i], option=best)
    return out


def _refit(number: Sequence[int], terms: Sequence[SelectedTerm], setting: Setting) -> Selection:
    return refit([terms[i] for i in number], setting) if number else fit_jointly((), setting)


def _reasons_against(
    problem: Problem, parts: Sequence[Fold], now: Selection, noise: tuple[Array, float]
) -> list[str]:
    """Return why a set of terms is not delivered, in words; empty where it may be."""
    if not now.terms:
        return []
    out = [
        f"it makes rows worse that were not fitted ({fold})"
        for fold in worsened_folds(problem, parts, now, noise)
    ]
    plain = rms_after_terms(problem, replace(now, terms=(), fit=None))
    return ([OWN_ROWS] if rms_after_terms(problem, now) > plain else []) + out


def rms_after_terms(problem: Problem, selection: Selection) -> float:
    """Return the rms of all rows as they are, mm or rad, after the terms and the nuisance refitted."""
    rest = _beside_nuisance(problem, residual_after_terms(problem, selection))
    return float(np.sqrt(np.mean(rest**2)))


def _beside_nuisance(problem: Problem, values: Array) -> Array:
    """Return values (m,) of the rows without nuisance, beside the known uncertainty of this recording."""
    return remove_nuisance(values, problem.nuisance, problem.u, problem.own_uncertainty)[0]


def residual_after_terms(problem: Problem, selection: Selection) -> Array:
    """Return the residual (m,) less the signals of the terms."""
    if selection.fit is None:
        return problem.residual
    columns = np.concatenate([t.option.columns for t in selection.terms], axis=1)
    return np.asarray(problem.residual - columns @ selection.fit.mean)


def shares_of_rows(problem: Problem, selection: Selection) -> tuple[float, ...]:
    """Return, of the excess energy of the rows as they are, the nuisance refitted, the share of every term."""
    if selection.fit is None:
        return ()
    weight = 1.0 / problem.u
    alone = [
        weight * _beside_nuisance(problem, t.option.columns @ selection.fit.mean[selection.span(i)])
        for i, t in enumerate(selection.terms)
    ]
    before = weight * _beside_nuisance(problem, problem.residual)
    noise = (problem.m - problem.nuisance.shape[1]) * selection.fit.sigma**2
    excess = max(float(before @ before) - noise, LEAST_FRACTION)
    return tuple(float(np.clip(s @ s / excess, 0.0, 1.0)) for s in alone)
