"""vcmm/physics/catalogue/cutting.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import required
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.cutting import ToolRunout, ToolWear


def _run(**columns: float) -> Run:
    named = {"nx": 0.0, "ny": 0.6, "nz": 0.8} | columns
    return Run(
        {a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()}
    )


def test_tool_wear_leaves_material():
    # 0.2 um/m x 50 m = 10 um outward along n = (0, 0.6, 0.8)
    error = machine(ToolWear(2e-7)).tip_error(_run(cut_length_mm=5e4))[0]
    assert error == pytest.approx([0, 6e-3, 8e-3], abs=1e-15)


def test_tool_runout_takes_material():
    # 5 um larger radius: 5 um inward
    assert machine(ToolRunout(5e-3)).tip_error(_run())[0] == pytest.approx([0, -3e-3, -4e-3], abs=1e-15)
    # once per turn, 4 um cosine and 2 um sine at 60 deg: 4 x 0.5 + 2 x 0.866025 = 3.732051 um inward
    once = ToolRunout(4e-3, 2e-3, 1)
    assert required(once)[-1] == "spindle_angle_rad"
    error = once.error_motion(_run(spindle_angle_rad=np.pi / 3))[0, 2]
    assert error == pytest.approx(-0.8 * 3.732051e-3, abs=1e-9)
    with pytest.raises(UsageError, match="harmonic must be 0"):
        ToolRunout(harmonic=-1)


def test_runout_shows_as_far_as_the_normal_lies_across_the_axis():
    """5 um of radius, 0.6 of n across the tool's axis: 5 x 0.6 = 3 um inward along n = (0, 0.6, 0.8), and nothing on a floor (0)."""
    error = machine(ToolRunout(5e-3)).tip_error(_run(across_tool=0.6))[0]
    assert error == pytest.approx([0, -1.8e-3, -2.4e-3], abs=1e-15)
    assert machine(ToolRunout(5e-3)).tip_error(_run(across_tool=0.0))[0].tolist() == [0, 0, 0]
