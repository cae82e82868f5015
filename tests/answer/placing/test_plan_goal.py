"""What a plan is judged by: squares in units of the tolerance, form as the range of residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import DIAMETER, FORM, scenario
from vcmm.answer.placing.candidates import problem_of
from vcmm.answer.placing.design import Design, Target, TouchCandidates
from vcmm.answer.placing.motions import motions_of
from vcmm.answer.placing.plan_goal import FormCheck, goal_of
from vcmm.part.part import Feature
from vcmm.task.measuring.strategies import Around, plan_points

RING = Feature("ring", "circle", np.zeros(3), np.array([0, 0, 1.0]), np.array([10.0]))


def test_form_by_hand():
    """One touch of four stands out by 4 um. The circle takes up all but the pattern + - + -, of which 1 um is left: range 2."""
    points, normals = plan_points(RING, Around(4))
    rows = motions_of(RING).rows(points, normals)
    c = TouchCandidates(
        ("ring",), np.zeros(4, dtype=int), points, normals, rows=(rows,), common=np.zeros((4, 0)),
        touch=np.zeros(4), short=np.zeros(4), seconds=np.ones(1),
    )  # fmt: skip
    design = Design(c, Target(np.zeros((0, 3)), np.zeros(0)), np.ones(4, dtype=int))
    error = np.array([[3.0], [0.0], [0.0], [0.0]])
    check = FormCheck(
        0, error, np.array([[0.5], [0], [0], [0]]), np.array([[0.5], [0], [0], [0]]), np.array([0.5])
    )
    assert check.square(design) == pytest.approx((2.0 - 0.5) ** 2)
    assert check.typical == 0.5
    # touched four times each, the scatter of 0.5 is halved: 3.75 stand out, the range is 1.875
    often = Design(c, design.target, 4 * np.ones(4, dtype=int))
    assert check.square(often) == pytest.approx((1.875 - 0.5) ** 2)


@pytest.fixture(scope="module")
def problem():
    job = scenario(characteristics=(DIAMETER, FORM))
    bore = [s for s in job.plan.steps if s.feature == "bore"]
    job = replace(job, plan=replace(job.plan, steps=tuple(bore)))
    return problem_of(job, {"bore": "down"}, {"bore": bore[0].points}, {"bore": 1e-3})


def test_weights_are_per_tolerance_squared(problem):
    goal = goal_of(problem, {"diameter": 0.5, "form": 2.0}, "U", 0)
    assert goal.target.weight == pytest.approx([0.5 / 0.02**2])  # limits -10 to 10 um
    check, weight = goal.forms["form"]
    assert weight == pytest.approx(2.0 / 0.01**2)
    design = Design(problem.candidates, goal.target, np.ones(16, dtype=int))
    u2 = goal.variances(design)
    assert goal.value(design) == pytest.approx(0.5 * u2["diameter"] / 0.02**2 + 2.0 * u2["form"] / 0.01**2)
    assert u2["form"] == check.square(design)


def test_criterion_a_counts_motions_and_only_reports_characteristics(problem):
    goal = goal_of(problem, None, "A", 0, plain=True)
    assert goal.target.weight.tolist() == [0.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    assert np.diag(goal.target.rows[1:]).tolist() == [1.0, 1.0, 15.0, 15.0, 1.0]
    assert goal.forms == {}


def test_without_a_tolerance_the_plan_as_it_stands_is_the_measure():
    """u of the diameter of the smallest plan stands for the tolerance: its weight is 1 / u^2."""
    job = scenario(characteristics=(replace(DIAMETER, limits=None),))
    points = {s.feature: s.points for s in job.plan.steps}
    alone = problem_of(job, dict.fromkeys(points, "down"), points, {})
    goal = goal_of(alone, None, "U", 0)
    assert 1e-4 < 1.0 / np.sqrt(goal.target.weight[0]) < 1e-2  # mm: some um of scatter and form
