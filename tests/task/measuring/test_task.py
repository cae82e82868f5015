"""From errors of the machine to measured points, fitted elements and characteristics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import BORE, scenario
from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points, nominal_element, per_normal


def test_without_errors_the_nominal_part():
    task = scenario().task()
    points = measured_points(task, np.zeros((24, 3)))
    assert points == pytest.approx(task.touches.points)
    # bore 30 mm, faces 100 mm apart, no form
    assert evaluate_all(task, fit_features(task, points)) == pytest.approx([30.0, 100.0, 0.0], abs=1e-9)


def test_an_error_along_the_normal_is_read():
    # every touch reads 2 um too far out: the bore, whose outward normal points to its axis, 4 um too small, the length 4 um too large
    task = scenario().task()
    values = evaluate_all(task, fit_features(task, measured_points(task, 2e-3 * task.touches.run.normal)))
    assert values == pytest.approx([30.0 - 4e-3, 100.0 + 4e-3, 0.0], abs=1e-9)


def test_form_lies_on_the_normal():
    task = replace(scenario().task(), form=np.full(24, 1e-3))
    values = evaluate_all(task, fit_features(task, measured_points(task, np.zeros((2, 24, 3)))))
    assert values == pytest.approx(np.tile([30.0 - 2e-3, 100.0 + 2e-3, 0.0], (2, 1)), abs=1e-9)


def test_an_oblique_approach_goes_further():
    # at 60 deg to the normal: 1 mm of surface is 1 / cos 60 = 2 mm of approach
    touches = scenario().task().touches
    oblique = -0.5 * touches.normals + np.sqrt(0.75) * np.cross(touches.normals, [0.0, 0.0, 1.0])
    way = per_normal(replace(touches, approach=oblique))
    assert np.linalg.norm(way, axis=1) == pytest.approx(np.full(24, 2.0))


def test_the_nominal_element_starts_the_fit():
    start = nominal_element(BORE)
    assert (start.kind, start.sizes.tolist()) == ("cylinder", [15.0])
