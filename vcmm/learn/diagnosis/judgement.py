"""Which of the chosen terms hold, what they compete with, and what is left without a name.

A field without a name that stands is put beside the calibration, as one more covariance, and the search is made again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.learn.diagnosis.adequacy import describe_shape, unknown_rest
from vcmm.learn.diagnosis.answers import of_the_machine
from vcmm.learn.diagnosis.candidates import Catalogue, Family
from vcmm.learn.diagnosis.confusion import Standing, standing
from vcmm.learn.diagnosis.constants import EVEN_ODDS, FEW, MOSTLY
from vcmm.learn.diagnosis.evidence import Dictionary
from vcmm.learn.diagnosis.families import by_simplest
from vcmm.learn.diagnosis.field import Field, is_simple, kept_terms, rival_field
from vcmm.learn.diagnosis.holdout import Fold, folds, gate, is_free_curve, wins_everywhere
from vcmm.learn.diagnosis.mistakes import Mistake
from vcmm.learn.diagnosis.modulation import find_modulation
from vcmm.learn.diagnosis.neighbours import departure
from vcmm.learn.diagnosis.problem import FIELD, Problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.search import SearchResult, Stage, build_stage, search, setting_of
from vcmm.learn.diagnosis.select import Selection, Setting, Term, basis_of, joint
from vcmm.learn.diagnosis.shortfall import failing_fold, of_fold


@dataclass(frozen=True, eq=False)
class Judgement:
    """Terms that hold, and what they compete with. failed: terms were held back; thought: all that the search named; tied: see
    Chosen.
    """

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
    thought: Sequence[Term] = ()


def judge_terms(chosen: SearchResult, stage: Stage, seed: int, in_field: bool = False) -> Judgement:
    """The terms that hold, what they are worth, and a field that may stand for them.

    in_field: a field stands beside the calibration already. No further shape without physics is weighed, and a fold, in which
    the field is as free again, refuses no term here; what makes rows worse is not handed over all the same.
    """
    used, selection = chosen.problem, chosen.selection
    setting = replace(setting_of(used, stage), start=selection.y)
    parts = folds(used, stage.u, stage.noise.rho)
    shapes = None if in_field else stage.generic
    searched, selection = selection, selection if in_field else _gate_terms(used, parts, selection, setting)
    failed = len(selection.terms) < len(searched.terms)
    selection = of_the_machine(selection, _standings(used, parts, selection, setting, shapes), setting)
    places = _standings(used, parts, selection, setting, shapes)
    simple = by_simplest(selection, [p.kin for p in places if p.kin], setting)
    if simple is not selection:
        selection, places = simple, _standings(used, parts, simple, setting, shapes)
    firm = tuple(i for i in range(len(places)) if wins_everywhere(used, parts, selection, i))
    field = rival_field(used, selection, setting, stage.sample, shapes, firm) if selection.terms else None
    rest = _rest(used, stage, selection, setting, parts, seed, field)
    return Judgement(
        used,
        stage,
        setting,
        parts,
        selection,
        places,
        chosen.mistake,
        chosen.tied,
        failed,
        field,
        rest,
        chosen.selection.terms,
    )


def beside_field(
    first: Judgement, known: Catalogue, generics: Sequence[Family], seed: int, nulls: int
) -> Judgement:
    """The search again beside a field that stands, which then is one more covariance; as it was where nothing is found so, or
    where nothing is left without a name.
    """
    if first.rest is None or not first.thought:
        return first
    field = first.field or rival_field(first.problem, first.selection, first.setting, first.stage.sample)
    if field is None or not field.stands:
        return first
    beside = first.problem.with_statement(FIELD, field.columns)
    stage = build_stage(beside, _simple(known), generics, first.stage.noise, seed, nulls, first.stage.screen)
    chosen = search(beside, stage)
    second = judge_terms(chosen, chosen.stage, seed, in_field=True)
    if not second.selection.terms or _loses_name(first, second) or not _told_before(first, second):
        return first
    what = describe_shape(field.unknown, first.problem, first.setting, joint((), first.setting), first.parts)
    return replace(second, mistake=first.mistake, field=None, rest=what)


def _simple(known: Catalogue) -> Catalogue:
    """The catalogue without names of more numbers than FEW: shapes of their own, as free as a field, which say it once more."""
    kept = []
    for family in (f for f in known.families if not is_free_curve(f.name)):
        few = tuple(o for o in family.options if o.columns.shape[1] <= FEW)
        kept += [replace(family, options=few)] if few else []
    return replace(known, families=tuple(kept))


def _told_before(first: Judgement, second: Judgement) -> bool:
    """Is most of what the second search names what the first one named, perhaps as a curve? A field takes the place of what
    a name has too much; what is new beside it is a shadow of what it leaves out, and names of more numbers than the first
    ones had are one of them in parts.
    """
    if _freedom(second.selection.terms) > _freedom(first.thought):
        return False
    white = first.stage.white
    basis = basis_of(first.thought, first.problem.m)
    fit = second.selection.fit
    assert fit is not None
    for i, term in enumerate(second.selection.terms):
        signal = white.apply(term.option.columns @ fit.mean[second.selection.span(i)])
        if float(np.sum((basis.T @ signal) ** 2)) < MOSTLY * float(signal @ signal):
            return False
    return True


def _freedom(terms: Sequence[Term]) -> int:
    """Free numbers of some names, scanned ones among them."""
    return sum(t.option.freedom for t in terms)


def _loses_name(first: Judgement, second: Judgement) -> bool:
    """Is a name gone that was found and wins all its folds? A free curve may be: it is as free as the field."""
    kept = _probable_ids(second)
    own = first.selection
    gone = [i for i, t in enumerate(own.terms) if t.family.id in _probable_ids(first) - kept]
    return any(
        wins_everywhere(first.problem, first.parts, own, i)
        for i in gone
        if not is_free_curve(own.terms[i].family.name)
    )


def _probable_ids(one: Judgement) -> set[str]:
    """Ids of the names that are more probable than not, with what repeats them exactly; none that a field makes superfluous."""
    refused = one.field.refused if one.field is not None and one.field.stands else ()
    pairs = enumerate(zip(one.selection.terms, one.places))
    return {t.family.id for i, (t, p) in pairs if i not in refused and p.with_aliases >= EVEN_ODDS}


def _gate_terms(problem: Problem, parts: Sequence[Fold], selection: Selection, setting: Setting) -> Selection:
    """The terms that predict rows held out: the one that fails worst is refused, the others are refitted and asked again."""
    while failed := gate(problem, parts, selection):
        selection = joint([t for i, t in enumerate(selection.terms) if i != failed[0]], setting)
    return selection


def _standings(
    problem: Problem,
    parts: Sequence[Fold],
    selection: Selection,
    setting: Setting,
    generic: Dictionary | None,
) -> list[Standing]:
    """Every term among its rivals. A shape without physics is none of a simple name that wins all its folds: it has no linear
    part, no wave and no step of its own.
    """
    shapes = [
        None if is_simple(t) and wins_everywhere(problem, parts, selection, i) else generic
        for i, t in enumerate(selection.terms)
    ]
    return [standing(selection, setting, i, shape) for i, shape in enumerate(shapes)]


def _rest(
    problem: Problem,
    stage: Stage,
    selection: Selection,
    setting: Setting,
    parts: Sequence[Fold],
    seed: int,
    field: Field | None,
) -> Unknown | None:
    """What has no name: a field that beats the names, a shape in the residual, neighbours that agree, a field beside the names
    that is surer than shapes are in null recordings, else a fold that falls short of what the names promise.
    """
    if field is not None and field.wins:
        return describe_shape(
            field.unknown, problem, setting, joint(kept_terms(selection, field), setting), parts
        )
    rest = unknown_rest(stage.generic, selection, stage.white, stage.chance, stage.generic_threshold)
    rest = rest or find_modulation(problem, selection, stage.white, stage.generic_threshold)
    rest = rest or departure(problem, selection, stage.white, stage.sample)
    if rest is None and field is not None and field.lead > stage.generic_threshold:
        rest = field.unknown
    rest = describe_shape(rest, problem, setting, selection, parts)
    short = failing_fold(problem, parts, selection, stage.noise, stage.u, seed)
    return of_fold(short) if short and rest is None else rest
