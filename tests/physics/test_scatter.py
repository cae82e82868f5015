"""Scatter along the normal, re-indexing of the head."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.structure.scatter import Reindexing, Scatter


def test_scatter_is_a_reading_along_n():
    # 0.7 um along n = (0.6, 0, -0.8): (0.42, 0, -0.56) um
    run = Run({}, np.zeros((1, 3)), {"nx": np.array([0.6]), "ny": np.zeros(1), "nz": np.array([-0.8])})
    assert Scatter(0.7e-3).error_motion(run)[0, :3] == pytest.approx([0.42e-3, 0.0, -0.56e-3], abs=1e-18)


def test_reindexing_moves_the_tip():
    # the tip stands (1, -2, 0.5) um off after indexing: the indication is off by the opposite
    run = Run({a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)))
    moved = machine(Reindexing(np.array([1e-3, -2e-3, 0.5e-3])))
    assert moved.tip_error(run)[0] == pytest.approx([1e-3, -2e-3, 0.5e-3], abs=1e-18)
    assert moved.indication_error(run)[0] == pytest.approx([-1e-3, 2e-3, -0.5e-3], abs=1e-18)
