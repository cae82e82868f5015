"""A kernel of free shapes as a proposal in words: where, in which direction, and whether its shape can be drawn."""

from __future__ import annotations

from vcmm.learn.diagnosis.kernels import Kernel
from vcmm.learn.diagnosis.locate import modulators
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Unknown


def proposal(kernel: Kernel, problem: Problem, rms: float, says: str) -> Unknown:
    """The unknown over the covariates of a kernel; `says` with {} for the names.

    A translation of a component is drawn in its own direction; what a rotation does depends on the arm, so that no curve
    over the axis can show it.
    """
    over = " and ".join(kernel.names)
    own = kernel.component[1:2].lower()
    direction = own if own in modulators(problem) else kernel.direction
    if kernel.what:
        what = kernel.what
    elif kernel.component:
        what = f"a shape of {kernel.component} over {over}"
    else:
        along = "along the normal" if direction == "normal" else f"in {direction}"
        what = f"a dependence on {over} {along} without a name"
    drawn = kernel.component[1:2] not in tuple("ABC") and not kernel.what
    text = f"{what} {says.format('the names' if kernel.component == '' else 'its names')}"
    return Unknown(kernel.names[:3], text, rms, direction, len(kernel.names) > 1, drawn=drawn)
