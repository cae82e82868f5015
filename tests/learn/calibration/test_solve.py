"""The joint posterior against dense algebra: nothing of the reduced equations is used for what is expected."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import t

from tests.learn.calibration.drawn import bare, draw, recorded
from vcmm.learn.calibration.evidence import _factor
from vcmm.learn.calibration.model import error_model
from vcmm.learn.calibration.readings import readings
from vcmm.learn.calibration.solve import DOFS, _likelihood, _t_scale, nuisance_basis, solve
from vcmm.task.instruments.laser import line


def test_evidence_is_the_density_of_the_readings():
    """ln N(N' y; 0, N' (diag(u^2) + G F F' G') N) with N square to the nuisance; u^-1 stands for the unit of the density."""
    rng = np.random.default_rng(3)
    middle, tip = {"X": 300.0, "Y": 250.0, "Z": -200.0}, np.array([0.0, 0.0, -100.0])
    place = line(bare(), "X", np.linspace(0, 600, 13), middle, tip, "X", 0.2e-3)
    (reading,) = recorded(draw(rng), [place], rng)
    model = error_model({"X": (0.0, 600.0)}, 9, only=("EXX",))
    part = readings(reading, bare(), model)
    got = solve([part], model)
    (curve,) = model.curves
    prior = curve.free @ _factor(curve, got.smooth.lengths["EXX"], float(got.smooth.sizes[0]))
    scale = got.noise[0].scale * part.u
    assert got.noise[0].dof == np.inf
    y, g = part.value / scale, part.errors @ prior / scale[:, None]
    if part.instrument_errors:
        g = np.concatenate([g, *[c / scale[:, None] for _, c in part.instrument_errors]], axis=1)
    basis = nuisance_basis(part.nuisance / scale[:, None])
    rest = np.linalg.svd(basis, full_matrices=True)[0][:, basis.shape[1] :]
    c = np.eye(rest.shape[1]) + rest.T @ g @ g.T @ rest
    z = rest.T @ y
    expected = -0.5 * (np.linalg.slogdet(c)[1] + z @ np.linalg.solve(c, z)) - np.log(scale).sum()
    assert got.log_evidence == pytest.approx(expected, abs=1e-6)


def test_likelihoods_of_residuals_are_those_of_the_laws():
    # (1, -1) by the normal law of scale 1: -1/2 - 1/2 - 2 ln sqrt(2 pi) = -2.837877
    assert _likelihood(np.array([1.0, -1.0]), np.inf) == pytest.approx(-2.837877, abs=1e-6)
    e = np.random.default_rng(0).standard_normal(50)
    for dof in DOFS:
        assert _likelihood(e, dof) == pytest.approx(t.logpdf(e, dof, scale=_t_scale(e, dof)).sum(), abs=1e-9)
