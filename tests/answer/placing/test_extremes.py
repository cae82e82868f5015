"""Spread of extreme values against the Monte Carlo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.placing.extremes import _factors
from vcmm.answer.placing.objective import Uncertain
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.fixture import Goal, pose_of, six_of


@pytest.mark.thorough
def test_extreme_values_follow_the_monte_carlo_from_pose_to_pose():
    """The approximation of a form: its ratio between poses, against 20 000 trials."""
    paper = load_scenario(example("gaska2014"))
    objective = Uncertain.of(paper, Goal({"U": 1.0}, {"form of the bore": 1.0}))
    six = np.array([six_of(paper.places[n]) for n in ("1", "4")])
    u = objective.spread(six).u[:, 0]
    found = [
        evaluate(paper.at(pose_of(p)).task(), replace(paper.settings, trials=20_000))
        .characteristics[0]
        .summary.u
        for p in six
    ]
    assert u[0] / u[1] == pytest.approx(found[0] / found[1], rel=0.05)
    assert np.allclose(u, found, rtol=0.06)


def test_draws_are_normal_to_second_order_and_factors_give_the_covariance_back():
    which, extremes = Uncertain.of(scenario(), Goal({"U": 1.0}, {"form": 1.0}))._extremes
    assert which == (2,)
    draws = extremes.draws
    assert draws.mean(axis=0) == pytest.approx(0.0, abs=1e-12)
    assert draws.T @ draws / len(draws) == pytest.approx(np.eye(draws.shape[1]), abs=1e-12)
    a = np.random.default_rng(3).normal(size=(2, 4, 4)) * np.array([1.0, 1e-6, 1e-3, 1.0])[:, None]
    covariance = a @ a.swapaxes(1, 2)
    factors = _factors(covariance)
    scale = np.sqrt(np.einsum("mi,mj->mij", *[np.einsum("mii->mi", covariance)] * 2))
    assert factors @ factors.swapaxes(1, 2) / scale == pytest.approx(covariance / scale, abs=1e-9)
