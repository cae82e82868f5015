"""The filter, rates, jumps and alarms against numbers by pencil and against regressions that share nothing with them."""

import math

import numpy as np
import pytest

import vcmm
from tests.learn.tracking.small_folder import write_machine
from vcmm.learn.tracking import alarms, changes, rates
from vcmm.learn.tracking.compress import SeenRecording
from vcmm.learn.tracking.evidence import log_likelihoods
from vcmm.learn.tracking.kalman import GaussianState, advance, chance_beyond, condition, innovation, square_at
from vcmm.learn.tracking.learn_rates import columns_for, is_due
from vcmm.learn.tracking.quantities import tracked_machine


def one(mean, u):
    return GaussianState(np.array([mean]), np.array([[u]]))


def test_one_number_by_pencil():
    # prior 0 +- 2, reading 3 +- 1: mean 3 x 4 / 5 = 2.4, variance 4 / 5
    after = condition(one(0.0, 2.0), innovation(one(0.0, 2.0), np.eye(1), np.array([3.0])))
    assert after.mean[0] == pytest.approx(2.4)
    assert after.covariance[0, 0] == pytest.approx(0.8)
    # a year of a walk of 1 in a year: 0.8 + 1
    assert advance(after, np.ones(1)).covariance[0, 0] == pytest.approx(1.8)


def test_several_numbers_as_the_normal_equations_have_it():
    rng = np.random.default_rng(3)
    factor, columns, value = rng.normal(size=(5, 7)), rng.normal(size=(9, 5)), rng.normal(size=9)
    state = GaussianState(rng.normal(size=5), factor)
    after = condition(state, innovation(state, columns, value))
    information = np.linalg.inv(factor @ factor.T) + columns.T @ columns
    mean = np.linalg.solve(information, np.linalg.solve(factor @ factor.T, state.mean) + columns.T @ value)
    assert after.covariance == pytest.approx(np.linalg.inv(information), rel=1e-7)
    assert after.mean == pytest.approx(mean, rel=1e-7)


def test_a_very_exact_reading_leaves_no_negative_variance():
    state = GaussianState(np.zeros(2), np.diag([1e6, 1.0]))
    after = condition(state, innovation(state, np.array([[1e6, 1e6]]), np.array([1.0])))
    assert np.linalg.eigvalsh(after.covariance).min() >= -1e-9
    # var(a - b) stays, var(a + b) = 1e-12: a has nearly the variance of b
    assert after.covariance[0, 0] == pytest.approx(1.0, rel=1e-3)


def test_walk_trend_season_and_swing_are_the_regression_with_their_covariance():
    """Readings of z + b + w + s at irregular days are a Gaussian process of the covariance, with a = 2 pi / year,

    p0 + walk^2 min(t, u) / year + trend^2 t u / year^2 + swing^2 exp(-|t - u| / tau)
       + season^2 (cos a(t - u) - cos at - cos au + 1)        of (A cos at + B sin at) - A, which is zero on the first day
    """
    year, p0 = 365.25, 2.0
    walk, trend, season, swing, tau = 1.5, 2.5, 1.2, 0.7, 30.0
    days, y = np.array([0.0, 3.0, 40.0, 41.0, 300.0]), np.array([1.0, -0.5, 2.0, 2.2, 0.3])
    motion = rates.WanderingMotion(1, *(np.array([v]) for v in (walk, trend, season, swing, tau)))
    columns = np.array([[math.sqrt(p0), 1.0, 1.0, 1.0, 0.0, 0.0, 1.0]])
    state, before = rates.first_state(motion), 0.0
    for day, value in zip(days, y):
        state = motion.step(state, day - before)
        state = condition(state, innovation(state, columns, np.array([value])))
        before = day
    kept, state = state, motion.step(state, 60.0)
    when = np.append(days, 360.0)
    t, u, a = when[:, None], when, 2 * math.pi / year
    cov = p0 + walk**2 * np.minimum(t, u) / year + trend**2 * t * u / year**2
    cov = cov + swing**2 * np.exp(-np.abs(t - u) / tau)
    cov = cov + season**2 * (np.cos(a * (t - u)) - np.cos(a * t) - np.cos(a * u) + 1)
    gain = np.linalg.solve(cov[:5, :5] + np.eye(5), cov[:5, 5])
    assert columns @ state.mean == pytest.approx(gain @ y)
    variance = (columns @ state.covariance @ columns.T)[0, 0]
    assert variance == pytest.approx(cov[5, 5] - gain @ cov[:5, 5])
    later = motion.later(kept.covariance, 60.0)
    assert later == pytest.approx(state.covariance, abs=1e-12)


def test_a_passing_change_goes_back_and_a_lasting_one_stays():
    # 3 usual sizes into p, seven days on: 3 e^-7; into b: 3; into w with a time constant of 30 d: 3 e^(-7 / 30), which is no day or a few
    motion = rates.WanderingMotion(0, *(np.array([v]) for v in (0.0, 0.0, 0.0, 0.5, 30.0)))
    later = motion.carry(np.array([3.0, 3.0, 0, 0, 0, 3.0]), 7.0)
    assert later[[0, 1, 5]] == pytest.approx([3.0, 3.0 * math.exp(-7 / 30), 3.0 * math.exp(-7)])


def test_a_passing_change_passes_whatever_swings(tmp_path):
    """Where a swing of 30 days was learnt, "everything, for a day or a few" still goes back in a day: it has numbers of its own."""
    tracked = tracked_machine(vcmm.load_machine(write_machine(tmp_path)))
    passing = next(j for j in changes.jumps_of(tracked) if j.name == changes.PASSING)
    own = tuple(rates.GroupRates(0.0, 0.0, 0.0, 5, 1) for _ in tracked.groups)
    motion = rates.motion_of(tracked.group_of_mode, tracked.stated, own)
    assert motion.carry(passing.columns, 7.0) == pytest.approx(math.exp(-7) * passing.columns)


@pytest.mark.parametrize("jumps", [True, False])
def test_the_evidence_by_covariances_is_that_of_the_filter(jumps):
    """Both forms of the filter over ten recordings with a jump among them, for rates with and without season, trend and swing at
    once: the likelihoods differ by rounding."""
    rng = np.random.default_rng(8)
    sizes = [(1.0, 0.5, 0.7, 0.3), (1.0, 0.5, 0.7, 0.0), (0.2, 0.0, 0.0, 0.0), (0.0, 2.0, 0.0, 0.0)]
    motions = [
        rates.WanderingMotion(2, *(np.array([v, v / 2]) for v in own), np.array([1.0, 30.0])) for own in sizes
    ]
    ones = np.eye(motions[0].size)
    hits = [changes.Jump("a", ones[:, 2:3]), changes.Jump("passing", ones[:, 12:14])] if jumps else []
    seen = []
    for day in range(10):
        columns = rng.normal(size=(3, 4))
        off = {3: 9.0 * columns.sum(axis=1), 6: 9.0 * columns[:, 2]}.get(day, 0.0)
        seen.append(SeenRecording("", 40.0 + 7.0 * day, columns, rng.normal(size=3) + off, 1.0, 1, 3, 0.0, 0))
    totals = []
    for motion in motions:
        state, total = rates.first_state(motion), 0.0
        for day, one in enumerate(seen):
            state = motion.step(state, 7.0 if day else 0.0)
            new = changes.update(state, columns_for(one, 2), one.value, hits, 7.0 if day else 0.0)
            state, total = new.state, total + new.log_likelihood
        totals.append(total)
    assert log_likelihoods(seen, motions, hits) == pytest.approx(totals, abs=1e-8)
    assert log_likelihoods(seen, motions[2:], hits) == pytest.approx(totals[2:], abs=1e-8)


def test_the_square_at_a_chance():
    # two degrees of freedom: exp(-x / 2) = 0.01 at x = 2 ln 100; one: 6.634897 (tables of chi-square, 0.99)
    assert square_at(2, 0.01) == pytest.approx(2 * math.log(100), rel=1e-14)
    assert square_at(1, 0.01) == pytest.approx(6.634897, abs=1e-6)
    for count in (1, 2, 7, 13):
        at = square_at(count, 0.01)
        assert chance_beyond(count, at) <= 0.01 < chance_beyond(count, at * (1 - 1e-12))


def test_a_jump_by_pencil():
    # 0 +- 0, reading 5 +- 1, ten days later: no change N(5; 0, 1); a jump of usual size 1 (or 4): N(5; 0, 2), N(5; 0, 17)
    state = GaussianState(np.zeros(1), np.zeros((1, 1)))
    jump = changes.Jump("k", np.eye(1))
    new = changes.update(state, np.eye(1), np.array([5.0]), [jump], 10.0)
    p = 1 - math.exp(-10 / 365.25)
    density = [math.exp(-12.5 / v) / math.sqrt(v) for v in (1.0, 2.0, 17.0)]
    weights = np.array([(1 - p) * density[0], p / 2 * density[1], p / 2 * density[2]])
    weights /= weights.sum()
    assert new.probability == pytest.approx(1 - weights[0])
    assert new.suspects == (("k", pytest.approx(weights[1] + weights[2])),)
    means = np.array([0.0, 5 / 2, 5 * 16 / 17])  # shrunk by 1 / (1 + 1) and 16 / (16 + 1)
    mean = weights @ means
    spread = weights @ (np.array([0.0, 1 / 2, 16 / 17]) + (means - mean) ** 2)
    assert new.state.mean[0] == pytest.approx(mean, rel=1e-3)  # below MATTERS nothing is joined
    assert new.state.covariance[0, 0] == pytest.approx(spread, rel=2e-3)


def test_all_recordings_together_spend_alpha():
    total = sum(alarms.level(k, 0.05) for k in range(1, 200_001))
    left = 0.05 / (alarms.SUM * math.log(200_001.5))  # integral of 1 / (x ln^2 x) from there on
    assert total + left == pytest.approx(0.05, rel=1e-6)


def test_an_alarm_is_as_rare_as_it_says():
    """White readings of a known state: chance below 0.05 in at most 5 % of 2000 draws (and not in none: Bonferroni of two tests)."""
    rng = np.random.default_rng(5)
    columns = rng.normal(size=(4, 3))
    state = GaussianState(np.zeros(3), np.diag([1.0, 2.0, 0.5]))
    jumps = [changes.Jump("a", np.eye(3)[:, :1])]
    root = np.linalg.cholesky(columns @ state.covariance @ columns.T + np.eye(4))
    hits = sum(
        alarms.chance_of(state, columns, root @ rng.normal(size=4), jumps)[0] < 0.05 for _ in range(2000)
    )
    assert 50 < hits < 100 + 3 * math.sqrt(2000 * 0.05 * 0.95)


def test_the_prior_of_a_rate_is_bounded_and_what_is_used_is_its_root_mean_square():
    # log2 of a walk: -7 for none, else -6 .. 3; exp(-((x + 2) / 2)^2 / 2)
    x = np.array([-7, *range(-6, 4)])
    weight = np.exp(-(((x + 2) / 2) ** 2) / 2)
    square = np.where(x == -7, 0.0, 4.0**x)
    found = rates.root_mean_square(rates.log_priors("walk"), np.array(rates.WALKS))
    assert found == pytest.approx(math.sqrt((weight * square).sum() / weight.sum()))
    assert max(rates.WALKS) == 8.0
    # a season: half at zero, half over 2^-5 .. 2^1
    x = np.arange(-5, 2)
    weight = np.exp(-(((x + 2) / 2) ** 2) / 2)
    found = rates.root_mean_square(rates.log_priors("season"), np.array(rates.SEASONS))
    assert found == pytest.approx(math.sqrt(0.5 * (weight * 4.0**x).sum() / weight.sum()))


def test_rates_are_learnt_ever_more_seldom():
    assert [k for k in range(1, 100) if is_due(k)] == [3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96]


def test_the_mixture_of_rates_holds_what_it_says():
    """Bands of u from the root mean square of a rate whose levels are drawn by their probabilities hold 95 % within a few per cent.

    x ~ N(0, r^2), r of 0.5, 1, 2 by 1/4, 1/2, 1/4: u^2 = (0.25 + 2 + 4) / 4 = 1.5625. P(|x| < 1.96 x 1.25) = 1 / 4 (1 + 0.9857 x 2 + 0.7794)
    """
    logs, levels = np.log([0.25, 0.5, 0.25]), np.array([0.5, 1.0, 2.0])
    u = rates.root_mean_square(logs, levels)
    assert u == pytest.approx(1.25)
    share = sum(p * math.erf(1.96 * u / r / math.sqrt(2)) for p, r in zip((0.25, 0.5, 0.25), levels))
    assert share == pytest.approx((1 + 0.98571 * 2 + 0.77942) / 4, abs=1e-4)  # 0.938


def test_the_chance_of_a_sum_of_squares():
    from scipy.special import chdtrc

    assert chance_beyond(2, 6.0) == pytest.approx(math.exp(-3))  # e^-h
    assert chance_beyond(1, 3.841459) == pytest.approx(0.05, rel=1e-5)
    for count, square in ((1, 0.1), (3, 7.0), (10, 200.0), (337, 350.0), (338, 1.0), (5, 0.0)):
        assert chance_beyond(count, square) == pytest.approx(chdtrc(count, square), rel=1e-10)


def test_a_scale_is_a_shape_of_a_table(tmp_path):
    # a new encoder makes a straight line; the smooth modes alone left 0.04 um of 15 um beside a second mode of 2.6
    machine = write_machine(tmp_path)
    text = machine.read_text()
    (tmp_path / "errors.csv").write_text("X EXX\n" + "".join(f"{q} 0\n" for q in range(0, 501, 100)))
    head = text[: text.index("[[effects]]")]
    machine.write_text(f'{head}[errors]\ntable = "errors.csv"\nuncertainty = {{ translation = "2 um" }}\n')
    tracked = tracked_machine(vcmm.load_machine(machine))
    shape = next(q for q in tracked.quantities if q.effect.where == "EXX").shape
    # positions less their mean, of unit rms times the usual size: (-250 ... 250) / 170.78, for (250^2 + 150^2 + 50^2) / 3 = 170.78^2
    line = np.linspace(-250.0, 250.0, 6) / np.sqrt((250**2 + 150**2 + 50**2) / 3)
    assert shape[:, 0] / np.sqrt((shape[:, 0] ** 2).mean()) == pytest.approx(line)
    assert shape[:, 1:].T @ line == pytest.approx(0.0, abs=1e-12)  # bends stand beside it
