"""vcmm.core.laws: moments, quantiles and characteristic functions against closed forms and each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vcmm.core.errors import UsageError
from vcmm.core.laws import (
    Arcsine,
    CurvilinearTrapezoidal,
    Law,
    MultivariateNormal,
    MultivariateSamples,
    Normal,
    Samples,
    StudentT,
    Trapezoidal,
    Triangular,
    Uniform,
    row_factor,
)

SYMMETRIC: list[Law] = [
    Normal(2.0),
    StudentT(0.5, 5.0),
    Uniform(3.0),
    Triangular(1.0),
    Trapezoidal(2.0, 0.5),
    Trapezoidal(2.0, 2.0),
    Arcsine(0.5),
    CurvilinearTrapezoidal(1.0, 0.3),
    CurvilinearTrapezoidal(1.0, 0.0),
]


@pytest.mark.parametrize(
    ("law", "u"),
    [
        (Normal(0.4), 0.4),
        (StudentT(0.2, 3.0), 0.346410),  # 0.2 sqrt(3 / 1) = 0.346410
        (StudentT(0.2, 13.0), 0.217423),  # 0.2 sqrt(13 / 11) = 0.2 * 1.087115
        (StudentT(0.2, 2.0), math.inf),
        (StudentT(0.2, 1.0), math.inf),
        (Uniform(3.0), 1.732051),  # 3 / sqrt 3
        (Triangular(3.0), 1.224745),  # 3 / sqrt 6
        (Trapezoidal(2.0, 0.5), 0.841625),  # sqrt((4 + 0.25) / 6) = sqrt(0.708333)
        (Arcsine(0.5), 0.353553),  # 0.5 / sqrt 2
        (CurvilinearTrapezoidal(0.05, 0.025), 0.0300463),  # sqrt(0.0025/3 + 0.000625/9) = sqrt(9.02778e-4)
        (Samples(np.array([1.0, 2.0, 6.0])), 2.160247),  # mean 3, squares 4 1 9, sqrt(14 / 3)
    ],
    ids=lambda v: getattr(v, "name", None),
)
def test_standard_deviation(law: Law, u: float):
    assert law.u == pytest.approx(u, rel=2e-6)


def test_budget_words_and_degrees_of_freedom():
    assert StudentT(1.0, 13.0).name == "t, nu = 13"
    assert StudentT(1.0, 13.0).dof == 13
    assert Normal(1.0).dof == Uniform(1.0).dof == math.inf
    assert Samples(np.array([1.0, 2.0, 6.0])).mean == 3.0
    assert Uniform(1.0).mean == 0.0


def test_quantiles_by_hand():
    assert Normal(2.0).quantile(0.975) == pytest.approx(2 * 1.959963985, rel=1e-9)
    assert StudentT(1.0, 13.0).quantile(0.975) == pytest.approx(2.160369, rel=1e-6)  # table of t
    assert StudentT(1.0, 1.0).isf(2.0**-32) == pytest.approx(2**32 / math.pi, rel=1e-9)  # Cauchy: 1 / (pi p)
    assert Uniform(3.0).quantile(0.75) == pytest.approx(1.5)
    assert Triangular(1.0).quantile(0.5 + 0.375) == pytest.approx(0.5)  # tail (1 - x)^2 / 2 = 0.125
    # base 2, plateau 1: density 1/3 on the plateau, tail (2 - x)^2 / 6 = 1/24 at x = 1.5
    assert Trapezoidal(2.0, 1.0).isf(1 / 24) == pytest.approx(1.5)
    assert Trapezoidal(2.0, 1.0).isf(1 / 3) == pytest.approx(0.5)  # 1/2 - x / 3
    assert Arcsine(0.5).quantile(5 / 6) == pytest.approx(0.5 * math.cos(math.pi / 6))
    # half width w uniform on [0.5, 1.5]: P(X > 0.5) = mean of (w - 0.5) / (2 w) = (1 - 0.5 ln 3) / 2 = 0.225347
    assert CurvilinearTrapezoidal(1.0, 0.5).isf(0.2253469) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("law", SYMMETRIC, ids=lambda law: law.name)
def test_cdf_inverts_quantile(law: Law):
    p = np.array([1e-6, 1e-3, 0.2, 0.5, 0.7, 0.999])
    np.testing.assert_allclose(law.cdf(law.quantile(p)), p, rtol=1e-7, atol=1e-10)
    np.testing.assert_allclose(law.quantile(p), -law.isf(p))
    assert law.shape.scale == 1.0
    assert law.shape.shape == law.shape
    np.testing.assert_allclose(law.isf(p), law.scale * law.shape.isf(p), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("law", SYMMETRIC, ids=lambda law: law.name)
def test_characteristic_function_is_the_mean_of_cos(law: Law):
    """Against the quantile function: cf(t) = integral of cos(t Q(p)) dp, with p = (1 - cos s) / 2 by midpoints."""
    s = (np.arange(20_000) + 0.5) * math.pi / 20_000
    p, weight = (1 - np.cos(s)) / 2, np.sin(s) * math.pi / 20_000
    t = np.array([0.0, 1e-3, 0.5, 2.0, 7.0]) / law.scale
    mean = np.cos(np.multiply.outer(t, law.quantile(p))) @ (weight / 2)
    np.testing.assert_allclose(law.cf(t), mean, atol=2e-5)
    grid = np.linspace(0, 80, 4001) / law.scale
    assert (np.abs(law.cf(grid)) <= law.bound(grid) + 1e-10).all()
    assert (np.diff(law.bound(grid)) <= 1e-12).all()


@pytest.mark.parametrize("dof", [1.0, 1.5, 2.0, 3.0, 4.0, 13.0, 60.0])
def test_cf_of_t_is_the_bessel_form(dof: float):
    from scipy.special import gammaln, kve

    t = np.array([0.03, 0.3, 1.0, 2.5, 9.0])
    a, z = dof / 2, math.sqrt(dof) * t
    log_cf = np.log(kve(a, z)) - z + a * np.log(z) - gammaln(a) - (a - 1) * math.log(2)
    np.testing.assert_allclose(StudentT(1.0, dof).log_cf(t[:4]), log_cf[:4], rtol=1e-10)
    np.testing.assert_allclose(StudentT(1.0, dof).cf(t), np.exp(log_cf), atol=1e-14)


def test_cf_of_t_where_the_bessel_form_fails():
    # small t, nu > 4: ln cf = -t^2 nu / (2 (nu - 2)) to order t^4; nu = 9: 9 / 14 * 1e-12
    assert StudentT(1.0, 9.0).log_cf(1e-6) == pytest.approx(-9 / 14 * 1e-12, rel=1e-9)
    assert StudentT(1.0, 1.0).log_cf(1e-6) == pytest.approx(-1e-6, rel=1e-9)  # Cauchy: exp(-|t|)
    assert StudentT(1.0, 1e6).log_cf(1.0) == pytest.approx(-0.5 * 1e6 / (1e6 - 2), rel=1e-6)
    # nu = 3: cf = (1 + sqrt 3 t) exp(-sqrt 3 t)
    assert StudentT(1.0, 3.0).log_cf(8.0) == pytest.approx(
        math.log(1 + 13.8564064606) - 13.8564064606, rel=1e-9
    )


def test_samples_are_an_exact_empirical_law():
    law = Samples(np.array([5.0, 1.0, 3.0, 3.0]))
    np.testing.assert_array_equal(law.cdf([0.9, 1.0, 3.0, 4.9, 5.0]), [0, 0.25, 0.75, 0.75, 1])
    np.testing.assert_array_equal(law.quantile([0.1, 0.25, 0.26, 0.75, 0.76, 1.0]), [1, 1, 3, 3, 5, 5])
    assert law.isf(0.24) == 5.0


def test_cf_of_samples_keeps_mean_and_u():
    law = Samples(np.random.default_rng(1).exponential(size=5000))
    t = np.array([0.0, 0.01, 0.5, 3.0])
    exact = np.exp(1j * np.multiply.outer(t, law.values)).mean(axis=1)
    np.testing.assert_allclose(law.cf(t), exact, atol=2e-5)
    h = 1e-4
    assert law.cf(np.array([h]))[0].imag / h == pytest.approx(law.mean, rel=1e-6)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Normal(-1.0), "u = -1.0"),
        (lambda: Normal(math.nan), "finite"),
        (lambda: StudentT(1.0, 0.5), "dof = 0.5"),
        (lambda: Trapezoidal(1.0, 1.5), "top = 1.5"),
        (lambda: CurvilinearTrapezoidal(1.0, 1.0), "inexact = 1.0"),
        (lambda: Samples(np.array([1.0])), "at least 2"),
        (lambda: Samples(np.array([1.0, math.inf])), "finite"),
        (lambda: MultivariateNormal(np.array([[1.0, 0.5], [0.4, 1.0]])), "symmetric"),
        (lambda: MultivariateNormal(np.array([[1.0, 2.0], [2.0, 1.0]])), "positive semidefinite"),
        (lambda: MultivariateNormal(np.array([[1.0, np.nan], [np.nan, 1.0]])), "finite"),
        (lambda: MultivariateNormal(-np.eye(2)), "variances >= 0"),
        (lambda: MultivariateSamples(np.ones(5)), "rows"),
    ],
)
def test_impossible_laws_are_refused(make, words: str):
    with pytest.raises(UsageError, match=words):
        make()


def test_zero_width_is_allowed():
    assert Normal(0.0).cdf([-1.0, 0.0, 1.0]).tolist() == [0, 1, 1]
    assert Trapezoidal(0.0, 0.0).u == CurvilinearTrapezoidal(0.0, 0.0).u == 0
    assert Uniform(0.0).quantile(0.9) == 0


def test_factor_by_hand():
    # Cholesky of [[4, 2], [2, 5]]: l11 = 2, l21 = 2/2 = 1, l22 = sqrt(5 - 1) = 2
    law = MultivariateNormal(np.array([[4.0, 2.0], [2.0, 5.0]]))
    np.testing.assert_allclose(law.factor, [[2, 0], [1, 2]], atol=1e-12)
    np.testing.assert_allclose(law.u, [2, math.sqrt(5)])
    # gain (1, -1): variance 4 - 2 * 2 + 5 = 5
    assert law.project(np.array([1.0, -1.0])).u == pytest.approx(math.sqrt(5))


def test_rounding_does_not_spoil_symmetry():
    assert MultivariateNormal(np.array([[1.0, 1e-17], [0.0, 1.0]])).factor.shape == (2, 2)


def test_null_directions_are_dropped():
    a = np.array([[1.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 0.0], [3.0, -2.0]])
    law = MultivariateNormal(a @ a.T)
    assert law.factor.shape == (5, 2)
    np.testing.assert_allclose(law.factor @ law.factor.T, a @ a.T, atol=1e-9)


def test_smooth_process_covariance_is_reproduced():
    """Squared-exponential covariance of 40 nodes: numerically of rank about 15, the worst case for factors."""
    q = np.linspace(0, 400, 40)
    covariance = 0.4e-3**2 * np.exp(-(np.subtract.outer(q, q) ** 2) / (2 * 150**2))
    factor = MultivariateNormal(covariance).factor
    assert factor.shape[1] < 20
    np.testing.assert_allclose(factor @ factor.T, covariance, atol=2e-6 * 0.4e-3**2)


@given(arrays(float, (4, 6), elements=st.floats(-10, 10, width=32)))
@settings(max_examples=100, deadline=None, derandomize=True)
def test_row_factor_keeps_every_product(gain):
    factor = row_factor(gain)
    assert factor.shape[1] <= 4
    size = np.linalg.norm(gain, axis=1)
    assert (np.abs(factor @ factor.T - gain @ gain.T) <= 1e-9 * np.outer(size, size)).all()


def test_row_factor_does_not_look_ahead():
    gain = np.random.default_rng(2).normal(size=(5, 9))
    np.testing.assert_array_equal(row_factor(gain)[:3, :3], row_factor(gain[:3]))
    # differences of nearly equal outputs survive: rows 1e-9 apart
    twin = np.stack([gain[0], gain[0] + 1e-9 * gain[1]])
    factor = row_factor(twin)
    assert np.linalg.norm(factor[1] - factor[0]) == pytest.approx(1e-9 * np.linalg.norm(gain[1]), rel=1e-5)


def test_joint_samples():
    law = MultivariateSamples(np.array([[0.0, 1.0], [2.0, 5.0]]))
    np.testing.assert_allclose(law.mean, [1, 3])
    np.testing.assert_allclose(law.covariance, [[1, 2], [2, 4]])
    np.testing.assert_allclose(law.u, [1, 2])
    np.testing.assert_allclose(law.project(np.array([1.0, 1.0])).values, [1, 7])


def test_the_bound_of_a_sample_holds_its_characteristic_function():
    """Values spread over bins of width w: |sin(w t / 2) / (w t / 2)| is at most 2 / (w t), and never more than 1."""
    law = Samples(np.array([-1.0, 0.0, 0.5, 2.0]))
    width = law._bins[2]
    t = np.concatenate([[0.0, 0.1, 1.0], np.array([2.0, 20.0, 200.0]) / width])
    assert law.bound(t) == pytest.approx([1.0, 1.0, 1.0, 1.0, 0.1, 0.01])
    assert (np.abs(law.cf(t)) <= law.bound(t) + 1e-12).all()


def test_many_quantities_of_few_directions():
    """cos(x_i - x_j) has two directions: with the first as reference its triangular factor is (cos, sin) of x_i - x_0."""
    x = np.linspace(0.0, 6.0, 300)
    factor = MultivariateNormal(4.0 * np.cos(x[:, None] - x)).factor
    assert factor.shape == (300, 2)
    np.testing.assert_allclose(factor, 2.0 * np.stack([np.cos(x), np.sin(x)], axis=1), atol=1e-6)


def test_many_quantities_with_a_covariance_that_is_none_are_refused():
    x = np.linspace(0.0, 6.0, 300)
    covariance = np.cos(x[:, None] - x)
    covariance[250, 30] = covariance[30, 250] = 0.99  # of two directions this pair has -0.29
    with pytest.raises(UsageError, match="not positive semidefinite"):
        MultivariateNormal(covariance)


def test_many_independent_quantities_keep_their_directions():
    assert MultivariateNormal(np.diag(np.full(250, 9.0))).factor == pytest.approx(3.0 * np.eye(250))


def test_the_bound_of_a_curvilinear_trapezoid_is_the_greatest_sine_integral():
    """|Si(a) - Si(b)| <= Si(pi) = 1.852, so the mean of sin(w t) / (w t) is at most 1.852 / (2 d t) for a half width of 1 +- d."""
    law, t = CurvilinearTrapezoidal(1.0, 0.9), np.array([np.pi / 1.9])  # 1.653: 1.9 t = pi
    # 1.852 / (2 x 0.9 x 1.6535) = 0.6222; (1.8519 - Si(0.16535) = 0.1651) / 2.9763 = 0.5668 lies below
    assert law._bound(t) == pytest.approx([0.6222], abs=2e-4)
    assert law._cf(t) == pytest.approx([0.5668], abs=2e-4)
    far = np.linspace(0.1, 60.0, 600)
    assert (np.abs(law._cf(far)) <= law._bound(far) * (1 + 1e-3)).all()
