"""The filter, rates, jumps and alarms against numbers by pencil and against regressions that share nothing with them."""

import math

import numpy as np
import pytest

from vcmm.learn.tracking import alarms, changes, rates
from vcmm.learn.tracking.kalman import GaussianState, advance, condition, innovation


def one(mean, u):
    return GaussianState(np.array([mean]), np.array([[u]]))


def test_one_number_by_pencil():
    # prior 0 +- 2, reading 3 +- 1: mean 3 x 4 / 5 = 2.4, variance 4 / 5
    after = condition(one(0.0, 2.0), innovation(one(0.0, 2.0), np.eye(1), np.array([3.0])))
    assert after.mean[0] == pytest.approx(2.4)
    assert after.covariance[0, 0] == pytest.approx(0.8)
    # a year of a walk of 1 in a year: 0.8 + 1
    assert advance(after, np.ones(1), np.ones(1)).covariance[0, 0] == pytest.approx(1.8)


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


def test_walk_and_swing_are_the_regression_with_their_covariance():
    """Readings of b + w at irregular days: a Gaussian process with cov = p0 + walk^2 min(t, s) / year + swing^2 exp(-|t - s| / tau)."""
    walk, swing, tau, p0 = 1.5, 0.7, 30.0, 2.0
    days, y = np.array([0.0, 3.0, 40.0, 41.0, 300.0]), np.array([1.0, -0.5, 2.0, 2.2, 0.3])
    motion = rates.WanderingMotion(
        np.array([0.0, walk, 0.0]), np.array([0.0, 0.0, swing]), np.array([1.0, 1.0, tau])
    )
    state = GaussianState(np.zeros(3), np.diag([math.sqrt(p0), 0.0, swing]))
    before = 0.0
    for day, value in zip(days, y):
        state = motion.step(state, day - before)
        state = condition(state, innovation(state, np.ones((1, 3)), np.array([value])))
        before = day
    state = motion.step(state, 60.0)
    when = np.append(days, 360.0)
    gap, least = np.abs(when[:, None] - when), np.minimum(when[:, None], when)
    cov = p0 + walk**2 * least / 365.25 + swing**2 * np.exp(-gap / tau)
    gain = np.linalg.solve(cov[:5, :5] + np.eye(5), cov[:5, 5])
    assert state.mean.sum() == pytest.approx(gain @ y)
    assert state.covariance.sum() == pytest.approx(cov[5, 5] - gain @ cov[:5, 5])


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
    assert new.changed == (("k", pytest.approx(weights[1] + weights[2])),)
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


def test_the_prior_of_a_rate_is_bounded_and_its_mean_is_that_of_the_grid():
    levels = range(len(rates.WALKS))
    logs = np.array([rates.GroupRates(k).log_prior for k in levels])
    # log2: -7 for none, else -6 .. 3; exp(-((x + 2) / 2)^2 / 2)
    x = np.array([-7, *range(-6, 4)])
    weight = np.exp(-(((x + 2) / 2) ** 2) / 2)
    square = np.where(x == -7, 0.0, 4.0**x)
    assert rates.mean_walk(logs, levels) == pytest.approx(math.sqrt((weight * square).sum() / weight.sum()))
    assert max(rates.WALKS) == 8.0
