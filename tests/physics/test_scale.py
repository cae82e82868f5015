"""Scale factor: too far in proportion to the position."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.scale import ScaleFactor


def test_5_um_per_m_at_400_mm():
    # 5e-6 x 400 mm = 0.002 mm too far in +Y; at -100 mm: -0.0005 mm
    run = Run({"X": np.zeros(2), "Y": np.array([400.0, -100.0]), "Z": np.zeros(2)}, np.zeros((2, 3)))
    error = machine(ScaleFactor("Y", 5e-6)).tip_error(run)
    assert error == pytest.approx(np.array([[0.0, 0.002, 0.0], [0.0, -0.0005, 0.0]]), abs=1e-15)
    # a machine that travels too far indicates too little
    assert machine(ScaleFactor("Y", 5e-6)).indication_error(run)[0, 1] == pytest.approx(-0.002, abs=1e-15)
