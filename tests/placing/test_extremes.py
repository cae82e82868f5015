"""Spread of extreme values against the Monte Carlo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.evaluation.uncertainty import evaluate
from vcmm.files.scenario import load_scenario
from vcmm.library import path
from vcmm.measuring.fixture import Goal, pose_of, six_of
from vcmm.placing.objective import Uncertain


def test_extreme_values_follow_the_monte_carlo_from_pose_to_pose():
    """The approximation of a form: its ratio between poses, against 20 000 trials."""
    scenario = load_scenario(path("gaska2014"))
    objective = Uncertain.of(scenario, Goal({"U": 1.0}, {"form of the bore": 1.0}))
    six = np.array([six_of(scenario.places[n]) for n in ("1", "4")])
    u = objective.spread(six).u[:, 0]
    found = [
        evaluate(scenario.at(pose_of(p)).task(), replace(scenario.settings, trials=20_000))
        .characteristics[0]
        .u
        for p in six
    ]
    assert u[0] / u[1] == pytest.approx(found[0] / found[1], rel=0.05)
    assert np.allclose(u, found, rtol=0.06)
