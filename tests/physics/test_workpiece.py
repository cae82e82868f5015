"""vcmm/physics/catalogue/workpiece.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.workpiece import WorkpieceHeating

E1 = 0.632121  # 1 - 1/e


def _run(time: list[float], x: float = 0.0, log: Series | None = None, **columns: float) -> Run:
    n = len(time)
    more = {k: np.full(n, v) for k, v in columns.items()}
    position = {"X": np.full(n, x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(
        position, np.zeros((n, 3)), {"time_s": np.array(time), **more}, {}, {"air": log} if log else {}
    )


def test_workpiece_heating_leaves_the_part_small():
    # 20 um/(m h) x 0.5 h at p = (100, 0, -50) mm: -1 um and +0.5 um; with tau = 1800 s 0.632121 of it
    run = _run([1800.0], part_x_mm=100.0, part_y_mm=0.0, part_z_mm=-50.0)
    k = 20e-6 / 3600
    assert WorkpieceHeating(k).error_motion(run)[0, :3] == pytest.approx([-1e-3, 0, 0.5e-3], abs=1e-15)
    assert WorkpieceHeating(k, 1800.0).error_motion(run)[0, 0] == pytest.approx(-1e-3 * E1, abs=1e-9)
    assert machine(WorkpieceHeating(k)).indication_error(run)[0, 0] == pytest.approx(-1e-3, abs=1e-15)
