"""The verdict: when names, and when noise, are the whole story."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.answer.evaluation.gaussian import whitener
from vcmm.core.run import Run
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.holdout import folds, worsened_folds
from vcmm.learn.diagnosis.locate import Place
from vcmm.learn.diagnosis.noise import Audit, audit, chain_noise
from vcmm.learn.diagnosis.null_recordings import Noise
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.result import Answer
from vcmm.learn.diagnosis.scans import trials
from vcmm.learn.diagnosis.select import SelectedTerm, Setting, fit_jointly, select
from vcmm.learn.diagnosis.verdict import (
    clear_places,
    describe_probability,
    doubt_remarks,
    shared_curve_remarks,
    unstated_scatter,
    verdict,
)
from vcmm.physics.catalogue.dynamics import StructuralVibration


def answer(probability: float, rivals: float = 0.0) -> Answer:
    return Answer("backlash", {"axis": "X"}, {}, probability, 1.0, (), 10.0, rival_probability=rivals)


def test_a_name_is_doubtful_where_it_and_its_rivals_are_less_probable_than_not() -> None:
    """0.3 alone is no finding, whatever its rivals hold; with exact aliases of 0.3 more it is one: no row could tell them apart."""
    assert answer(0.3, 0.1).doubtful
    assert answer(0.3, 0.6).doubtful
    assert not replace(answer(0.3, 0.6), alias_probability=0.6).doubtful
    assert replace(answer(0.9), withheld_because="the rows become worse").doubtful
    assert not answer(0.5).doubtful


def test_a_size_that_may_be_anything_is_no_finding() -> None:
    """510 to 1 140 000 um/m is a factor of 2235; a small share alone, or a wide interval of what explains much, is not."""
    wide, tight = Estimate(207.0, 103.0, (510.0, 1.14e6), "um/m"), Estimate(40.0, 2.0, (36.0, 44.0), "urad")
    assert replace(answer(0.99), share=0.001, parameters={"k": wide}).doubtful
    assert not replace(answer(0.99), share=0.001, parameters={"k": tight}).doubtful
    assert not replace(answer(0.99), share=0.3, parameters={"k": wide}).doubtful
    said = doubt_remarks((replace(answer(0.99), share=0.001, parameters={"k": wide}),))
    assert "orders of magnitude" in said[0]


def test_doubtful_names_and_folds_made_worse_speak_against_the_names() -> None:
    assert doubt_remarks((answer(0.9),)) == ()
    worse = replace(answer(0.9), withheld_because="it makes rows worse that were not fitted (far zone Y)")
    said = doubt_remarks((answer(0.9), answer(0.2), worse))
    assert len(said) == 2
    assert "backlash X is a candidate" in said[0]
    assert "far zone Y" in said[1]


def test_a_place_is_said_where_nothing_is_named_only_if_it_is_sure_and_then_it_counts() -> None:
    sure, weak = (Place("X", "x", p, "the residual in x depends on X", 9.0) for p in (0.005, 0.04))
    assert clear_places((weak,), named=False) == ((), ())
    places, why = clear_places((sure, weak), named=False)
    assert places == (sure,)
    assert len(why) == 1
    assert clear_places((sure, weak), named=True) == ((sure, weak), ())


def test_the_scatter_is_compared_whatever_was_found_about_it() -> None:
    """hypot(1.5, sqrt 1.5625) = hypot(1.5, 1.25) = 1.953: what strong templates leave is forgiven."""
    heavy = Audit(1.8, 0.0, 0.0, Noise(4.0), ("heavy tails", "the noise is 1.8 times what was stated"), 1.5)
    assert "1.8 times what was stated (2.2 times by rms)" in unstated_scatter(heavy, 2.2)
    assert unstated_scatter(heavy, 2.2, 1.5625) == ""
    assert unstated_scatter(replace(heavy, scale=1.4), 2.2) == ""


@pytest.fixture(scope="module")
def quiet():
    recording = make.make((), 0.0, 41).recording
    problem = make_problem(recording, make.machine())
    return problem, problem.whitener()


def looked_at(quiet, e: np.ndarray) -> Audit:
    """The audit of noise e in units of u."""
    problem, white = quiet
    return audit(problem, white, white.apply(e * problem.u), 1)


def scatter(problem, name: str, rng: np.random.Generator) -> np.ndarray:
    base = rng.standard_t(6, problem.m) / np.sqrt(1.5)  # variance 6 / (6 - 2) = 1.5
    if name == "t3":
        return rng.standard_t(3, problem.m) / np.sqrt(1.5) * 0.938
    if name == "outliers":
        return np.where(rng.random(problem.m) < 0.02, 10.0, base)
    if name == "1.3":
        return 1.3 * base
    if name == "speed":
        column = np.linalg.norm(problem.run.vector("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s"), axis=1)
        speed = problem.per_observation(column)
        return base * np.clip(0.7 + 0.3 * speed / np.median(speed), 0.7, 3.0)
    return chain_noise(base[:, None], problem.before, float(name[2:]))[:, 0]


@pytest.mark.parametrize("name", ["t3", "outliers", "1.3", "speed", "ar0.3", "ar0.6"])
def test_noise_of_the_stated_scale_is_no_alarm_whatever_its_law(quiet, name):
    rng = np.random.default_rng(11)
    alarms = [unstated_scatter(looked_at(quiet, scatter(quiet[0], name, rng)), 1.0) for _ in range(6)]
    assert alarms == [""] * 6


def test_noise_that_was_stated_too_large_is_counted_as_it_is(quiet):
    """0.7 of the stated scatter: u is 0.7 of what was stated within 10 %, so the calibration weighs more beside it."""
    problem, _ = quiet
    base = scatter(problem, "ar0", np.random.default_rng(3))
    found = looked_at(quiet, 0.7 * base)
    assert found.u_factor == pytest.approx(0.7, rel=0.1)
    assert found.u(problem) == pytest.approx(found.u_factor * problem.u)
    assert looked_at(quiet, base).u_factor == 1.0
    assert looked_at(quiet, 1.3 * base).u_factor == 1.0  # more may be physics that is not named yet


def test_twice_the_noise_and_a_movement_in_it_are_told(quiet):
    problem, _ = quiet
    rng = np.random.default_rng(12)
    assert unstated_scatter(looked_at(quiet, 2.0 * scatter(problem, "t3", rng)), 1.0)
    slow = 2.0 * np.sin(0.6 * np.arange(problem.m))  # correlation (gamma2 / gamma1 - 1) = 2.28 / 1.35 - 1
    found = looked_at(quiet, scatter(problem, "ar0.0", rng) + slow)
    assert found.rho > 0.6
    assert unstated_scatter(found, 1.0)


def test_a_fold_that_the_names_make_worse_is_named(quiet):
    """A cubic of time fitted on the first 70 % of a step in mid-time runs away over the last 30 %."""
    problem, _ = quiet
    time = problem.per_observation(problem.run.column("time_s"))
    t = (time - time.min()) / np.ptp(time)
    residual = 5.0 * problem.u * (np.abs(t - 0.5) < 0.2)
    case = replace(problem, residual=residual, nuisance=problem.nuisance[:, :0])
    columns = np.stack([t, t**2, t**3, t**4], axis=1) * np.median(problem.u)
    option = Option(None, columns, np.ones(4), ("a", "b", "c", "d"), 0.0)
    family = Family("drift", {}, (option,))
    white = whitener(case.u, case.nuisance, case.calibration)
    setting = Setting(
        dictionary([family], white),
        white,
        white.apply(residual),
        np.inf,
        3.0,
        lambda option, r, basis: option,
    )
    selection = fit_jointly([SelectedTerm(family, option, white.apply(columns), 64.0)], setting)
    parts = [p for p in folds(case, case.u, 0.0) if p.name == "later time"]
    assert worsened_folds(case, parts, selection) == ("later time",)


def test_a_ringing_is_no_candidate_where_no_row_comes_after_an_acceleration() -> None:
    """On a circle the acceleration never ends: time zero, sine 0, cosine 1, the sense of the axis alone: a backlash."""
    sense = np.where(np.arange(50) < 25, 1.0, -1.0)
    here = Run({"X": np.linspace(0.0, 100.0, 50)}, np.zeros((50, 3)), {"sense_X": sense}, {}, {})
    moving = here.with_columns({"time_since_accel_s": np.zeros(50)})
    waiting = here.with_columns({"time_since_accel_s": np.full(50, 0.3)})
    assert trials(StructuralVibration("X"), moving) == []
    assert len(trials(StructuralVibration("X"), waiting)) == 24  # 8 frequencies x 3 damping ratios


def test_a_name_that_closes_the_account_of_a_strong_one_is_taken_and_one_that_does_not_is_held_for_its_error() -> (
    None
):
    """Strong 1000: without the weak one the rest is 81 + 225 of 100 rows, sigma = 1.75, allowance 0.5 (0.05 x 571)^2 = 408
    nats; the weak one brings 50 ln(306 / 81) = 66 and leaves 81 < 100 + 2.33 sqrt 200. With 400 more, 481 stay open.
    """
    rng = np.random.default_rng(3)
    q = np.linalg.qr(rng.standard_normal((100, 3)))[0]
    none = np.zeros((100, 0))
    white = whitener(np.ones(100), none, none)

    def family(name: str, column: np.ndarray) -> Family:
        return Family(name, {}, (Option(None, 10.0 * column[:, None], np.ones(1), ("k",), 0.0),))

    families = [family("strong", q[:, 0]), family("weak", q[:, 1])]
    found = dictionary(families, white)
    noise = rng.standard_normal(100)
    y = 1000.0 * q[:, 0] + 15.0 * q[:, 1] + 0.9 * noise / np.std(noise)
    names = []
    for raw in (y, y + 20.0 * q[:, 2]):
        setting = Setting(found, white, raw, np.inf, 3.0, lambda option, r, basis: option)
        names.append({t.family.name for t in select(setting).terms})
    assert names == [{"strong", "weak"}, {"strong"}]


def test_two_free_curves_over_one_component_explain_nothing():
    def curve(name: str, component: str) -> Answer:
        return replace(answer(0.99), effect=name, where={"component": component})

    both = (curve("geometric_change", "EXX"), curve("map_interpolation", "EXX"))
    (said,) = shared_curve_remarks(both)
    assert "over EXX" in said
    assert verdict(True, shared_curve_remarks(both)) == "partly explained"
    assert shared_curve_remarks((both[0], curve("map_interpolation", "EYX"))) == ()


def test_small_probabilities_are_not_told_to_digits():
    assert describe_probability(0.0463) == "0.046"
    assert describe_probability(1.7e-51) == "below 0.001"
