"""What effects say of themselves along a direction at once is what unit steps say one by one."""

from __future__ import annotations

import numpy as np

from vcmm.core.declaration import WithResponse
from vcmm.core.effect import projected_basis, stepped_basis
from vcmm.core.run import Run
from vcmm.physics import ALL
from vcmm.physics.structure.tip_form import TipForm


def test_tip_form_along_weights() -> None:
    """Of two styli one; seen along any direction. Y_2 of order 0 is sqrt(5) (3 z^2 - 1) / 2: sqrt(5) at the pole, -sqrt(5) / 2 on the equator."""
    rng = np.random.default_rng(1)
    normals = rng.normal(size=(40, 3))
    normals[:2] = (0, 0, 1), (1, 0, 0)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    stylus = np.array(["a"] * 20 + ["b"] * 20)
    run = Run(
        {"X": np.zeros(40)},
        np.zeros((40, 3)),
        columns=dict(zip(("nx", "ny", "nz"), normals.T)),
        labels={"stylus": stylus},
    )
    weights = rng.normal(size=(40, 6))
    effect = TipForm("a", coefficients=np.zeros(12))
    due = np.einsum("ni,nik->nk", weights, stepped_basis(effect, "coefficients", run))
    assert np.allclose(projected_basis(effect, "coefficients", run, weights), due, rtol=0, atol=1e-12)
    along = np.concatenate([normals, np.zeros((40, 3))], axis=1)
    seen = projected_basis(effect, "coefficients", run, along)
    assert np.allclose(seen[:2, 2], [np.sqrt(5), -np.sqrt(5) / 2], atol=1e-12)
    assert not seen[20:].any()


def test_a_formula_of_an_effect_is_asked() -> None:
    """`response` and `projected` are asked of `WithResponse` alone: that of the form of the tip was never called."""
    written = [e for e in ALL if hasattr(e, "response") or hasattr(e, "projection")]
    assert TipForm in written
    assert not [e.__name__ for e in written if not issubclass(e, WithResponse)]
