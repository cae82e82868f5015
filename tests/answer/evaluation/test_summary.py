"""Summaries of trials: quantiles, intervals, numerical error, and the accumulator that streams."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.answer.evaluation.summary import Accumulator, summarise, tolerance
from vcmm.core.errors import ModelLimit, UsageError


def test_five_values_by_hand():
    # sorted 1..5: P(Y <= k) = (k - 1/2) / 5, so that the median is 3 and the 0.1 quantile is 1
    one = summarise([3.0, 1.0, 2.0, 5.0, 4.0])
    assert (one.mean, one.minimum, one.maximum) == (3.0, 1.0, 5.0)
    assert one.u == pytest.approx(math.sqrt(2.5))
    assert (one.quantile(0.5), one.quantile(0.1)) == (pytest.approx(3.0), pytest.approx(1.0))
    assert one.interval(0.6) == (pytest.approx(1.5), pytest.approx(4.5))
    assert one.probability(high=3.0) == pytest.approx(0.5)
    with pytest.raises(ModelLimit, match="run at least 50"):
        one.quantile(0.99)


def test_the_shortest_interval_of_a_skewed_sample():
    # squares of 0..99: density falls, so that the shortest interval begins at the least value
    one = summarise(np.arange(100.0) ** 2)
    low, high = one.interval(0.5, "shortest")
    assert low == 0.0
    assert high == pytest.approx(50.0**2, rel=0.02)


def test_tolerance_of_a_standard_uncertainty():
    # JCGM 101, 7.9.2: u = 0.0217 to two digits is 22e-3 x 10^0: delta = 0.5e-3
    assert tolerance(0.0217, 2) == pytest.approx(0.5e-3)
    assert tolerance(3.2, 1) == pytest.approx(0.5)


def test_the_accumulator_agrees_with_the_sample():
    values = np.random.default_rng(5).normal(10.0, 2.0, 20_000)
    streamed = Accumulator(10.0, 2.0)
    for part in np.array_split(values, 7):
        streamed.add(part)
    one, whole = streamed.summary(), summarise(values)
    assert one.mean == pytest.approx(values.mean(), abs=1e-6)
    assert one.u == pytest.approx(values.std(ddof=1), rel=1e-6)
    assert one.interval(0.95) == pytest.approx(whole.interval(0.95), abs=5e-3)
    assert one.digits() == whole.digits() == 1


def test_two_workers_are_one():
    values = np.random.default_rng(6).normal(size=1000)
    whole, first, second = Accumulator(0.0, 1.0), Accumulator(0.0, 1.0), Accumulator(0.0, 1.0)
    whole.add(values)
    first.add(values[:300])
    second.add(values[300:])
    first.merge(second)
    assert (first.summary().mean, first.summary().u) == (whole.summary().mean, whole.summary().u)
    with pytest.raises(UsageError, match="cannot be merged"):
        first.merge(Accumulator(1.0, 1.0))


def test_trials_beyond_the_histogram_are_reported():
    one = Accumulator(0.0, 1.0)
    one.add(np.array([0.0, 0.5, 100.0]))
    assert "1 of 3 trials lie beyond" in one.summary().warnings[0]
    assert one.summary().mean == pytest.approx(100.5 / 3, abs=1e-5)
    with pytest.raises(ModelLimit, match="at least 2 trials"):
        Accumulator(0.0, 1.0).summary()
