"""JCGM 102:2011, 9.3: a complex quantity from real and imaginary part to magnitude and phase, u = 0.01 each.

The magnitude of an uncorrelated pair has a Rice law; the correlated figures are published to three digits.
"""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.evaluation.streams import draw
from vcmm.core.laws import MultivariateNormal, Normal

TRIALS = 1_000_000


def magnitude_and_phase(x1: float, r: float) -> tuple[np.ndarray, np.ndarray]:
    law = MultivariateNormal(1e-4 * np.array([[1.0, r], [r, 1.0]]))
    z = draw(102, "reflection", np.array([[0, 0], [1, 0]]), Normal(1.0), 0, TRIALS) @ law.factor.T
    return np.hypot(x1 + z[:, 0], z[:, 1]), np.arctan2(z[:, 1], x1 + z[:, 0])


@pytest.mark.parametrize(
    ("x1", "published", "u_phase"),
    [(0.001, (0.0126, 0.0066), 1.744), (0.010, (0.0155, 0.0078), 1.117), (0.100, (0.1005, 0.0100), 0.1005)],
)
def test_uncorrelated(x1: float, published: tuple[float, float], u_phase: float):
    from scipy.stats import rice

    magnitude, phase = magnitude_and_phase(x1, 0.0)
    law = rice(x1 / 0.01, scale=0.01)
    assert (law.mean(), law.std()) == pytest.approx(published, abs=6e-5)
    assert magnitude.mean() == pytest.approx(law.mean(), abs=5 * 0.01 / 1e3)
    assert magnitude.std() == pytest.approx(law.std(), rel=0.004)
    assert phase.std() == pytest.approx(u_phase, rel=0.004)
    assert phase.mean() == pytest.approx(0, abs=5 * u_phase / 1e3)
    low, high = law.ppf([0.025, 0.975])
    assert np.mean((magnitude >= low) & (magnitude <= high)) == pytest.approx(0.95, abs=0.0011)


@pytest.mark.parametrize(
    ("x1", "mean", "u", "phase", "u_phase", "correlation"),
    [
        (0.001, 0.0117, 0.0080, -0.558, 1.598, -0.069),
        (0.010, 0.0153, 0.0081, -0.343, 0.903, 0.352),
        (0.100, 0.1005, 0.0099, -0.009, 0.102, 0.882),
    ],
)
def test_correlated(x1: float, mean: float, u: float, phase: float, u_phase: float, correlation: float):
    """r = 0.9."""
    found, angle = magnitude_and_phase(x1, 0.9)
    assert (found.mean(), found.std()) == pytest.approx((mean, u), abs=7e-5)
    assert angle.mean() == pytest.approx(phase, abs=5 * u_phase / 1e3 + 6e-4)
    assert angle.std() == pytest.approx(u_phase, abs=0.004)
    assert np.corrcoef(found, angle)[0, 1] == pytest.approx(correlation, abs=0.006)
