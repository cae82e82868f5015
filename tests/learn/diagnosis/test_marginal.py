"""Draws of sizes and scanned values together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.estimates import _end_of_lobes, _first_fall, _gaps


def test_a_moment_is_known_to_lie_between_rows():
    """Rows at 0, 10, 20 ...: the gap that holds 25 is from 20 to 30; its neighbour is as good, the next ones are not."""
    time = np.arange(0.0, 100.0, 10.0)
    assert _gaps(time, 25.0, lambda value: True) == [(20.0, 30.0)]
    assert _gaps(time, 25.0, lambda value: not 20.0 < value < 40.0) == [(20.0, 30.0), (30.0, 40.0)]


def test_the_range_of_a_value_ends_where_the_evidence_has_fallen():
    """Steps of the logarithm 0.1, 0.2, 0.4: 100 e^0.2 = 122 is the first beyond 115; without a fall the last counts."""
    steps = np.array([0.1, 0.2, 0.4])
    assert _first_fall(100.0, steps, "tau", lambda value: value > 115.0) == pytest.approx(0.2)
    assert _first_fall(100.0, steps, "tau", lambda value: False) == pytest.approx(0.4)


def test_a_side_lobe_and_a_moment_beyond_a_worse_one_are_within_the_range():
    """Steps 0.1, 0.2, 0.3, 0.4 about 100 mm: 110.5, 122.1, 135.0, 149.2; a lobe at 130 to 140 ends at 0.4. Gaps (20, 30), which
    holds the moment, and (50, 60)."""
    steps = np.array([0.1, 0.2, 0.3, 0.4])
    assert _end_of_lobes(100.0, steps, "period", lambda v: not 130 < v < 140) == pytest.approx(0.4)
    assert _end_of_lobes(100.0, steps, "period", lambda v: v > 115) == pytest.approx(0.2)
    assert _end_of_lobes(100.0, steps, "period", lambda v: True) == pytest.approx(0.1)
    time = np.arange(0.0, 100.0, 10.0)
    assert _gaps(time, 25.0, lambda value: not 50.0 < value < 60.0) == [(20.0, 30.0), (50.0, 60.0)]


@pytest.mark.thorough
def test_the_size_of_a_drift_carries_what_its_lag_leaves_open():
    case = make.make(("thermal_drift",), 12.0, 31, replace(make.RICH, n=120))
    found = diagnose_recording(case.recording, make.machine(), 1, 400)
    drift = next(a for a in found.answer if a.effect == "thermal_drift")
    for name, estimate in drift.parameters.items():
        low, high = estimate.interval95
        assert low <= estimate.value <= high, name
        assert estimate.u > 0
