"""vcmm/physics/structure/rotary.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.structure.rotary import RotaryCyclic


def test_rotary_cyclic_is_the_motion_of_the_axis_itself():
    # EXC: 2 um sin q at 30 deg: 1 um; second harmonic 3 um cos 2q at 60 deg: 3 x cos 120 = -1.5 um (sin 60 = 0.866025)
    run = Run({"X": np.zeros(2), "C": np.radians([30.0, 60.0])}, np.zeros((2, 3)))
    effect = RotaryCyclic("EXC", np.array([0.0, 2e-3, 3e-3, 0.0]))
    assert effect.error_motion(run)[:, 0] == pytest.approx([1e-3 + 1.5e-3, 1.732051e-3 - 1.5e-3], abs=1e-9)
    axes = {"X": Axis("X", (-1.0, 1.0)), "C": Axis("C", (-4.0, 4.0))}
    for structure, sign in (("w b X C t", 1.0), ("w C' b X t", -1.0)):
        still = Run({"X": np.zeros(1), "C": np.zeros(1)}, np.zeros((1, 3)))
        moved = Machine(
            "m", "cmm", parse_structure(structure), axes, (RotaryCyclic("EXC", np.array([2e-3])),)
        )
        assert moved.tip_error(still)[0] == pytest.approx([sign * 2e-3, 0, 0], abs=1e-15)
    # ECC turns: 5 urad at the angle zero, 100 mm out in x: +0.5 um in y
    out = Run({"X": np.zeros(1), "C": np.zeros(1)}, np.array([[100.0, 0.0, 0.0]]))
    turning = Machine(
        "m", "cmm", parse_structure("w b X C t"), axes, (RotaryCyclic("ECC", np.array([5e-6])),)
    )
    assert turning.tip_error(out)[0] == pytest.approx([0, 0.5e-3, 0], abs=1e-15)
