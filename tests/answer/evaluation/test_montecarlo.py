"""vcmm.answer.evaluation.montecarlo and vcmm.answer.evaluation.summary: same trials whatever the blocks, right covariance, right summaries."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.answer.evaluation import montecarlo, streams
from vcmm.answer.evaluation.montecarlo import (
    Accumulator,
    Summary,
    Term,
    adaptive,
    covariance,
    marginal,
    simulate,
    summarise,
    uncertainty,
)
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import MultivariateNormal, MultivariateSamples, Normal, Samples, StudentT, Uniform

START = np.array([1.0, -2.0, 0.5])


def lanes(n: int, copy: int = 0) -> np.ndarray:
    return np.stack([np.arange(n), np.full(n, copy)], axis=1)


def terms() -> list[Term]:
    """Three outputs; normal, t, rectangular, joint normal (two copies) and joint samples."""
    rng = np.random.default_rng(4)
    joint = MultivariateNormal(np.array([[4.0, 1.0], [1.0, 2.0]]))
    rows = MultivariateSamples(rng.normal(size=(50, 2)) @ [[1.0, 0.5], [0.0, 1.0]] + [0.3, 0.0])
    return [
        Term("curve", Normal(2.0), rng.normal(size=(3, 9)), lanes(9)),
        Term("node", StudentT(0.5, 6.0), rng.normal(size=(3, 7)), lanes(7)),
        Term("sensor", Uniform(1.0), rng.normal(size=(3, 2)), lanes(2)),
        Term("fit", joint, rng.normal(size=(3, 4)), np.concatenate([lanes(2, 5), lanes(2, 6)])),
        Term("history", rows, rng.normal(size=(3, 2)), lanes(2)),
    ]


def run(**settings: object) -> np.ndarray:
    return np.concatenate(list(simulate(START, terms(), seed=1, **settings)))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def trials() -> np.ndarray:
    return run(trials=20_000)


def test_blocks_and_shards_give_the_same_bits(trials: np.ndarray):
    assert trials.shape == (20_000, 3)
    np.testing.assert_array_equal(run(trials=20_000, block=1000), trials)
    parts = [run(first=first, trials=2500, block=8192) for first in range(0, 20_000, 2500)]  # eight workers
    np.testing.assert_array_equal(np.concatenate(parts), trials)


def test_numba_gives_the_bits_of_numpy(trials: np.ndarray, monkeypatch):
    fast = streams._load_kernels()
    if fast is None:
        pytest.skip("numba is not installed or cannot keep its cache")
    for backend in (None, fast):
        monkeypatch.setattr(streams, "kernels", lambda numbers, backend=backend: backend)
        np.testing.assert_array_equal(run(trials=3000, first=500), trials[500:3500])


@pytest.mark.parametrize("outputs", [1, 2, 8, 9, 15, 17])
def test_any_number_of_outputs_lanes_and_trials_gives_the_bits_of_numpy(outputs: int, monkeypatch):
    """Strips of outputs and trials, their ends, and the edges of blocks of counters (2047, 2048, 4096)."""
    fast = streams._load_kernels()
    if fast is None:
        pytest.skip("numba is not installed or cannot keep its cache")
    rng = np.random.default_rng(outputs)
    laws = {"a": (StudentT(1.0, 4.0), 35), "b": (Normal(0.5), 2), "c": (Uniform(2.0), 1)}
    several = [Term(n, law, rng.normal(size=(outputs, k)), lanes(k)) for n, (law, k) in laws.items()]
    start = rng.normal(size=outputs)
    for first, trials in ((0, 1), (2047, 2), (1021, 3077), (511, 130)):
        found = []
        for backend in (None, fast):
            monkeypatch.setattr(streams, "kernels", lambda numbers, backend=backend: backend)
            drawn = simulate(start, several, seed=3, trials=trials, first=first, fold=False)
            found.append(np.concatenate(list(drawn)))
        np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("fold", [True, False])
def test_covariance_of_the_trials_is_the_closed_form(fold: bool):
    y = run(trials=400_000, fold=fold)
    closed = covariance(terms())
    sd = np.sqrt(np.diag(closed))
    np.testing.assert_allclose(sd, uncertainty(terms()))
    # standard error of a covariance of near-normal outputs: <= sqrt(2) s_i s_j / sqrt(n) = 0.0022 s_i s_j; 5 times that
    assert (np.abs(np.cov(y.T) - closed) / np.outer(sd, sd)).max() < 0.011
    for k in range(3):
        law = marginal(START[k], terms(), k)
        assert law.u == pytest.approx(sd[k])
        assert y[:, k].mean() == pytest.approx(law.centre, abs=5 * sd[k] / math.sqrt(4e5))
        low, high = law.interval(0.95)
        inside = np.mean((y[:, k] >= low) & (y[:, k] <= high))
        assert inside == pytest.approx(0.95, abs=0.0016)  # 4.6 sd of the count, sqrt(0.0475 / 4e5) = 3.4e-4


def test_unfolded_trials_are_the_input_streams():
    """Common random numbers: y = start + gain . draw of each input by its own name, trial by trial."""
    y = run(trials=3000, fold=False)
    expected = np.tile(START, (3000, 1))
    for term in terms():
        if isinstance(term.law, MultivariateNormal):
            for i, copy in enumerate((5, 6)):
                z = streams.draw(1, term.name, lanes(2, copy), Normal(1.0), 0, 3000)
                expected += z @ term.law.factor.T @ term.gain[:, 2 * i : 2 * i + 2].T
        else:
            expected += streams.draw(1, term.name, term.lanes, term.law, 0, 3000) @ term.gain.T
    np.testing.assert_allclose(y, expected, rtol=0, atol=1e-12)


def test_an_input_without_effect_changes_nothing(trials: np.ndarray):
    nothing = [
        Term("idle", StudentT(1.0, 4.0), np.zeros((3, 2)), lanes(2)),
        Term("sure", Normal(0.0), np.ones((3, 1)), lanes(1)),
    ]
    more = np.concatenate(list(simulate(START, [*terms(), *nothing], seed=1, trials=20_000)))
    np.testing.assert_array_equal(more, trials)


def test_an_added_input_is_added():
    """Unfolded, a further input adds its own numbers and leaves all others as they were (to rounding)."""
    more = [*terms(), Term("late", Uniform(1.0), np.ones((3, 1)), lanes(1))]
    y = np.concatenate(list(simulate(START, more, seed=1, trials=1000, fold=False)))
    late = streams.draw(1, "late", lanes(1), Uniform(1.0), 0, 1000)
    np.testing.assert_allclose(y - late, run(trials=1000, fold=False), atol=1e-12)


def test_folding_keeps_earlier_outputs_when_one_is_added():
    gain = np.random.default_rng(3).normal(size=(4, 9))
    few, many = (
        next(simulate(np.zeros(k), [Term("a", Normal(1.0), gain[:k], lanes(9))], seed=2, trials=100))
        for k in (3, 4)
    )
    np.testing.assert_allclose(many[:, :3], few, atol=1e-13)


def test_closed_form_of_heavy_tails():
    heavy = [
        Term("a", StudentT(1.0, 2.0), np.array([[1.0], [0.0]]), lanes(1)),
        Term("b", StudentT(1.0, 3.0), np.array([[0.0], [2.0]]), lanes(1)),
    ]
    assert uncertainty(heavy).tolist() == [math.inf, pytest.approx(2 * math.sqrt(3))]
    with pytest.raises(ModelLimit, match="no variance"):
        covariance(heavy)
    law = marginal(0.0, heavy, 0)
    assert law.u == math.inf
    assert law.quantile(0.975) == pytest.approx(4.302653, rel=1e-6)  # table of t, nu = 2


def test_wrong_terms_are_refused():
    with pytest.raises(UsageError, match=r"lanes \(3, 2\)"):
        Term("a", Normal(1.0), np.ones((2, 4)), lanes(3))
    with pytest.raises(ModelLimit, match="not finite"):
        Term("a", Normal(1.0), np.array([[np.nan]]), lanes(1))
    with pytest.raises(UsageError, match="gain has 2 rows, start has 3"):
        simulate(START, [Term("a", Normal(1.0), np.ones((2, 1)), lanes(1))], seed=1, trials=1)
    with pytest.raises(UsageError, match="block = 0"):
        simulate(START, terms(), seed=1, trials=1, block=0)
    with pytest.raises(ModelLimit, match="use another seed"):
        simulate(START, terms(), seed=1, trials=2, first=2**43 - 1)


def test_summary_of_a_known_sample():
    """0, 1, ..., 9999: mean 4999.5, u = sqrt((n^2 - 1) / 12 * n / (n - 1)) = 2886.895680, interval by 7.7."""
    s = summarise(np.random.default_rng(1).permutation(np.arange(10_000.0)))
    assert (s.trials, s.mean, s.minimum, s.maximum) == (10_000, 4999.5, 0, 9999)
    assert s.u == pytest.approx(2886.895680)
    assert s.interval(0.95) == pytest.approx((249.5, 9749.5))  # order statistic r at (r - 1/2) / M
    low, high = s.interval(0.95, "shortest")
    assert high - low == pytest.approx(9500)
    assert s.interval(0.95, "upper") == (-math.inf, pytest.approx(9499.5))
    assert s.probability(2499.5, 7499.5) == pytest.approx(0.5)
    assert s.probability() == 1.0
    assert s.histogram[1].sum() == 10_000


def test_shortest_interval_of_a_skew_sample():
    """Exponential law: the shortest 95 % interval is [0, ln 20]."""
    y = -np.log((np.arange(100_000) + 0.5) / 100_000)
    low, high = summarise(y).interval(0.95, "shortest")
    assert low == pytest.approx(0, abs=1e-3)
    assert high - low == pytest.approx(math.log(20), rel=1e-3)


def two_ways(y: np.ndarray, scale: float) -> tuple[Summary, Summary]:
    accumulator = Accumulator(0.5, scale)
    for block in np.array_split(y, 7):
        accumulator.add(block)
    return accumulator.summary(), summarise(y)


def test_accumulator_agrees_with_the_sample():
    y = 0.4 + 2 * np.random.default_rng(2).standard_t(5, 100_000)
    streamed, sample = two_ways(y, 2.0)
    assert streamed.mean == pytest.approx(sample.mean, abs=1e-8)
    assert streamed.u == pytest.approx(sample.u, rel=1e-7)
    assert (streamed.minimum, streamed.maximum) == (sample.minimum, sample.maximum)
    assert streamed.interval() == pytest.approx(sample.interval(), abs=2.0 / 1024)
    # the ends of a shortest interval wander, its width does not
    width = [high - low for low, high in (s.interval(0.95, "shortest") for s in (streamed, sample))]
    assert width[0] == pytest.approx(width[1], abs=4.0 / 1024)
    assert streamed.probability(-1, 3) == pytest.approx(sample.probability(-1, 3), abs=1e-4)
    assert streamed.histogram[1].sum() == 100_000 - int((np.abs(y - 0.5) >= 24).sum())
    # se of the 2.5 % quantile: 2 sqrt(0.025 * 0.975 / 1e5) / 0.030 (density of t_5 there) = 0.033; 0.05 < 2 se < 0.5
    assert streamed.digits() == sample.digits() == 1
    assert sample.numerical_error() == pytest.approx(0.033, rel=0.15)


def test_accumulator_does_not_depend_on_order_blocks_or_backend(monkeypatch):
    y = 1e3 * np.random.default_rng(3).standard_cauchy(50_000)  # trials beyond 12 and beyond 2048 scales
    one = Accumulator(0.0, 1e3)
    one.add(y)
    parts = [Accumulator(0.0, 1e3) for _ in range(3)]
    for i, block in enumerate(np.array_split(y[::-1], 11)):
        parts[i % 3].add(block)
    parts[0].merge(parts[2])
    parts[0].merge(parts[1])
    monkeypatch.setattr(streams, "kernels", lambda numbers: None)
    plain = Accumulator(0.0, 1e3)
    plain.add(y)
    for other in (parts[0], plain):
        assert (one.counts == other.counts).all()
        assert (one._first, one._second) == (other._first, other._second)
        assert one.summary().interval(0.9) == other.summary().interval(0.9)
    outside = int((np.abs(y) >= 12e3).sum())
    assert one.counts.sum() == 50_000
    assert abs(one.counts[0] + one.counts[-1] - outside) <= 1  # a trial within half a step of the edge
    assert f"{one.counts[0] + one.counts[-1]} of 50000 trials lie beyond" in one.summary().warnings[0]
    assert one.summary().u == pytest.approx(y.std(ddof=1), rel=1e-9)


def test_compiled_tally_is_the_numpy_tally(monkeypatch):
    fast = streams._load_kernels()
    if fast is None:
        pytest.skip("numba is not installed or cannot keep its cache")
    y = np.random.default_rng(5).standard_t(1.5, 20_000)
    results = []
    for backend in (None, fast):
        monkeypatch.setattr(streams, "kernels", lambda numbers, backend=backend: backend)
        a = Accumulator(0.1, 0.7)
        a.add(y)
        results.append(a)
    assert (results[0].counts == results[1].counts).all()
    assert (results[0]._first, results[0]._second) == (results[1]._first, results[1]._second)


def test_closed_form_u_replaces_that_of_the_sample():
    y = np.random.default_rng(6).standard_t(3, 10_000)
    s = summarise(y, u=math.sqrt(3))
    assert (s.u, s.exact_u) == (math.sqrt(3), True)
    endless = summarise(np.random.default_rng(6).standard_t(2, 1_000_000), u=math.inf)
    assert endless.u == math.inf
    assert endless.digits() >= 2  # the interval +-4.30 is known to better than 0.05
    assert endless.interval() == pytest.approx((-4.302653, 4.302653), abs=0.05)


def test_bad_trials_are_refused():
    with pytest.raises(ModelLimit, match="1 not finite"):
        summarise(np.array([1.0, np.nan, 2.0]))
    accumulator = Accumulator(0.0, 1.0)
    for bad in (np.nan, np.inf, 1e15):
        with pytest.raises(ModelLimit, match="do not fit the scale"):
            accumulator.add(np.array([0.0, bad]))
    with pytest.raises(ModelLimit, match="at least 2 trials"):
        accumulator.summary()
    with pytest.raises(UsageError, match="> 0"):
        Accumulator(0.0, 0.0)
    with pytest.raises(UsageError, match="cannot be merged"):
        accumulator.merge(Accumulator(0.0, 2.0))
    with pytest.raises(ModelLimit, match="run at least 500"):
        summarise(np.arange(100.0)).quantile(0.999)


def normal_trials(first: int, count: int) -> np.ndarray:
    return streams.draw(9, "y", np.zeros((1, 2)), Normal(2.0), first, count)[:, 0]


def test_adaptive_stops_when_stable():
    """u = 2.0, two digits: delta = 0.05. se of a 2.5 % quantile of 1e4 N trials is 2 * 2.67 / sqrt(1e4 N), twice
    that is below 0.05 at N = 4.6: stops after about 5 batches, and the ends are within delta of 3.92."""
    s = adaptive(normal_trials, digits=2, u0=2.0)
    assert 40_000 <= s.trials <= 150_000
    assert s.trials % 10_000 == 0
    assert s.interval() == pytest.approx((-3.919928, 3.919928), abs=0.05)
    assert not s.warnings
    assert adaptive(normal_trials, digits=1).trials == 20_000


def test_adaptive_says_when_it_does_not_converge():
    s = adaptive(normal_trials, digits=4, most=50_000)
    assert s.trials == 50_000
    assert "did not reach 4 stable digits" in s.warnings[-1]


def test_constant_output():
    s = adaptive(lambda first, count: np.full(count, 7.0))
    assert (s.mean, s.u, s.interval(), s.digits()) == (7.0, 0.0, (7.0, 7.0), 6)


def test_samples_with_a_mean_move_the_output():
    law = Samples(np.array([1.0, 2.0, 3.0]))
    block = next(
        simulate(np.array([10.0]), [Term("s", law, np.array([[2.0]]), lanes(1))], seed=1, trials=6000)
    )
    assert set(np.unique(block)) == {12.0, 14.0, 16.0}
    assert block.mean() == pytest.approx(14.0, abs=5 * 1.633 / math.sqrt(6000))


def test_lanes_meet_only_the_quantities_that_they_act_on(monkeypatch):
    """Scatter of touches moves their own feature: rows of zeros are left out, and no bit changes."""
    gain = np.zeros((7, 6))
    gain[3:5, :4], gain[6, 4:] = 2.0, 1.0
    assert montecarlo._acting(gain[:, :4]) == (3, 5)
    term = Term("scatter", Uniform(1.0), gain, lanes(6))
    few = np.concatenate(list(simulate(np.arange(7.0), [term], seed=3, trials=5000)))
    monkeypatch.setattr(montecarlo, "_acting", lambda rows: (0, len(rows)))
    assert np.array_equal(few, np.concatenate(list(simulate(np.arange(7.0), [term], seed=3, trials=5000))))
    assert np.array_equal(few[:, 0], np.zeros(5000))
    assert few[:, 6].std() > 0.5
