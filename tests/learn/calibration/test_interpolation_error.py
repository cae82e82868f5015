"""What nodes leave of a curve between them, by hand and in the limits of rough and smooth curves."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.learn.calibration.interpolation import expected_between, left_between
from vcmm.learn.calibration.model import Curve, ErrorModel


def posterior(
    curve: Curve, values: np.ndarray, u: float, length: float = 100.0, size: float = 1.0
) -> SimpleNamespace:
    model = ErrorModel((curve,), ())
    smooth = SimpleNamespace(sizes=np.array([size]), lengths={curve.component: length})
    return SimpleNamespace(model=model, theta=values, covariance=u**2 * np.eye(len(values)), smooth=smooth)


def test_two_nodes_of_three_by_hand():
    # linear between its nodes: at 50 mm 1 is left of (0, 1, 0); its variance is 4 + (4 + 4) / 4 = 6, that of the curve there 4
    three = Curve("EXX", np.array([0.0, 50.0, 100.0]), kind="table")
    two = ErrorModel((Curve("EXX", np.array([0.0, 100.0]), kind="table"),), ())
    assert left_between(posterior(three, np.array([0.0, 1.0, 0.0]), 2.0), two) == pytest.approx(
        np.sqrt(7 / 4)
    )
    # a line is left by nothing
    assert left_between(posterior(three, np.array([1.0, 2.0, 3.0]), 1e-9), two) == pytest.approx(np.sqrt(1.5))


def test_rough_curves_run_otherwise_between_17_nodes_and_smooth_ones_do_not():
    curve = Curve("EXX", np.linspace(0, 600, 17))
    nothing = np.zeros(17)
    # neighbours know nothing of one another: the curve itself, 1, and what a spline makes of the nodes beside, about 0.6
    assert 1.0 < expected_between(posterior(curve, nothing, 1.0, length=5.0)) < 1.6
    # of a process 600 mm long only its millionth without correlation is left
    assert expected_between(posterior(curve, nothing, 1.0, length=600.0)) < 5e-3
    few = posterior(curve, nothing, 0.25, length=60.0, size=2.0)
    once = posterior(curve, nothing, 1.0, length=60.0)
    assert expected_between(few) == pytest.approx(8 * expected_between(once))
