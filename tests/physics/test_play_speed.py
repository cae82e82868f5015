"""vcmm/physics/catalogue/play_speed.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.lag import ServoLag
from vcmm.physics.catalogue.play_speed import SpeedPlay


def _run(speed: list[float], sense: list[float], axis: str = "X", unit: str = "mm") -> Run:
    n = len(speed)
    columns = {f"sense_{axis}": np.array(sense), f"speed_{axis}_{unit}_s": np.array(speed)}
    return Run({axis: np.zeros(n)}, np.zeros((n, 3)), columns)


def test_the_gap_goes_with_a_power_of_the_speed():
    # 3 um at 1000 mm/min = 16.6667 mm/s; at 4 times that with power 0.5 it is 6 um, of which half lies behind: -3 um ahead, +3 um on the way back
    effect = SpeedPlay("X", 3e-3, 0.5)
    motion = effect.error_motion(_run([16.666667, 66.666667, -66.666667], [1.0, 1.0, -1.0]))
    assert motion[:, 0] == pytest.approx([-1.5e-3, -3e-3, 3e-3], rel=1e-7)
    # power 0: a backlash of 3 um whatever the speed
    assert SpeedPlay("X", 3e-3, 0.0).error_motion(_run([1.0, 100.0], [1.0, -1.0]))[:, 0] == pytest.approx(
        [-1.5e-3, 1.5e-3]
    )


def test_with_power_one_it_is_the_lag_of_a_servo():
    # 1/2 gap v / v0 = lag v: gap = 2 x 0.1 ms x 16.6667 mm/s = 3.3333 um
    run = _run([5.0, 40.0, -20.0], [1.0, 1.0, -1.0])
    lag = ServoLag("X", 1e-4).error_motion(run)
    assert SpeedPlay("X", 2 * 1e-4 * 1000 / 60, 1.0).error_motion(run) == pytest.approx(lag, abs=1e-15)


def test_one_speed_does_not_show_a_power():
    shows_in = SpeedPlay.diagnosis.shows_in
    assert not shows_in(SpeedPlay(), _run([20.0, -20.0], [1.0, -1.0]))
    assert shows_in(SpeedPlay(), _run([20.0, -50.0], [1.0, -1.0]))


def test_a_power_below_zero_has_no_size_where_the_axis_stands():
    with pytest.raises(UsageError, match="must not be below zero"):
        SpeedPlay("X", 1e-3, -0.3)


def test_a_rotary_axis_counts_in_turns():
    # 10 turns a minute = 1.047198 rad/s
    motion = SpeedPlay("C", 30e-6, 0.5).error_motion(_run([1.0471976], [1.0], "C", "rad"))
    assert motion[0, 5] == pytest.approx(-15e-6, rel=1e-6)
