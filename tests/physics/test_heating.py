"""vcmm/physics/catalogue/heating.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.heating import ScrewHeating

E1 = 0.632121  # 1 - 1/e


def _run(time: list[float], x: float = 0.0, log: Series | None = None, **columns: float) -> Run:
    n = len(time)
    more = {k: np.full(n, v) for k, v in columns.items()}
    position = {"X": np.full(n, x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(
        position, np.zeros((n, 3)), {"time_s": np.array(time), **more}, {}, {"air": log} if log else {}
    )


def test_screw_heating_grows_with_travel():
    # 50 um/m x 300 mm = 15 um when warm, less 5 um: 10 um x (1 - 1/e) after 100 m of travel
    effect = ScrewHeating("X", 50e-6, -5e-3, 1e5)
    error = machine(effect).tip_error(_run([0.0], 300.0, travel_X_mm=1e5))
    assert error[0] == pytest.approx([10e-3 * E1, 0, 0], abs=1e-8)
    assert effect.error_motion(_run([0.0], 300.0, travel_X_mm=0.0))[0, 0] == 0.0
