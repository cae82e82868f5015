"""Draws of sizes and scanned values together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnosis import generator as make
from vcmm.diagnosis.engine import diagnose_recording
from vcmm.diagnosis.marginal import _fallen_at, _gaps


def test_a_moment_is_known_to_lie_between_rows():
    """Rows at 0, 10, 20 ...: the gap that holds 25 is from 20 to 30; its neighbour is as good, the next ones are not."""
    time = np.arange(0.0, 100.0, 10.0)
    assert _gaps(time, 25.0, lambda value: True) == [(20.0, 30.0)]
    assert _gaps(time, 25.0, lambda value: not 20.0 < value < 40.0) == [(20.0, 30.0), (30.0, 40.0)]


def test_the_range_of_a_value_ends_where_the_evidence_has_fallen():
    """Steps of the logarithm 0.1, 0.2, 0.4: 100 e^0.2 = 122 is the first beyond 115; without a fall the last counts."""
    steps = np.array([0.1, 0.2, 0.4])
    assert _fallen_at(100.0, steps, "tau", lambda value: value > 115.0) == pytest.approx(0.2)
    assert _fallen_at(100.0, steps, "tau", lambda value: False) == pytest.approx(0.4)


def test_the_size_of_a_drift_carries_what_its_lag_leaves_open():
    case = make.make(("thermal_drift",), 12.0, 31, replace(make.RICH, n=120))
    found = diagnose_recording(case.recording, make.machine(), 1, 400)
    drift = next(a for a in found.answer if a.effect == "thermal_drift")
    for name, estimate in drift.parameters.items():
        low, high = estimate.interval95
        assert low <= estimate.value <= high, name
        assert estimate.u > 0
