"""What was named in some of the rows, fitted to all of them: templates, noise, mistakes of the table."""

from __future__ import annotations

from dataclasses import replace

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.learn.diagnosis.answers import NamedTerms
from vcmm.learn.diagnosis.candidates import rebuild_option
from vcmm.learn.diagnosis.delivery import left_over, setting_for
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.mistakes import Mistake, hypotheses
from vcmm.learn.diagnosis.noise import audit
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import Term, fitted_again


def on_all_rows(named: NamedTerms, whole: Problem, seed: int) -> NamedTerms:
    """The terms fitted again to the observations of `whole`, with the noise that is found there; their standings stay.

    The same where a term cannot be worked out for all rows (a row beyond what its law holds for).
    """
    kept = {name for name, _ in named.problem.stated}
    whole = whole.without([name for name, _ in whole.stated if name not in kept])
    terms = lift_terms(named.selection.terms, whole)
    if terms is None:
        return named
    plain = whole.whitener()
    stage = _stage_of(whole, named.stage, plain)
    first = fitted_again(terms, setting_for(whole, stage), rounds=1)
    noise = audit(whole, plain, plain.apply(left_over(whole, first)), seed)
    stage = replace(stage, noise=noise, u=noise.u(whole))
    stage = _stage_of(whole, stage, whole.whitener(stage.u, noise.rho))
    selection = fitted_again(first.terms, setting_for(whole, stage))
    return replace(named, problem=whole, stage=stage, selection=selection, searched=named)


def lift_terms(terms: tuple[Term, ...], whole: Problem) -> tuple[Term, ...] | None:
    """The terms with columns for the observations of `whole`; None where one has none."""
    options = [rebuild_option(t.option, whole) for t in terms]
    if any(o is None for o in options):
        return None
    return tuple(replace(t, option=o) for t, o in zip(terms, options) if o is not None)


def _stage_of(whole: Problem, stage: Stage, white: Whitener) -> Stage:
    """The stage with the whitener of all rows; its candidates are named there and not looked at again."""
    bare = dictionary((), white)
    found = replace(bare, families=stage.found.families, options=stage.found.options, first=stage.found.first)
    u = whole.u if len(stage.u) != whole.m else stage.u
    return replace(stage, white=white, u=u, found=found)


def mistake_on_all_rows(mistake: Mistake | None, whole: Problem) -> tuple[Mistake | None, Problem]:
    """The same mistake of the table with its departure in all rows, and the rows without it."""
    if mistake is None:
        return None, whole
    same = ("component", "what", "effect", "factor", "source", "both")
    own = next(
        h for h in hypotheses(whole) if all(getattr(h, name) == getattr(mistake, name) for name in same)
    )
    repaired = replace(whole, residual=whole.residual - own.departure)
    return replace(mistake, departure=own.departure), repaired
