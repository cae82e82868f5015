"""Correct measured points by the known errors of the machine: corrected = indicated - (indicated - true)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class CorrectedPoints:
    """indicated, error = indicated - true, corrected: (n, 3) mm, workpiece axes; tip positions (axes and offset)."""

    indicated: Array
    error: Array
    corrected: Array


def corrected_points(machine: Machine, run: Run, exact: bool = False) -> CorrectedPoints:
    """Correct the points of a run. Errors are tabulated over what the scales say, so no iteration is needed."""
    prepared = machine.prepare(run)
    error = machine.indication_error(prepared, exact)
    indicated = np.asarray(nominal_tip(machine.chain, machine.axes, run))
    return CorrectedPoints(indicated, error, indicated - error)
