"""The plan of a stretch: kernel and plain twin."""

from __future__ import annotations

import numpy as np
import pytest

from tests.programs import mill, random_moves
from vcmm.shop.motion._timing_kernels import _ask, _tree
from vcmm.shop.motion.timing import plan_motion


@pytest.mark.parametrize("seed", range(8))
def test_kernel_and_twin_plan_the_same_motion(seed):
    moves = random_moves(np.random.default_rng(100 + seed), 80)
    fast, slow = plan_motion(moves, mill()), plan_motion(moves, mill(), kernel=False)
    times = np.linspace(0, slow.seconds, 5000)
    assert fast.seconds == pytest.approx(slow.seconds, abs=1e-9)
    assert fast.state(times).position == pytest.approx(slow.state(times).position, abs=1e-7)


@pytest.mark.parametrize(
    ("speed", "first", "last", "slowest"),
    [
        (
            [5, 6, 7, 1, 8, 9, 1, 4],
            1,
            6,
            3,
        ),  # of equals the first, as argmin takes it, though the tree asks for 6 before 3
        ([5, 1, 7, 8, 9, 5, 1, 4], 1, 6, 1),  # and here for 1 before 6
        ([1, 6, 7, 5, 8, 9, 4, 4], 0, 7, 0),  # the first element of all
        ([1, 6, 7, 5, 8, 9, 4, 4], 0, 6, 0),  # the first of all, asked for last
        ([5, 6, 7, 4, 8, 9, 6, 1], 1, 6, 3),  # the one behind the stretch does not count
        ([1, 6, 7, 4, 8, 9, 6, 5], 1, 6, 3),  # nor the one before
        ([5, 6, 7], 2, 2, 2),
    ],
)
def test_the_slowest_element_of_a_stretch(speed, first, last, slowest):
    """The tree answers as the plain question does: slowest element, highest speed, largest need of each kind."""
    speeds = np.array(speed, dtype=float)
    needs = np.arange(5.0 * len(speeds)).reshape(-1, 5)[::-1].copy()
    low, high, most, size = _tree(speeds, needs)
    need = np.zeros(5)
    found, fastest = _ask(speeds, low, high, most, size, first, last, need)
    assert found == slowest
    assert fastest == max(speed[first : last + 1])
    assert need.tolist() == needs[first].tolist()  # needs fall along the row
