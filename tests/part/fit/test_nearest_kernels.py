"""Steps of criterion C in one free direction, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.part.fit._nearest_kernels import minimax_steps


@pytest.mark.parametrize(
    ("two_sided", "d", "expected"),
    [
        # 2 + x <= 2 + l and -x <= 2 + l: along x = l the sum l + l^2/2 + l^2/2 is least at l = -1/2, where 1/2 <= 3/2
        (False, [2.0, 0.0], (-0.5, 1.5)),
        # 1 - 0.4 = 0.6 is the level at which both touch: 1 + x = 0.2 - x at x = -0.4, before l reaches -1/2
        (False, [1.0, 0.2], (-0.4, 0.6)),
        # -3 is the largest in size: 3 - x <= 3 + l: x = -l = 1/2, and the other 0 - x stays within
        (True, [-3.0, 0.0], (0.5, 2.5)),
    ],
)
def test_one_step_by_hand(two_sided: bool, d: list[float], expected: tuple[float, float]) -> None:
    """Least l + l^2 / 2 + x^2 / 2 with d_0 + x and d_1 - x at most max d + l; level: max d + l."""
    step, level, weight = np.zeros((1, 1)), np.zeros(1), np.zeros((1, 2))
    jac, metric = np.array([[[1.0, -1.0]]]), np.ones((1, 1, 1))
    minimax_steps(jac, np.array([d]), two_sided, metric, np.full(1, 1e-12), step, level, weight)
    assert (step[0, 0], level[0]) == pytest.approx(expected, abs=1e-9)
