"""When the tool passes which side of a turning part, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.shop.machining.spindle import Spindle


def test_passes_of_a_spindle_by_hand():
    """60 turns per minute, M3: the tool runs round the part by -1 turn/s. It passes 90 deg 0.75 s after the start, then each s."""
    time = np.linspace(0.0, 10.0, 11)
    spindle = Spindle(time, -2 * np.pi * time, 2 * np.pi * time)
    found = spindle.passes(np.array([3.0]), np.array([np.pi / 2]), 2)
    assert found[0] == pytest.approx([1.75, 2.75, 3.75, 4.75], abs=1e-12)
    late = spindle.passes(np.array([9.9]), np.array([np.pi / 2]), 1)
    assert late[0, 0] == pytest.approx(9.75)
    assert np.isnan(late[0, 1])  # the program ends before
