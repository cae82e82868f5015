"""One curve without its own prior: what the readings and all other priors leave of it, however small the others are."""

from __future__ import annotations

import numpy as np

from vcmm.learn.calibration.evidence import EXTREMES, JointPosterior, NormalEquations, PriorSite
from vcmm.learn.calibration.model import error_model
from vcmm.learn.calibration.prior import line_factor, unit_factor, widest_pairs


def test_a_small_curve_with_a_free_line_costs_no_digits() -> None:
    """Readings by many setups, 0.2 um; the other curves at their least size, EYY besides with a scale error of any size: a prior
    precision that spans 20 decades. The reference projects them out of the readings by QR, without normal equations.
    """
    model = error_model({"X": (0.0, 600.0), "Y": (0.0, 500.0)}, 17)
    rng = np.random.default_rng(3)
    x = (
        rng.standard_normal((400, 9)) @ rng.standard_normal((9, model.size)) / 2e-4
    )  # nine directions only are told
    y = x @ (rng.standard_normal(model.size) * 1e-6) + rng.standard_normal(400)
    factors = [
        np.concatenate([unit_factor(c, 0.9 * c.travel) * c.usual * EXTREMES[0], c.coordinates @ line_factor(c)], axis=1)
        for c in model.curves
    ]  # fmt: skip
    sites = [PriorSite(f, np.zeros(len(f))) for f in factors]
    joint = JointPosterior(NormalEquations(x.T @ x, x.T @ y, model), sites)
    a, b = joint.without(2)
    beside = [x[:, model.slices[c.component]] @ c.free @ f for c, f in zip(model.curves, factors)]
    del beside[2]
    beside.append(x[:, model.size - len(model.pairs) :] * widest_pairs(model))
    others = np.concatenate(beside, axis=1)
    q = np.linalg.qr(np.concatenate([others, np.eye(others.shape[1])]))[0][: len(y)]
    own = x[:, model.slices["EZX"]] @ model.curves[2].free
    left = own - q @ (q.T @ own)
    exact, pull = left.T @ own, left.T @ y
    assert np.linalg.norm(a - exact) < 1e-8 * np.linalg.norm(exact)
    fit = float(b @ np.linalg.pinv(a, rcond=1e-9) @ b)
    assert abs(fit - float(pull @ np.linalg.pinv(exact, rcond=1e-9) @ pull)) < 1e-5 * fit
    assert fit < float(y @ y)  # the best curve cannot explain more than there is
