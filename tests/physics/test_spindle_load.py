"""Growth of the spindle by its load: numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.spindle_load import SpindleLoadGrowth


def run(load: Series | None) -> Run:
    time = np.array([0.0, 600.0, 1200.0])
    return Run(
        {"Z": np.zeros(3)},
        np.zeros((3, 3)),
        {"time_s": time},
        series={} if load is None else {"spindle_load_W": load},
    )


def test_half_a_kilowatt_for_ten_minutes_and_none_after():
    """A = 20 um per kW, tau = 600 s, 500 W for 600 s: 10 (1 - 1/e) = 6.321 um down, after 600 s without load 6.321/e = 2.325 um."""
    load = Series(np.array([0.0, 600.0, 600.0, 1200.0]), np.array([500.0, 500.0, 0.0, 0.0]))
    moved = SpindleLoadGrowth("Z", amplitude=20e-3, tau=600.0).error_motion(run(load))
    assert moved[:, 2] == pytest.approx([0.0, -6.321e-3, -2.325e-3], abs=1e-6)
    assert not moved[:, :2].any()


def test_without_a_log_it_says_what_to_add():
    with pytest.raises(ModelLimit, match="needs a log of spindle_load_W"):
        SpindleLoadGrowth("Z", 1e-3).error_motion(run(None))
