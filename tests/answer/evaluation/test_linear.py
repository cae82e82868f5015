"""The linear model: blocks of q, gains, gradient."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.answer.evaluation.linear import build, term_of
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.task.response.influence import Influence

K = Input("scale_factor", "X", "k", Normal(1e-6))


def model():
    return build(replace(scenario(ScaleFactor("X")), inputs=(K,)).task())


def test_where_the_numbers_stand():
    blocks = model().blocks
    # bore: point 3, axis 3, radius, 16 residuals for its form; the faces 6 each
    assert (blocks["bore"].start, blocks["bore"].stop, blocks["bore"].residuals) == (0, 23, 16)
    assert (blocks["left"].start, blocks["left"].stop) == (23, 29)
    assert blocks["right"].stop == 35


def test_the_nominal_part_and_its_gradient():
    one = model()
    assert one.values(one.q0) == pytest.approx([30.0, 100.0, 0.0], abs=1e-9)
    gradient = one.gradient()
    assert gradient[0, 6] == pytest.approx(2.0)  # the diameter per radius
    # the distance per position of the faces along x
    assert gradient[1, [one.blocks["left"].start, one.blocks["right"].start]] == pytest.approx([-1.0, 1.0])


def test_a_scale_factor_gains_the_length():
    # the axis goes 100 mm between the faces and the diameter of the tip, 4 mm: indicated - true = -104 mm per unit of k
    one = model()
    scatter, scale = one.terms()
    assert scale.gain.shape == (35, 1)
    assert (one.gradient() @ scale.gain)[1, 0] == pytest.approx(-104.0)
    assert scatter.gain.shape == (35, 24)  # a lane per touch
    # the mean of 4 touches each side: u = 1 um sqrt(1/4 + 1/4)
    u = 1e-3 * np.linalg.norm((one.gradient() @ scatter.gain)[1])
    assert u == pytest.approx(1e-3 / np.sqrt(2.0), rel=1e-6)


def test_unpacked_elements_have_unit_axes():
    one = model()
    q = np.tile(one.q0, (2, 1))
    q[1, 3:6] *= 3.0
    out = one.unpack(q)["bore"]
    assert np.linalg.norm(out.axis, axis=-1) == pytest.approx([1.0, 1.0])
    assert out.residuals.shape == (2, 16)


@pytest.mark.parametrize("codes", [[0, 1, 2, 3, 4, 5], [2, 0, 1, 0, 2, 1], [5, 3, 0, 1, 4, 2]])
def test_a_lane_per_element_and_copy_in_any_order_of_rows(codes):
    rng = np.random.default_rng(3)
    change, operator = rng.normal(size=(6, 2)), rng.normal(size=(4, 6))
    one = Influence(K, np.zeros((6, 3, 2)), tuple(f"c{i}" for i in range(max(codes) + 1)), np.array(codes))
    term = term_of(one, change, operator, keep=True)
    copies = range(max(codes) + 1)
    wanted = [
        sum(operator[:, i] * change[i, k] for i in range(6) if codes[i] == c) for c in copies for k in (0, 1)
    ]
    assert pytest.approx(np.array(wanted), abs=1e-15) == term.gain.T
    assert term.lanes[:, 0].tolist() == [0, 1] * len(copies)
    assert len(set(term.lanes[::2, 1].tolist())) == len(copies)
