"""diagnose_recording: the whole method, in order. See vcmm/diagnosis/__init__.py."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.diagnosis.aliases import unresolved, with_aliases
from vcmm.diagnosis.answers import Named, answers
from vcmm.diagnosis.candidates import Catalogue, Family, catalogue
from vcmm.diagnosis.confusion import Standing
from vcmm.diagnosis.contradicted import pulls_of, told_pulls, unexplained_pulls, with_contradicted
from vcmm.diagnosis.delivered import delivered, rms_left
from vcmm.diagnosis.evidence import scorer
from vcmm.diagnosis.holdout import judge
from vcmm.diagnosis.judged import Judged, beside_field, judged
from vcmm.diagnosis.locate import generic_families, locate, score_map
from vcmm.diagnosis.machine_match import check_belonging, wild
from vcmm.diagnosis.mistakes import MISTAKE, tables_of
from vcmm.diagnosis.nextstep import closer, next_steps
from vcmm.diagnosis.noise import Audit, audit
from vcmm.diagnosis.null import clipped
from vcmm.diagnosis.order import in_order
from vcmm.diagnosis.power import power
from vcmm.diagnosis.problem import Problem, make_problem
from vcmm.diagnosis.qualify import qualified
from vcmm.diagnosis.result import Diagnosis, Fit
from vcmm.diagnosis.sanity import Checked, checked
from vcmm.diagnosis.search import Chosen, Stage, search, staged
from vcmm.diagnosis.select import Selection, mismatch
from vcmm.diagnosis.shortfall import scatter_excess
from vcmm.diagnosis.verdict import beyond, curves, doubts, reasons, seen, verdict
from vcmm.diagnosis.written_fit import with_written_fit
from vcmm.evaluation.gaussian import Whitener
from vcmm.response.indexing import told
from vcmm.response.recording import Recording

NULLS = 2000
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
    held = beside_field(judged(chosen, stage, seed), known, generics, seed, nulls)
    found = _result(problem, known, held, seed, tell)
    found = replace(found, warnings=warnings)
    found = qualified(found, fit.doubtful, stage.noise.scale, only_table=len(tables_of(problem)) == 1)
    return with_written_fit(found, [recording], machine)


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
    earlier: Selection | None = None
    for turn in range(PASSES):
        tell("simulating recordings with nothing concealed", 0.15 + 0.2 * turn)
        stage = staged(problem, known, generics, noise, seed, nulls)
        tell("weighing the evidence", 0.25 + 0.2 * turn)
        chosen = search(problem, stage, earlier)
        earlier = chosen.selection
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


def _result(problem: Problem, known: Catalogue, one: Judged, seed: int, tell: Progress) -> Diagnosis:
    selection, mistake, used = one.selection, one.mistake, one.problem
    stage, setting, field, rest = one.stage, one.setting, one.field, one.rest
    excess = "" if rest else scatter_excess(selection, stage.white, stage.noise, stage.sample)
    sigma = _sigma(selection, stage)
    places = _with_other_rivals(one.places, used, stage, selection, one.tied)
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
        is_named, rest, one.failed, excess or beyond(stage.noise, left, forgiven), stage.noise, left
    )
    against = (*against, *curves(every), *doubts(every))
    pulls = pulls_of(given, stage)
    against = (*against, *unexplained_pulls(pulls, given))
    places_of, unnamed = seen(locate(scorer(stage.generic), y, stage.chance), is_named or bool(against))
    against = (*against, *unnamed)
    predicted = tuple(
        judge(given.problem, part, given.selection, given.selection.terms) for part in given.parts
    )
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
            predicted if given.selection.terms else (),
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


def _once(gone: Sequence[str]) -> tuple[str, ...]:
    """Names and places without repetition; a name says all its places."""
    return tuple(g for g in dict.fromkeys(gone) if "[" not in g or g.split("[")[0] not in gone)


def _with_mistake(place: Standing, selection: Selection, i: int, tied: Sequence[str]) -> Standing:
    """The standing with a mistake of the table among the rivals where one explains as much."""
    if selection.terms[i].family.id not in tied:
        return place
    return replace(place, names=(*place.names, MISTAKE))
