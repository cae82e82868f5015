"""Do neighbours agree in what the names leave? Then it is no scatter, whatever shape it has. Two questions:

shape   over the axis and in the component of a named term: few kernels, so little is overlooked. A name that fits the
        coarse part of something else leaves the fine part there.
rest    over everything that the recording knows.

The largest z of all kernels is compared with the largest of every null recording. Errors of templates are forgiven as in
the selection: what they leave may lie wholly in the strongest direction of a kernel.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, best_width
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import FALSE_ALARM, NOTHING
from vcmm.learn.diagnosis.evidence import orthonormal
from vcmm.learn.diagnosis.kernels import (
    Kernel,
    KernelQuestion,
    PulledResiduals,
    components_of,
    everywhere,
    normal_scores,
    of_components,
    principal,
    pull_back,
    questions,
    reach,
)
from vcmm.learn.diagnosis.null import upper_quantile
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.select import Selection, mismatch
from vcmm.learn.diagnosis.shape_proposal import proposal

NOTHING_NAMED = (
    FALSE_ALARM / 3
)  # a null recording has paid 1 % to the catalogue and 1 % to the shapes already
BEYOND = 10  # null recordings beyond the threshold, where there are so many
MOST_QUESTIONS = 20  # of the clearest questions: where templates explain them all, there is none to ask
FUNCTIONS = 20  # in which the size of a departure is estimated


def departure(problem: Problem, selection: Selection, white: Whitener, null: Array) -> Unknown | None:
    """The clearest departure from white, None where chance explains it. null (m, M): prepared null recordings, white."""
    basis = orthonormal(np.concatenate([null[:, :0], *(t.white for t in selection.terms)], axis=1))
    alarm = FALSE_ALARM if selection.terms else NOTHING_NAMED
    rows = pull_back(white, basis, np.column_stack([selection.rest, null[:, : round(BEYOND / alarm)]]))
    forgiven = (
        2.0
        * mismatch(selection)
        * _variance(selection)
        / max(float(selection.rest @ selection.rest), NOTHING)
    )
    found = _clearest(of_components(problem, components_of(selection.terms)), rows, forgiven, alarm)
    found = found or _clearest(everywhere(problem), rows, forgiven, alarm)
    return None if found is None else _measure_departure(found[0], problem, found[1], selection, white)


def _variance(selection: Selection) -> float:
    """Of the noise found, in units of the one stated: `mismatch` counts in the former, residuals in the latter."""
    return selection.fit.sigma**2 if selection.fit else 1.0


def _clearest(
    groups: Iterable[list[Kernel]], rows: PulledResiduals, forgiven: float, alarm: float
) -> tuple[Kernel, Array] | None:
    """The kernel of the largest departure and its white columns, where it exceeds what a share `alarm` of the null
    recordings reaches.
    """
    largest = np.full(rows.rows.shape[1] - 1, -np.inf)
    clearest = heapq.nlargest(
        MOST_QUESTIONS, _track_largest(questions(groups, rows), largest), key=lambda a: float(a.z[0])
    )
    limit = upper_quantile(largest, alarm)
    for asked in (a for a in clearest if a.z[0] > limit):
        x = rows.columns(asked.kernels)
        if x.shape[1] and normal_scores(asked.t, _of_templates(x, rows, forgiven))[0] > limit:
            return asked.clearest, rows.columns([asked.clearest])
    return None


def _track_largest(asked: Iterable[KernelQuestion], largest: Array) -> Iterator[KernelQuestion]:
    """The same, while `largest` (M,) takes the largest z of every null recording."""
    for one in asked:
        np.maximum(largest, one.z[1:], out=largest)
        yield one


def _of_templates(x: Array, rows: PulledResiduals, forgiven: float) -> float:
    """Share of t that errors of templates of energy `forgiven` (over that of the residual) may bring, at their worst."""
    return reach(x) * forgiven / max(float(np.sum((x.T @ rows.residual) ** 2)), NOTHING)


def _measure_departure(
    kernel: Kernel, problem: Problem, columns: Array, selection: Selection, white: Whitener
) -> Unknown:
    """The departure with its size, from the principal functions of the kernel."""
    functions = principal(columns, FUNCTIONS)
    fit = best_width(functions, selection.rest, white.dof)
    rms = float(np.sqrt(np.mean((functions @ fit.mean / white.weight) ** 2)))
    return proposal(kernel, problem, rms, "is left that no name explains: neighbours agree")
