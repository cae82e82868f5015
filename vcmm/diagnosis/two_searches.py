"""Two roads to an answer: everything at once, or one number per name first. Rows held out decide between them.

The evidence of the rows that were fitted favours curves, since nature is never quite straight; what counts is what is
predicted where conditions go beyond the fit. Where both predict alike, the evidence of all rows decides, as far as errors of
templates leave it to say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vcmm.diagnosis.constants import FEW, STRONG
from vcmm.diagnosis.holdout import Fold, judge
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.select import Selection, Setting, Term, mismatch, select_simply, worth

Gate = Callable[[Problem, Sequence[Fold], Selection, Setting], Selection]


def best_road(
    problem: Problem, parts: Sequence[Fold], straight: Selection, setting: Setting, gated: Gate
) -> tuple[Selection, bool]:
    """The better of `straight` and the simple road, of each what `gated` lets through; whether it held terms back there.

    Where rows held out cannot tell them apart, the simple road is better if it has fewer numbers, or if its evidence falls short
    by no more than errors of templates may bring. One term of one number, or the same names: nothing to choose.
    """
    first = gated(problem, parts, straight, setting)
    short = len(first.terms) < len(straight.terms)
    if not any(free(t) for t in straight.terms) and len(straight.terms) < 2:
        return first, short
    simple = select_simply(setting)
    if names(simple) == names(straight):
        return first, short
    second = gated(problem, parts, simple, setting)
    if not second.terms:
        return first, short
    lead = _gain(problem, parts, second, first, setting) - _gain(problem, parts, first, second, setting)
    forgiven = max(mismatch(first), mismatch(second))
    alike = lead > -STRONG
    cheaper = numbers(second) < numbers(first)
    if lead > STRONG or (alike and (cheaper or worth(second, setting) > worth(first, setting) - forgiven)):
        return second, len(second.terms) < len(simple.terms)
    return first, short


def free(term: Term) -> bool:
    """Has it many numbers? Then it may stand for several simple names."""
    return term.white.shape[1] > FEW


def numbers(selection: Selection) -> int:
    """Free numbers of all terms."""
    return sum(t.white.shape[1] for t in selection.terms)


def names(selection: Selection) -> set[str]:
    return {t.family.id for t in selection.terms}


def _gain(
    problem: Problem, parts: Sequence[Fold], selection: Selection, other: Selection, setting: Setting
) -> float:
    """Nats on the rows held out, both counted in the smaller noise of the two; of the fit itself where there is no fold."""
    if not parts:
        return worth(selection, setting)
    quieter = min((selection, other), key=lambda s: s.fit.sigma if s.fit else float("inf"))
    return sum(judge(problem, part, quieter, selection.terms).gain for part in parts)
