"""Inputs: names, sizes, and how draws become departures."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, Normal, StudentT


def test_the_name_says_where_and_of_whom():
    one = Input("backlash", "X", "gap", Normal(1e-3))
    assert one.id == "backlash[X].gap"
    assert Input("scatter", "", "value", Normal(1e-3)).id == "scatter.value"
    assert Input("backlash", "X", "gap", Normal(1e-3), owner="mill").id == "mill: backlash[X].gap"
    assert Input("channel", "", "temp_part_C", Normal(0.1)).is_channel
    assert not one.is_channel


def test_a_scalar_law_is_drawn_for_every_element_times_its_scale():
    law, factor = Input("e", "", "p", Normal(2.0), scale=np.array([1.0, 3.0])).spread(2)
    assert law.u == 2.0
    assert factor.tolist() == [[1.0, 0.0], [0.0, 3.0]]


def test_a_joint_law_gives_its_factor():
    # covariance [[4, 2], [2, 5]] = F F^T
    law, factor = Input("e", "", "p", MultivariateNormal(np.array([[4.0, 2.0], [2.0, 5.0]]))).spread(2)
    assert law.u == 1.0
    assert np.allclose(factor @ factor.T, [[4.0, 2.0], [2.0, 5.0]])


def test_size_of_a_scalar_input():
    assert Input("e", "", "p", Normal(2e-3), scale=np.array([-3.0])).size == pytest.approx(6e-3)
    assert Input("e", "", "p", StudentT(1.0, 2.0)).size == 1e-6  # no variance
