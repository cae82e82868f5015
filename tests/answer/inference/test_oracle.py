"""The interval of who knows the law of the parts, where that law can be written down."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.evaluation.belts import inverse_of
from vcmm.answer.evaluation.pairs import Pairs
from vcmm.answer.inference.oracle import IntervalLengths, lengths, oracle
from vcmm.part.part import Characteristic

FLATNESS = Characteristic("f", "flatness", of=("top",), zone=0.01)
MATING = Characteristic("d", "size", of=("bore",), criterion="GX", limits=(0.0, 0.1))
Z = 1.959964


def drawn(seed: int, count: int = 20_000, spread: float = 2e-3) -> Pairs:
    """True values of N(20 um, spread), indicated with N(0, 1 um), residuals of 1 um."""
    rng = np.random.default_rng(seed)
    true = 0.020 + spread * rng.normal(size=(count, 1))
    return Pairs(true, true + 1e-3 * rng.normal(size=(count, 1)), np.full((count, 1), 1e-3))


def test_the_oracle_is_the_conditional_law_of_two_normal_ones() -> None:
    """Of N(20, 2) seen with N(0, 1): mean 20 + 0.8 (y - 20), standard deviation 2 x 1 / sqrt 5 = 0.894 um."""
    known = drawn(1)
    y = np.array([0.019, 0.020, 0.021])
    low, high = oracle(
        FLATNESS, (known.true[:, 0], known.indicated[:, 0], known.rest[:, 0]), (y, np.full(3, 1e-3)), 0.95
    )
    assert (low + high) / 2 == pytest.approx(0.020 + 0.8 * (y - 0.020), abs=0.25e-3)  # 300 parts: 0.1 um
    assert high - low == pytest.approx(2 * Z * 0.894e-3, rel=0.15)


def test_of_a_size_parts_as_rough_are_alike() -> None:
    """The error is five residuals of the part, whatever it indicates: 5 +- 1 of them."""
    rng = np.random.default_rng(2)
    rest = 10 ** rng.uniform(-4, -2, 20_000)
    true = rng.normal(size=20_000)
    low, high = oracle(
        MATING,
        (true, true - rest * (5 + rng.normal(size=20_000)), rest),
        (np.zeros(2), np.array([1e-3, 5e-3])),
        0.95,
    )
    assert low / [1e-3, 5e-3] == pytest.approx(5 - Z, abs=0.5)
    assert high / [1e-3, 5e-3] == pytest.approx(5 + Z, abs=0.5)


def test_lengths_beside_the_oracle_of_each_family() -> None:
    """Both families alike, the prior wide beside the noise: belts and oracle have 2 x 1.96 um, in the mean of both."""
    known, fresh = (
        [drawn(3, spread=5e-3), drawn(4, spread=5e-3)],
        [drawn(5, 2000, 5e-3), drawn(6, 2000, 5e-3)],
    )
    found = lengths(FLATNESS, 0, inverse_of(FLATNESS, 0, known), known, fresh, 0.95)
    assert found.oracle == pytest.approx(2 * Z * 1e-3 * 5 / np.sqrt(26), rel=0.05)
    assert found.own == pytest.approx(2 * Z * 1e-3, rel=0.08)
    assert found.own <= found.belts
    assert found.oracle_held == pytest.approx(0.95, abs=0.015)
    assert found.belts_held >= found.own_held
    assert found.ratio == pytest.approx(found.belts / found.oracle)
    assert np.isnan(IntervalLengths(1, 1, 0, 1, 1, 1).ratio)
