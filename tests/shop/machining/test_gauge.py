"""The usual points of features, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.shop.machining.gauge import gauge_plan, ideal_gauge, usual_points
from vcmm.task.measuring.strategies import Grid, Levels

Z = np.array([0.0, 0.0, 1.0])
TOP = Feature("top", "plane", np.zeros(3), Z, np.zeros(0), extent=(40.0, 20.0))
BORE = Feature("bore", "cylinder", np.zeros(3), Z, np.array([10.0]), extent=(40.0,), inside=True)


def test_a_tenth_is_kept_from_the_edges():
    assert isinstance(usual_points(TOP), Grid)
    (step,) = gauge_plan(Part({"top": TOP}, ()), None).steps
    assert len(step.points) == 49
    assert np.abs(step.points).max(axis=0)[:2].tolist() == pytest.approx([18.0, 8.0])


def test_three_levels_of_24():
    assert isinstance(usual_points(BORE), Levels)
    (step,) = gauge_plan(Part({"bore": BORE}, ()), None).steps
    assert len(step.points) == 72
    assert sorted(set(step.points[:, 2].round(9))) == pytest.approx([6.0, 20.0, 34.0])


def test_only_features_that_a_characteristic_names():
    part = Part(
        {"top": TOP, "bore": BORE}, (Characteristic("size", "size", of=("bore",), limits=(-1.0, 1.0)),)
    )
    assert [s.feature for s in gauge_plan(part, None).steps] == ["bore"]


def test_a_lone_point_needs_a_plan_and_the_gauge_errs_nowhere():
    lone = Feature("p", "point", np.zeros(3), Z, np.zeros(0))
    with pytest.raises(UsageError, match="a point has no usual points"):
        gauge_plan(Part({"p": lone}, ()), None)
    assert ideal_gauge().effects == ()
