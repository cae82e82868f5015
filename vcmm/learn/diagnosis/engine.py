"""diagnose_recording: all steps of the method, in order. See vcmm/learn/diagnosis/__init__.py.

The prior of a mechanism that no catalogue holds.

Such a mechanism can mimic the best name, so the rows cannot tell it from that name, however many nats the name has: its odds
against the name are a constant w, and a probability p becomes p / (1 + w).

w is the ratio of wrong to right claims of the exam, each plus one: OUTSIDE where the account closes; OUTSIDE_OPEN where a residual remains that
the catalogue does not hold, for then there is such a mechanism, and it may have caused the findings as well as the name. Either was
fitted on each half of the cases and tested on the other (docs/exam.md).
It is a statement about the name. A finding stays one, and is written: it predicted rows held out, under any name.

Rows far from what is predicted, by their lines: a verdict counts each of them as a few standard deviations, and says so.

A row is reported where, by the stated law of the noise, so many rows would show one as far less than once in 1000 recordings.

Further evidence about the names before they are claimed: parts of the rows, and a second opinion.

Lower what is claimed where the recording itself is in doubt, and explain a possible sign over everything.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count

import numpy as np

from vcmm.core.blocks import Progress
from vcmm.core.effect import Effect
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.diagnosis.accepted_terms import AcceptedTerms, accept_terms, search_beside_field
from vcmm.learn.diagnosis.answers import add_copied_stretch, share_with_instrument
from vcmm.learn.diagnosis.assembly import assemble_diagnosis
from vcmm.learn.diagnosis.candidates import Catalogue, Family, build_catalogue
from vcmm.learn.diagnosis.constants import (
    CHANCE,
    EVEN_ODDS,
    FAR_SIGMAS,
    LEAST_FRACTION,
    MISMATCH,
    OUTSIDE,
    OUTSIDE_OPEN,
    UNSEEN,
)
from vcmm.learn.diagnosis.copied_readings import find_copied_stretch
from vcmm.learn.diagnosis.cross_checks import lower_claim, second_opinion, stability
from vcmm.learn.diagnosis.delivery import residual_after_terms
from vcmm.learn.diagnosis.locate import each_shape, generic_families
from vcmm.learn.diagnosis.log_mistakes import LOG
from vcmm.learn.diagnosis.machine_match import check_belonging, noise_warning, wild_rows
from vcmm.learn.diagnosis.mistakes import tables_of
from vcmm.learn.diagnosis.noise import Audit, audit, stated_noise
from vcmm.learn.diagnosis.null_recordings import robust_scale
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.diagnosis.result import VERDICTS, Diagnosis
from vcmm.learn.diagnosis.result_parts import Attempt, CrossChecks
from vcmm.learn.diagnosis.rivals import Standing, scale_standing
from vcmm.learn.diagnosis.row_order import sort_rows
from vcmm.learn.diagnosis.sanity import SanityCheck, check_recording
from vcmm.learn.diagnosis.search import SearchResult, Stage, build_stage, search
from vcmm.learn.diagnosis.select import Selection
from vcmm.learn.diagnosis.thinning import (
    LARGEST,
    MOST_SCREENED,
    screen_families,
    screen_shapes,
    thin_problem,
)
from vcmm.learn.diagnosis.written_machine import add_written_fit
from vcmm.task.response.indexing import index_text
from vcmm.task.response.recording import Recording

DOUBT_REASON = "the recording itself is in doubt; see the warnings"


def qualify(d: Diagnosis, doubtful: bool, scale: float, only_table: bool = False) -> Diagnosis:
    """Return the diagnosis with its warnings, and with its claim lowered where there is doubt.

    scale: noise over what was stated; only_table: the machine has a single table, whose sign is the sign of everything.
    """
    units = noise_warning(scale)
    warnings = [w for w in (*d.warnings, units, _sign_remark(d, only_table)) if w]
    d = replace(
        d, warnings=tuple(dict.fromkeys(warnings)), answer=tuple(map(share_with_instrument, d.answer))
    )
    if not (doubtful or units):
        return d
    answer = tuple(
        replace(
            a,
            probability=min(a.probability, EVEN_ODDS),
            alias_probability=min(a.alias_probability, EVEN_ODDS),
            kin=a.kin.times(min(1.0, EVEN_ODDS / a.kin.probability))
            if a.kin and a.kin.probability
            else a.kin,
        )
        for a in d.answer
    )
    verdict = {"explained": "partly explained", "nothing missing": "unexplained"}.get(d.verdict, d.verdict)
    return replace(d, answer=answer, verdict=verdict, reasons=(*d.reasons, DOUBT_REASON))


def _sign_remark(d: Diagnosis, only_table: bool) -> str | None:
    """Return the remark on all tables reversed, which looks like a recording with the wrong sense of observation."""
    if d.mistake is None or d.mistake.what != "sign" or d.mistake.effect == LOG:
        return None
    if d.mistake.component != "all" and not only_table:
        return None
    return (
        "the recording holds minus what the machine predicts, in all components: either the tables have the wrong sign,"
        ' or the sense of the observation does ("indicated - true" against "actual - commanded"); look at `observed` first'
    )


def cross_check(accepted: AcceptedTerms) -> tuple[AcceptedTerms, CrossChecks]:
    """Return the judgement with the probability that parts of the rows and a second opinion leave to its names."""
    stable = stability(accepted.problem, accepted.stage, accepted.selection, accepted.standings)
    opinion = second_opinion(
        accepted.stage.candidates, accepted.selection, accepted.standings, accepted.stage.white.dof
    )
    standings = [
        _lower_standing(standing, most, opinion.for_ours if lacks else None)
        for standing, most, lacks in zip(accepted.standings, stable.probability_limits, opinion.lacks)
    ]
    return replace(accepted, standings=standings), CrossChecks(stable, opinion)


def unstable_names(accepted: AcceptedTerms, checks: CrossChecks) -> set[str]:
    """Return the ids of the terms that more parts of the rows lack than have."""
    return {
        t.family.id
        for t, most in zip(accepted.selection.terms, checks.stable.probability_limits)
        if most < EVEN_ODDS
    }


def choose_steadier(
    first: tuple[AcceptedTerms, CrossChecks], second: tuple[AcceptedTerms, CrossChecks]
) -> tuple[AcceptedTerms, CrossChecks]:
    """Return the answer without the names that parts of the rows lack, where none of its own is so; the changes stay reported."""
    accepted, checks = second
    if not accepted.selection.terms or min(checks.stable.probability_limits) < EVEN_ODDS:
        return first
    stable = first[1].stable
    return accepted, replace(checks, stable=replace(checks.stable, same=stable.same, text=stable.text))


def _lower_standing(standing: Standing, most: float, for_ours: float | None) -> Standing:
    """Lower a standing. most: of the name with its family, that the parts allow; for_ours: that of a second opinion that lacks the name, which leaves
    even odds to a name that had them."""
    best = max(standing.probability, standing.alias_probability)
    claim = max(best, standing.kin.probability if standing.kin else 0.0)
    share = 1.0
    if for_ours is not None and claim > 0.0:
        share = max(lower_claim(claim, for_ours) / claim, min(EVEN_ODDS / max(best, LEAST_FRACTION), 1.0))
    share = min(share, most / max(claim, most))
    return standing if share >= 1.0 else scale_standing(standing, share * (1.0 + UNSEEN))


def far_row_remarks(problem: Problem, rest: Array) -> tuple[str, ...]:
    """Return remarks on rows far from the prediction; rest (m,): white residuals after all names, without limits on outliers."""
    size = np.abs(rest) / float(robust_scale(rest))
    out = size > _outlier_limit(stated_noise(problem).dof, len(rest))
    if not out.any():
        return ()
    count = int(out.sum())
    rows = f"{problem.recording.places(out)} lie{'s' if count == 1 else ''}"
    far = f"{size[out].max():.1f}" if count == 1 else f"{size[out].min():.1f} to {size[out].max():.1f}"
    return (
        f"{rows} {far} standard deviations from what is predicted, and count as {FAR_SIGMAS:g}: bad readings, or something that happened there"
        " alone and that no verdict is about; look at them",
    )


def _outlier_limit(dof: float, m: int) -> float:
    """Return the standard deviations (of the normal law's robust scale) that one of m rows exceeds with the probability 1 - CHANCE."""
    from scipy.stats import norm, t

    tail = (1.0 - CHANCE) / (2.0 * m)
    if not np.isfinite(dof):
        return float(norm.isf(tail))
    return float(t.isf(tail, dof) / t.isf(norm.sf(1.0), dof))


CLOSED = VERDICTS[:2]  # nothing missing, explained


def discount_unknown_mechanism(d: Diagnosis) -> Diagnosis:
    """Return the diagnosis with probabilities lowered for a mechanism outside the catalogue."""
    odds = OUTSIDE if d.verdict in CLOSED else OUTSIDE_OPEN
    return replace(d, answer=tuple(replace(a.against(odds), was_finding=not a.improbable) for a in d.answer))


NULLS = 2000
USUAL_STEPS = 4  # after which half is done
STEP_COMPARE = "compare the machine as it is written with all rows"
PASSES = 3  # noise audit and selection look at each other's result


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
    tell = _progress_reporter(progress)
    tell("checking and predicting the recording")
    again = find_copied_stretch(recording)
    fit = check_recording(recording if again is None else recording.take(~again.is_copy), machine)
    problem, warnings = _usable_problem(fit, machine)
    searched = thin_problem(problem, LARGEST)
    tell("listing what could be missing")
    effects_of_kinds, generics, stage, chosen = _search_in_two_steps(
        searched, extra_effects, seed, nulls, tell
    )
    tell("predicting rows held out, and weighing the names against physics without a name")
    accepted = search_beside_field(accept_terms(chosen, stage, seed), effects_of_kinds, generics, seed, nulls)
    tell("asking parts of the rows, and a second opinion")
    accepted, checks = cross_check(accepted)
    gone = unstable_names(accepted, checks)
    if gone:
        tell("searching without a name that parts of the rows do not have")
        fewer = replace(
            effects_of_kinds, families=tuple(f for f in effects_of_kinds.families if f.id not in gone)
        )
        stage, chosen = _search_until_noise_settles(
            searched, fewer, generics, stage.screen, seed, nulls, tell
        )
        other = search_beside_field(accept_terms(chosen, stage, seed), fewer, generics, seed, nulls)
        accepted, checks = choose_steadier((accepted, checks), cross_check(other))
    tell("planning the next measurement")
    diagnosis = assemble_diagnosis(accepted, effects_of_kinds, searched, problem, seed)
    rest = accepted.stage.white.apply(residual_after_terms(accepted.problem, accepted.selection))
    warnings = (*warnings, *diagnosis.warnings, *checks.texts, *far_row_remarks(accepted.problem, rest))
    diagnosis = replace(diagnosis, warnings=warnings, checks=checks)
    diagnosis = qualify(diagnosis, fit.doubtful, stage.noise.scale, only_table=len(tables_of(searched)) == 1)
    diagnosis = diagnosis if again is None else add_copied_stretch(diagnosis, again)
    attempt = Attempt.none()
    diagnosis = attempt(STEP_COMPARE, lambda: add_written_fit(diagnosis, [recording], machine), diagnosis)
    attempt.raise_bugs()
    diagnosis = replace(diagnosis, failures=(*diagnosis.failures, *attempt.failures))
    diagnosis = discount_unknown_mechanism(diagnosis)
    if progress:
        progress("done", 1.0)
    return diagnosis


def _progress_reporter(progress: Progress | None) -> Callable[[str], None]:
    """Return a function that reports the present step; how many steps follow depends on the findings, so the share done grows towards one."""
    steps = count()

    def tell(text: str) -> None:
        done = next(steps)
        if progress:
            progress(text, done / (done + USUAL_STEPS))

    return tell


def _usable_problem(fit: SanityCheck, machine: Machine) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem without rows that cannot belong to it, and remarks."""
    recording = sort_rows(fit.recording, machine)
    problem = make_problem(recording, machine)
    out, text = wild_rows(problem)
    if out.any():
        problem = make_problem(recording.take(~out), machine)
    check_belonging(problem, problem.whitener())
    moved = index_text(problem.recording)
    index = [f"readings moved by their index on the exact chain: {moved}; it stays free"] if moved else []
    return problem, (*fit.warnings, *index, *([text] if text else []))


def _search_in_two_steps(
    problem: Problem, extra: Sequence[type[Effect]], seed: int, nulls: int, tell: Callable[[str], None]
) -> tuple[Catalogue, tuple[Family, ...], Stage, SearchResult]:
    """Return the catalogue and the findings; of a long recording first in some of its rows, with the whole catalogue."""
    screen = thin_problem(problem, MOST_SCREENED)
    effects_of_kinds, generics = build_catalogue(screen, extra), generic_families(screen)
    stage, chosen = _search_until_noise_settles(screen, effects_of_kinds, generics, None, seed, nulls, tell)
    if screen is problem:
        return effects_of_kinds, generics, stage, chosen
    tell("comparing in all rows what explains most in some of them")
    effects_of_kinds = replace(effects_of_kinds, families=screen_families(chosen, problem))
    generics = screen_shapes(each_shape(problem), chosen, problem, problem.whitener())
    return (
        effects_of_kinds,
        generics,
        *_search_until_noise_settles(problem, effects_of_kinds, generics, stage, seed, nulls, tell),
    )


def _search_until_noise_settles(
    problem: Problem,
    effects_of_kinds: Catalogue,
    generics: Sequence[Family],
    screen: Stage | None,
    seed: int,
    nulls: int,
    tell: Callable[[str], None],
) -> tuple[Stage, SearchResult]:
    """Audit the noise, select, audit the residuals again, until the preparation does not change.

    Neighbours that agree because of the effects looked for are no correlation of the noise (a reversal is a square wave), so
    the first pass takes them for independent.
    """
    plain = problem.whitener()
    noise = replace(audit(problem, plain, plain.apply(problem.residual), seed), rho=0.0)
    earlier: Selection | None = None
    for _ in range(PASSES):
        tell("simulating recordings with nothing concealed")
        stage = build_stage(problem, effects_of_kinds, generics, noise, seed, nulls, screen)
        tell("weighing the evidence")
        chosen = search(problem, stage, earlier)
        earlier = chosen.selection
        before, noise = (
            noise,
            audit(problem, plain, plain.apply(residual_after_terms(chosen.problem, chosen.selection)), seed),
        )
        if _is_same_audit(noise, before):
            break
    final = replace(stage.noise, findings=noise.findings, scale=noise.scale, limit=noise.limit)
    return replace(chosen.stage, noise=final), chosen


def _is_same_audit(a: Audit, b: Audit) -> bool:
    alike = abs(a.rho - b.rho) < 2.0 * MISMATCH and abs(a.u_factor - b.u_factor) < MISMATCH
    return alike and (a.growth == 0) == (b.growth == 0) and a.noise == b.noise
