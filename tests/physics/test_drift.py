"""vcmm/physics/catalogue/drift.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import UsageError
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.drift import LinearDrift, SettlingDrift, StepChange
from vcmm.physics.catalogue.heating import ScrewHeating
from vcmm.physics.catalogue.workpiece import WorkpieceHeating
from vcmm.physics.structure.spindle_growth import SpindleGrowth
from vcmm.physics.structure.thermal import ThermalDriftTwoLags


def _run(time: list[float], x: float = 0.0, log: Series | None = None, **columns: float) -> Run:
    n = len(time)
    more = {k: np.full(n, v) for k, v in columns.items()}
    position = {"X": np.full(n, x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(
        position, np.zeros((n, 3)), {"time_s": np.array(time), **more}, {}, {"air": log} if log else {}
    )


def test_linear_drift():
    # 2 um/h = 2e-3 / 3600 mm/s; after 1800 s +1 um in y
    error = machine(LinearDrift("y", 2e-3 / 3600)).tip_error(_run([0.0, 1800.0]))
    assert error == pytest.approx(np.array([[0, 0, 0], [0, 1e-3, 0]]), abs=1e-15)


def test_a_drift_that_settles_begins_like_a_linear_one_and_ends():
    # 36 um/h = 1e-5 mm/s with 600 s: after 600 s 6 um x (1 - 1/e) = 3.792723 um, at last 6 um; at first 1e-5 t
    error = machine(SettlingDrift("y", 1e-5, 600.0)).tip_error(_run([0.0, 0.6, 600.0, 60000.0]))
    assert error[:, 1] == pytest.approx([0.0, 5.997e-6, 3.792723e-3, 6e-3], abs=1e-9)
    assert SettlingDrift.diagnosis.family == "linear_drift"
    with pytest.raises(UsageError, match="must be above zero"):
        SettlingDrift("y", 1e-5, 0.0)


def test_step_change_comes_after_its_time():
    error = machine(StepChange("z", 3e-3, 100.0)).tip_error(_run([99.0, 100.0, 101.0]))
    assert error[:, 2] == pytest.approx([0.0, 0.0, 3e-3], abs=1e-18)


def test_words_are_checked():
    with pytest.raises(UsageError, match='must be "x", "y" or "z"'):
        LinearDrift("Z")
    with pytest.raises(UsageError, match="tau is negative"):
        ThermalDriftTwoLags("z", "air", tau_slow=-1.0)
    with pytest.raises(UsageError, match="tau positive"):
        SpindleGrowth("Z", tau=0.0)
    with pytest.raises(UsageError, match="distance must be positive"):
        ScrewHeating("X", distance=0.0)
    with pytest.raises(UsageError, match="is negative"):
        WorkpieceHeating(tau=-1.0)
