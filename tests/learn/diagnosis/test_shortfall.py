"""What names do not deliver: folds that fall short of simulated ones, scatter without a name, places that are not seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.learn.diagnosis.accepted_terms import failing_fold, unknown_of_fold
from vcmm.learn.diagnosis.candidates import Family, build_catalogue, unseen_places
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.holdout import folds
from vcmm.learn.diagnosis.mistakes import generalises
from vcmm.learn.diagnosis.noise import audit
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.rivals import compare_with_rivals
from vcmm.learn.diagnosis.select import Setting, select


@pytest.fixture(scope="module")
def searched():
    case = make.make(("backlash",), 14.0, 23)
    problem = make_problem(case.recording, make.machine())
    white = problem.whitener()
    raw = white.apply(problem.residual)
    found = dictionary(build_catalogue(problem).families, white)
    setting = Setting(found, white, raw, 3.0, 6.0, Refiner(problem, white))
    return problem, setting, select(setting), audit(problem, white, raw, 1)


def test_a_right_name_delivers_in_every_fold(searched):
    problem, _, selection, noise = searched
    parts = folds(problem, problem.u, 0.0)
    assert failing_fold(problem, parts, selection, noise, problem.u, 1) == ""


def test_a_term_that_turns_over_in_time_is_seen(searched):
    problem, _, selection, noise = searched
    assert selection.fit is not None
    signal = np.concatenate([t.option.columns for t in selection.terms], axis=1) @ selection.fit.mean
    late = problem.per_observation(problem.run.column("time_s")) > np.quantile(
        problem.run.column("time_s"), 0.7
    )
    turned = replace(problem, residual=problem.residual - 2.0 * signal * late)
    parts = folds(problem, problem.u, 0.0)
    assert failing_fold(turned, parts, selection, noise, problem.u, 1) == "later time"
    assert unknown_of_fold("later time").covariates == ("time",)
    assert unknown_of_fold("far zone X").covariates == ("X",)
    assert unknown_of_fold("pose p3").covariates == ("pose",)


def test_generalisations_stand_aside_and_others_are_rivals(searched):
    _, setting, selection, _ = searched
    rivals = compare_with_rivals(selection, setting, 0).names
    assert "lost_motion" not in rivals  # holds a backlash whatever is recorded
    assert generalises("lost_motion", "backlash")
    assert not generalises("backlash", "lost_motion")
    assert not generalises("tip_form", "backlash")


@pytest.mark.thorough
def test_scatter_without_a_name_is_told_and_not_called_nothing():
    recording = make.make((), 0.0, 41).recording
    found = diagnose_recording(replace(recording, value=1.35 * recording.value), make.machine(), 1, 500)
    assert found.answer == ()
    assert found.verdict == "unexplained"
    assert any("nothing found explains it" in text for text in found.noise_findings)


def test_places_at_which_nothing_is_seen():
    lost = [
        Family("squareness", {"pair": "B0Z"}, ()),
        Family("thermal_drift", {"direction": "z", "sensor": "air"}, ()),
    ]
    seen = [
        Family("squareness", {"pair": "C0Y"}, ()),
        Family("thermal_drift", {"direction": "z", "sensor": "part"}, ()),
    ]
    assert unseen_places(lost, seen) == ("squareness[B0Z]",)
