"""Measured points with the known errors taken off."""

from __future__ import annotations

import numpy as np
import pytest

from tests.compensation.mill import mill
from vcmm.compensation.points import corrected_points
from vcmm.core.run import Run
from vcmm.physics.catalogue.scale import ScaleFactor


def test_corrected_points():
    # tip error +10 um at X 100: the tip is at 100.010 where the scale says 100 (indicated - true = -10 um)
    run = Run({"X": np.array([100.0]), "Y": np.zeros(1), "Z": np.zeros(1)}, np.zeros((1, 3)))
    found = corrected_points(mill(ScaleFactor("X", 100e-6)), run)
    assert found.error[0] == pytest.approx([-0.010, 0, 0])
    assert found.corrected[0] == pytest.approx([100.010, 0, 0])
