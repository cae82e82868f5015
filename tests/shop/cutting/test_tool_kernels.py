"""The compiled distance to a tool on a straight move, by hand: a flat mill of 10 mm from (10, 2, 0) to (30, 2, -10)."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.shop.cutting._tool_kernels import FLAT, at_line, nearest

MOVE = np.zeros(23)
MOVE[:6] = 10.0, 2.0, 0.0, 30.0, 2.0, -10.0
MILL = np.array([FLAT, 5.0, 0.0, 5.0, 1.0, 0.0, 1000.0])


def test_the_tool_stands_where_its_share_of_the_move_says():
    # half way the tip is at (20, 2, -5): (27, 2, 0) is 7 - 5 = 2 mm beside the flank; (20, 2, -8) 3 mm below the bottom
    assert at_line(MOVE, MILL, np.array([27.0, 2.0, 0.0]), 0.5) == pytest.approx(2.0)
    assert at_line(MOVE, MILL, np.array([20.0, 2.0, -8.0]), 0.5) == pytest.approx(3.0)
    # (20, 9, 0): 7 mm across, and the same from any place right below it
    assert at_line(MOVE, MILL, np.array([20.0, 9.0, 0.0]), 0.5) == pytest.approx(2.0)


def test_the_least_over_the_move():
    out = np.zeros(3)
    # beside the path: 7 mm from it all along the passage, 2 mm from the flank; behind the end: 36 - 30 - 5 = 1 mm
    assert nearest(MOVE, MILL, np.array([20.0, 9.0, 5.0]), out)[0] == pytest.approx(2.0, abs=1e-12)
    assert out == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
    distance, share = nearest(MOVE, MILL, np.array([36.0, 2.0, 0.0]), out)
    assert (distance, share) == pytest.approx((1.0, 1.0))
