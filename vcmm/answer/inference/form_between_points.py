"""A result with what the form between the points adds: a wider law of the true value, a line in the budget, and no claim where some
form of any size would not show at the points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.result import BudgetLine, CharacteristicResult, PlottedBudget
from vcmm.answer.evaluation.truth import Additive
from vcmm.answer.evaluation.widened_law import together, widen
from vcmm.answer.inference.between_points import FormTold

MATTERS = 1e-3  # of U: less is no line
UNSEEN = "what lies between the points has no bound"
MOST_NAMED = 3  # forms that a reason names
CURE = 'touch more points, all over the feature, or state what is known of its form (form = { amplitude = "1 um" })'


def is_moved_by_form(c: CharacteristicResult) -> bool:
    """Whether form moves it as an error does: sizes, distances and angles of least-squares elements."""
    return isinstance(c.truth, Additive) and not c.extreme


def with_form(c: CharacteristicResult, told: Sequence[FormTold]) -> CharacteristicResult:
    """The result, whatever is indicated, with the forms of its features."""
    truth = c.truth
    if not told or not isinstance(truth, Additive):
        return c
    why = c.why_not_shown or _unseen(told)
    c = replace(c, why_not_shown=why, coverage_shown=not why)
    added = [(one, float(np.sqrt((one.sizes**2).mean()))) for one in told]
    added = [(one, u) for one, u in added if u > MATTERS * c.expanded]
    if not added:
        return c
    u = float(np.sqrt(c.u**2 + sum(u**2 for _, u in added)))
    rest = (c.u / u) ** 2 if np.isfinite(u) else 1.0
    lines = [replace(line, share=line.share * rest) for line in c.budget]
    lines += [_line(one, own, u) for one, own in added]
    largest_first = sorted(added, key=lambda one: -one[1])  # not as the file lists the features
    law = widen(truth.law, together([one.sizes for one, _ in largest_first]))
    return replace(
        c, u=u, budget=PlottedBudget(sorted(lines, key=lambda line: -line.u)), truth=replace(truth, law=law),
        interaction_share=c.interaction_share * rest,
    )  # fmt: skip


def _line(one: FormTold, u_i: float, u: float) -> BudgetLine:
    shape = f": {one.shape}, which its residuals leave possible" if one.shape else ""
    return BudgetLine(
        input=f"form[{one.feature}]", what=f"form of {one.feature} between the points{shape}", distribution="by the residuals",
        dof=float("inf"), redraw="part", estimate=None, u_input=None, unit="", sensitivity=None, u=u_i,
        share=(u_i / u) ** 2 if np.isfinite(u) and u > 0 else float("nan"), evidence=f"residuals of {one.points} points",
    )  # fmt: skip


def _unseen(told: Sequence[FormTold]) -> str:
    """Why nothing bounds the form; empty where the points do."""
    found = []
    for one in told:
        if one.unseen:
            more = f" and {len(one.unseen) - MOST_NAMED} more" if len(one.unseen) > MOST_NAMED else ""
            shapes = ", ".join(one.unseen[:MOST_NAMED])
            found.append(
                f"at the {one.points} points of {one.feature} {shapes}{more} of any size would not show"
            )
    return f"{UNSEEN}: {'; '.join(found)}; {CURE}" if found else ""
