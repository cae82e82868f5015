"""vcmm/physics/catalogue/gravity.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.run import Run
from vcmm.physics.catalogue.gravity import GravityFlexure


def _run(offset=(0.0, 0.0, 0.0), **columns: float) -> Run:
    position = {"X": np.array([500.0]), "Y": np.array([100.0]), "Z": np.array([-400.0])}
    return Run(position, np.array([offset]), {k: np.array([v]) for k, v in columns.items()})


def test_gravity_flexure_lowers_a_level_tool():
    # level tool of 200 mm along x, down = -z: x x (-z) = +y, so 30 urad about +y; the tip sinks by 30e-6 x 200 = 6 um
    effect, down = GravityFlexure(30e-6), {"down_x": 0.0, "down_y": 0.0, "down_z": -1.0}
    motion = effect.error_motion(_run((200.0, 0.0, 0.0), **down))
    assert motion[0] == pytest.approx([0.0, 0.0, -6e-3, 0.0, 30e-6, 0.0], abs=1e-15)
    # upright it stands; at 30 deg from the vertical half of it: (100, 0, -173.2) hangs, and swings towards the plumb line
    assert effect.error_motion(_run((0.0, 0.0, 200.0), **down))[0] == pytest.approx(np.zeros(6), abs=1e-15)
    half = effect.error_motion(_run((100.0, 0.0, -100.0 * np.sqrt(3.0)), **down))[0]
    assert half[4] == pytest.approx(15e-6, abs=1e-15)
    assert half[0] < 0.0
