"""Stylus qualification: offset and radius of one stylus, together."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.run import Run
from vcmm.physics.structure.qualification import StylusQualification


def test_offset_and_radius_add():
    # d = (1, 2, 3, 0.5) um, n = (0, 0.6, 0.8): (1, 2 + 0.5 x 0.6, 3 + 0.5 x 0.8) = (1, 2.3, 3.4) um
    columns = {"nx": np.zeros(2), "ny": np.full(2, 0.6), "nz": np.full(2, 0.8)}
    run = Run({}, np.zeros((2, 3)), columns, {"stylus": np.array(["down", "side"])})
    reading = StylusQualification("down", np.array([1e-3, 2e-3, 3e-3, 0.5e-3])).error_motion(run)[:, :3]
    assert reading[0] == pytest.approx([1e-3, 2.3e-3, 3.4e-3], abs=1e-18)
    assert np.all(reading[1] == 0.0)  # another stylus
