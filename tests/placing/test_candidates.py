"""Places that can be touched, and what errors do there: the closed form against the evaluation of the same plan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.files.scenario import load_scenario
from vcmm.placing.candidates import nearest, problem_of, spots
from vcmm.placing.design import Design, Target
from vcmm.placing.motions import outputs


def test_u_agrees_with_the_evaluation_of_the_same_plan(tmp_path: Path):
    """Without form the closed form is that of `vcmm uncertainty`: another route, through q and its operator."""
    from vcmm.api import uncertainty

    scenario = load_scenario(edited(tmp_path))
    styli = {s.feature: s.stylus for s in scenario.plan.steps}
    problem = problem_of(scenario, styli, spots(scenario, styli), dict.fromkeys(styli, 0.0))
    found = outputs(
        scenario.part.characteristics, scenario.part.features, problem.motions, scenario.plan.alignment
    )
    counts = np.zeros(len(problem.candidates.feature), dtype=int)
    for step in scenario.plan.steps:
        counts[nearest(problem.candidates, step.feature, step.points)] += 1
    rows = found["bore diameter"]
    ours = np.sqrt(Design(problem.candidates, Target(rows, np.ones(1)), counts).variances()[0])
    theirs = uncertainty(scenario).characteristics[0].u
    assert ours == pytest.approx(theirs, rel=1e-3)  # products of inputs are left out
