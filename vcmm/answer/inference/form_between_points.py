"""Add the form between the points to a result: a wider law of the true value, a line in the budget, and no claim where some
form of any size would not show at the points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.result import BudgetLine, CharacteristicResult, PlottedBudget
from vcmm.answer.evaluation.truth import Additive
from vcmm.answer.evaluation.widened_law import sum_with_random_signs, widen
from vcmm.answer.inference.between_points import FormTold

MATTERS = 1e-3  # of U: less is no line
UNSEEN = "what lies between the points has no bound"
MOST_NAMED = 3  # forms that a reason names
CURE = 'touch more points, all over the feature, or state what is known of its form (form = { amplitude = "1 um" })'


def is_moved_by_form(c: CharacteristicResult) -> bool:
    """Return whether form moves it as an error does: sizes, distances and angles of least-squares elements."""
    return isinstance(c.truth, Additive) and not c.extreme


def with_form(c: CharacteristicResult, statements: Sequence[FormTold]) -> CharacteristicResult:
    """Return the result, for any indicated value, with the forms of its features."""
    truth = c.truth
    if not statements or not isinstance(truth, Additive):
        return c
    why = c.why_not_shown or _unseen(statements)
    c = replace(c, why_not_shown=why, coverage_shown=not why)
    added = [(form, float(np.sqrt((form.sizes**2).mean()))) for form in statements]
    added = [(form, u) for form, u in added if u > MATTERS * c.expanded]
    if not added:
        return c
    u = float(np.sqrt(c.u**2 + sum(u**2 for _, u in added)))
    rest = (c.u / u) ** 2 if np.isfinite(u) else 1.0
    lines = [replace(line, share=line.share * rest) for line in c.budget]
    lines += [_line(form, own_u, u) for form, own_u in added]
    largest_first = sorted(added, key=lambda form_and_u: -form_and_u[1])  # not as the file lists the features
    law = widen(truth.law, sum_with_random_signs([form.sizes for form, _ in largest_first]))
    return replace(
        c, u=u, budget=PlottedBudget(sorted(lines, key=lambda line: -line.u)), truth=replace(truth, law=law),
        interaction_share=c.interaction_share * rest,
    )  # fmt: skip


def _line(form: FormTold, u_i: float, u: float) -> BudgetLine:
    shape = f": {form.shape}, which its residuals leave possible" if form.shape else ""
    return BudgetLine(
        input=f"form[{form.feature}]", what=f"form of {form.feature} between the points{shape}", distribution="by the residuals",
        dof=float("inf"), redraw="part", estimate=None, u_input=None, unit="", sensitivity=None, u=u_i,
        share=(u_i / u) ** 2 if np.isfinite(u) and u > 0 else float("nan"), evidence=f"residuals of {form.points} points",
    )  # fmt: skip


def _unseen(statements: Sequence[FormTold]) -> str:
    """Return why the form is not bounded; empty where the points bound it."""
    remarks = []
    for form in statements:
        if form.unseen:
            more = f" and {len(form.unseen) - MOST_NAMED} more" if len(form.unseen) > MOST_NAMED else ""
            shapes = ", ".join(form.unseen[:MOST_NAMED])
            remarks.append(
                f"at the {form.points} points of {form.feature} {shapes}{more} of any size would not show"
            )
    return f"{UNSEEN}: {'; '.join(remarks)}; {CURE}" if remarks else ""
