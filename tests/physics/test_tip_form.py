"""vcmm/physics/structure/tip_form.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.clamping import Clamping
from vcmm.physics.structure.tip_form import TipForm, harmonics


def _touch(normal, **columns: float) -> Run:
    named = dict(zip(("nx", "ny", "nz"), normal)) | columns
    return Run(
        {a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()}
    )


@pytest.mark.parametrize(
    ("term", "normal", "value"),
    [
        (2, (0.0, 0.0, 1.0), 2.236068),  # sqrt(5) (3 - 1) / 2
        (2, (1.0, 0.0, 0.0), -1.118034),  # sqrt(5) (0 - 1) / 2
        (4, (1.0, 0.0, 0.0), 1.936492),  # cos(2 phi): sqrt(5 x 2 / 24) x 3
        (4, (0.0, 1.0, 0.0), -1.936492),
        (0, (0.6, 0.8, 0.0), 1.859032),  # sin(2 phi) = 2 x 0.6 x 0.8 = 0.96, times 1.936492
        (3, (0.6, 0.0, 0.8), 1.859032),  # cos(phi): sqrt(5 x 2 / 6) x 3 x 0.6 x 0.8
        (1, (0.0, 0.6, 0.8), 1.859032),  # sin(phi)
    ],
)
def test_tip_form_by_hand(term: int, normal, value: float):
    # 1 um of one harmonic of degree 2; a high ball indicates too much, along n
    c = np.zeros(5)
    c[term] = 1e-3
    reading = machine(TipForm("", c)).indication_error(_touch(normal))[0]
    assert reading == pytest.approx(value * 1e-3 * np.array(normal), abs=1e-9)


def test_tip_form_harmonics_are_orthogonal_and_know_no_radius_or_offset():
    # Gauss points in the height times equal steps in azimuth integrate products up to degree 8 exactly
    height, weight = np.polynomial.legendre.leggauss(6)
    azimuth = np.arange(12) * np.pi / 6
    z, phi = (g.ravel() for g in np.meshgrid(height, azimuth, indexing="ij"))
    n = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)
    share = np.repeat(weight, 12) / 24
    terms = np.concatenate([np.ones((len(n), 1)), np.sqrt(3) * n, harmonics(n, 4)], axis=1)
    assert terms.T @ (share[:, None] * terms) == pytest.approx(np.eye(25), abs=1e-12)
    assert TipForm("", np.full(12, 1e-3)).rms == pytest.approx(np.sqrt(12) * 1e-3)


def test_tip_form_belongs_to_its_stylus():
    run = Run({}, np.zeros((2, 3)), {c: np.full(2, 0.57735027) for c in ("nx", "ny", "nz")},
              {"stylus": np.array(["down", "side"])})  # fmt: skip
    reading = TipForm("down", np.full(5, 1e-3)).error_motion(run)
    assert np.abs(reading[0]).max() > 1e-4
    assert np.all(reading[1] == 0.0)


def test_sizes_are_checked():
    with pytest.raises(UsageError, match="give 5, 12 or 21"):
        TipForm("", np.zeros(6))
    with pytest.raises(UsageError, match="give 3 or 7 coefficients"):
        Clamping("z", np.zeros(4))
    with pytest.raises(UsageError, match='must be "x", "y" or "z"'):
        Clamping("Z")
