"""From terms that were judged to the diagnosis: numbers, rivals, what is left, what could not have been seen, what to measure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import nan

import numpy as np

from vcmm.learn.diagnosis.aliases import unresolved_shapes, with_aliases
from vcmm.learn.diagnosis.all_rows import mistake_on_all_rows, on_all_rows
from vcmm.learn.diagnosis.answers import NamedTerms, answers
from vcmm.learn.diagnosis.candidates import Catalogue
from vcmm.learn.diagnosis.confusion import Standing
from vcmm.learn.diagnosis.contradictions import add_contradictions, pulls_of, told_pulls, unexplained_pulls
from vcmm.learn.diagnosis.delivery import DeliveredTerms, deliver_terms, rms_left
from vcmm.learn.diagnosis.evidence import scorer
from vcmm.learn.diagnosis.holdout import Fold, HeldOut, judge, says_something
from vcmm.learn.diagnosis.judgement import Judgement
from vcmm.learn.diagnosis.locate import locate, score_map
from vcmm.learn.diagnosis.mistakes import MISTAKE, Mistake
from vcmm.learn.diagnosis.nextstep import closer, next_steps
from vcmm.learn.diagnosis.null import clip_residuals
from vcmm.learn.diagnosis.power import power
from vcmm.learn.diagnosis.problem import FIELD, Problem
from vcmm.learn.diagnosis.result import STATUS_NOT_MODELLED, Answer, Diagnosis, Fit
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import Selection, mismatch
from vcmm.learn.diagnosis.shortfall import scatter_excess
from vcmm.learn.diagnosis.table_renewal import is_stale, renew_tables
from vcmm.learn.diagnosis.thinning import loss, thinning_text
from vcmm.learn.diagnosis.verdict import beyond, clear_places, curves, doubts, reasons, verdict


def account(one: Judgement, known: Catalogue, searched: Problem, whole: Problem, seed: int) -> Diagnosis:
    """The diagnosis of what was judged in the rows that were searched, with numbers of all rows; these may be the same."""
    stage, mistake, used, rest = one.stage, one.mistake, one.problem, one.rest
    sigma = _sigma(one.selection, stage)
    places = _with_other_rivals(one.places, used, stage, one.selection, one.tied)
    named = add_contradictions(NamedTerms(used, stage, one.selection, places, one.field))
    found = [i for i, a in enumerate(named.probabilities()) if not a.doubtful]
    screen = stage.screen or stage
    shown, hidden = power(screen.found, sigma / loss(len(screen.u), len(stage.u)))
    steps = (*next_steps(used, one.setting, named.selection, named.places), *closer(used, rest))
    if searched is not whole and not _has_field(used):
        mistake, whole = mistake_on_all_rows(mistake, whole)
        named = on_all_rows(named, whole, seed)
    given, every = _determine(named, found, one.parts if named.problem is used else None, mistake, seed)
    every, held, unmodelled = _renew_tables(every, given, named.stage)
    excess = "" if rest else scatter_excess(one.selection, stage.white, stage.noise, stage.sample)
    pulls = pulls_of(given, named.stage)
    against = (*unmodelled, *_of_noise(one, every, searched, excess), *unexplained_pulls(pulls, given))
    y = clip_residuals(stage.white.apply(searched.residual), stage.white, stage.noise.noise.clip)
    is_named = any(not a.doubtful for a in every) or mistake is not None
    places_of, unnamed = clear_places(
        locate(scorer(stage.generic), y, stage.chance), is_named or bool(against)
    )
    against = (*against, *unnamed)
    predicted = tuple(
        judge(given.problem, f, given.selection, given.selection.terms)
        for f in given.parts
        if says_something(f, given.selection)
    )
    scatter = _sigma(named.selection, named.stage) * float(np.sqrt(np.mean(named.stage.u**2)))
    left = rms_left(named.problem, named.selection)
    return Diagnosis(
        STATUS_NOT_MODELLED if unmodelled and is_named else verdict(is_named, against),
        every,
        rest,
        places_of,
        mistake,
        scatter,
        (*stage.noise.findings, *([excess] if excess else [])),
        Fit(nan, nan, scatter, (*predicted, *held) if given.selection.terms else (), left),
        known.not_testable,
        _unique_places((*known.unseen, *screen.found.invisible, *hidden)),
        shown,
        steps,
        stage.threshold,
        seed,
        searched.recording.kind == "angle",
        map=score_map(scorer(stage.generic), y),
        chance=stage.generic_threshold,
        reasons=(*against, *told_pulls(pulls, given)),
        pulls=pulls,
        searched=(searched.m, whole.m),
        recorded=whole.recording.chosen_from,
        warnings=(thinning_text(searched.m, whole.m, named.problem is used),)
        if searched is not whole
        else (),
    )


def _determine(
    named: NamedTerms, found: Sequence[int], parts: Sequence[Fold] | None, mistake: Mistake | None, seed: int
) -> tuple[DeliveredTerms, tuple[Answer, ...]]:
    """What is handed over, and all answers: without the terms whose sizes turn out not to be known or not to be possible, the others
    refitted."""
    given = deliver_terms(named.problem, named.stage, named.selection.terms, found, parts)
    every = answers(named, given, mistake, seed)
    unknown = {a.id for a in every if (a.undetermined or a.beyond) and not a.alias_of}
    kept = [i for i in found if named.selection.terms[i].family.id not in unknown]
    if len(kept) == len(found):
        return given, every
    given = deliver_terms(named.problem, named.stage, named.selection.terms, kept, parts)
    return given, answers(named, given, mistake, seed)


def _renew_tables(
    every: Sequence[Answer], given: DeliveredTerms, stage: Stage
) -> tuple[tuple[Answer, ...], tuple[HeldOut, ...], tuple[str, ...]]:
    """The answers, that of a calibration which is stale as a whole with its tables anew where these predict rows held out; those
    rows; and what to say where they do not.
    """
    out, held, said = list(every), list[HeldOut](), list[str]()
    for k, a in enumerate(every):
        if a.doubtful or not is_stale(a.effect, a.where.get("component")):
            continue
        number = [t.family.id for t in given.selection.terms]
        new = (
            renew_tables(given.problem, stage, given.selection, number.index(a.id))
            if a.id in number
            else None
        )
        if new is not None and new.holds:
            out[k] = replace(a, renewed=new)
            held += new.held_out
        else:
            said.append(
                "the calibration as a whole is stale, and tables fitted to these rows do not predict rows that were not fitted: calibrate"
                " anew (vcmm calibrate)"
            )
    return tuple(out), tuple(held), tuple(said)


def _of_noise(one: Judgement, every: Sequence[Answer], searched: Problem, excess: str) -> tuple[str, ...]:
    """Why the names are not the whole story: what is left, folds, the scatter, answers that are doubtful."""
    selection, stage = one.selection, one.stage
    over_stated = float(np.sqrt(np.mean(stage.u**2) / np.mean(searched.u**2)))
    left = _sigma(selection, stage) * over_stated
    is_named = any(not a.doubtful for a in every) or one.mistake is not None
    forgiven = 2.0 * mismatch(selection) * left**2 / stage.white.dof
    unstated = excess or beyond(stage.noise, left, forgiven)
    against = reasons(is_named, one.rest, one.failed, unstated, stage.noise, left)
    return (*against, *curves(every), *doubts(every))


def _has_field(problem: Problem) -> bool:
    """Does a field without a name stand beside the calibration? It is known in the rows searched only."""
    return any(name == FIELD for name, _ in problem.stated)


def _sigma(selection: Selection, stage: Stage) -> float:
    """Noise over what was stated, after the terms."""
    return (
        selection.fit.sigma if selection.fit else float(np.sqrt(selection.y @ selection.y / stage.white.dof))
    )


def _with_other_rivals(
    places: Sequence[Standing], problem: Problem, stage: Stage, selection: Selection, tied: Sequence[str]
) -> list[Standing]:
    """The standings with rivals that are no candidates: a mistake of the table, shapes that the rows do not resolve."""
    if not selection.terms:
        return []
    hidden = unresolved_shapes(problem, stage.white)
    named = [_with_mistake(p, selection, i, tied) for i, p in enumerate(places)]
    return [with_aliases(p, selection, i, hidden) for i, p in enumerate(named)]


def _unique_places(gone: Sequence[str]) -> tuple[str, ...]:
    """Names and places without repetition; a name says all its places."""
    return tuple(g for g in dict.fromkeys(gone) if "[" not in g or g.split("[")[0] not in gone)


def _with_mistake(place: Standing, selection: Selection, i: int, tied: Sequence[str]) -> Standing:
    """The standing with a mistake of the table among the rivals where one explains as much."""
    if selection.terms[i].family.id not in tied:
        return place
    return replace(place, names=(*place.names, MISTAKE))
