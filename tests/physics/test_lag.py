"""vcmm/physics/catalogue/lag.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.lag import ReadoutDelay, ServoLag


def _run(x: list[float], offset=(0.0, 0.0, 0.0), **columns: list[float]) -> Run:
    n = len(x)
    position = {"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(position, np.tile(offset, (n, 1)), {k: np.array(v) for k, v in columns.items()})


def test_servo_lag_stays_behind():
    # 0.1 ms more than nominal at +50 mm/s: -5 um; the same for an axis that carries the workpiece
    run = _run([0.0, 0.0], speed_X_mm_s=[50.0, -20.0])
    assert machine(ServoLag("X", 1e-4)).tip_error(run)[:, 0] == pytest.approx([-5e-3, 2e-3], abs=1e-15)
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    table = Machine("m", "machine-tool", parse_structure("w X' b Y Z t"), axes, (ServoLag("X", 1e-4),))
    assert table.tip_error(run)[:, 0] == pytest.approx([-5e-3, 2e-3], abs=1e-15)


def test_unequal_lags_make_an_oval_at_45_degrees():
    # circle of R at speed v, CCW: velocity v (-sin, cos); lag of X alone: radial error = +v lag sin cos:
    # at 45 degrees 50 x 1e-4 x 0.5 = +2.5 um, at 135 degrees -2.5 um; running CW it turns over
    angle = np.radians([45.0, 135.0])
    for way in (1.0, -1.0):
        columns = {"speed_X_mm_s": -way * 50.0 * np.sin(angle)}
        six = ServoLag("X", 1e-4).error_motion(_run([0.0, 0.0], **columns))
        assert six[:, 0] * np.cos(angle) == pytest.approx([way * 2.5e-3, -way * 2.5e-3], abs=1e-15)


def test_readout_delay_runs_ahead_when_measuring():
    # 1 ms at (5, 0, -2) mm/s: tip error (-5, 0, +2) um, so indicated - true = (+5, 0, -2) um
    run = _run([0.0], speed_X_mm_s=[5.0], speed_Y_mm_s=[0.0], speed_Z_mm_s=[-2.0])
    late = machine(ReadoutDelay(1e-3))
    assert late.tip_error(run)[0] == pytest.approx([-5e-3, 0.0, 2e-3], abs=1e-15)
    assert late.indication_error(run)[0] == pytest.approx([5e-3, 0.0, -2e-3], abs=1e-15)
