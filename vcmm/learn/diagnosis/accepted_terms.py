"""Judge the chosen terms: which hold, their rivals, and the residual without a name.

A field without a name that is accepted is put beside the calibration, as one more covariance, and the search is made again.

Test the named terms against the simulator's own null, with no shape assumed, in two ways:

folds    recordings with exactly the fitted terms and the noise found are simulated, and every fold predicts its held-out
         rows from the others; a fold of the real recording that gains far less than they do holds a wrong shape
scatter  the scatter left over, against that of null recordings of the stated noise; an excess that no finding about the
         noise names may be physics that no covariate shows
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import (
    Whitener,
    condition,
    log_density,
)
from vcmm.core.run import Array
from vcmm.learn.diagnosis.answers import prefer_machine_terms
from vcmm.learn.diagnosis.candidates import Catalogue, Family
from vcmm.learn.diagnosis.constants import (
    CHANCE,
    EVEN_ODDS,
    FALSE_ALARM,
    FAR_SIGMAS,
    FEW,
    LEAST_SPREAD,
    MISMATCH,
    MOSTLY,
)
from vcmm.learn.diagnosis.families import use_simplest_members
from vcmm.learn.diagnosis.field import Field, kept_terms, rival_field
from vcmm.learn.diagnosis.holdout import (
    Fold,
    failing_terms,
    folds,
    is_free_curve,
    is_own_zone,
    wins_every_fold,
)
from vcmm.learn.diagnosis.kernels import find_departure
from vcmm.learn.diagnosis.log_mistakes import Mistake
from vcmm.learn.diagnosis.noise import Audit, chain_noise
from vcmm.learn.diagnosis.problem import FIELD, Problem, generator
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.rivals import Standing, compare_with_rivals
from vcmm.learn.diagnosis.search import SearchResult, Stage, build_stage, search, setting_of
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, Setting, fit_jointly, terms_basis
from vcmm.learn.diagnosis.unknown_shapes import add_shape_and_formula, find_modulation, find_unknown_shape


@dataclass(frozen=True, eq=False)
class AcceptedTerms:
    """Terms that hold, and their rivals. has_refused_terms: terms failed on rows held out; search_terms: all terms of the search;
    mistake_rivals: see SearchResult.
    """

    problem: Problem
    stage: Stage
    setting: Setting
    parts: Sequence[Fold]
    selection: Selection
    standings: Sequence[Standing]
    mistake: Mistake | None
    mistake_rivals: tuple[str, ...]
    has_refused_terms: bool
    field: Field | None = None
    unknown: Unknown | None = None
    search_terms: Sequence[SelectedTerm] = ()


def accept_terms(chosen: SearchResult, stage: Stage, seed: int, in_field: bool = False) -> AcceptedTerms:
    """Return the terms that hold, their probabilities, and a field that may replace them.

    in_field: a field is beside the calibration already. No further shape without physics is weighed, and a fold, in which
    the field is as free again, refuses no term here; terms that make rows worse are still not delivered.
    """
    used, selection = chosen.problem, chosen.selection
    setting = replace(setting_of(used, stage), start=selection.y)
    parts = folds(used, stage.u, stage.noise.rho)
    shapes = None if in_field else stage.generic
    searched, selection = selection, selection if in_field else _gate_terms(used, parts, selection, setting)
    failed = len(selection.terms) < len(searched.terms)
    selection = prefer_machine_terms(selection, _standings(selection, setting), setting)
    standings = _standings(selection, setting)
    simple = use_simplest_members(selection, [p.kin for p in standings if p.kin], setting)
    if simple is not selection:
        selection, standings = simple, _standings(simple, setting)
    field = rival_field(used, selection, setting, stage.sample, shapes) if selection.terms else None
    rest = _find_unknown(used, stage, selection, setting, parts, seed, field)
    return AcceptedTerms(
        used,
        stage,
        setting,
        parts,
        selection,
        standings,
        chosen.mistake,
        chosen.mistake_rivals,
        failed,
        field,
        rest,
        chosen.selection.terms,
    )


def search_beside_field(
    first: AcceptedTerms, catalogue: Catalogue, generics: Sequence[Family], seed: int, nulls: int
) -> AcceptedTerms:
    """Search again beside an accepted field, which then is one more covariance; return the first result where this finds nothing, or
    where nothing remains without a name.
    """
    if first.unknown is None or not first.search_terms:
        return first
    field = first.field or rival_field(first.problem, first.selection, first.setting, first.stage.sample)
    if field is None or not field.is_probable:
        return first
    beside = first.problem.with_statement(FIELD, field.columns)
    stage = build_stage(
        beside, _with_few_numbers(catalogue), generics, first.stage.noise, seed, nulls, first.stage.screen
    )
    chosen = search(beside, stage)
    second = accept_terms(chosen, chosen.stage, seed, in_field=True)
    if not second.selection.terms or _loses_name(first, second) or not _is_named_before(first, second):
        return first
    what = add_shape_and_formula(
        field.unknown, first.problem, first.setting, fit_jointly((), first.setting), first.parts
    )
    return replace(second, mistake=first.mistake, field=None, unknown=what)


def _with_few_numbers(effects_of_kinds: Catalogue) -> Catalogue:
    """Return the catalogue without names of more numbers than FEW, which are as free as a field."""
    kept = []
    for family in (f for f in effects_of_kinds.families if not is_free_curve(f.name)):
        few = tuple(o for o in family.options if o.columns.shape[1] <= FEW)
        kept += [replace(family, options=few)] if few else []
    return replace(effects_of_kinds, families=tuple(kept))


def _is_named_before(first: AcceptedTerms, second: AcceptedTerms) -> bool:
    """Return whether the first search named most of the signal that the second one names, perhaps as a curve. A field replaces the excess of
    a name; a signal that is new beside the field comes from what the field omits, and names with more numbers than the first
    ones are one of these in parts.
    """
    if _count_numbers(second.selection.terms) > _count_numbers(first.search_terms):
        return False
    white = first.stage.white
    basis = terms_basis(first.search_terms, first.problem.m)
    fit = second.selection.fit
    assert fit is not None
    for i, term in enumerate(second.selection.terms):
        signal = white.apply(term.option.columns @ fit.mean[second.selection.span(i)])
        if float(np.sum((basis.T @ signal) ** 2)) < MOSTLY * float(signal @ signal):
            return False
    return True


def _count_numbers(terms: Sequence[SelectedTerm]) -> int:
    """Return the number of free numbers of the terms, scanned values included."""
    return sum(t.option.freedom for t in terms)


def _loses_name(first: AcceptedTerms, second: AcceptedTerms) -> bool:
    """Return whether a name is missing that was found and wins all its folds. A free curve may be missing: it is as free as the field."""
    kept = _probable_ids(second)
    selection = first.selection
    gone = [i for i, t in enumerate(selection.terms) if t.family.id in _probable_ids(first) - kept]
    return any(
        wins_every_fold(first.problem, first.parts, selection, i)
        for i in gone
        if not is_free_curve(selection.terms[i].family.name)
    )


def _probable_ids(judgement: AcceptedTerms) -> set[str]:
    """Return the ids of the names that are more probable than not together with their exact aliases; a field makes none of them superfluous."""
    refused = (
        judgement.field.superfluous if judgement.field is not None and judgement.field.is_probable else ()
    )
    pairs = enumerate(zip(judgement.selection.terms, judgement.standings))
    return {t.family.id for i, (t, p) in pairs if i not in refused and p.alias_probability >= EVEN_ODDS}


def _gate_terms(problem: Problem, parts: Sequence[Fold], selection: Selection, setting: Setting) -> Selection:
    """Return the terms that predict rows held out: the one that fails worst is refused, the others are refitted and tested again."""
    while failed := failing_terms(problem, parts, selection):
        selection = fit_jointly([t for i, t in enumerate(selection.terms) if i != failed[0]], setting)
    return selection


def _standings(selection: Selection, setting: Setting) -> list[Standing]:
    return [compare_with_rivals(selection, setting, i) for i in range(len(selection.terms))]


def _find_unknown(
    problem: Problem,
    stage: Stage,
    selection: Selection,
    setting: Setting,
    parts: Sequence[Fold],
    seed: int,
    field: Field | None,
) -> Unknown | None:
    """Return the residual without a name: a field that beats the names, a shape in the residual, neighbours that agree, a field beside the names
    that is surer than shapes are in null recordings, else a fold that gains less than the names predict.
    """
    if field is not None and field.replaces_names:
        return add_shape_and_formula(
            field.unknown, problem, setting, fit_jointly(kept_terms(selection, field), setting), parts
        )
    unknown = find_unknown_shape(stage.generic, selection, stage.white, stage.chance, stage.generic_threshold)
    unknown = unknown or find_modulation(problem, selection, stage.white, stage.generic_threshold)
    unknown = unknown or find_departure(problem, selection, stage.white, stage.sample)
    if unknown is None and field is not None and field.lead > stage.generic_threshold:
        unknown = field.unknown
    unknown = add_shape_and_formula(unknown, problem, setting, selection, parts)
    fold = failing_fold(problem, parts, selection, stage.noise, stage.u, seed)
    return unknown_of_fold(fold) if fold and unknown is None else unknown


DRAWS = 400


def failing_fold(
    problem: Problem, parts: Sequence[Fold], selection: Selection, noise: Audit, u: Array, seed: int
) -> str:
    """Return the fold that falls short most, "" where the shortfall is within the 1 % of simulated recordings."""
    parts = [p for p in parts if not all(is_own_zone(t, p) for t in selection.terms)]
    if not parts or selection.fit is None:
        return ""
    columns = np.concatenate([t.option.columns for t in selection.terms], axis=1)
    width = np.concatenate([np.full(t.white.shape[1], t.width) for t in selection.terms])
    sample = _simulate(problem, selection, columns, noise, u, seed)
    raw = np.column_stack([problem.residual, sample])
    gains = np.stack([_gains_of_draws(p, columns, width, selection.fit.sigma, raw) for p in parts])
    simulated = gains[:, 1:]
    spread = np.maximum(simulated.std(axis=1), LEAST_SPREAD)[:, None]
    shortfall = (gains - simulated.mean(axis=1)[:, None]) / spread
    shortfall[:, 0] += _forgiven_nats(selection) / spread[:, 0]
    limit = float(np.quantile(shortfall[:, 1:].min(axis=0), FALSE_ALARM))
    worst = int(np.argmin(shortfall[:, 0]))
    return parts[worst].name if shortfall[worst, 0] < limit else ""


def _forgiven_nats(selection: Selection) -> float:
    """Return the nats lost to templates that are never exact, twice: a fold predicts from a part that has the error too."""
    return sum(0.5 * (2 * MISMATCH * selection.delta(i)) ** 2 for i in range(len(selection.terms)))


def _simulate(
    problem: Problem, selection: Selection, columns: Array, noise: Audit, u: Array, seed: int
) -> Array:
    """Simulate recordings (m, DRAWS) of the fitted terms, the noise found and the calibration; the nuisance is projected out later."""
    assert selection.fit is not None
    rng = generator(seed, "shortfall")
    dof = noise.noise.dof
    e = rng.standard_normal((problem.m, DRAWS))
    if np.isfinite(dof):
        e = rng.standard_t(dof, (problem.m, DRAWS)) * np.sqrt((dof - 2) / dof)
    if noise.rho:
        e = chain_noise(e, problem.before, noise.rho)
    calibration = problem.calibration @ rng.standard_normal((problem.calibration.shape[1], DRAWS))
    out = (columns @ selection.fit.mean)[:, None] + calibration + selection.fit.sigma * u[:, None] * e
    return np.asarray(out)


def _gains_of_draws(fold: Fold, columns: Array, width: Array, sigma: float, raw: Array) -> Array:
    """Return the log score (D,) that the terms win in the held-out rows of recordings raw (m, D), fitted on the other rows."""
    x, r = fold.fit_whitener.apply(columns[~fold.test]), fold.fit_whitener.apply(raw[~fold.test])
    posterior = condition(x.T @ x, x.T @ r, width)
    signal = x @ posterior.mean
    limited = signal + np.clip(r - signal, -FAR_SIGMAS * sigma, FAR_SIGMAS * sigma)
    mean = posterior.covariance @ (x.T @ limited)
    x, r = fold.test_whitener.apply(columns[fold.test]), fold.test_whitener.apply(raw[fold.test])
    before, rest = (np.clip(v, -FAR_SIGMAS * sigma, FAR_SIGMAS * sigma) / sigma for v in (r, r - x @ mean))
    return np.asarray(
        0.5 * (before**2).sum(axis=0) + log_density(rest, x, posterior.half)
    )  # in units of sigma


def unknown_of_fold(fold: str) -> Unknown:
    """Return the statement of a failing fold: where the named terms do not hold."""
    word = fold[-1] if fold.startswith("far zone") else fold.replace("later ", "").split()[0]
    text = f"the named terms, fitted on the other rows, do not predict the rows of the fold '{fold}': their shape is not right"
    return Unknown((word,), text, 0.0)


def scatter_excess(selection: Selection, white: Whitener, noise: Audit, null: Array) -> str:
    """Return the finding about a scatter beyond the null's quantile that nothing names; null (m, M) prepared white residuals."""
    if any("times what was stated" not in text for text in noise.findings):
        return ""  # outliers, tails, correlation, speed: the scatter has a name
    usual = np.sqrt((null**2).sum(axis=0) / white.dof)
    sigma = selection.sigma(white.dof)
    if sigma <= np.quantile(usual, CHANCE):
        return ""
    return (
        f"the scatter is {sigma / float(np.median(usual)):.2f} times what was stated, beyond what chance gives in"
        " 1 of 1000 recordings, and nothing found explains it: the noise is larger than stated, or there is physics that no"
        " column of the recording shows"
    )
