"""How far the linear model is from the truth."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.evaluation.test_linear import model
from vcmm.answer.evaluation.certify import check, out_of_range
from vcmm.core.errors import ModelLimit
from vcmm.task.measuring.settings import Settings


def test_smooth_values_are_nearly_linear_and_form_is_not():
    one = model()
    result = check(one, one.gradient(), Settings(certify=50))
    assert (result.linear_error < 1e-6).all()  # 1 nm
    assert (result.tangent_error[:2] < 1e-5).all()  # 10 nm: tilts of the faces, of second order
    assert (result.curvature[:2] < 1e-2).all()
    assert result.curvature[2] > 0.1  # the tangent of an extreme value says nothing


def test_without_exact_trials_nothing_is_certified():
    one = model()
    result = check(one, one.gradient(), Settings(certify=0))
    assert np.isinf(result.linear_error).all()
    assert np.isfinite(result.curvature).all()


def test_draws_of_no_use_are_named():
    assert "nu < 2" in str(out_of_range(ModelLimit("x")))
    with pytest.raises(ModelLimit, match="leave the range"):
        raise out_of_range(ModelLimit("tilt"))
