"""The best plan under a budget: the curve, styli, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import DIAMETER
from tests.build import scenario as job
from vcmm.answer.placing.planning import optimise_plan
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.task.measuring.plan import Plan, Step, Stylus


def test_the_curve_falls_and_beats_the_present_plan(planned):
    _, result = planned
    seconds = [p.seconds for p in result.pareto]
    worth = [p.objective for p in result.pareto]
    assert seconds == sorted(seconds)
    assert worth == sorted(worth, reverse=True)
    assert result.choice.seconds <= 30.0
    quicker = [p for p in result.pareto if p.seconds <= result.present.seconds]
    assert min(p.objective for p in quicker) < result.present.objective


def test_bad_input_is_named():
    scenario = job(characteristics=(DIAMETER,))
    with pytest.raises(UsageError, match='unknown characteristic "diametre"'):
        optimise_plan(scenario, 60.0, weights={"diametre": 1.0})
    with pytest.raises(UsageError, match="criterion"):
        optimise_plan(scenario, 60.0, criterion="E")
    with pytest.raises(ModelLimit, match=r"the shortest plan takes .* s, the budget is 1 s"):
        optimise_plan(scenario, 1.0)


@pytest.mark.thorough
def test_a_feature_that_no_stylus_reaches_is_named():
    scenario = job()
    side = Stylus("side", np.array([0.0, 0.0, 100.0]), 2.0, 100.0)  # points up
    steps = tuple(Step(s.feature, "side", s.points, s.normals) for s in scenario.plan.steps)
    with pytest.raises(ModelLimit, match=r"can be touched|no stylus"):
        optimise_plan(replace(scenario, plan=Plan(steps, {"side": side})), 60.0)


def test_a_second_stylus_is_taken_where_it_serves_better():
    """One stylus is too short to go down the bore (its head of 60 mm does not): the long one takes over."""
    scenario = job(characteristics=(DIAMETER,))
    short = Stylus("short", np.array([0.0, 0.0, -4.0]), 2.0, 4.0)
    plan = scenario.plan
    steps = tuple(replace(s, stylus="short") for s in plan.steps if s.feature == "bore")
    found = optimise_plan(replace(scenario, plan=Plan(steps, {"short": short, **plan.styli})), 20.0, most=10)
    assert found.styli == {"bore": "down"}
    assert {s.stylus for s in found.plan.steps} == {"down"}
