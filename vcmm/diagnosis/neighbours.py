"""Do neighbours agree in what the names leave? Then it is no scatter, whatever shape it has. Two questions:

shape   over the axis and in the component of a named term: few kernels, so little is overlooked. A name that fits the
        coarse part of something else leaves the fine part there.
rest    over everything that the recording knows.

The largest z of all kernels is compared with the largest of every null recording. Errors of templates are forgiven as in
the selection: what they leave may lie wholly in the strongest direction of a kernel.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vcmm.diagnosis.evidence import orthonormal
from vcmm.diagnosis.kernels import (
    Asked,
    Kernel,
    components_of,
    departed,
    everywhere,
    of_components,
    principal,
    questions,
    reach,
)
from vcmm.diagnosis.null import FALSE_ALARM, upper_quantile
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.result import Unknown
from vcmm.diagnosis.select import Selection, mismatch
from vcmm.gaussian import Whitener, best_width, without_span
from vcmm.run import Array

NOTHING_NAMED = (
    FALSE_ALARM / 3
)  # a null recording has paid 1 % to the catalogue and 1 % to the shapes already
BEYOND = 10  # null recordings beyond the threshold, where there are so many
WORTH_KEEPING = 2.0  # standard deviations; the largest of so many kernels always exceeds it
FUNCTIONS = 20  # in which the size of a departure is estimated


def departure(problem: Problem, selection: Selection, white: Whitener, null: Array) -> Unknown | None:
    """The clearest departure from white, None where chance explains it. null (m, M): prepared null recordings, white."""
    basis = orthonormal(np.concatenate([null[:, :0], *(t.white for t in selection.terms)], axis=1))
    alarm = FALSE_ALARM if selection.terms else NOTHING_NAMED
    rows = without_span(np.column_stack([selection.rest, null[:, : round(BEYOND / alarm)]]), basis)
    rows = rows / np.linalg.norm(rows, axis=0)
    forgiven = 2.0 * mismatch(selection) / max(float(selection.rest @ selection.rest), 1e-300)
    shapes = of_components(problem, components_of(selection.terms), white, basis)
    kernel = _clearest(questions(shapes, rows), forgiven, alarm)
    kernel = kernel or _clearest(questions(everywhere(problem, white, basis), rows), forgiven, alarm)
    return None if kernel is None else _described(kernel, selection, white)


def _clearest(all_asked: Iterable[Asked], forgiven: float, alarm: float) -> Kernel | None:
    """The kernel of the largest departure, where it exceeds what a share `alarm` of the null recordings reaches."""
    kept: list[Asked] = []
    largest: Array | None = None
    for asked in all_asked:
        largest = asked.z[1:] if largest is None else np.maximum(largest, asked.z[1:])
        if asked.z[0] > WORTH_KEEPING:
            kept.append(asked)
    if largest is None:
        return None
    limit = upper_quantile(largest, alarm)
    for asked in sorted(kept, key=lambda a: -float(a.z[0])):
        if asked.z[0] > limit and departed(asked.t, reach(asked.white) * forgiven)[0] > limit:
            return asked.clearest
    return None


def _described(kernel: Kernel, selection: Selection, white: Whitener) -> Unknown:
    columns = principal(kernel.white, FUNCTIONS)
    fit = best_width(columns, selection.rest, white.dof)
    rms = float(np.sqrt(np.mean((columns @ fit.mean / white.weight) ** 2)))
    over = " and ".join(kernel.names)
    if kernel.component:
        text = f"what is left of {kernel.component} still depends on {over}: its error has another shape than what was named"
    else:
        along = "along the normal" if kernel.direction == "normal" else f"in {kernel.direction}"
        text = f"a dependence on {over} {along} that no effect of the catalogue explains; neighbours agree in what is left"
    return Unknown(kernel.names[:3], text, rms, kernel.direction, len(kernel.names) > 1)
