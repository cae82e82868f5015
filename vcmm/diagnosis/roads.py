"""Two roads to an answer: everything at once, or one number per name first. Rows held out decide between them.

The evidence of the rows that were fitted favours curves, since nature is never quite straight; what counts is what is
predicted where conditions go beyond the fit. Where both predict alike, the road with fewer numbers stands.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vcmm.diagnosis.holdout import Fold, judge
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.select import Selection, Setting, select_simply, worth

EQUAL = 3.0  # nats: predictions that differ by less are alike
Gate = Callable[[Problem, Sequence[Fold], Selection, Setting], Selection]


def best_road(
    problem: Problem, parts: Sequence[Fold], straight: Selection, setting: Setting, gated: Gate
) -> Selection:
    """The better of `straight` and the simple road, both after the gate. One term, or the same names: nothing to choose."""
    first = gated(problem, parts, straight, setting)
    if len(straight.terms) < 2:
        return first
    simple = select_simply(setting)
    if names(simple) == names(straight):
        return first
    second = gated(problem, parts, simple, setting)
    if not second.terms:
        return first
    lead = _gain(problem, parts, second, first, setting) - _gain(problem, parts, first, second, setting)
    fewer = numbers(second) < numbers(first)
    return second if lead > (-EQUAL if fewer else EQUAL) else first


def names(selection: Selection) -> set[str]:
    return {t.family.id for t in selection.terms}


def numbers(selection: Selection) -> int:
    """How many free numbers the terms have."""
    return sum(t.option.freedom for t in selection.terms)


def _gain(
    problem: Problem, parts: Sequence[Fold], selection: Selection, other: Selection, setting: Setting
) -> float:
    """Nats on the rows held out, both counted in the smaller noise of the two; of the fit itself where there is no fold."""
    if not parts:
        return worth(selection, setting)
    quieter = min((selection, other), key=lambda s: s.fit.sigma if s.fit else float("inf"))
    return sum(judge(problem, part, quieter, selection.terms).gain for part in parts)
