"""diagnose_recording: the whole method, in order. See vcmm/diagnosis/__init__.py."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.diagnosis.adequacy import described, unknown_rest
from vcmm.diagnosis.aliases import unresolved, with_aliases
from vcmm.diagnosis.answers import Named, answers, of_the_machine
from vcmm.diagnosis.candidates import Catalogue, Family, catalogue
from vcmm.diagnosis.confusion import Standing, standing
from vcmm.diagnosis.contradicted import pulls_of, told_pulls, unexplained_pulls, with_contradicted
from vcmm.diagnosis.delivered import delivered, rms_left
from vcmm.diagnosis.evidence import scorer
from vcmm.diagnosis.field import Field, kept_terms, rival_field
from vcmm.diagnosis.holdout import Fold, folds, is_free_curve, judge, wins_everywhere
from vcmm.diagnosis.kept_terms import that_hold
from vcmm.diagnosis.locate import generic_families, locate, score_map
from vcmm.diagnosis.machine_match import check_belonging, wild
from vcmm.diagnosis.mistakes import MISTAKE, Mistake, tables_of
from vcmm.diagnosis.modulated import modulated
from vcmm.diagnosis.neighbours import departure
from vcmm.diagnosis.nextstep import closer, next_steps
from vcmm.diagnosis.noise import Audit, audit
from vcmm.diagnosis.null import clipped
from vcmm.diagnosis.order import in_order
from vcmm.diagnosis.power import power
from vcmm.diagnosis.problem import Problem, make_problem
from vcmm.diagnosis.qualify import qualified
from vcmm.diagnosis.result import EVEN_ODDS, Diagnosis, Fit, Unknown
from vcmm.diagnosis.sanity import Checked, checked
from vcmm.diagnosis.search import Chosen, Stage, search, setting_of, staged
from vcmm.diagnosis.select import Selection, Setting, joint, mismatch
from vcmm.diagnosis.shortfall import failing_fold, of_fold, scatter_excess
from vcmm.diagnosis.two_searches import best_road
from vcmm.diagnosis.verdict import beyond, curves, doubts, reasons, seen, verdict
from vcmm.diagnosis.written_fit import with_written_fit
from vcmm.evaluation.gaussian import Whitener
from vcmm.response.indexing import told
from vcmm.response.recording import Recording

NULLS = 2000
FIELD = "field"  # a covariance beside those of the machine's Inputs
PASSES = 3  # noise audit and selection look at each other's result
Progress = Callable[[str, float], None]


def diagnose_recording(
    recording: Recording,
    machine: Machine,
    seed: int = 0,
    nulls: int = NULLS,
    extra_effects: Sequence[type[Effect]] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Say what physics the recording holds and the machine lacks.

    nulls: number of simulated recordings with nothing concealed; extra_effects: effect classes beside the catalogue;
    progress(text, share done). Same arguments, same result. Raises ModelLimit for recordings that cannot be used: rows
    outside the travels, no noise, fewer rows than nuisance parameters.
    """
    tell = progress or (lambda text, share: None)
    tell("checking and predicting the recording", 0.0)
    fit = checked(recording, machine)
    problem, warnings = _usable(fit, machine)
    plain = problem.whitener()
    tell("listing what could be missing", 0.05)
    known = catalogue(problem, extra_effects)
    generics = generic_families(problem)
    stage, chosen = _passes(problem, known, generics, plain, seed, nulls, tell)
    tell("predicting rows held out, and weighing the names against physics without a name", 0.75)
    judged = _beside_field(_judged(chosen, stage, seed), known, generics, seed, nulls)
    found = _result(problem, known, judged, seed, tell)
    found = replace(found, warnings=warnings)
    found = qualified(found, fit.doubtful, stage.noise.scale, only_table=len(tables_of(problem)) == 1)
    return with_written_fit(found, recording, machine)


def _usable(fit: Checked, machine: Machine) -> tuple[Problem, tuple[str, ...]]:
    """The problem without rows that cannot belong to it, and what to tell."""
    recording = in_order(fit.recording, machine)
    problem = make_problem(recording, machine)
    out, text = wild(problem)
    if out.any():
        problem = make_problem(recording.take(~out), machine)
    check_belonging(problem, problem.whitener())
    moved = told(problem.recording)
    index = [f"readings moved by their index on the exact chain: {moved}; it stays free"] if moved else []
    return problem, (*fit.warnings, *index, *([text] if text else []))


def _passes(
    problem: Problem,
    known: Catalogue,
    generics: Sequence[Family],
    plain: Whitener,
    seed: int,
    nulls: int,
    tell: Progress,
) -> tuple[Stage, Chosen]:
    """Audit the noise, select, audit again what is left; until the preparation stands.

    Neighbours that agree because of what is looked for are no correlation of the noise (a reversal is a square wave), so
    the first pass takes them for independent.
    """
    noise = replace(audit(problem, plain, plain.apply(problem.residual), seed), rho=0.0)
    for turn in range(PASSES):
        tell("simulating recordings with nothing concealed", 0.15 + 0.2 * turn)
        stage = staged(problem, known, generics, noise, seed, nulls)
        tell("weighing the evidence", 0.25 + 0.2 * turn)
        chosen = search(problem, stage)
        before, noise = noise, audit(problem, plain, _left(chosen.problem, plain, chosen.selection), seed)
        if _same(noise, before):
            break
    final = replace(stage.noise, findings=noise.findings, scale=noise.scale, limit=noise.limit)
    return replace(chosen.stage, noise=final), chosen


def _same(a: Audit, b: Audit) -> bool:
    alike = abs(a.rho - b.rho) < 0.1 and abs(a.less - b.less) < 0.05
    return alike and (a.growth == 0) == (b.growth == 0) and a.noise == b.noise


def _left(problem: Problem, plain: Whitener, selection: Selection) -> Array:
    """What the chosen terms leave, in the space without filter and weights."""
    rest = problem.residual
    if selection.fit is not None:
        columns = np.concatenate([t.option.columns for t in selection.terms], axis=1)
        rest = rest - columns @ selection.fit.mean
    return plain.apply(rest)


@dataclass(frozen=True, eq=False)
class _Judged:
    """Terms that hold, and what they compete with. failed: terms were held back; tied: see Chosen."""

    problem: Problem
    stage: Stage
    setting: Setting
    parts: Sequence[Fold]
    selection: Selection
    places: Sequence[Standing]
    mistake: Mistake | None
    tied: tuple[str, ...]
    failed: bool
    field: Field | None = None
    rest: Unknown | None = None


def _judged(chosen: Chosen, stage: Stage, seed: int) -> _Judged:
    """The better of the two roads, what its terms are worth, and a field that may stand for them."""
    used, selection = chosen.problem, chosen.selection
    setting = replace(setting_of(used, stage), start=selection.y)
    parts = folds(used, stage.u, stage.noise.rho)
    held_by = partial(that_hold, generic=stage.generic)
    selection, failed = best_road(used, parts, selection, setting, held_by)
    selection = of_the_machine(selection, _standings(selection, setting, stage), setting)
    places = _standings(selection, setting, stage)
    field = rival_field(used, selection, setting, stage.sample) if selection.terms else None
    rest = _rest(used, stage, selection, setting, parts, seed, field)
    return _Judged(
        used, stage, setting, parts, selection, places, chosen.mistake, chosen.tied, failed, field, rest
    )


def _beside_field(
    first: _Judged, known: Catalogue, generics: Sequence[Family], seed: int, nulls: int
) -> _Judged:
    """The search again beside a field that stands, which then is one more covariance; as it was where nothing is found so, or
    where nothing is left without a name.
    """
    if first.rest is None:
        return first
    field = first.field or rival_field(first.problem, first.selection, first.setting, first.stage.sample)
    if field is None or not field.stands:
        return first
    beside = first.problem.with_statement(FIELD, field.columns)
    stage = staged(beside, known, generics, first.stage.noise, seed, nulls)
    chosen = search(beside, stage)
    second = _judged(chosen, chosen.stage, seed)
    if not second.selection.terms or _lost(first, second):
        return first
    what = described(field.unknown, first.problem, first.setting, joint((), first.setting), first.parts)
    return replace(second, mistake=first.mistake, field=None, rest=what)


def _lost(first: _Judged, second: _Judged) -> bool:
    """Is a name gone that was found and wins all its folds? A free curve may be: it is as free as the field."""
    kept = _found(second)
    own = first.selection
    gone = [i for i, t in enumerate(own.terms) if t.family.id in _found(first) - kept]
    return any(
        wins_everywhere(first.problem, first.parts, own, i)
        for i in gone
        if not is_free_curve(own.terms[i].family.name)
    )


def _found(judged: _Judged) -> set[str]:
    """Ids of the names that are more probable than not, with what repeats them exactly."""
    pairs = zip(judged.selection.terms, judged.places)
    return {t.family.id for t, p in pairs if p.with_aliases >= EVEN_ODDS}


def _result(problem: Problem, known: Catalogue, judged: _Judged, seed: int, tell: Progress) -> Diagnosis:
    selection, mistake, used = judged.selection, judged.mistake, judged.problem
    stage, setting, field, rest = judged.stage, judged.setting, judged.field, judged.rest
    excess = "" if rest else scatter_excess(selection, stage.white, stage.noise, stage.sample)
    sigma = _sigma(selection, stage)
    places = _with_other_rivals(judged.places, used, stage, selection, judged.tied)
    named = with_contradicted(Named(used, stage, selection, places, field))
    found = [i for i, a in enumerate(named.probabilities()) if not a.doubtful]
    given = delivered(used, stage, named.selection.terms, found)
    every = answers(named, given, mistake, seed)
    shown, hidden = power(stage.found, sigma)
    tell("planning the next measurement", 0.92)
    steps = (*next_steps(used, setting, named.selection, named.places), *closer(used, rest))
    y = clipped(stage.white.apply(problem.residual), stage.white, stage.noise.noise.clip)
    tell("done", 1.0)
    left = sigma * float(
        np.sqrt(np.mean(stage.u**2) / np.mean(problem.u**2))
    )  # noise after over noise stated
    is_named = any(not a.doubtful for a in every) or mistake is not None
    forgiven = 2.0 * mismatch(selection) * left**2 / stage.white.dof
    against = reasons(
        is_named, rest, judged.failed, excess or beyond(stage.noise, left, forgiven), stage.noise, left
    )
    against = (*against, *curves(every), *doubts(every))
    pulls = pulls_of(given, stage)
    against = (*against, *unexplained_pulls(pulls, given))
    places_of, unnamed = seen(locate(scorer(stage.generic), y, stage.chance), is_named or bool(against))
    against = (*against, *unnamed)
    held = tuple(judge(given.problem, part, given.selection, given.selection.terms) for part in given.parts)
    return Diagnosis(
        verdict(is_named, against),
        every,
        rest,
        places_of,
        mistake,
        sigma * float(np.sqrt(np.mean(stage.u**2))),
        (*stage.noise.findings, *([excess] if excess else [])),
        Fit(
            0.0,
            0.0,
            sigma * float(np.sqrt(np.mean(stage.u**2))),
            held if given.selection.terms else (),
            rms_left(named.problem, named.selection),
        ),
        known.not_testable,
        _once((*known.unseen, *stage.found.invisible, *hidden)),
        shown,
        steps,
        stage.threshold,
        seed,
        problem.recording.kind == "angle",
        map=score_map(scorer(stage.generic), y),
        chance=stage.generic_threshold,
        reasons=(*against, *told_pulls(pulls, given)),
        pulls=pulls,
    )


def _standings(selection: Selection, setting: Setting, stage: Stage) -> list[Standing]:
    return [standing(selection, setting, i, stage.generic) for i in range(len(selection.terms))]


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
    hidden = unresolved(problem, stage.white)
    named = [_with_mistake(p, selection, i, tied) for i, p in enumerate(places)]
    return [with_aliases(p, selection, i, hidden) for i, p in enumerate(named)]


def _rest(
    problem: Problem,
    stage: Stage,
    selection: Selection,
    setting: Setting,
    parts: Sequence[Fold],
    seed: int,
    field: Field | None,
) -> Unknown | None:
    """What has no name: a field that beats the names, a shape in the residual, neighbours that agree, else a fold that
    falls short of what the names promise.
    """
    if field is not None and field.wins:
        return described(field.unknown, problem, setting, joint(kept_terms(selection, field), setting), parts)
    rest = unknown_rest(stage.generic, selection, stage.white, stage.chance, stage.generic_threshold)
    rest = rest or modulated(problem, selection, stage.white, stage.generic_threshold)
    rest = rest or departure(problem, selection, stage.white, stage.sample)
    rest = described(rest, problem, setting, selection, parts)
    short = failing_fold(problem, parts, selection, stage.noise, stage.u, seed)
    return of_fold(short) if short and rest is None else rest


def _once(gone: Sequence[str]) -> tuple[str, ...]:
    """Names and places without repetition; a name says all its places."""
    return tuple(g for g in dict.fromkeys(gone) if "[" not in g or g.split("[")[0] not in gone)


def _with_mistake(place: Standing, selection: Selection, i: int, tied: Sequence[str]) -> Standing:
    """The standing with a mistake of the table among the rivals where one explains as much."""
    if selection.terms[i].family.id not in tied:
        return place
    return replace(place, names=(*place.names, MISTAKE))
