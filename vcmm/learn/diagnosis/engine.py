"""diagnose_recording: the whole method, in order. See vcmm/learn/diagnosis/__init__.py."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count

from vcmm.core.effect import Effect
from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.answers import add_repeated
from vcmm.learn.diagnosis.assembly import account
from vcmm.learn.diagnosis.candidates import Catalogue, Family, catalogue
from vcmm.learn.diagnosis.constants import MISMATCH
from vcmm.learn.diagnosis.cross_checks import cross_check, steadier, unstable_names
from vcmm.learn.diagnosis.delivery import left_over
from vcmm.learn.diagnosis.far_rows import far_rows, raw_rest
from vcmm.learn.diagnosis.judgement import beside_field, judge_terms
from vcmm.learn.diagnosis.later import Attempt
from vcmm.learn.diagnosis.locate import each_shape, generic_families
from vcmm.learn.diagnosis.machine_match import check_belonging, wild
from vcmm.learn.diagnosis.mistakes import tables_of
from vcmm.learn.diagnosis.noise import Audit, audit
from vcmm.learn.diagnosis.outside import with_outside
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.diagnosis.qualify import qualify
from vcmm.learn.diagnosis.repeated import repeated_stretch
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.learn.diagnosis.row_order import in_order
from vcmm.learn.diagnosis.sanity import SanityCheck, check_recording
from vcmm.learn.diagnosis.screening import screen_families, screened_shapes
from vcmm.learn.diagnosis.search import SearchResult, Stage, build_stage, search
from vcmm.learn.diagnosis.select import Selection
from vcmm.learn.diagnosis.thinning import LARGEST, MOST_SCREENED, thin_problem
from vcmm.learn.diagnosis.written_fit import with_written_fit
from vcmm.task.response.indexing import index_text
from vcmm.task.response.recording import Recording

NULLS = 2000
USUAL_STEPS = 4  # after which half is done
STEP_COMPARE = "compare the machine as it is written with all rows"
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
    tell = _steps(progress)
    tell("checking and predicting the recording")
    again = repeated_stretch(recording)
    fit = check_recording(recording if again is None else recording.take(~again.copied), machine)
    problem, warnings = _usable(fit, machine)
    searched = thin_problem(problem, LARGEST)
    tell("listing what could be missing")
    known, generics, stage, chosen = _search(searched, extra_effects, seed, nulls, tell)
    tell("predicting rows held out, and weighing the names against physics without a name")
    held = beside_field(judge_terms(chosen, stage, seed), known, generics, seed, nulls)
    tell("asking parts of the rows, and a second opinion")
    held, checks = cross_check(held)
    gone = unstable_names(held, checks)
    if gone:
        tell("searching without a name that parts of the rows do not have")
        fewer = replace(known, families=tuple(f for f in known.families if f.id not in gone))
        stage, chosen = _passes(searched, fewer, generics, stage.screen, seed, nulls, tell)
        other = beside_field(judge_terms(chosen, stage, seed), fewer, generics, seed, nulls)
        held, checks = steadier((held, checks), cross_check(other))
    tell("planning the next measurement")
    found = account(held, known, searched, problem, seed)
    told = (*checks.texts, *far_rows(held.problem, raw_rest(held.problem, held.stage.white, held.selection)))
    found = replace(found, warnings=(*warnings, *found.warnings, *told), checks=checks)
    found = qualify(found, fit.doubtful, stage.noise.scale, only_table=len(tables_of(searched)) == 1)
    found = found if again is None else add_repeated(found, again)
    attempt = Attempt.none()
    found = attempt(STEP_COMPARE, lambda: with_written_fit(found, [recording], machine), found)
    attempt.raise_bugs()
    found = with_outside(replace(found, failed=(*found.failed, *attempt.failures)))
    if progress:
        progress("done", 1.0)
    return found


def _steps(progress: Progress | None) -> Callable[[str], None]:
    """Tells what is done now; how much is left depends on what is found, so the share done only grows towards one."""
    steps = count()

    def tell(text: str) -> None:
        done = next(steps)
        if progress:
            progress(text, done / (done + USUAL_STEPS))

    return tell


def _usable(fit: SanityCheck, machine: Machine) -> tuple[Problem, tuple[str, ...]]:
    """The problem without rows that cannot belong to it, and what to tell."""
    recording = in_order(fit.recording, machine)
    problem = make_problem(recording, machine)
    out, text = wild(problem)
    if out.any():
        problem = make_problem(recording.take(~out), machine)
    check_belonging(problem, problem.whitener())
    moved = index_text(problem.recording)
    index = [f"readings moved by their index on the exact chain: {moved}; it stays free"] if moved else []
    return problem, (*fit.warnings, *index, *([text] if text else []))


def _search(
    problem: Problem, extra: Sequence[type[Effect]], seed: int, nulls: int, tell: Callable[[str], None]
) -> tuple[Catalogue, tuple[Family, ...], Stage, SearchResult]:
    """What was looked for, and what was found; of a long recording first in some of its rows, with the whole catalogue."""
    screen = thin_problem(problem, MOST_SCREENED)
    known, generics = catalogue(screen, extra), generic_families(screen)
    stage, chosen = _passes(screen, known, generics, None, seed, nulls, tell)
    if screen is problem:
        return known, generics, stage, chosen
    tell("comparing in all rows what explains most in some of them")
    known = replace(known, families=screen_families(chosen, problem))
    generics = screened_shapes(each_shape(problem), chosen, problem, problem.whitener())
    return known, generics, *_passes(problem, known, generics, stage, seed, nulls, tell)


def _passes(
    problem: Problem,
    known: Catalogue,
    generics: Sequence[Family],
    screen: Stage | None,
    seed: int,
    nulls: int,
    tell: Callable[[str], None],
) -> tuple[Stage, SearchResult]:
    """Audit the noise, select, audit again what is left; until the preparation stands.

    Neighbours that agree because of what is looked for are no correlation of the noise (a reversal is a square wave), so
    the first pass takes them for independent.
    """
    plain = problem.whitener()
    noise = replace(audit(problem, plain, plain.apply(problem.residual), seed), rho=0.0)
    earlier: Selection | None = None
    for _ in range(PASSES):
        tell("simulating recordings with nothing concealed")
        stage = build_stage(problem, known, generics, noise, seed, nulls, screen)
        tell("weighing the evidence")
        chosen = search(problem, stage, earlier)
        earlier = chosen.selection
        before, noise = (
            noise,
            audit(problem, plain, plain.apply(left_over(chosen.problem, chosen.selection)), seed),
        )
        if _same(noise, before):
            break
    final = replace(stage.noise, findings=noise.findings, scale=noise.scale, limit=noise.limit)
    return replace(chosen.stage, noise=final), chosen


def _same(a: Audit, b: Audit) -> bool:
    alike = abs(a.rho - b.rho) < 2.0 * MISMATCH and abs(a.less - b.less) < MISMATCH
    return alike and (a.growth == 0) == (b.growth == 0) and a.noise == b.noise
