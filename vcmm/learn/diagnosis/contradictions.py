"""Statements of the machine file that the rows contradict: each becomes a name like any other, with the size that the rows give it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.learn.diagnosis.answers import NamedTerms
from vcmm.learn.diagnosis.delivery import DeliveredTerms, replaced_inputs, residual_after_terms, setting_for
from vcmm.learn.diagnosis.rivals import Standing, compare_with_rivals
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, best_option, refit
from vcmm.learn.diagnosis.statement_tests import (
    Pull,
    calibration_pulls,
    contradiction_probability,
    pull_limit,
)


def add_contradictions(named: NamedTerms) -> NamedTerms:
    """Return the terms with one more for every stated number that the rows contradict, where the catalogue has a name for it."""
    selection, stage = named.selection, named.stage
    sigma = selection.sigma(stage.white.dof)
    pulls = calibration_pulls(
        named.problem, residual_after_terms(named.problem, selection), sigma, stage.u, stage.noise.rho
    )
    far = pull_limit(len(pulls))
    new = [(p, t) for p in pulls if abs(p.pull) > far and (t := _statement_term(p.input, named)) is not None]
    if not new:
        return named
    terms = [*selection.terms, *(t for _, t in new)]
    free = named.problem.without_statements(replaced_inputs(named.problem, [t for _, t in new]))
    whole = refit(terms, setting_for(free, stage))
    standings = [
        *named.standings,
        *(
            _statement_standing(whole, len(selection.terms) + k, p, len(pulls), named)
            for k, (p, _) in enumerate(new)
        ),
    ]
    return replace(named, problem=free, selection=whole, standings=standings)


def _statement_term(statement: str, named: NamedTerms) -> SelectedTerm | None:
    """Return the family of the statement, as a term; None where it is named already or no candidate."""
    candidates = named.stage.candidates
    wanted = statement.rsplit(".", 1)[0]
    if any(t.option.effect is not None and t.option.effect.id == wanted for t in named.selection.terms):
        return None
    for i, family in enumerate(candidates.families):
        option = candidates.options[best_option(candidates, np.zeros(len(candidates.options)), i)]
        if option.effect is not None and option.effect.id == wanted and option.columns.shape[1] == 1:
            return SelectedTerm(
                family,
                option,
                candidates.columns(best_option(candidates, np.zeros(len(candidates.options)), i)),
            )
    return None


def _statement_standing(whole: Selection, i: int, pull: Pull, count: int, named: NamedTerms) -> Standing:
    """Return the standing; its probability is that the statement does not hold; only terms that repeat it exactly are rivals, for the statement is
    about this quantity and no other.
    """
    setting = setting_for(named.problem, named.stage)
    standing = compare_with_rivals(whole, setting, i)
    name = whole.terms[i].family.name
    families = named.stage.candidates.families
    names = dict.fromkeys(families[j].name for j in standing.exact if families[j].name != name)
    sure = contradiction_probability(pull.pull, count)
    return Standing(
        0.5 * pull.pull**2, sure, tuple(names), tuple(j for j in standing.exact if families[j].name != name),
        alias_probability=sure, exact=standing.exact,
    )  # fmt: skip


def pulls_after_terms(delivered: DeliveredTerms, stage: Stage) -> tuple[Pull, ...]:
    """Return the pulls after the delivered terms: of a quantity that was set free, the estimate less the statement."""
    selection = delivered.selection
    rest = residual_after_terms(delivered.problem, selection)
    inside = calibration_pulls(
        delivered.problem, rest, selection.sigma(stage.white.dof), stage.u, stage.noise.rho
    )
    stated = {item.id: item for item in delivered.problem.machine.inputs}
    free = []
    for i, term in enumerate(selection.terms):
        effect = term.option.effect
        for name, item in stated.items():
            if (
                effect is None
                or selection.fit is None
                or name.rsplit(".", 1)[0] != effect.id
                or len(term.option.unit) != 1
            ):
                continue
            size = float(selection.fit.mean[selection.span(i)][0] * term.option.unit[0])
            free.append(Pull(name, size / item.size, 1))
    return tuple(sorted((*inside, *free), key=lambda p: -abs(p.pull)))


def named_contradictions(pulls: Sequence[Pull], delivered: DeliveredTerms) -> tuple[str, ...]:
    """Return sentences about statements that are contradicted and have a name."""
    named = _effect_ids(delivered)
    far = pull_limit(len(pulls))
    return tuple(
        _contradiction_text(p) for p in pulls if abs(p.pull) > far and p.input.rsplit(".", 1)[0] in named
    )


def unnamed_contradictions(pulls: Sequence[Pull], delivered: DeliveredTerms) -> tuple[str, ...]:
    """Return sentences about statements that no name replaces: they contradict "explained"."""
    named = _effect_ids(delivered)
    far = pull_limit(len(pulls))
    return tuple(
        _contradiction_text(p) for p in pulls if abs(p.pull) > far and p.input.rsplit(".", 1)[0] not in named
    )


def _effect_ids(delivered: DeliveredTerms) -> set[str]:
    return {t.option.effect.id for t in delivered.selection.terms if t.option.effect is not None}


def _contradiction_text(p: Pull) -> str:
    return (
        f"the rows contradict what the machine file states of {p.input}: the estimate lies {abs(p.pull):.1f} of its standard"
        " uncertainties from the statement"
    )
