"""Weighing names against physics without a name: does a smooth field explain more than some of them?

A name with many free numbers, or two names on top of each other, follow much that they are not: a scale glued from pieces is
nearly a changed guide and nearly a table's gaps. The unknown deserves the same freedom. Its law is a Gaussian process (see
kernels) over a covariate that the residual follows, with or without the other names; its evidence is the mean over its
smoothness and size, and it pays UNNAMED nats, since the catalogue holds what machines usually have.

    lead = evidence(field and S) - evidence(all names) - UNNAMED - mismatch
    p(names not in S) = 1 / (1 + exp(lead))

S: the names that pay for themselves beside the field, each the threshold of the null and its prior. They stand. Where all do,
the field is no rival: it is what is left.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.diagnosis.evidence import orthonormal
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
from vcmm.diagnosis.select import Selection, Term, mismatch
from vcmm.diagnosis.shape_proposal import proposal
from vcmm.evaluation.gaussian import Ints, Whitener, evidence_from, posterior

UNNAMED = 5.0  # nats
TRIED = 8  # kernels that the residual follows most
SHORT = 4  # fields that are weighed with every subset of the names
NULLS = 200
COUNTS = (10, 20, 40, 80)  # principal functions: the fewer, the smoother
WIDTHS = (0.125, 0.5, 2.0, 8.0)  # of the first function, in units of the noise
SUREST = 14.0  # nats: no template is known so well that more would mean anything

Subset = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Field:
    """A field instead of the terms with the numbers `refused`. lead: nats beyond theirs and the price."""

    lead: float
    unknown: Unknown
    refused: Subset

    @property
    def wins(self) -> bool:
        """Is it more probable than the names that it refuses?"""
        return self.lead > 0

    @property
    def share(self) -> float:
        """Probability that is left to them."""
        return float(1.0 / (1.0 + np.exp(min(self.lead, SUREST))))


def rival_field(
    problem: Problem, selection: Selection, white: Whitener, null: Array, threshold: float
) -> Field | None:
    """The best field that makes names superfluous; None where there is none. null (m, M): white null recordings;
    threshold: nats that a name must pay.
    """
    if selection.fit is None:
        return None
    every = tuple(range(len(selection.terms)))
    pays = [threshold - t.family.log_prior - t.option.log_prior for t in selection.terms]
    price = selection.fit.log_evidence + UNNAMED + mismatch(selection)
    weighing = [
        _Weighing.of(asked, x, selection, white) for asked, x in _tried(problem, selection, white, null)
    ]
    weighing = heapq.nlargest(
        SHORT, weighing, key=lambda w: max(w.evidence(()), *(w.evidence(_without(every, i)) for i in every))
    )
    if not weighing:
        return None

    def worth(choice: tuple[_Weighing, Subset]) -> float:
        w, kept = choice
        return w.evidence(kept) - sum(pays[i] for i in kept)

    w, kept = max(itertools.product(weighing, _subsets(every)), key=worth)
    if kept == every:
        return None
    lead = w.evidence(kept) - price
    what = proposal(w.asked.clearest, problem, w.rms(white), "explains more than {}, which add little to it")
    return Field(lead, what, tuple(i for i in every if i not in kept))


def _subsets(every: Subset) -> Iterator[Subset]:
    return itertools.chain.from_iterable(itertools.combinations(every, k) for k in range(len(every) + 1))


def _without(every: Subset, i: int) -> Subset:
    return tuple(j for j in every if j != i)


@dataclass(frozen=True, eq=False)
class _Weighing:
    """One field beside the names. gram, b, total: products of all white columns, the names' first, and the residual."""

    asked: Asked
    functions: Array
    y: Array
    gram: Array
    b: Array
    dof: int
    spans: tuple[Ints, ...]
    widths: tuple[Array, ...]

    @staticmethod
    def of(asked: Asked, x: Array, selection: Selection, white: Whitener) -> _Weighing:
        functions = principal(x, COUNTS[-1])
        whole = np.concatenate([*(t.white for t in selection.terms), functions], axis=1)
        spans = tuple(np.arange(whole.shape[1])[selection.span(i)] for i in range(len(selection.terms)))
        widths = tuple(np.full(t.white.shape[1], t.width) for t in selection.terms)
        gram, b = whole.T @ whole, whole.T @ selection.y
        return _Weighing(asked, functions, selection.y, gram, b, white.dof, spans, widths)

    def evidence(self, kept: Subset) -> float:
        """Nats of the field and some of the names, the mean over the smoothness and size of the field."""
        names = [self.spans[i] for i in kept]
        first = len(self.b) - self.functions.shape[1]
        total = float(self.y @ self.y)
        out = []
        for count, width in itertools.product(COUNTS, WIDTHS):
            field = np.arange(first, min(first + count, len(self.b)))
            at = np.concatenate([*names, field])
            widths = np.concatenate([*(self.widths[i] for i in kept), np.full(len(field), width)])
            out.append(evidence_from(self.gram[np.ix_(at, at)], self.b[at], total, self.dof, widths))
        return float(np.logaddexp.reduce(out) - np.log(len(out)))

    def rms(self, white: Whitener) -> float:
        """Size of the field alone, mm or rad."""
        fits = [
            posterior(self.functions, self.y, self.dof, np.full(self.functions.shape[1], w)) for w in WIDTHS
        ]
        signal = self.functions @ max(fits, key=lambda f: f.log_evidence).mean
        return float(np.sqrt(np.mean((signal / white.weight) ** 2)))


def _tried(problem: Problem, selection: Selection, white: Whitener, null: Array) -> list[tuple[Asked, Array]]:
    """What the residual follows most clearly, nothing named or all names but one, with its white columns."""
    others = [[t for t in selection.terms if t is not one] for one in selection.terms]
    given = [[], *(o for o in others if o)]  # all but one of one is none
    free = pulled(white, null[:, :0], np.column_stack([selection.y, null[:, :1]]))
    found: list[Asked] = []
    for terms in given:
        basis = orthonormal(np.concatenate([null[:, :0], *(t.white for t in terms)], axis=1))
        rows = pulled(white, basis, np.column_stack([selection.y, null[:, :NULLS]]))
        groups = itertools.chain(of_components(problem, components_of(selection.terms)), everywhere(problem))
        found += heapq.nlargest(TRIED, questions(groups, rows), key=lambda a: float(a.z[0]))
    columns = [(asked, free.columns(asked.kernels)) for asked in found]
    return [(asked, x) for asked, x in columns if x.shape[1]]


def kept_terms(selection: Selection, field: Field) -> list[Term]:
    """The terms that stand beside the field."""
    return [t for i, t in enumerate(selection.terms) if i not in field.refused]


def weighed(answers: Sequence[Answer], field: Field | None) -> tuple[Answer, ...]:
    """The answers, in the order of the terms, with the probability that the field leaves them."""
    if field is None:
        return tuple(answers)
    return tuple(_less(a, field.share) if i in field.refused else a for i, a in enumerate(answers))


def _less(a: Answer, share: float) -> Answer:
    return replace(
        a, probability=a.probability * share, rival_probability=a.rival_probability * share,
        alias_probability=a.alias_probability * share,
    )  # fmt: skip
