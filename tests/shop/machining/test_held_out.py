"""What was found in a part, in passes that it was not fitted to: against the normal law written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vcmm.shop.machining.held_out import (
    SIZE,
    HeldOutProof,
    _best_by_chance,
    _evidence,
    _held_out,
    _in_precision,
)

U = 0.5


def conditional(cov, y, test):
    """ln p(y[test] | the others) of a normal law without a mean, by the textbook formula."""
    rest = np.setdiff1d(np.arange(len(y)), test)
    gain = cov[np.ix_(test, rest)] @ np.linalg.inv(cov[np.ix_(rest, rest)])
    left = cov[np.ix_(test, test)] - gain @ cov[np.ix_(rest, test)]
    return multivariate_normal(gain @ y[rest], left).logpdf(y[test])


@pytest.fixture
def law():
    rng = np.random.default_rng(1)
    a = rng.normal(size=(12, 3))
    cov = U**2 * np.eye(12) + 0.3 * a @ a.T
    shape = rng.normal(size=12)
    return cov, shape, shape * 2.0 + np.linalg.cholesky(cov) @ rng.normal(size=12)


def test_evidence_by_pencil():
    """12 points, u = 0.5 each, a shape of ones, all observations 1: z = sqrt(12) / 0.5 = 6.93, z^2 = 48; (49/50 x 48 - ln 50) / 2 = 21.56."""
    precision = np.eye(12) / U**2
    q = _in_precision(precision, np.ones((12, 1)))
    assert _evidence(precision, q, np.ones((12, 1)))[0] == pytest.approx(21.564, abs=1e-3)


def test_evidence_and_held_out_gain_are_those_of_the_normal_law(law):
    cov, shape, y = law
    precision = np.linalg.inv(cov)
    q = _in_precision(precision, shape[:, None])
    wide = cov + SIZE**2 * q @ q.T
    both = [multivariate_normal(np.zeros(12), c).logpdf(y) for c in (wide, cov)]
    assert _evidence(precision, q, y[:, None])[0] == pytest.approx(both[0] - both[1])
    groups = [np.arange(0, 5), np.arange(5, 7), np.arange(7, 12)]
    by_hand = sum(conditional(wide, y, g) - conditional(cov, y, g) for g in groups)
    assert _held_out(precision, q, y[:, None], groups)[0] == pytest.approx(by_hand)


def test_what_one_pass_alone_shows_is_not_confirmed_by_the_others():
    """A shape that one pass has: no other pass says its size, so held out it loses the logarithm of what its prior widens."""
    cov = U**2 * np.eye(12)
    shape = np.zeros(12)
    shape[:4] = 1.0
    precision = np.linalg.inv(cov)
    q = _in_precision(precision, shape[:, None])
    y = np.zeros((12, 1))
    assert _held_out(precision, q, y, [np.arange(4), np.arange(4, 12)])[0] == pytest.approx(
        -0.5 * np.log(1.0 + SIZE**2)
    )


def test_the_threshold_counts_the_choice():
    """The best of many shapes reaches more by chance than one of them does."""
    rng = np.random.default_rng(2)
    precision = np.eye(30)
    draws = rng.normal(size=(30, 300))
    many = [rng.normal(size=(30, 1)) for _ in range(40)]
    one, best = (np.quantile(_best_by_chance(precision, s, draws), 0.99) for s in (many[:1], many))
    assert best > one + 1.0


def test_it_holds_beyond_chance_and_where_no_pass_speaks_against_it():
    proof = HeldOutProof(
        evidence=9.0,
        threshold=6.0,
        gain=2.0,
        visible_square=1.0,
        rigid_square=0.0,
        largest=0.0,
        shift=(0.0, 0.0, 0.0),
    )
    assert proof.holds
    assert not HeldOutProof(5.0, 6.0, 2.0, 1.0, 0.0, 0.0, (0.0, 0.0, 0.0)).holds
    assert not HeldOutProof(9.0, 6.0, -1.5, 1.0, 0.0, 0.0, (0.0, 0.0, 0.0)).holds
