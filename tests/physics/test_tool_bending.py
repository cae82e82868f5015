"""vcmm/physics/structure/tool_bending.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.structure.tool_bending import ToolDeflection, bending


def _run(**columns: float) -> Run:
    named = {"nx": 0.0, "ny": 0.6, "nz": 0.8} | columns
    return Run(
        {a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()}
    )


def test_tool_deflection_follows_the_force():
    # 0.1 um/N x (200, -50, 0) N = (20, -5, 0) um
    run = _run(force_x_N=200.0, force_y_N=-50.0, force_z_N=0.0)
    assert machine(ToolDeflection(1e-4)).tip_error(run)[0] == pytest.approx([20e-3, -5e-3, 0], abs=1e-15)


def test_a_rod_bends_across_its_axis_alone():
    # 0.1 um/N x (200, -50, 400) N = (20, -5, 40) um; along z a rod is stiff
    run = _run(force_x_N=200.0, force_y_N=-50.0, force_z_N=400.0)
    assert machine(ToolDeflection(1e-4)).tip_error(run)[0] == pytest.approx([20e-3, -5e-3, 40e-3], abs=1e-15)
    rod = machine(ToolDeflection(1e-4, rod=1))
    assert rod.tip_error(run)[0] == pytest.approx([20e-3, -5e-3, 0], abs=1e-15)


def test_bending_of_a_rod_by_hand() -> None:
    """D 10, L 40, 100 N: I = pi 8^4 / 64 = 201.06 mm4; 100 x 64000 / (3 x 580000 x 201.06) = 18.29 um."""
    assert 100 * bending(5.0, 40.0) == pytest.approx(0.01829, abs=1e-5)
