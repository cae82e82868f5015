"""vcmm.answer.evaluation.interval: distributions of sums against closed forms, published values, scipy's t and Monte Carlo."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.answer.evaluation.interval import Linear, _panels, _sum_log_cf
from vcmm.core.errors import UsageError
from vcmm.core.laws import Arcsine, Law, Normal, Samples, StudentT, Trapezoidal, Triangular, Uniform

ONE = np.ones(1)
TINY = (Normal(1e-9), ONE)  # keeps a lone law from being used directly: the inversion must find it


def test_normal_sum_is_exact():
    law = Linear(10.0, [(Normal(3.0), ONE), (Normal(1.0), np.array([-4.0]))])  # u = sqrt(9 + 16) = 5
    assert law.u == pytest.approx(5.0)
    low, high = law.interval(0.95)
    assert (low, high) == pytest.approx((10 - 9.79981992, 10 + 9.79981992), abs=1e-8)
    assert law.probability(5.0, 15.0) == pytest.approx(0.6826894921, abs=1e-10)  # +-1 sigma
    assert law.scale == pytest.approx(5.0, rel=0.04)


def test_a_probability_far_out_is_never_negative():
    """The difference of two values of the inversion is off by 1e-12 either way, which is no probability."""
    law = Linear(0.0, [(StudentT(1.0, 13.0), ONE), (StudentT(0.7, 13.0), ONE), (Normal(0.3), ONE)])
    far = np.linspace(20, 200, 40)
    assert min(float(law.cdf(x + 0.5)) - float(law.cdf(x)) for x in far) < 0
    assert all(0 <= law.probability(x, x + 0.5) < 1e-6 for x in far)


@pytest.mark.parametrize("dof", [1.0, 1.5, 2.0, 3.0, 4.0, 9.0, 30.0])
@pytest.mark.parametrize("p", [0.6, 0.975, 0.999])
def test_lone_t_through_the_inversion(dof: float, p: float):
    from scipy.special import stdtrit

    law = Linear(0.0, [(StudentT(1.0, dof), ONE), TINY])
    assert law.quantile(p) == pytest.approx(stdtrit(dof, p), rel=1e-7)
    assert law.quantile(1 - p) == pytest.approx(-stdtrit(dof, p), rel=1e-7)


def test_sum_of_cauchy_laws_is_cauchy():
    """t with nu = 1: scales add, 3 + 2 = 5. No standard deviation: u is inf, the interval is finite."""
    law = Linear(1.0, [(StudentT(3.0, 1.0), ONE), (StudentT(1.0, 1.0), np.array([-2.0]))])
    assert law.u == math.inf
    assert law.interval(0.99) == pytest.approx(
        (1 - 5 * 63.6567412, 1 + 5 * 63.6567412), rel=1e-7
    )  # tan(0.495 pi)
    x = np.array([0.0, 6.0, 300.0, 5e3, 1e7])
    expected = 0.5 + np.arctan((x - 1) / 5) / math.pi
    np.testing.assert_allclose(law.cdf(x), expected, atol=3e-8)


@pytest.mark.parametrize(
    ("gains", "half"),
    [
        # sum of two uniforms +-1: triangle +-2, (2 - x)^2 / 8 = 0.025 -> 2 - sqrt 0.2
        ([(Uniform(1.0), np.ones(2))], 2 - math.sqrt(0.2)),
        ([(Uniform(1.5), ONE), (Uniform(0.5), ONE)], float(Trapezoidal(2.0, 1.0).quantile(0.975))),
        # JCGM 101, 9.2.3: four rectangular laws of u = 1: 2 sqrt 3 (2 - (3/5)^(1/4)) = 3.879407
        ([(Uniform(math.sqrt(3)), np.ones(4))], 2 * math.sqrt(3) * (2 - 0.6**0.25)),
        # JCGM 101, 9.2.4: one of them has u = 10; published +-17.0, exact value by convolution of polynomials
        ([(Uniform(math.sqrt(3)), np.array([1.0, 1.0, 1.0, 10.0]))], 17.015814),
    ],
    ids=["triangle", "trapezoid", "9.2.3", "9.2.4"],
)
def test_sums_of_rectangular_laws(gains: list[tuple[Law, np.ndarray]], half: float):
    law = Linear(0.0, gains)
    for kind in ("symmetric", "shortest"):
        low, high = law.interval(0.95, kind)
        assert (low, high) == pytest.approx((-half, half), abs=1e-6)


def test_bounded_law_with_a_little_noise():
    law = Linear(0.0, [(Uniform(1.0), ONE), (Normal(1e-3), ONE)])
    assert law.quantile(0.975) == pytest.approx(0.95, abs=1e-8)  # the noise acts at the edges only
    assert law.probability(-1.1, 1.1) == pytest.approx(1.0, abs=1e-8)
    assert law.cdf([-5.0, 5.0]).tolist() == pytest.approx([0, 1], abs=1e-8)


def test_two_arcsine_laws():
    """Density of the sum of two sine waves is K(sqrt(1 - x^2/4)) / pi^2; its slow cf is the hard case."""
    from scipy.integrate import quad
    from scipy.special import ellipk

    law = Linear(0.0, [(Arcsine(1.0), np.ones(2))])
    beyond, _ = quad(lambda x: ellipk(1 - x * x / 4) / math.pi**2, 1.5, 2.0)
    assert law.cdf(-1.5) == pytest.approx(beyond, abs=1e-6)
    assert law.u == pytest.approx(1.0)


def test_many_t_terms_equal_direct_product():
    """1000 terms by the interpolated table against the characteristic function itself."""
    rng = np.random.default_rng(5)
    gain, t = rng.exponential(size=1000), np.array([1e-3, 0.01, 0.05, 0.1])
    direct = StudentT(1.0, 4.0).log_cf(np.multiply.outer(t, gain)).sum(axis=1)
    np.testing.assert_allclose(_sum_log_cf(StudentT(1.0, 4.0), gain, t), direct, rtol=1e-8)
    law = Linear(0.0, [(StudentT(1.0, 4.0), gain)])
    assert law.quantile(0.975) / law.u == pytest.approx(1.96, abs=0.01)  # central limit


def test_mixed_terms_against_monte_carlo():
    """4e6 trials with numpy's own generators: coverage of the 95 % interval within 4.5 sd of the count."""
    rng, n = np.random.default_rng(11), 4_000_000
    law = Linear(
        2.0, [(StudentT(1.0, 4.0), np.array([1.0, 0.5, -0.3])), (Normal(0.4), ONE), (Uniform(1.0), 2 * ONE)]
    )
    y = 2.0 + sum(g * rng.standard_t(4, n) for g in (1.0, 0.5, -0.3))
    y += 0.4 * rng.standard_normal(n) + 2 * rng.uniform(-1, 1, n)
    for p in (0.5, 0.95, 0.99):
        low, high = law.interval(p)
        covered = np.mean((y >= low) & (y <= high))
        assert covered == pytest.approx(p, abs=4.5 * math.sqrt(p * (1 - p) / n))


def test_samples_shift_and_skew_the_interval():
    """Exponential quantiles as samples plus a normal: against convolution on a fine grid."""
    values = -np.log(1 - (np.arange(4000) + 0.5) / 4000)
    law = Linear(5.0, [(Samples(values), np.array([-2.0])), (Normal(0.3), ONE)])
    assert law.centre == pytest.approx(5 - 2 * values.mean())
    assert law.u == pytest.approx(math.hypot(2 * values.std(), 0.3))

    def exact(y: float) -> float:  # mean over the samples of the normal law around each
        return float(np.mean(Normal(0.3).cdf(y - 5 + 2 * values)))

    low, high = law.interval(0.95)
    assert (exact(low), exact(high)) == pytest.approx((0.025, 0.975), abs=1e-5)
    short = law.interval(0.95, "shortest")
    assert exact(short[1]) - exact(short[0]) == pytest.approx(0.95, abs=1e-5)
    assert short[1] - short[0] < 0.95 * (high - low)


def test_shortest_interval_of_a_single_law():
    # U-shaped: it hugs one edge. Width 1 - Q(0.05) = 1 + cos(0.05 pi) = 1.987688 against 2 cos(0.025 pi) = 1.993835
    low, high = Linear(0.0, [(Arcsine(1.0), ONE)]).interval(0.95, "shortest")
    assert high - low == pytest.approx(1.987688, abs=1e-6)
    low, high = Linear(0.0, [(Arcsine(1.0), ONE)]).interval(0.95)
    assert high - low == pytest.approx(1.993835, abs=1e-6)
    assert Linear(0.0, [(Triangular(1.0), ONE)]).interval(0.75, "shortest") == pytest.approx((-0.5, 0.5))


def test_single_samples_with_negative_gain():
    law = Linear(1.0, [(Samples(np.array([0.0, 1.0, 2.0, 7.0])), np.array([-1.0]))])
    np.testing.assert_allclose(law.cdf([-6.0, -1.0, 0.0, 1.0]), [0.25, 0.5, 0.75, 1.0])
    assert law.quantile(0.2) == -6.0


def test_nothing_uncertain():
    law = Linear(3.0, [(Normal(1.0), np.zeros(2))])
    assert (law.u, law.scale, law.interval()) == (0.0, 0.0, (3.0, 3.0))
    assert Linear(3.0, []).cdf([2.9, 3.0]).tolist() == [0, 1]


def test_panels_integrate_powers_and_waves():
    t, weight = _panels(10.0, 1.0)
    assert weight @ np.exp(-t) == pytest.approx(1 - math.exp(-10), rel=1e-14)
    assert weight @ t**-0.5 == pytest.approx(2 * math.sqrt(10), rel=1e-4)  # first panel starts at 4^-14
    assert weight @ np.cos(12 * t) == pytest.approx(math.sin(120) / 12, abs=1e-12)


def test_wrong_requests_are_refused():
    law = Linear(0.0, [(Normal(1.0), ONE)])
    with pytest.raises(UsageError, match="between 0 and 1"):
        law.interval(95)
    with pytest.raises(UsageError, match='Did you mean "shortest"'):
        law.interval(0.95, "shortst")
