"""Monte Carlo over the linear model: products of two Inputs are multiplied trial by trial."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.build import DIAMETER, LENGTH, scenario
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.montecarlo import Term, simulate
from vcmm.answer.evaluation.sampling import Sampler, multiplying, with_products
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.task.measuring.settings import Settings

ALPHA = Input("scale_expansion", "X", "alpha", Normal(1e-6))
WARM = Input("channel", "", "temp_scale_x_C", Normal(0.5))


def model(characteristics=(LENGTH,)):
    # alpha = 0 and no departure of the temperature: both Inputs act through their product only
    constants = {"temp_scale_x_C": 20.0, "reading_scale_x_C": 20.0}
    one = scenario(
        ScaleExpansion("X"), inputs=(ALPHA, WARM), characteristics=characteristics, constants=constants
    )
    return build(one.task())


def test_a_product_by_hand():
    # the axis goes 104 mm: u = 104 x 1e-6 x 0.5 mm = 0.052 um, the standard deviation of a product of two normals
    one = model()
    wide, values = with_products(one, one.terms())
    assert wide[0].gain.shape[0] == len(one.q0) + 2
    start = np.concatenate([one.q0, np.zeros(2)])
    length = np.concatenate([values(b)[:, 0] for b in simulate(start, wide, seed=1, trials=200_000)])
    assert length.std() == pytest.approx(0.052e-3, rel=0.02)
    kurtosis = ((length - length.mean()) ** 4).mean() / length.var() ** 2
    assert kurtosis == pytest.approx(9.0, rel=0.1)  # 3 x 3; a normal law has 3


def test_the_layout_of_q_changes_no_digit():
    """Sizes are read from one quantity; a length adds up components and keeps the layout that its digits came from."""
    for characteristics in ((DIAMETER,), (LENGTH, DIAMETER)):
        one = model(characteristics)
        wide, values = with_products(one, one.terms())
        _, multiplied = multiplying(one, one.terms())
        assert multiplied is not None
        start = np.concatenate([one.q0, np.zeros(2)])
        block = next(simulate(start, wide, seed=1, trials=3000))
        expected = one.values(np.ascontiguousarray(multiplied(block)))
        assert expected.std(axis=0).min() > 0.0
        np.testing.assert_array_equal(values(block), expected)


def test_alone_neither_does_anything():
    one = model()
    said: list[str] = []
    sampler = Sampler(one, one.terms(), Settings(trials=2000), lambda text, share: said.append(text))
    assert sampler.alone() == pytest.approx(np.zeros((2, 1)))
    assert set(said) == {"budget"}


def test_exact_trials_see_the_same_product():
    one = model()
    settings = Settings(trials=4000, engine="exact", seed=2)
    summary = Sampler(one, one.terms(), settings, lambda text, share: None).summaries([0])[0]
    assert summary.trials == 4000
    assert summary.u == pytest.approx(0.052e-3, rel=0.1)


def test_adaptive_trials_reach_their_digits():
    one = build(replace(scenario(characteristics=(LENGTH,))).task())
    settings = Settings(digits=1)
    summary = Sampler(one, one.terms(), settings, lambda text, share: None).summaries([0])[0]
    assert summary.u == pytest.approx(1e-3 / np.sqrt(2), rel=0.05)
    assert summary.digits() >= 1


def test_a_line_of_a_position_is_the_spread_of_its_input_alone():
    # 2 hypot(x, y) about zero: alone a half-normal, 4 (1 - 2 / pi) = 1.4535; both a Rayleigh, 4 (2 - pi / 2) = 1.7168: 84.66 % each
    place = SimpleNamespace(
        q0=np.zeros(2), products=(), influences=(), values=lambda b: 2 * np.hypot(b[:, 0], b[:, 1])[:, None]
    )
    terms = [Term(n, Normal(1.0), np.eye(2)[:, [i]], [[0, 0]]) for i, n in enumerate("xy")]
    alone = Sampler(place, terms, Settings(trials=20_000, seed=1), lambda text, share: None).alone()
    assert (alone**2).ravel() == pytest.approx([0.8466, 0.8466], abs=0.02)
