"""vcmm/physics/structure/spindle_growth.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run, Series
from vcmm.physics.structure.spindle_growth import SpindleGrowth

E1 = 0.632121  # 1 - 1/e


def _run(time: list[float], x: float = 0.0, log: Series | None = None, **columns: float) -> Run:
    n = len(time)
    more = {k: np.full(n, v) for k, v in columns.items()}
    position = {"X": np.full(n, x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(
        position, np.zeros((n, 3)), {"time_s": np.array(time), **more}, {}, {"air": log} if log else {}
    )


def test_spindle_growth_pushes_the_tip_away_from_the_spindle():
    # 20 um x (1 - 1/e) after one time constant, to -Z
    error = machine(SpindleGrowth("Z", 20e-3, 900.0)).tip_error(_run([0.0, 900.0]))
    assert error[:, 2] == pytest.approx([0.0, -20e-3 * E1], abs=1e-7)
    assert np.all(error[:, :2] == 0.0)
    # with a spindle that was started later: 0 s on, whatever the clock says
    assert SpindleGrowth("Z", 20e-3).error_motion(_run([900.0], spindle_on_s=0.0))[0, 2] == 0.0


def test_growth_that_follows_the_log_of_the_speed_pushes_the_same_way():
    """10 000 per min from the start: 20 um x (1 - 1/e) = 12.64 um to -Z after one time constant; at 5 000 half of it."""
    for speed, share in ((10_000.0, 1.0), (5_000.0, 0.5)):
        log = Series(np.array([0.0, 1800.0]), np.array([speed, speed]))
        run = Run(
            {a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), {"time_s": np.array([900.0]), "spindle_rpm": np.array([speed])},
            {}, {"spindle_rpm": log},
        )  # fmt: skip
        error = SpindleGrowth("Z", 20e-3, 900.0, follows=1).error_motion(run)
        assert error[0, 2] == pytest.approx(-20e-3 * E1 * share, abs=1e-6)
