"""Points of Sobol: by hand in two dimensions, and number for number those of scipy."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from vcmm.answer.placing.sobol import MOST_DIMENSIONS, sobol


def test_the_first_points_by_hand():
    # one dimension: van der Corput in Gray order; the second: m = 1, 3, so that its second direction number is 3/4
    expected = [[0.0, 0.0], [0.5, 0.5], [0.75, 0.25], [0.25, 0.75]]
    assert sobol(2, 4).tolist() == expected


@pytest.mark.parametrize("seed", [None, 0, 7])
def test_the_same_numbers_as_scipy(seed):
    from scipy.stats import qmc

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # 1000 is no power of two
        known = qmc.Sobol(MOST_DIMENSIONS, scramble=seed is not None, seed=seed).random(1000)
    rng = None if seed is None else np.random.default_rng(seed)
    assert (sobol(MOST_DIMENSIONS, 1000, rng) == known).all()
