"""Whitening, evidence and posterior against numbers worked by hand and against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.evaluation.gaussian import (
    blocks,
    condition,
    innovations,
    left_beside,
    log_density,
    log_evidence,
    orthonormal,
    posterior,
    whitener,
)
from vcmm.core.errors import ModelLimit

NONE = np.zeros((4, 0))


def test_nuisance_is_projected_out():
    # u = 2, values 2 4 6 8 -> 1 2 3 4; less their mean 2.5
    w = whitener(np.full(4, 2.0), np.ones((4, 1)), NONE)
    assert np.allclose(w.apply(np.array([2.0, 4.0, 6.0, 8.0])), [-1.5, -0.5, 0.5, 1.5])
    assert w.dof == 3


def test_calibration_is_shrunk_by_hand():
    # covariance I + c c^T with c = (3, 0, 0, 0) / u = 1: the first value is divided by sqrt(1 + 9)
    w = whitener(np.ones(4), NONE, np.array([[3.0], [0.0], [0.0], [0.0]]))
    assert np.allclose(w.apply(np.array([1.0, 1.0, 1.0, 1.0])), [10**-0.5, 1.0, 1.0, 1.0])


def test_whitening_gives_the_dense_mahalanobis_distance():
    rng = np.random.default_rng(1)
    c, u, x = rng.standard_normal((6, 2)), rng.uniform(0.5, 2, 6), rng.standard_normal(6)
    w = whitener(u, np.zeros((6, 0)), c)
    dense = x @ np.linalg.solve(np.diag(u**2) + c @ c.T, x)
    assert w.apply(x) @ w.apply(x) == pytest.approx(dense, rel=1e-10)


def test_autoregressive_filter_whitens():
    # rho = 0.6: (1 - 0.6 x 1) / sqrt(1 - 0.36) = 0.4 / 0.8 = 0.5; the first stays 1
    before = np.array([-1, 0, 1])
    assert np.allclose(innovations(np.ones(3), before, 0.6), [1.0, 0.5, 0.5])


def test_evidence_by_hand():
    # x = (1, 1, 0, 0), r = (1, 1, 1, -1), s = 1: G = 2, b = 2, q = 4 / 3, R = 4
    # ln BF = -ln(3) / 2 - 2 ln(1 - 1/3) = -0.549306 + 0.810930 = 0.261624
    found = blocks(np.array([[1.0], [1.0], [0.0], [0.0]]), np.array([0]))
    r = np.array([[1.0], [1.0], [1.0], [-1.0]])
    assert log_evidence(found, r, 4, (1.0,))[0, 0] == pytest.approx(0.261624, abs=1e-6)


def test_groups_of_columns_agree_with_dense_algebra():
    rng = np.random.default_rng(2)
    x, r, s = rng.standard_normal((20, 5)), rng.standard_normal((20, 3)), 2.0
    found = blocks(x, np.array([0, 3]))
    for group, columns in enumerate((x[:, :3], x[:, 3:])):
        k = columns.shape[1]
        gram = columns.T @ columns
        b = columns.T @ r
        q = np.einsum("km,km->m", b, np.linalg.solve(gram + np.eye(k) / s**2, b))
        wanted = -0.5 * np.linalg.slogdet(np.eye(k) + s**2 * gram)[1] - 10 * np.log(
            1 - q / (r * r).sum(axis=0)
        )
        assert np.allclose(log_evidence(found, r, 20, (s,))[group], wanted)


def test_posterior_is_least_squares_under_a_wide_prior():
    rng = np.random.default_rng(3)
    x = rng.standard_normal((50, 2))
    r = x @ [1.0, -2.0] + 0.1 * rng.standard_normal(50)
    fit = posterior(x, r, 50, np.full(2, 1e4))
    wanted = np.linalg.lstsq(x, r, rcond=None)[0]
    assert np.allclose(fit.mean, wanted, atol=1e-6)
    rest = r - x @ wanted
    assert fit.sigma == pytest.approx(np.sqrt(rest @ rest / 50), rel=1e-4)
    assert np.allclose(fit.covariance, fit.sigma**2 * np.linalg.inv(x.T @ x), rtol=1e-4)


def test_too_few_rows_and_missing_noise_are_refused():
    with pytest.raises(ModelLimit, match="cannot carry 2 nuisance"):
        whitener(np.ones(4), np.eye(4)[:, :2], NONE)
    with pytest.raises(ModelLimit, match="observation 2 has no standard uncertainty"):
        whitener(np.array([1.0, 0.0]), np.zeros((2, 0)), np.zeros((2, 0)))


def test_a_number_given_two_readings_by_hand():
    """x = (1, 1), r = (3, 1), prior 2 z: covariance of r = [[5, 4], [4, 5]], determinant 9, r' C^-1 r = (45 - 24 + 5) / 9 = 26 / 9;
    mean 4 / (2 + 1 / 4) = 16 / 9, variance 1 / (2 + 1 / 4) = 4 / 9."""
    x, r = np.ones((2, 1)), np.array([3.0, 1.0])
    for factor in (np.array([2.0]), np.array([[2.0]])):
        told = condition(x.T @ x, x.T @ r, factor)
        assert told.mean == pytest.approx([16 / 9])
        assert told.covariance == pytest.approx(np.array([[4 / 9]]))
        assert told.log_det == pytest.approx(np.log(9.0))
        assert float(told.gain) == pytest.approx(10 - 26 / 9)
    assert log_density(r, x, np.array([[2.0]])) == pytest.approx(-0.5 * (26 / 9 + np.log(9.0)))
    assert log_density(np.stack([r, 2 * r], axis=1), x, np.array([[2.0]])) == pytest.approx(
        [-0.5 * (26 / 9 + np.log(9.0)), -0.5 * (4 * 26 / 9 + np.log(9.0))]
    )


def test_a_factor_of_fewer_columns_ties_numbers_together():
    """Two numbers that are one, F = (1, 1)': readings 2 and 4 of each by itself give both 6 / 3."""
    told = condition(np.eye(2), np.array([2.0, 4.0]), np.ones((2, 1)))
    assert told.mean == pytest.approx([2.0, 2.0])
    assert told.covariance == pytest.approx(np.full((2, 2), 1 / 3))


def test_what_columns_leave_and_span():
    """(3, 4) beside (1, 0) leaves (0, 4); (1, 0), (1, 1e-12) and nothing span one direction."""
    assert left_beside(np.array([3.0, 4.0]), np.array([[1.0], [0.0]])) == pytest.approx([0.0, 4.0])
    assert orthonormal(np.array([[1.0, 1.0, 0.0], [0.0, 1e-12, 0.0]])).shape == (2, 1)
