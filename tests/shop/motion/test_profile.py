"""The plan of a stretch: kernel and plain twin."""

from __future__ import annotations

import numpy as np
import pytest

from tests.programs import mill, random_moves
from vcmm.shop.motion.timing import plan_motion


@pytest.mark.parametrize("seed", range(8))
def test_kernel_and_twin_plan_the_same_motion(seed):
    moves = random_moves(np.random.default_rng(100 + seed), 80)
    fast, slow = plan_motion(moves, mill()), plan_motion(moves, mill(), kernel=False)
    times = np.linspace(0, slow.seconds, 5000)
    assert fast.seconds == pytest.approx(slow.seconds, abs=1e-9)
    assert fast.state(times).position == pytest.approx(slow.state(times).position, abs=1e-7)
