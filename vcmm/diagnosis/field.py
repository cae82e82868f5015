"""Weighing names against physics without a name: does a smooth field explain more than they do, and need none of them?

A name with many free numbers, or two names on top of each other, follow much that they are not: a scale glued from pieces is
nearly a changed guide and nearly a table's gaps. The unknown deserves the same freedom. Its law is a Gaussian process (see
kernels) of any smoothness over the covariates that the residual follows most; its price is the evidence, as for every name,
and UNNAMED nats more, since the catalogue holds what machines usually have.

    p(names) = 1 / (1 + exp(evidence of the field - evidence of the names - UNNAMED - mismatch))

where the names do not pay for themselves beside the field: together they add less than the threshold of the null and their
prior for each. Where they do, both are there: names stand, and the field is what is left.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.diagnosis.kernels import (
    Asked,
    components_of,
    everywhere,
    of_components,
    principal,
    pulled,
    questions,
)
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.result import Answer, Unknown
from vcmm.diagnosis.select import Selection, mismatch
from vcmm.gaussian import Posterior, Whitener, posterior
from vcmm.run import Array

UNNAMED = 5.0  # nats
TRIED = 8  # kernels that the residual follows most
NULLS = 300
COUNTS = (10, 20, 40, 80)  # principal functions: the fewer, the smoother
WIDTHS = (0.125, 0.5, 2.0, 8.0)  # of the first function, in units of the noise


@dataclass(frozen=True, eq=False)
class Field:
    """A field without a name instead of the names. lead: nats beyond theirs and the price; unknown: what it looks like."""

    lead: float
    unknown: Unknown

    @property
    def wins(self) -> bool:
        """Is it more probable than the names?"""
        return self.lead > 0

    @property
    def share(self) -> float:
        """Probability that is left to the names."""
        return float(1.0 / (1.0 + np.exp(min(self.lead, 700.0))))


def rival_field(
    problem: Problem, selection: Selection, white: Whitener, null: Array, threshold: float
) -> Field | None:
    """The best field, where the names are nothing beside it; None where they hold. null (m, M): white null recordings;
    threshold: nats that a name must pay.
    """
    if selection.fit is None:
        return None
    fields = _tried(problem, selection, white, null)
    if not fields:
        return None
    best = max(fields, key=lambda f: f.fit.log_evidence)
    lead = best.fit.log_evidence - selection.fit.log_evidence - UNNAMED - mismatch(selection)
    price = sum(threshold - t.family.log_prior - t.option.log_prior for t in selection.terms)
    if _beside(best, selection, white.dof) > price:
        return None
    signal = best.columns @ best.fit.mean
    rms = float(np.sqrt(np.mean((signal / white.weight) ** 2)))
    return Field(lead, _described(best.asked, rms))


@dataclass(frozen=True, eq=False)
class _Fitted:
    asked: Asked
    columns: Array
    width: float
    fit: Posterior


def _tried(problem: Problem, selection: Selection, white: Whitener, null: Array) -> list[_Fitted]:
    """Fields over what the residual, nothing named, follows most clearly."""
    rows = pulled(white, null[:, :0], np.column_stack([selection.y, null[:, :NULLS]]))
    groups = itertools.chain(of_components(problem, components_of(selection.terms)), everywhere(problem))
    out: list[_Fitted] = []
    for asked in heapq.nlargest(TRIED, questions(groups, rows), key=lambda a: float(a.z[0])):
        x = rows.columns(asked.kernels)
        out += [_best(asked, x, selection.y, white.dof)] if x.shape[1] else []
    return out


def _best(asked: Asked, x: Array, y: Array, dof: int) -> _Fitted:
    """The field of highest evidence over its smoothness and size."""
    whole = principal(x, COUNTS[-1])
    tried = []
    for count, width in itertools.product(COUNTS, WIDTHS):
        columns = whole[:, :count]
        fit = posterior(columns, y, dof, np.full(columns.shape[1], width))
        tried.append(_Fitted(asked, columns, width, fit))
    return max(tried, key=lambda f: f.fit.log_evidence)


def _beside(field: _Fitted, selection: Selection, dof: int) -> float:
    """Nats that the names add to the field."""
    named = np.concatenate([t.white for t in selection.terms], axis=1)
    size = np.concatenate([np.full(t.white.shape[1], t.width) for t in selection.terms])
    x = np.concatenate([named, field.columns], axis=1)
    both = [
        posterior(x, selection.y, dof, np.r_[size, np.full(field.columns.shape[1], w)]).log_evidence
        for w in WIDTHS
    ]
    return max(both) - field.fit.log_evidence


def _described(asked: Asked, rms: float) -> Unknown:
    kernel = asked.clearest
    over = " and ".join(kernel.names)
    if kernel.component:
        what = f"an error of {kernel.component} over {over} of no shape in the catalogue"
    else:
        along = "along the normal" if kernel.direction == "normal" else f"in {kernel.direction}"
        what = f"a dependence on {over} {along} without a name"
    text = f"{what} explains more than the names, which add little to it"
    return Unknown(kernel.names[:3], text, rms, kernel.direction, len(kernel.names) > 1)


def weighed(answers: Sequence[Answer], field: Field | None) -> tuple[Answer, ...]:
    """The answers with the probability that the field leaves them."""
    if field is None:
        return tuple(answers)
    return tuple(
        replace(
            a, probability=a.probability * field.share, rival_probability=a.rival_probability * field.share
        )
        for a in answers
    )
