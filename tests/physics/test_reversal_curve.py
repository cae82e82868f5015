"""vcmm/physics/catalogue/reversal_curve.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.reversal_curve import LostMotionCurve


def _run(x: list[float], offset=(0.0, 0.0, 0.0), **columns: list[float]) -> Run:
    n = len(x)
    position = {"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(position, np.tile(offset, (n, 1)), {k: np.array(v) for k, v in columns.items()})


def test_lost_motion_may_change_sign_along_the_travel():
    # nodes 0 and 200 mm: s = (2 q - 200) / 200 = -1, 0, 1 at 0, 100, 200 mm. P2 = (3 s^2 - 1) / 2 = 1, -0.5, 1.
    # gap = 1 um + 10 um/m q + 8 um P2 = 9, 1 + 1 - 4 = -2, 1 + 2 + 8 = 11 um; moving up the error is -gap / 2
    effect = LostMotionCurve("X", np.array([0.0, 200.0]), 1e-3, 10e-6, np.array([8e-3]))
    assert effect.gap(np.array([0.0, 100.0, 200.0])) == pytest.approx([9e-3, -2e-3, 11e-3], abs=1e-15)
    error = machine(effect).tip_error(_run([0.0, 100.0, 200.0], sense_X=[1.0] * 3))
    assert error[:, 0] == pytest.approx([-4.5e-3, 1e-3, -5.5e-3], abs=1e-15)
