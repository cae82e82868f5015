"""Answers from terms: numbers of what is delivered from its own refit, of candidates from the fit of everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import RANK, SCALES, Whitener
from vcmm.learn.diagnosis.bounds import beyond
from vcmm.learn.diagnosis.candidates import rebuild_option
from vcmm.learn.diagnosis.confusion import Standing
from vcmm.learn.diagnosis.constants import EVEN_ODDS, LOWEST, NOTHING, STRONG
from vcmm.learn.diagnosis.delivery import DeliveredTerms, fitted_noise, setting_for, shares_of_rows
from vcmm.learn.diagnosis.estimates import estimates
from vcmm.learn.diagnosis.evidence import Dictionary
from vcmm.learn.diagnosis.families import open_text
from vcmm.learn.diagnosis.field import Field, weigh_against_field
from vcmm.learn.diagnosis.improve import fitted_effect
from vcmm.learn.diagnosis.log_mistakes import LOG
from vcmm.learn.diagnosis.mistakes import MISTAKE, Mistake
from vcmm.learn.diagnosis.periods import alias_names
from vcmm.learn.diagnosis.plain_words import remark
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import Refiner, scanned_names
from vcmm.learn.diagnosis.repeated import STRETCH, Repeated
from vcmm.learn.diagnosis.result import Answer, Diagnosis
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import Selection, Setting, Term, fitted_again
from vcmm.learn.diagnosis.simple_part import simple_part


@dataclass(frozen=True, eq=False)
class NamedTerms:
    """Everything that was thought of: the terms with their joint fit, and each among its rivals.

    searched: the same in the rows that were searched, where these are not all.
    """

    problem: Problem
    stage: Stage
    selection: Selection
    places: Sequence[Standing]
    field: Field | None = None
    searched: NamedTerms | None = None

    def probabilities(self) -> list[Answer]:
        """Every term as an answer without numbers: what of it is probable."""
        bare = [self._bare(i) for i in range(len(self.places))]
        return list(weigh_against_field(bare, self.field))

    def _bare(self, i: int) -> Answer:
        term, place = self.selection.terms[i], self.places[i]
        twins = tuple(self.stage.found.families[j].id for j in place.twins)
        signal, excess = self.selection.signal(i), _excess(self.selection, self.stage)
        assert self.selection.fit is not None
        largest = float(np.abs(self.selection.fit.mean[self.selection.span(i)]).max())
        return Answer(
            term.family.name,
            term.family.where,
            {},
            place.probability,
            float(np.clip(signal @ signal / excess, 0.0, 1.0)),
            (*twins, *place.names),
            place.evidence,
            self.selection.delta(i),
            largest > SCALES[-1],
            remark=_remarks(self.selection, i, self.problem, self.stage, place),
            contained_in=place.contained_in,
            rival_probability=place.rival_probability,
            alias_probability=place.with_aliases,
            kin=place.kin,
            of_instrument=_of_instrument(place, self.stage.found),
        )


def _of_instrument(place: Standing, found: Dictionary) -> tuple[str, ...]:
    """Errors of the instrument that repeat an answer exactly and are together as probable as all of the machine that do."""
    own = [(j, p) for j, p in zip(place.exact, place.exact_shares) if _is_of_instrument(found, j)]
    if not own or sum(p for _, p in own) < EVEN_ODDS * place.with_aliases:
        return ()
    return tuple(dict.fromkeys(found.families[j].name for j, _ in own))


def _is_of_instrument(found: Dictionary, family: int) -> bool:
    effect = found.options[int(found.first[family])].effect
    return effect is not None and effect.per == "instrument"


def _excess(selection: Selection, stage: Stage) -> float:
    variance = selection.fit.sigma**2 if selection.fit else 1.0
    return max(float(selection.y @ selection.y) - stage.white.dof * variance, NOTHING)


def answers(
    named: NamedTerms, given: DeliveredTerms, mistake: Mistake | None, seed: int
) -> tuple[Answer, ...]:
    """All answers, those of the largest share first; below each its twins at other places, which repeat it exactly."""
    of_rows = shares_of_rows(given.problem, given.selection)
    apart = shares_of_rows(named.problem, named.selection)
    out: list[tuple[Answer, ...]] = []
    for i, bare in enumerate(named.probabilities()):
        k = given.term(i)
        problem, selection, at = (
            (named.problem, named.selection, i) if k is None else (given.problem, given.selection, k)
        )
        shown = _with_numbers(bare, problem, selection, at, named.stage, seed)
        share = apart[i] if k is None else of_rows[k]
        shown = replace(shown, share_of_rows=share, withheld=given.withheld.get(i, ""))
        out.append((shown, *_twins(shown, named, problem, selection, at, i, seed)))
    of_table = [(_of_mistake(mistake, named.stage.white),)] if mistake is not None else []
    return tuple(a for group in sorted((*of_table, *out), key=lambda g: -g[0].share) for a in group)


def _with_numbers(
    bare: Answer, problem: Problem, selection: Selection, i: int, stage: Stage, seed: int
) -> Answer:
    white = problem.whitener(*fitted_noise(problem, stage))
    found = estimates(problem, selection, i, Refiner(problem, white), seed)
    effect, inputs = fitted_effect(selection, i, problem.machine)
    terms, offset = (*scanned_names(selection.terms[i].option), "period"), problem.run.offset
    outside = beyond(effect, found, problem.machine, offset)
    rivals = (*bare.cannot_be_told_from, *alias_names(effect, problem.run))
    return replace(
        bare, parameters=found, fitted=effect, inputs=inputs, scanned=terms, beyond=outside, cannot_be_told_from=rivals
    )  # fmt: skip


def _twins(
    of: Answer, named: NamedTerms, problem: Problem, selection: Selection, at: int, i: int, seed: int
) -> list[Answer]:
    """The same name at the places that repeat answer `of`, each with its own numbers; none of them is written."""
    setting, out = setting_for(problem, named.stage), []
    place = named.places[i]
    for j, probability in zip(place.twins, place.shares):
        term = _twin(named, selection, at, i, j)
        moved = fitted_again(
            [term if k == at else t for k, t in enumerate(selection.terms)], setting, rounds=1
        )
        new = replace(of, where=term.family.where, probability=probability, alias_of=of.id)
        new = _with_numbers(new, problem, moved, at, named.stage, seed)
        others = [of.id, *(n for n in of.cannot_be_told_from if n != term.family.id)]
        out.append(replace(new, fitted=None, inputs=(), cannot_be_told_from=tuple(others)))
    return out


def _twin(named: NamedTerms, selection: Selection, at: int, i: int, j: int) -> Term:
    """Term `at` of a refit, which is term i of all, as family j."""
    if named.searched is None:
        return _at_place(named.stage.found, selection, at, j)
    term = _at_place(named.searched.stage.found, named.searched.selection, i, j)
    option = rebuild_option(term.option, named.problem)
    return selection.terms[at] if option is None else replace(term, option=option)


def _at_place(found: Dictionary, selection: Selection, at: int, j: int) -> Term:
    """Term `at` as family j, in the shape that repeats its signal best."""
    signal = selection.signal(at)
    stop = int(found.first[j + 1]) if j + 1 < len(found.first) else len(found.options)

    def left(option: int) -> float:
        x = found.columns(option)
        return float(np.linalg.norm(signal - x @ np.linalg.lstsq(x, signal, rcond=RANK)[0]))

    best = min(range(int(found.first[j]), stop), key=left)
    return Term(found.families[j], found.options[best], found.columns(best), selection.terms[at].width)


def _remarks(selection: Selection, i: int, problem: Problem, stage: Stage, place: Standing) -> str:
    """What must be said beside answer i."""
    exact = {stage.found.families[j].id for j in place.twins}
    name = selection.terms[i].family.name
    open_at = [w for w in place.elsewhere if f"{name}[{','.join(w.values())}]" not in exact]
    others = " | ".join(" ".join(w.values()) for w in open_at)
    said = (
        f"its place is open: as good at {others}" if others else "",
        remark(selection.terms[i].option.effect, problem.run, problem.recording.kind),
        open_text(place.kin) if place.kin else "",
        simple_part(selection, i, stage.found.families, problem, stage.white),
    )
    return "; ".join(s for s in said if s)


def _of_mistake(mistake: Mistake, white: Whitener) -> Answer:
    places = {MISTAKE: "component", LOG: "columns"}
    where = {places.get(mistake.effect, "axis"): mistake.component}
    size = float(np.linalg.norm(white.apply(mistake.departure)))
    something = 1.0 - float(np.exp(-mistake.score))
    sure = something / (1.0 + float(np.exp(-mistake.lead)))  # free terms share it
    rivals = mistake.free if mistake.lead < STRONG else ()
    theirs = something - sure if rivals else 0.0
    return Answer(
        mistake.effect, where, {}, sure, 1.0, rivals, mistake.score, size, rival_probability=theirs,
        alias_probability=sure, share_of_rows=1.0, mistake=mistake.what if mistake.effect == LOG else "",
    )  # fmt: skip


def add_repeated(d: Diagnosis, again: Repeated) -> Diagnosis:
    """The diagnosis of the other rows, and the stretch that stands there twice as a mistake of the log."""
    sure = 1.0 - min(again.expected, 1.0)
    count = int(again.copied.sum())
    answer = Answer(
        LOG, {"columns": again.where}, {}, sure, 0.0, (), float(-np.log(max(again.expected, LOWEST))),
        alias_probability=sure, share_of_rows=count / (count + d.searched[1]), mistake=STRETCH,
        remark=f"the {count} copied readings are left out",
    )  # fmt: skip
    verdict = {"nothing missing": "explained"}.get(d.verdict, d.verdict)
    return replace(d, answer=(answer, *d.answer), verdict=verdict)


def of_the_machine(selection: Selection, places: Sequence[Standing], setting: Setting) -> Selection:
    """Terms that no machine file can hold (errors of the instrument, a calibration that is stale as a whole) give way to names
    that repeat them exactly and that one can hold; both remain named.
    """
    terms = list(selection.terms)
    for i, place in enumerate(places):
        if not _has_a_number(terms[i]):
            others = (_at_place(setting.found, selection, i, j) for j in place.exact)
            terms[i] = next((t for t in others if _has_a_number(t)), terms[i])
    return selection if list(selection.terms) == terms else fitted_again(terms, setting, rounds=1)


def _has_a_number(term: Term) -> bool:
    """Can a machine file hold it?"""
    effect = term.option.effect
    return effect is not None and effect.per != "instrument" and not any("@" in n for n in term.option.labels)
