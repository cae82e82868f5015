"""Worked examples of JCGM 101:2008, clause 9, and of JCGM 100 (GUM), H.1, run with the sampler and the exact engine.

Published figures are rounded and themselves Monte Carlo; "exact" ones are closed forms. The ends of a shortest
interval wander from run to run, so widths and attained coverage are compared, not ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from vcmm.answer.evaluation.interval import Linear
from vcmm.answer.evaluation.montecarlo import (
    Summary,
    Term,
    adaptive,
    covariance,
    marginal,
    simulate,
    summarise,
)
from vcmm.answer.evaluation.streams import draw
from vcmm.core.laws import (
    Arcsine,
    CurvilinearTrapezoidal,
    Law,
    MultivariateNormal,
    Normal,
    StudentT,
    Uniform,
)

LANE = np.zeros((1, 2), np.uint32)
TRIALS = 1_000_000


def sample(name: str, law: Law, centre: float = 0.0, count: int = TRIALS, first: int = 0) -> np.ndarray:
    return centre + draw(101, name, LANE, law, first, count)[:, 0]


def share(y: np.ndarray, interval: tuple[float, float]) -> float:
    return float(np.mean((y >= interval[0]) & (y <= interval[1])))


def one_output(laws: list[Law]) -> list[Term]:
    return [Term(f"X{i}", law, np.ones((1, 1)), LANE) for i, law in enumerate(laws, 1)]


@pytest.mark.parametrize(
    ("laws", "u", "half"),
    [
        ([Normal(1.0)] * 4, 2.0, 3.919928),  # 9.2.2: 1.959964 * 2, published 3.92
        ([Uniform(math.sqrt(3))] * 4, 2.0, 3.879407),  # 9.2.3: 2 sqrt3 (2 - 0.6^(1/4)), published 3.88
        (
            [Uniform(math.sqrt(3))] * 3 + [Uniform(10 * math.sqrt(3))],
            math.sqrt(103),
            17.015814,
        ),  # 9.2.4: 17.0
    ],
    ids=["9.2.2", "9.2.3", "9.2.4"],
)
def test_additive_model(laws: list[Law], u: float, half: float):
    terms = one_output(laws)
    exact = marginal(0.0, terms, 0)
    assert exact.u == pytest.approx(u)
    assert exact.interval(0.95) == pytest.approx((-half, half), abs=1e-6)
    y = np.concatenate(list(simulate(np.zeros(1), terms, seed=101, trials=TRIALS, fold=False)))[:, 0]
    found = summarise(y)
    assert found.mean == pytest.approx(0, abs=5 * u / 1e3)
    assert found.u == pytest.approx(u, rel=0.004)  # 5 u / sqrt(2 M) = 0.0035 u
    assert share(y, (-half, half)) == pytest.approx(0.95, abs=0.0011)  # 5 sqrt(0.0475 / M)
    for kind in ("symmetric", "shortest"):
        low, high = found.interval(0.95, kind)
        assert high - low == pytest.approx(2 * half, rel=0.005)


def test_additive_model_adaptive():
    """9.2.2.5: two significant digits of u = 2.0 (delta = 0.05), results y = 0.00, u = 2.0, [-3.92, 3.92]."""
    terms = one_output([Normal(1.0)] * 4)

    def run(first: int, count: int) -> np.ndarray:
        return np.concatenate(list(simulate(np.zeros(1), terms, seed=1, trials=count, first=first)))[:, 0]

    found = adaptive(run, digits=2, u0=2.0)
    assert found.mean == pytest.approx(0, abs=0.05)
    assert found.u == pytest.approx(2.0, abs=0.05)
    assert found.interval() == pytest.approx((-3.92, 3.92), abs=0.07)  # both ends within the tolerance, 2 s
    assert found.digits() == 2


def test_mass_calibration():
    """9.3: published MCM 1.2341 mg, u = 0.0754 mg, shortest [1.0834, 1.3825]; 4e6 trials: 1.2340, 0.0754, 0.2990."""
    mass = sample("m_Rc", Normal(0.050), 100_000.0) + sample("dm_Rc", Normal(0.020), 1.234)
    air = sample("rho_a", Uniform(0.10))  # departure from rho_a0 = 1.2 kg/m^3
    buoyancy = 1 / sample("rho_W", Uniform(1000.0), 8000.0) - 1 / sample("rho_R", Uniform(50.0), 8000.0)
    y = mass * (1 + air * buoyancy) - 100_000.0
    found = summarise(y)
    assert found.mean == pytest.approx(1.2340, abs=5e-4)
    assert found.u == pytest.approx(0.0754, abs=2e-4)
    low, high = found.interval(0.95, "shortest")
    assert high - low == pytest.approx(0.2990, abs=0.0012)
    assert share(y, (1.0834, 1.3825)) == pytest.approx(0.95, abs=0.002)
    assert share(y, (1.1285, 1.3395)) < 0.85  # first order (GUF), u = 0.0539: far too short


@pytest.mark.parametrize(
    ("x1", "mean", "u", "width"),
    [
        (0.0, 50, 50, 149.787),  # exponential law: -50 ln 0.05
        (0.010, 150, 111.803, 366.005),
        (0.050, 2550, 502.494, 3548.57 - 1593.57),
    ],
)
def test_power_loss(x1: float, mean: float, u: float, width: float):
    """9.4, y = X1^2 + X2^2, u = 0.005, r = 0, in 1e-6: u^2 times a noncentral chi square of two degrees."""
    from scipy.stats import ncx2

    y = 1e6 * (sample("X1", Normal(0.005), x1) ** 2 + sample("X2", Normal(0.005)) ** 2)
    found, law = summarise(y), ncx2(2, (x1 / 0.005) ** 2, scale=25.0)
    assert (law.mean(), law.std()) == pytest.approx((mean, u), rel=1e-5)
    assert found.mean == pytest.approx(mean, abs=5 * u / 1e3)
    assert found.u == pytest.approx(u, rel=0.007)  # kurtosis 9 of the exponential: 5 sqrt(8 / 4 / M)
    low, high = found.interval(0.95, "shortest")
    assert high - low == pytest.approx(width, rel=0.006)
    assert law.cdf(high) - law.cdf(low) == pytest.approx(0.95, abs=0.002)
    low, high = found.interval(0.95)
    assert (law.cdf(low), law.cdf(high)) == pytest.approx((0.025, 0.975), abs=8e-4)


@pytest.mark.parametrize(
    ("x1", "mean", "u", "width"), [(0.0, 50, 67.3, 185), (0.010, 150, 120.6, 385), (0.050, 2550, 504.7, 1930)]
)
def test_power_loss_correlated(x1: float, mean: float, u: float, width: float):
    """9.4.3, r = 0.9: published 50 / 67 / [0, 185], 150 / 121 / [13, 398], 2551 / 505 / [1626, 3556]."""
    law = MultivariateNormal(0.005**2 * np.array([[1.0, 0.9], [0.9, 1.0]]))
    z = draw(101, "joint", np.array([[0, 0], [1, 0]]), Normal(1.0), 0, TRIALS) @ law.factor.T
    found = summarise(1e6 * ((x1 + z[:, 0]) ** 2 + z[:, 1] ** 2))
    assert found.mean == pytest.approx(mean, abs=5 * u / 1e3)
    assert found.u == pytest.approx(u, rel=0.012)
    low, high = found.interval(0.95, "shortest")
    assert high - low == pytest.approx(width, rel=0.015)


def gauge_block(first: int, count: int) -> np.ndarray:
    """9.5, model (36) and table 11: departure from the nominal 50 mm, nm."""

    def x(name: str, law: Law, centre: float = 0.0) -> np.ndarray:
        return sample(name, law, centre, count, first)

    standard = x("L_s", StudentT(25.0, 18), 50_000_623.0)
    difference = x("D", StudentT(6.0, 24), 215.0) + x("d1", StudentT(4.0, 5)) + x("d2", StudentT(7.0, 8))
    alpha, theta0 = x("alpha_s", Uniform(2e-6), 11.5e-6), x("theta_0", Normal(0.2), -0.1)
    room, d_alpha = x("Delta", Arcsine(0.5)), x("d_alpha", CurvilinearTrapezoidal(1e-6, 1e-7))
    d_theta = x("d_theta", CurvilinearTrapezoidal(0.050, 0.025))
    return standard + difference - standard * (d_alpha * (theta0 + room) + alpha * d_theta) - 50e6


def attained(run: Callable[[int, int], np.ndarray], interval: tuple[float, float]) -> float:
    return share(run(TRIALS, TRIALS), interval)  # trials that took no part in the interval


def test_gauge_block_calibration():
    """9.5.4: published MCM 838 nm, u = 36 nm, 99 % [745, 932]; 4e6 trials: 838.0, 35.8, [744.3, 931.7]."""
    found: Summary = summarise(gauge_block(0, TRIALS))
    assert found.mean == pytest.approx(838.0, abs=0.2)
    assert found.u == pytest.approx(35.8, abs=0.2)
    low, high = found.interval(0.99)
    assert high - low == pytest.approx(931.7 - 744.3, abs=2.0)
    assert attained(gauge_block, (745, 932)) == pytest.approx(0.99, abs=0.001)
    assert attained(gauge_block, (low, high)) == pytest.approx(0.99, abs=0.0007)


def test_gum_h1_end_gauge():
    """GUM H.1.6: u_c = 31.7 nm to first order from 25, 9.7, 2.9 and 16.6 nm."""
    length, theta, alpha = 50_000_623.0, -0.1, 11.5e-6
    terms = [
        Term("l_s", Normal(25.0), np.ones((1, 1)), LANE),
        Term("d", Normal(9.7), np.ones((1, 1)), LANE),
        Term("d_alpha", Uniform(1e-6), np.full((1, 1), -length * theta), LANE),  # 5e6 * 0.577e-6 = 2.89
        Term("d_theta", Uniform(0.05), np.full((1, 1), -length * alpha), LANE),  # 575 * 0.02887 = 16.60
    ]
    # 625 + 94.09 + 8.33 + 275.5 = 1002.9
    assert math.sqrt(covariance(terms)[0, 0]) == pytest.approx(31.67, abs=0.01)
    exact: Linear = marginal(838.0, terms, 0)
    low, high = exact.interval(0.99)
    assert (high - low) / 2 == pytest.approx(
        2.5758 * 31.67, rel=0.03
    )  # nearly normal; k = 2.92 there comes from nu_eff
