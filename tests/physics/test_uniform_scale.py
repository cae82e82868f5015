"""vcmm/physics/catalogue/uniform_scale.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics.ask import ask
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.uniform_scale import UniformScale


def one_row(position=(0.0, 0.0, 0.0), **columns: float) -> Run:
    named = {k: np.array([v]) for k, v in columns.items()}
    return Run({a: np.array([q]) for a, q in zip("XYZ", position)}, np.zeros((1, 3)), named)


def test_a_uniform_scale_moves_the_tip_from_the_origin():
    # 5 um/m of (400, 200, -100) mm: 2, 1 and -0.5 um; the same on a machine whose table moves
    run = one_row((400.0, 200.0, -100.0))
    for structure in ("w b Y X Z t", "w X' Y' b Z t"):
        axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
        machine = Machine("m", "cmm", parse_structure(structure), axes, (UniformScale(5e-6),))
        assert machine.tip_error(run)[0] == pytest.approx([2e-3, 1e-3, -0.5e-3], abs=1e-15)


def test_a_uniform_scale_is_for_recordings_without_a_thermometer():
    run = Run({"X": np.array([0.0, 100.0]), "Y": np.array([0.0, 100.0])}, np.zeros((2, 3)))
    assert ask(UniformScale(), "shows_in", run)
    assert not ask(UniformScale(), "shows_in", run.with_columns({"temp_part_C": np.array([20.0, 21.0])}))
    assert not ask(
        UniformScale(), "shows_in", Run({"X": np.array([0.0, 100.0]), "Y": np.zeros(2)}, np.zeros((2, 3)))
    )
