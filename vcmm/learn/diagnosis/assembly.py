"""Assemble the diagnosis from judged terms: numbers, rivals, residuals, invisible effects, what to measure.

Names from some of the rows are fitted to all of them: templates, noise, mistakes of the table.

Shapes that the rows do not resolve are no candidates, but they may still be the true cause.

Pre-travel over the seats of a probe is a sum of waves (a triangle is no cosine), and a wave with k lobes probed in 2 k
directions or fewer has the numbers of another one (Shannon; see periods): from four directions six lobes and two lobes
are the same readings, and four lobes are a wrong radius. No evidence can speak for such a shape, for it has no numbers of
its own; but its name is among the rivals of an answer whose signal it, or the sum of such shapes, repeats with no
more columns than the answer has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import nan

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.declaration import reported_name
from vcmm.learn.diagnosis.accepted_terms import AcceptedTerms, scatter_excess
from vcmm.learn.diagnosis.answers import NamedTerms, make_answers
from vcmm.learn.diagnosis.candidates import Catalogue, Family, Option, applies, make_option, rebuild_option
from vcmm.learn.diagnosis.constants import LEAST_FRACTION, MISMATCH, RESOLUTION_DELTA
from vcmm.learn.diagnosis.contradictions import (
    add_contradictions,
    named_contradictions,
    pulls_after_terms,
    unnamed_contradictions,
)
from vcmm.learn.diagnosis.delivery import (
    DeliveredTerms,
    deliver_terms,
    residual_after_terms,
    rms_after_terms,
    setting_for,
)
from vcmm.learn.diagnosis.evidence import Dictionary, detectable_effects, dictionary, scorer
from vcmm.learn.diagnosis.holdout import Fold, HeldOut, predict_fold, shows_any_term, worsened_folds
from vcmm.learn.diagnosis.instances import instances, missing_columns, where_of
from vcmm.learn.diagnosis.locate import locate, score_map
from vcmm.learn.diagnosis.log_mistakes import LABELS_EXCHANGED, MISTAKE, Mistake
from vcmm.learn.diagnosis.mistakes import hypotheses, is_stale, slipped_labels
from vcmm.learn.diagnosis.next_measurement import next_steps, steps_for_unknown
from vcmm.learn.diagnosis.noise import audit
from vcmm.learn.diagnosis.null_recordings import clip_residuals
from vcmm.learn.diagnosis.problem import FIELD, Problem
from vcmm.learn.diagnosis.result import STATUS_NOT_MODELLED, Answer, Diagnosis, Fit
from vcmm.learn.diagnosis.rivals import Standing, rank_of, ranks, scale_standing, separability
from vcmm.learn.diagnosis.scans import unresolved_changes
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, mismatch, refit
from vcmm.learn.diagnosis.table_renewal import renew_tables
from vcmm.learn.diagnosis.thinning import size_loss, thinning_text
from vcmm.learn.diagnosis.verdict import (
    clear_places,
    doubt_remarks,
    reasons_against,
    shared_curve_remarks,
    unstated_scatter,
    verdict,
)
from vcmm.physics import ALL


def unresolved_shapes(problem: Problem, white: Whitener) -> Dictionary:
    """Return the signals of the refused shapes of the catalogue on this recording, where they have any."""
    out = []
    for kind in ALL:
        changes = unresolved_changes(kind, problem.run)
        if not changes or not applies(kind, problem):
            continue
        for effect in instances(kind, problem):
            if missing_columns(effect, problem.run):
                continue
            made = [make_option(replace(effect, **c), problem) for c in changes]
            options = [o for o in made if o is not None]
            if options:
                out.append(Family(reported_name(kind), where_of(effect), (*options, *_all_together(options))))
    return dictionary(out, white)


def _all_together(options: Sequence[Option]) -> list[Option]:
    """Return all shapes together as one option."""
    if len(options) < 2:
        return []
    columns = np.concatenate([o.columns for o in options], axis=1)
    unit = np.concatenate([o.unit for o in options])
    return [Option(None, columns, unit, tuple(label for o in options for label in o.labels), 0.0)]


def add_unresolved_names(standing: Standing, selection: Selection, i: int, hidden: Dictionary) -> Standing:
    """Return the standing with the names of refused shapes that repeat the signal of term i within this noise."""
    if not hidden.families:
        return standing
    others = [t.white for j, t in enumerate(selection.terms) if j != i]
    given = scorer(hidden, np.concatenate(others, axis=1) if others else None)
    gap = separability(given, selection.signal(i))
    mine = rank_of(selection.terms[i].white, given.basis)
    nearest = np.minimum.reduceat(np.where(ranks(given) <= mine, gap, np.inf), hidden.first)
    near = nearest < max(RESOLUTION_DELTA / max(selection.delta(i), LEAST_FRACTION), MISMATCH)
    names_of_term = {selection.terms[i].family.name, *standing.names}
    names = dict.fromkeys(f.name for f, close in zip(hidden.families, near) if close)
    return replace(standing, names=(*standing.names, *(n for n in names if n not in names_of_term)))


def refit_to_all_rows(named: NamedTerms, whole: Problem, seed: int) -> NamedTerms:
    """Fit the terms again to the observations of `whole`, with the noise estimated there; their standings stay.

    The same where a term cannot be computed for all rows (a row beyond what its law holds for).
    """
    kept = {name for name, _ in named.problem.stated}
    whole = whole.without_statements([name for name, _ in whole.stated if name not in kept])
    terms = lift_terms(named.selection.terms, whole)
    if terms is None:
        return named
    plain = whole.whitener()
    stage = _stage_of_all_rows(whole, named.stage, plain)
    first = refit(terms, setting_for(whole, stage), rounds=1)
    noise = audit(whole, plain, plain.apply(residual_after_terms(whole, first)), seed)
    stage = replace(stage, noise=noise, u=noise.u(whole))
    stage = _stage_of_all_rows(whole, stage, whole.whitener(stage.u, noise.rho))
    selection = refit(first.terms, setting_for(whole, stage))
    return replace(named, problem=whole, stage=stage, selection=selection, in_searched_rows=named)


def lift_terms(terms: tuple[SelectedTerm, ...], whole: Problem) -> tuple[SelectedTerm, ...] | None:
    """Return the terms with columns for the observations of `whole`; None where one has none."""
    options = [rebuild_option(t.option, whole) for t in terms]
    if any(o is None for o in options):
        return None
    return tuple(replace(t, option=o) for t, o in zip(terms, options) if o is not None)


def _stage_of_all_rows(whole: Problem, stage: Stage, white: Whitener) -> Stage:
    """Return the stage with the whitener of all rows; its candidates are named there and not searched again."""
    bare = dictionary((), white)
    candidates = replace(
        bare,
        families=stage.candidates.families,
        options=stage.candidates.options,
        first=stage.candidates.first,
    )
    u = whole.u if len(stage.u) != whole.m else stage.u
    return replace(stage, white=white, u=u, candidates=candidates)


def mistake_on_all_rows(mistake: Mistake | None, whole: Problem) -> tuple[Mistake | None, Problem]:
    """Return the same mistake of the table or the log with its departure in all rows, and the rows without it."""
    if mistake is None:
        return None, whole
    same_mistake = _mistake_in_all_rows(mistake, whole)
    return same_mistake, whole if same_mistake is None else replace(
        whole, residual=whole.residual - same_mistake.departure
    )


def _mistake_in_all_rows(mistake: Mistake, whole: Problem) -> Mistake | None:
    """Return the mistake with its departure in all rows; None where these do not have it. A clock keeps its seconds; of labels that slipped
    the number of rows of the whole file counts that leaves least."""
    if mistake.clock is not None:
        clocks = [h.clock for h in hypotheses(whole) if h.clock is not None and h.what == mistake.what]
        made = clocks[0].at(mistake.clock.value) if clocks else None
        return None if made is None else replace(mistake, component=made[0], departure=made[1])
    same = ("component", "what", "effect", "factor", "source", "both", "words")
    alike = [h for h in hypotheses(whole) if all(getattr(h, name) == getattr(mistake, name) for name in same)]
    if not alike and mistake.what == LABELS_EXCHANGED:
        white, label = whole.whitener(), mistake.component.split(",")[0]
        slips = (h for h in slipped_labels(whole, white) if h.component.split(",")[0] == label)
        alike = sorted(slips, key=lambda h: float(np.linalg.norm(white.apply(whole.residual - h.departure))))
    return replace(mistake, component=alike[0].component, departure=alike[0].departure) if alike else None


def assemble_diagnosis(
    accepted: AcceptedTerms, catalogue: Catalogue, searched: Problem, whole: Problem, seed: int
) -> Diagnosis:
    """Return the diagnosis of the accepted terms in the searched rows, with numbers of all rows; these may be the same."""
    stage, mistake, used, unknown = accepted.stage, accepted.mistake, accepted.problem, accepted.unknown
    named = add_contradictions(NamedTerms(used, stage, accepted.selection, _standings(accepted)))
    indices = [i for i, a in enumerate(named.bare_answers()) if not a.doubtful]
    screen = stage.screen or stage
    sigma = accepted.selection.sigma(stage.white.dof)
    shown, hidden = detectable_effects(screen.candidates, sigma / size_loss(len(screen.u), len(stage.u)))
    steps = next_steps(used, accepted.setting, named.selection, named.standings)
    if searched is not whole and not _has_field(used):
        mistake, whole = mistake_on_all_rows(mistake, whole)
        named = refit_to_all_rows(named, whole, seed)
    parts = accepted.parts if named.problem is used else None
    delivered, all_answers = _deliver_determined(named, indices, parts, mistake, seed)
    all_answers, held_out, unmodelled = _renew_tables(all_answers, delivered, named.stage)
    excess = "" if unknown else scatter_excess(accepted.selection, stage.white, stage.noise, stage.sample)
    pulls = pulls_after_terms(delivered, named.stage)
    of_noise = _reasons_of_noise(accepted, all_answers, searched, excess)
    reasons = (
        *unmodelled,
        *of_noise,
        *unnamed_contradictions(pulls, delivered),
        *_worsened_far_zones(delivered),
    )
    y = clip_residuals(stage.white.apply(searched.residual), stage.white, stage.noise.noise.clip)
    is_named = any(not a.doubtful for a in all_answers) or mistake is not None
    places = locate(scorer(stage.generic), y, stage.chance)
    clear, unnamed = clear_places(places, is_named or bool(reasons))
    reasons = (*reasons, *unnamed)
    scatter = named.selection.sigma(named.stage.white.dof) * float(np.sqrt(np.mean(named.stage.u**2)))
    held_out = (*_predicted_folds(delivered), *held_out) if delivered.selection.terms else ()
    is_thinned = searched is not whole
    return Diagnosis(
        verdict=STATUS_NOT_MODELLED if unmodelled and is_named else verdict(is_named, reasons),
        answer=all_answers,
        unknown=unknown,
        location=clear,
        mistake=mistake,
        noise_scale=scatter,
        noise_findings=(*stage.noise.findings, *([excess] if excess else [])),
        fit=Fit(nan, nan, scatter, held_out, rms_after_terms(named.problem, named.selection)),
        not_testable=catalogue.not_testable,
        invisible=_unique_places((*catalogue.invisible, *screen.candidates.invisible, *hidden)),
        detectable=shown,
        next_measurement=(*steps, *steps_for_unknown(used, unknown)),
        threshold=stage.threshold,
        seed=seed,
        angle=searched.recording.kind == "angle",
        map=score_map(scorer(stage.generic), y),
        chance=stage.generic_threshold,
        reasons=(*reasons, *named_contradictions(pulls, delivered)),
        pulls=pulls,
        search_counts=(searched.m, whole.m),
        recorded_count=whole.recording.chosen_from,
        warnings=(thinning_text(searched.m, whole.m, named.problem is used),) if is_thinned else (),
    )


def _standings(accepted: AcceptedTerms) -> list[Standing]:
    """Return the standings with rivals that are no candidates, and with the share that a field leaves to each term."""
    standings = _with_other_rivals(
        accepted.standings, accepted.problem, accepted.stage, accepted.selection, accepted.mistake_rivals
    )
    if accepted.field is None:
        return standings
    return [scale_standing(p, share) for p, share in zip(standings, accepted.field.shares, strict=True)]


def _predicted_folds(delivered: DeliveredTerms) -> tuple[HeldOut, ...]:
    """Return the folds in which some term is seen, as the delivered terms predict them."""
    return tuple(
        predict_fold(delivered.problem, f, delivered.selection, delivered.selection.terms)
        for f in delivered.parts
        if shows_any_term(f, delivered.selection)
    )


def _deliver_determined(
    named: NamedTerms,
    indices: Sequence[int],
    parts: Sequence[Fold] | None,
    mistake: Mistake | None,
    seed: int,
) -> tuple[DeliveredTerms, tuple[Answer, ...]]:
    """Return the delivered terms, and all answers: without the terms whose sizes turn out to be undetermined or impossible, the others
    refitted."""
    delivered = deliver_terms(named.problem, named.stage, named.selection.terms, indices, parts)
    all_answers = make_answers(named, delivered, mistake, seed)
    unknown = {a.id for a in all_answers if (a.is_undetermined or a.impossible_because) and not a.alias_of}
    kept = [i for i in indices if named.selection.terms[i].family.id not in unknown]
    if len(kept) == len(indices):
        return delivered, all_answers
    delivered = deliver_terms(named.problem, named.stage, named.selection.terms, kept, parts)
    return delivered, make_answers(named, delivered, mistake, seed)


def _renew_tables(
    answers: Sequence[Answer], delivered: DeliveredTerms, stage: Stage
) -> tuple[tuple[Answer, ...], tuple[HeldOut, ...], tuple[str, ...]]:
    """Return the answers, that of a calibration which is stale as a whole with its renewed tables where these predict rows held out; those
    rows; and remarks where they do not.
    """
    out, held_out, remarks = list(answers), list[HeldOut](), list[str]()
    for k, a in enumerate(answers):
        if a.doubtful or not is_stale(a.effect, a.where.get("component")):
            continue
        number = [t.family.id for t in delivered.selection.terms]
        new = (
            renew_tables(delivered.problem, stage, delivered.selection, number.index(a.id))
            if a.id in number
            else None
        )
        if new is not None and new.holds:
            out[k] = replace(a, renewed_tables=new)
            held_out += new.held_out
        else:
            remarks.append(
                "the calibration as a whole is stale, and tables fitted to these rows do not predict rows that were not fitted: calibrate"
                " anew (vcmm calibrate)"
            )
    return tuple(out), tuple(held_out), tuple(remarks)


def _worsened_far_zones(delivered: DeliveredTerms) -> tuple[str, ...]:
    """Return the far zones that the delivered terms predict worse than no terms do, for which blocks along the axis decided."""
    if not delivered.selection.terms:
        return ()
    return tuple(
        f"from the other rows the names predict the {fold} worse than nothing does: they hold between the rows (blocks held out along"
        " that axis are predicted) and not beyond them"
        for fold in worsened_folds(delivered.problem, delivered.parts, delivered.selection)
    )


def _reasons_of_noise(
    accepted: AcceptedTerms, every: Sequence[Answer], searched: Problem, excess: str
) -> tuple[str, ...]:
    """Return why the names are not the whole story: residuals, folds, the scatter, doubtful answers."""
    selection, stage = accepted.selection, accepted.stage
    over_stated = float(np.sqrt(np.mean(stage.u**2) / np.mean(searched.u**2)))
    left = selection.sigma(stage.white.dof) * over_stated
    is_named = any(not a.doubtful for a in every) or accepted.mistake is not None
    forgiven = 2.0 * mismatch(selection) * left**2 / stage.white.dof
    unstated = excess or unstated_scatter(stage.noise, left, forgiven)
    against = reasons_against(
        is_named, accepted.unknown, accepted.has_refused_terms, unstated, stage.noise, left
    )
    return (*against, *shared_curve_remarks(every), *doubt_remarks(every))


def _has_field(problem: Problem) -> bool:
    """Return whether a field without a name is part of the calibration. It is known in the searched rows only."""
    return any(name == FIELD for name, _ in problem.stated)


def _with_other_rivals(
    standings: Sequence[Standing], problem: Problem, stage: Stage, selection: Selection, tied: Sequence[str]
) -> list[Standing]:
    """Return the standings with rivals that are no candidates: a mistake of the table, shapes that the rows do not resolve."""
    if not selection.terms:
        return []
    hidden = unresolved_shapes(problem, stage.white)
    named = [_with_mistake(p, selection, i, tied) for i, p in enumerate(standings)]
    return [add_unresolved_names(p, selection, i, hidden) for i, p in enumerate(named)]


def _unique_places(gone: Sequence[str]) -> tuple[str, ...]:
    """Return the names and places without repetition; a name lists all its places."""
    return tuple(g for g in dict.fromkeys(gone) if "[" not in g or g.split("[")[0] not in gone)


def _with_mistake(standing: Standing, selection: Selection, i: int, tied: Sequence[str]) -> Standing:
    """Return the standing with a mistake of the table among the rivals where one explains as much."""
    if selection.terms[i].family.id not in tied:
        return standing
    return replace(standing, names=(*standing.names, MISTAKE))
