"""vcmm/physics/catalogue/drift_vector.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import UsageError
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.drift_vector import DriftVector, StepVector, ThermalVector


def _run(time: list[float], x: float = 0.0, log: Series | None = None, **columns: float) -> Run:
    n = len(time)
    more = {k: np.full(n, v) for k, v in columns.items()}
    position = {"X": np.full(n, x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(
        position, np.zeros((n, 3)), {"time_s": np.array(time), **more}, {}, {"air": log} if log else {}
    )


def test_what_moves_several_directions_at_once_is_the_sum_of_its_directions():
    times = [99.0, 100.0, 3600.0]
    step = machine(StepVector("xz", np.array([2e-3, -1e-3]), 100.0)).tip_error(_run(times))
    assert step == pytest.approx(np.array([[0, 0, 0], [0, 0, 0], [2e-3, 0, -1e-3]]), abs=1e-18)
    # 2 um/h = 2e-3 / 3600 mm/s: after an hour 2 um in x, 4 um in y, -6 um in z
    drift = DriftVector("xyz", np.array([1.0, 2.0, -3.0]) * 2e-3 / 3600)
    assert machine(drift).tip_error(_run(times))[2] == pytest.approx([2e-3, 4e-3, -6e-3], abs=1e-15)
    log = Series(np.array([-10.0, 0.0, 0.0, 9000.0]), np.array([20.0, 20.0, 21.0, 21.0]))
    warm = ThermalVector("xy", "air", np.array([1e-3, -2e-3]), 300.0).error_motion(_run([300.0], log=log))
    # 1 K, one time constant: 0.632121 of 1 um and of -2 um
    assert warm[0, :3] == pytest.approx([0.632121e-3, -1.264241e-3, 0.0], abs=1e-9)
    with pytest.raises(UsageError, match="has 3 numbers; expected 2"):
        StepVector("xy", np.ones(3))
    with pytest.raises(UsageError, match="allowed: xyz, xy, xz, yz"):
        DriftVector("x")
