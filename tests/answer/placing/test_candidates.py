"""Places that can be touched, and what errors do there: the closed form against the evaluation of the same plan."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.answer.placing.test_design import PLANE, candidates, on_plane
from tests.build import SCATTER, scenario
from tests.plate import edited
from vcmm.answer.placing.candidates import _compress, _seconds, nearest, problem_of, spots
from vcmm.answer.placing.design import Design, Target
from vcmm.answer.placing.motions import outputs
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.files.own.scenario import load_scenario
from vcmm.physics.structure.squareness import Squareness


@pytest.mark.thorough
def test_u_agrees_with_the_evaluation_of_the_same_plan(tmp_path: Path):
    """Without form the closed form is that of `vcmm uncertainty`: another route, through q and its operator."""
    from vcmm.face.api import uncertainty

    plate = load_scenario(edited(tmp_path))
    styli = {s.feature: s.stylus for s in plate.plan.steps}
    problem = problem_of(plate, styli, spots(plate, styli), dict.fromkeys(styli, 0.0))
    found = outputs(plate.part.characteristics, plate.part.features, problem.motions, plate.plan.alignment)
    counts = np.zeros(len(problem.candidates.feature), dtype=int)
    for step in plate.plan.steps:
        counts[nearest(problem.candidates, step.feature, step.points)] += 1
    rows = found["bore diameter"]
    ours = np.sqrt(Design(problem.candidates, Target(rows, np.ones(1)), counts).variances()[0])
    theirs = uncertainty(plate).characteristics[0].u
    assert ours == pytest.approx(theirs, rel=1e-3)  # products of inputs are left out


def test_nearest_within_a_micrometre():
    points = on_plane((0, 0), (10, 0), (10, 10))
    c = candidates(PLANE, points)
    asked = np.array([[10.0, 0.0005, 0.0], [10.0, 9.998, 0.0], [0.0, 0.0, 0.0]])
    assert nearest(c, "top", asked).tolist() == [1, -1, 0]


def test_fewer_columns_of_the_same_covariance():
    rng = np.random.default_rng(2)
    wide = rng.normal(size=(6, 2)) @ rng.normal(size=(2, 9))  # rank 2
    slim = _compress(wide)
    assert slim.shape == (6, 2)
    assert slim @ slim.T == pytest.approx(wide @ wide.T)
    # the size does not matter, only the share of the largest: 1e-6 of it counts, 1e-11 of it does not
    assert _compress(np.diag([1e-3, 1e-9])).shape == (2, 2)
    assert _compress(np.diag([1e-3, 1e-14])).shape == (2, 1)


def test_time_of_a_touch_by_hand():
    """2 x 3 mm at 5 mm/s; four touches over 30 x 40 mm stand 50 / sqrt 4 = 25 mm apart, at 50 mm/s 0.5 s."""
    plan = SimpleNamespace(touch=SimpleNamespace(approach=3.0, speed=5.0, positioning=50.0))
    assert _seconds(plan, on_plane((0, 0), (30, 0), (0, 40), (30, 40))) == pytest.approx(1.2 + 0.5)


def test_scatter_shared_errors_and_drift_by_hand():
    """Scatter of 1 um is of every touch; a linear drift of 36 um/h along z is 10 nm/s, read by the cosine of the normal."""
    job = scenario(Squareness("C0Y"), inputs=(SCATTER, Input("squareness", "C0Y", "angle", Normal(2e-6))))
    points = {"bore": job.plan.steps[0].points}
    problem = problem_of(job, {"bore": "down"}, points, {"bore": 0.0}, drift=(1e-5, 0.0, 0.0))
    c = problem.candidates
    assert c.touch == pytest.approx(1e-3)
    assert c.short == pytest.approx(0.0)
    assert problem.drift == pytest.approx(1e-5 * c.normals[:, :1])
    # a squareness of 2 urad: x is read wrong by 2e-6 y, up to sign
    u = np.sqrt((c.common[:, : problem.form.start] ** 2).sum(axis=1))
    y = c.points[:, 1] + 2.0 * c.normals[:, 1]
    assert u == pytest.approx(np.abs(2e-6 * y * c.normals[:, 0]), abs=1e-12)


def test_a_feature_with_too_few_places_is_refused():
    job = scenario()
    with pytest.raises(
        ModelLimit, match='only 3 places on "bore" can be touched with stylus "down", 5 are needed'
    ):
        problem_of(job, {"bore": "down"}, {"bore": job.plan.steps[0].points[:3]}, {})
