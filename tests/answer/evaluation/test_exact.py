"""The exact trials draw what the linear model draws, and agree where all is linear."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.evaluation.test_linear import model
from vcmm.answer.evaluation.exact import draw_inputs, exact_values, linear_quantities


def test_draws_are_those_of_the_trials():
    one = model()
    whole = draw_inputs(one, 3, 0, 6)
    later = draw_inputs(one, 3, 4, 2)
    assert whole[0].departures.shape == (6, 24, 1)  # a copy per touch
    assert whole[1].departures.shape == (6, 1, 1)
    for a, b in zip(whole, later):
        assert np.array_equal(a.raw[4:], b.raw)


def test_exact_and_linear_agree_to_second_order():
    one = model()
    drawn = draw_inputs(one, 1, 0, 20)
    linear, exact = one.values(linear_quantities(one, drawn)), exact_values(one, drawn)
    spread = exact.std(axis=0)
    assert (spread > 1e-5).all()
    # departures of 1 um on 15 mm: second order (1 um)^2 / 30 mm
    assert np.abs(linear - exact).max() < 1e-6
    # the length follows k by -104 mm (the axis goes further by the diameter of the tip) and the scatter of the faces
    k = drawn[1].departures[:, 0, 0]
    faces = drawn[0].departures[:, :, 0]
    along = -104.0 * k + faces[:, 16:].reshape(20, 2, 4).mean(axis=2).sum(axis=1)
    assert exact[:, 1] - 100.0 == pytest.approx(along, abs=1e-5)  # tilts of the faces, of second order


def test_without_inputs_the_estimates():
    one = model()
    assert linear_quantities(one, []) == pytest.approx(one.q0[None])
