"""vcmm/physics/catalogue/clamping.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.clamping import Clamping


def _touch(normal, **columns: float) -> Run:
    named = dict(zip(("nx", "ny", "nz"), normal)) | columns
    return Run(
        {a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()}
    )


def test_clamping_by_hand():
    # p = (50, -100, .) mm over 100 mm: s = 0.5, t = -1: P2(s) = -0.125, s t = -0.5, P2(t) = 1:
    # 1 x (-0.125) + 2 x (-0.5) + 3 x 1 = 1.875 um in z
    run = _touch((0, 0, 1), part_x_mm=50.0, part_y_mm=-100.0, part_z_mm=7.0)
    bent = Clamping("z", np.array([1e-3, 2e-3, 3e-3]))
    assert machine(bent).indication_error(run)[0] == pytest.approx([0, 0, 1.875e-3], abs=1e-15)
    # third order in y over (z, x) = (0.07, 0.5): P2(s) t = (3 x 0.0049 - 1) / 2 x 0.5 = -0.246325
    third = Clamping("y", np.array([0, 0, 0, 0, 1e-3, 0, 0]))
    assert third.error_motion(run)[0, 1] == pytest.approx(-0.246325e-3, abs=1e-15)
    # rms over the square: sqrt(1/5 + 4/9 + 9/5) = 1.563472 um
    assert bent.rms == pytest.approx(1.563472e-3, abs=1e-9)
