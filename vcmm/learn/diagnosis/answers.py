"""Answers from terms: numbers of delivered terms from their own refit, of candidates from the fit of everything.

Simple names of curves: a change of geometry whose slope is a scale or a squareness is reported with that number too.

A curve with a small bend has more evidence than its straight part; an operator still needs "square by -60 urad".

Sizes beyond what physics allows: a name of such a size is a candidate, however well it fits.

An effect declares them where there are any (`Typical.bounds`, `one_sided`). An Abbe arm is bounded by the machine: no reference line lies
farther from the tip than the diagonal of its travels and tools. A size is outside where its whole 95 % coverage interval is.

A size beyond what machines have: the instrument is then as probable a cause as the machine.

An effect declares how large it usually is, and where that is known the most that a machine has; the widest prior of the search
is SCALES[-1] = 64 times the usual size, which counts where no most is declared. A number beyond it (an axis that errs by 8 mm/m, a cyclic error of a degree) is more often a wrong unit, gain or sensor than a machine. There is no
model of such a mistake that could be weighed, so name and instrument share the probability evenly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Whitener
from vcmm.core.effect import Effect, parameter, parameter_fields, required, typical, unit_at
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import in_unit
from vcmm.learn.diagnosis.candidates import Family, Option, rebuild_option
from vcmm.learn.diagnosis.constants import EVEN_ODDS, LEAST_FRACTION, LOWEST, MOSTLY, STRONG
from vcmm.learn.diagnosis.copied_readings import STRETCH, CopiedStretch
from vcmm.learn.diagnosis.delivery import DeliveredTerms, noise_for_fit, setting_for, shares_of_rows
from vcmm.learn.diagnosis.estimates import Estimate, estimate_parameters
from vcmm.learn.diagnosis.evidence import Dictionary, best_mimic, visible_columns
from vcmm.learn.diagnosis.families import open_members_text
from vcmm.learn.diagnosis.improve import fitted_effect
from vcmm.learn.diagnosis.log_mistakes import LOG, MISTAKE, Mistake
from vcmm.learn.diagnosis.mistakes import generalises
from vcmm.learn.diagnosis.periods import alias_names
from vcmm.learn.diagnosis.plain_words import answer_remark
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import Refiner, scanned_names
from vcmm.learn.diagnosis.result import Answer, Diagnosis
from vcmm.learn.diagnosis.rivals import Standing
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, Setting, refit
from vcmm.physics import BY_NAME

ARM = "arm"


def reason_impossible(
    effect: Effect | None, estimates: Mapping[str, Estimate], machine: Machine, offset: Array
) -> str:
    """Return why a fitted effect is impossible, in words; "" where it is possible. offset (n, 3) mm: tips from the last frame."""
    if effect is None:
        return ""
    if effect.diagnosis.is_never_negative and _is_negative(effect):
        return f"{effect.name} cannot be below zero"
    back = {name: shown for shown, name in effect.about.aliases.items()}
    for spec in parameter_fields(effect):
        usual, estimate = spec.metadata["typical"], estimates.get(back.get(spec.name, spec.name))
        if usual is None or usual.bounds is None or estimate is None:
            continue
        low, high = (in_unit(b, estimate.unit) for b in usual.bounds)
        if estimate.interval95[1] < low or estimate.interval95[0] > high:
            return f"{spec.name} = {estimate.value:.3g} {estimate.unit} lies outside {low:.3g} to {high:.3g}: {usual.why}"
    arm = estimates.get(ARM)
    if effect.diagnosis.size_name == ARM and arm is not None:
        reach = in_unit(_reach(machine, offset), arm.unit)
        if arm.interval95[0] > reach:
            return f"an arm of {arm.value:.3g} {arm.unit} lies outside the machine, whose travels and tools reach {reach:.3g} {arm.unit}"
    return ""


def _is_negative(effect: Effect) -> bool:
    linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
    return any(float(np.min(getattr(effect, name))) < 0.0 for name in linear)


def _reach(machine: Machine, offset: Array) -> float:
    """Return the reach in mm: the diagonal of the travels, and the longest tool."""
    travels = [float(np.ptp(a.travel)) for a in machine.axes.values() if not a.rotary]
    return float(np.linalg.norm(travels)) + float(np.linalg.norm(offset, axis=1).max(initial=0.0))


def simple_part(
    selection: Selection, i: int, families: tuple[Family, ...], problem: Problem, white: Whitener
) -> str:
    """Return '95 % of it is squareness C0Y, -61.2 urad'; '' where term i is no curve or holds no simple name to that extent."""
    term = selection.terms[i]
    if term.option.columns.shape[1] < 2:
        return ""
    signal = selection.signal(i)
    best: tuple[float, Family, Option, float] | None = None
    for family in families:
        simple = family.name in BY_NAME and BY_NAME[family.name].diagnosis.is_uniform
        if not simple or not generalises(term.family.name, family.name):
            continue
        for simple_option in (o for o in family.options if o.columns.shape[1] == 1 and o.effect is not None):
            option = (
                simple_option
                if len(simple_option.columns) == problem.m
                else rebuild_option(simple_option, problem)
            )
            x = None if option is None else visible_columns(option.columns, white)
            if option is None or x is None:
                continue
            size = float(x[:, 0] @ signal / (x[:, 0] @ x[:, 0]))
            share = size**2 * float(x[:, 0] @ x[:, 0]) / max(float(signal @ signal), LEAST_FRACTION)
            if share > (best[0] if best else MOSTLY):
                best = share, family, option, size
    return _simple_part_text(*best) if best else ""


def _simple_part_text(share: float, family: Family, option: Option, size: float) -> str:
    assert option.effect is not None
    show = parameter(option.effect, option.labels[0]).metadata["show"]
    unit = unit_at(option.effect, show, axis=str(getattr(option.effect, "axis", "")))
    value = in_unit(size * float(option.unit[0]), unit)
    where = " ".join(family.where.values())
    return f"{100 * share:.0f} % of it is {family.name} {where}".rstrip() + f", {value:.3g} {unit}"


@dataclass(frozen=True, eq=False)
class NamedTerms:
    """All terms that were considered, with their joint fit, and each among its rivals.

    in_searched_rows: the same in the rows that were searched, where these are not all.
    """

    problem: Problem
    stage: Stage
    selection: Selection
    standings: Sequence[Standing]
    in_searched_rows: NamedTerms | None = None

    def bare_answers(self) -> list[Answer]:
        """Return every term as an answer without numbers, with its probability."""
        return [self._bare_answer(i) for i in range(len(self.standings))]

    def _bare_answer(self, i: int) -> Answer:
        term, standing = self.selection.terms[i], self.standings[i]
        same = (*standing.twins, *(j for j, _ in standing.elsewhere if j not in standing.twins))
        others = tuple(dict.fromkeys(self.stage.candidates.families[j].id for j in same))
        signal, excess = self.selection.signal(i), _excess_energy(self.selection, self.stage)
        assert self.selection.fit is not None
        largest = float(np.abs(self.selection.fit.mean[self.selection.span(i)]).max())
        return Answer(
            term.family.name,
            term.family.where,
            {},
            standing.probability,
            float(np.clip(signal @ signal / excess, 0.0, 1.0)),
            (*others, *standing.names),
            standing.evidence,
            self.selection.delta(i),
            largest > SCALES[-1],
            remark=_remarks(self.selection, i, self.problem, self.stage, standing),
            contained_in=standing.contained_in,
            rival_probability=standing.rival_probability,
            alias_probability=standing.alias_probability,
            kin=standing.kin,
            of_instrument=_instrument_aliases(standing, self.stage.candidates),
        )


def _instrument_aliases(standing: Standing, candidates: Dictionary) -> tuple[str, ...]:
    """Return the errors of the instrument that repeat an answer exactly and are together as probable as all of the machine that do."""
    of_instrument = [
        (j, p) for j, p in zip(standing.exact, standing.exact_shares) if _is_of_instrument(candidates, j)
    ]
    if not of_instrument or sum(p for _, p in of_instrument) < EVEN_ODDS * standing.alias_probability:
        return ()
    return tuple(dict.fromkeys(candidates.families[j].name for j, _ in of_instrument))


def _is_of_instrument(candidates: Dictionary, family: int) -> bool:
    effect = candidates.options[int(candidates.first[family])].effect
    return effect is not None and effect.per == "instrument"


def _excess_energy(selection: Selection, stage: Stage) -> float:
    variance = selection.fit.sigma**2 if selection.fit else 1.0
    return max(float(selection.y @ selection.y) - stage.white.dof * variance, LEAST_FRACTION)


def make_answers(
    named: NamedTerms, delivered: DeliveredTerms, mistake: Mistake | None, seed: int
) -> tuple[Answer, ...]:
    """Return all answers, those of the largest share first; below each its twins at other places, which repeat it exactly."""
    of_rows = shares_of_rows(delivered.problem, delivered.selection)
    apart = shares_of_rows(named.problem, named.selection)
    out: list[tuple[Answer, ...]] = []
    for i, bare in enumerate(named.bare_answers()):
        k = delivered.term(i)
        problem, selection, at = (
            (named.problem, named.selection, i) if k is None else (delivered.problem, delivered.selection, k)
        )
        shown = _with_numbers(bare, problem, selection, at, named.stage, seed)
        share = apart[i] if k is None else of_rows[k]
        shown = replace(shown, share_of_rows=share, withheld_because=delivered.reasons_withheld.get(i, ""))
        out.append((shown, *_twin_answers(shown, named, problem, selection, at, i, seed)))
    of_table = [(_mistake_answer(mistake, named.stage.white),)] if mistake is not None else []
    return tuple(a for group in sorted((*of_table, *out), key=lambda g: -g[0].share) for a in group)


def _with_numbers(
    bare: Answer, problem: Problem, selection: Selection, i: int, stage: Stage, seed: int
) -> Answer:
    white = problem.whitener(*noise_for_fit(problem, stage))
    numbers = estimate_parameters(problem, selection, i, Refiner(problem, white), seed)
    effect, inputs = fitted_effect(selection, i, problem.machine)
    terms, offset = (*scanned_names(selection.terms[i].option), "period"), problem.run.offset
    outside = reason_impossible(effect, numbers, problem.machine, offset)
    rivals = (*bare.cannot_be_told_from, *alias_names(effect, problem.run))
    return replace(
        bare, parameters=numbers, fitted=effect, inputs=inputs, scanned_parameters=terms, impossible_because=outside, cannot_be_told_from=rivals
    )  # fmt: skip


def _twin_answers(
    of: Answer, named: NamedTerms, problem: Problem, selection: Selection, at: int, i: int, seed: int
) -> list[Answer]:
    """Return the same name at the places that repeat answer `of`, each with its own numbers; none of them is written."""
    setting, out = setting_for(problem, named.stage), []
    standing = named.standings[i]
    for j, probability in zip(standing.twins, standing.shares):
        term = _twin_term(named, selection, at, i, j)
        moved = refit([term if k == at else t for k, t in enumerate(selection.terms)], setting, rounds=1)
        new = replace(of, where=term.family.where, probability=probability, alias_of=of.id)
        new = _with_numbers(new, problem, moved, at, named.stage, seed)
        others = [of.id, *(n for n in of.cannot_be_told_from if n != term.family.id)]
        out.append(replace(new, fitted=None, inputs=(), cannot_be_told_from=tuple(others)))
    return out


def _twin_term(named: NamedTerms, selection: Selection, at: int, i: int, j: int) -> SelectedTerm:
    """Return the term `at` of a refit, which is term i of all, as family j."""
    if named.in_searched_rows is None:
        return _term_at_place(named.stage.candidates, selection, at, j)
    term = _term_at_place(named.in_searched_rows.stage.candidates, named.in_searched_rows.selection, i, j)
    option = rebuild_option(term.option, named.problem)
    return selection.terms[at] if option is None else replace(term, option=option)


def _term_at_place(candidates: Dictionary, selection: Selection, at: int, j: int) -> SelectedTerm:
    """Return the term `at` as family j, in the shape that repeats its signal best."""
    best = best_mimic(candidates, j, selection.signal(at))
    return SelectedTerm(
        candidates.families[j], candidates.options[best], candidates.columns(best), selection.terms[at].width
    )


def _remarks(selection: Selection, i: int, problem: Problem, stage: Stage, standing: Standing) -> str:
    """Return the remarks beside answer i."""
    exact = {stage.candidates.families[j].id for j in standing.twins}
    open_at = [
        (stage.candidates.families[j], p)
        for j, p in standing.elsewhere
        if stage.candidates.families[j].id not in exact
    ]
    others = " | ".join(f"{' '.join(f.where.values())} (p {p:.2f})" for f, p in open_at)
    sentences = (
        f"its place is open: as good at {others}" if others else "",
        answer_remark(selection.terms[i].option.effect, problem.run, problem.recording.kind),
        open_members_text(standing.kin) if standing.kin else "",
        simple_part(selection, i, stage.candidates.families, problem, stage.white),
    )
    return "; ".join(s for s in sentences if s)


def _mistake_answer(mistake: Mistake, white: Whitener) -> Answer:
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
        remark=mistake.words,
    )  # fmt: skip


def add_copied_stretch(d: Diagnosis, again: CopiedStretch) -> Diagnosis:
    """Return the diagnosis of the other rows, and the stretch that occurs twice as a mistake of the log."""
    sure = 1.0 - min(again.expected_count, 1.0)
    count = int(again.is_copy.sum())
    answer = Answer(
        LOG, {"columns": again.where}, {}, sure, 0.0, (), float(-np.log(max(again.expected_count, LOWEST))),
        alias_probability=sure, share_of_rows=count / (count + d.search_counts[1]), mistake=STRETCH,
        remark=f"the {count} copied readings are left out",
    )  # fmt: skip
    verdict = {"nothing missing": "explained"}.get(d.verdict, d.verdict)
    return replace(d, answer=(answer, *d.answer), verdict=verdict)


def prefer_machine_terms(selection: Selection, standings: Sequence[Standing], setting: Setting) -> Selection:
    """Replace terms that no machine file can hold (errors of the instrument, a calibration that is stale as a whole) by names
    that repeat them exactly and that one can hold; both remain named.
    """
    terms = list(selection.terms)
    for i, standing in enumerate(standings):
        if not _fits_machine_file(terms[i]):
            others = (_term_at_place(setting.candidates, selection, i, j) for j in standing.exact)
            terms[i] = next((t for t in others if _fits_machine_file(t)), terms[i])
    return selection if list(selection.terms) == terms else refit(terms, setting, rounds=1)


def _fits_machine_file(term: SelectedTerm) -> bool:
    """Return whether a machine file can hold a term."""
    effect = term.option.effect
    return effect is not None and effect.per != "instrument" and not any("@" in n for n in term.option.labels)


INSTRUMENT, SENSOR = "instrument", "sensor"  # rivals that are no effects


def has_usual_sizes(effect: Effect) -> bool:
    """Return whether every parameter of a fitted effect has a size that machines have."""
    for f in parameter_fields(effect):
        usual = f.metadata["typical"]
        if usual is not None:
            most = usual.most or SCALES[-1] * typical(effect, f.name)
            if np.abs(np.asarray(getattr(effect, f.name), dtype=float)).max(initial=0.0) > most:
                return False
    return True


def share_with_instrument(a: Answer) -> Answer:
    """Return the answer, where it is too large, with the instrument as a rival of the same weight and a remark."""
    if not a.implausible or (a.fitted is not None and has_usual_sizes(a.fitted)):
        return a
    rival = (
        SENSOR
        if a.fitted is not None and any(c.startswith("temp_") for c in required(a.fitted))
        else INSTRUMENT
    )
    text = (
        f"far more than such an effect usually has: look first at unit, gain and mounting of the {rival} that recorded it,"
        " and repeat it with another one"
    )
    half = a.probability / 2
    return replace(
        a,
        probability=half,
        kin=None if a.kin is None else a.kin.times(0.5),
        rival_probability=a.rival_probability + half,
        cannot_be_told_from=(*a.cannot_be_told_from, rival),
        remark="; ".join(s for s in (a.remark, text) if s),
    )
