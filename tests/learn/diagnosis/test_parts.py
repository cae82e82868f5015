"""Pieces of the method: scans, threshold, noise audit, localisation shapes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.core.run import Run
from vcmm.learn.diagnosis.addons import ADDONS, instruction, minutes_of
from vcmm.learn.diagnosis.candidates import build_catalogue
from vcmm.learn.diagnosis.estimates import _estimate
from vcmm.learn.diagnosis.evidence import dictionary, scorer
from vcmm.learn.diagnosis.locate import generic_families, polynomials, surface, without_unit
from vcmm.learn.diagnosis.noise import audit, neighbour_correlation
from vcmm.learn.diagnosis.null_recordings import clip_residuals, upper_quantile
from vcmm.learn.diagnosis.problem import make_problem, predecessors
from vcmm.learn.diagnosis.scans import change_points, fill_gaps, spectral_lines


def problem(noise="t6", names=(), delta=0.0, seed=3):
    return make_problem(make.make(names, delta, seed, noise=noise).recording, make.machine())


def test_gaps_between_time_constants_are_filled():
    # 60 to 240 is a factor 4: their geometric mean 120 is added; 240 to 300 is not filled
    assert fill_gaps([60.0, 240.0, 300.0, 0.0]) == [0.0, 60.0, pytest.approx(120.0), 240.0, 300.0]


def test_spectral_lines_follow_the_travel():
    q = np.linspace(0, 100, 41)
    lines = spectral_lines(q)
    assert lines[0] == pytest.approx(100 / 1.5)
    assert lines[1] == pytest.approx(50.0)
    assert min(lines) >= 100 / 20.5  # 41 places cannot show more than 20 waves
    assert spectral_lines(np.zeros(50)) == []


def test_change_points_keep_ten_rows_on_each_side():
    run = Run({"X": np.zeros(24)}, np.zeros((24, 3)), {"time_s": np.arange(24.0)})
    assert change_points(run) == [9.5, 10.5, 11.5, 12.5, 13.5]


def test_order_statistic_bound_lies_above_the_quantile():
    values = np.arange(2000.0)
    # binomial(2000, 0.99): mean 1980, sd 4.45; 95 % point 1987 (0-based rank)
    assert 1985 <= upper_quantile(values, 0.01) <= 1989


def test_predecessors_of_points_with_three_components():
    assert list(predecessors(np.array([0, 0, 0, 1, 1, 1]))) == [-1, -1, -1, 0, 1, 2]
    assert list(predecessors(np.arange(3))) == [-1, 0, 1]


def test_clipping_pulls_outliers_only():
    w = problem().whitener()
    r = np.zeros(500)
    r[::2], r[1::2] = 1.0, -1.0
    r[0] = 50.0
    assert clip_residuals(r, w, 3.0)[0] < 5.0


def test_neighbour_correlation_ignores_a_drift_and_sees_ar():
    rng = np.random.default_rng(1)
    n = 4000
    before = np.arange(n) - 1
    white = rng.standard_normal(n)
    assert abs(neighbour_correlation(white + np.linspace(0, 20, n), before)) < 0.06
    ar = np.zeros(n)
    for i in range(1, n):
        ar[i] = 0.6 * ar[i - 1] + white[i]
    assert neighbour_correlation(ar, before) == pytest.approx(0.6, abs=0.06)


def test_noise_audit_names_what_is_wrong_and_only_that():
    for noise, word in (("t6", ""), ("outliers", "outliers"), ("ar0.6", "correlated"), ("speed", "speed")):
        p = problem(noise)
        w = p.whitener()
        findings = audit(p, w, w.apply(p.residual), 1).findings
        assert [f for f in findings if word in f] if word else not findings, (noise, findings)


def test_shapes_of_localisation():
    x = np.linspace(-1, 1, 9)
    assert np.allclose(polynomials(x)[:, 2], (3 * x**2 - 1) / 2)  # Legendre P2
    assert polynomials(np.array([0.0, 1.0, 0.0])).shape == (3, 2)  # two values carry one degree
    assert surface(x, x).shape == (9, 6)
    assert without_unit("speed_X_mm_s") == "speed_X"
    assert without_unit("time_s") == "time"


def test_missing_columns_make_effects_untestable_by_name():
    p = problem()
    found = build_catalogue(p)
    assert "structural_vibration" in found.not_testable
    assert "backlash" in {f.name for f in found.families}
    where = {f.where["axis"] for f in found.families if f.name == "backlash"}
    assert where == {"X", "Y", "Z"}


def test_the_true_template_has_the_highest_score():
    p = problem(names=("backlash",), delta=12.0)
    w = p.whitener()
    found = dictionary(build_catalogue(p).families, w)
    scores = scorer(found).scores(w.apply(p.residual)[:, None])[:, 0]
    assert found.families[int(np.argmax(scores))].name == "backlash"


def test_generic_shapes_cover_positions_time_and_labels():
    names = {f.name for f in generic_families(problem())}
    assert {"X", "X and Y", "time", "time (step)", "pose", "probe_angle", "sense_X"} <= names


def test_the_gate_refuses_what_makes_one_kind_of_rows_clearly_worse():
    from vcmm.learn.diagnosis.holdout import _is_refused

    assert not _is_refused(np.array([12.0, 8.0, -2.0]))  # within what estimation costs
    assert _is_refused(np.array([12.0, 8.0, -7.0]))  # a wrong shape: seven nats lost on rows of one kind
    assert not _is_refused(np.array([300.0, 80.0, -7.0]))  # no template is exact
    assert _is_refused(np.array([1.0, -4.0]))
    assert _is_refused(np.array([2.0, -1.0, -1.0]))


def test_the_interval_of_a_length_holds_its_value_and_that_of_a_step_reaches_its_rows():
    draws = np.hypot(
        *np.random.default_rng(1).normal(0.1, 1.0, (2, 4000))
    )  # all lengths lie far above that of the mean
    found = _estimate(0.14e-3, 1e-3, draws * 1e-3, "um")
    assert found.interval95[0] <= found.value <= found.interval95[1]


def test_minutes_follow_the_recording():
    touched = make_problem(make.make((), 0.0, 3, replace(make.RICH, n=60)).recording, make.machine())
    log, speed = ADDONS[-1], ADDONS[0]
    hours = np.ptp(touched.run.columns["time_s"]) / 3600
    assert minutes_of(log, touched) == round(120 * hours)
    assert minutes_of(speed, touched) == 15.0  # 5 min and 60 touches of 10 s
    short = touched.run.with_columns({"time_s": touched.run.columns["time_s"] * 84 / (3600 * hours)})
    run = replace(touched, run=short, recording=replace(touched.recording, run=short, kind="path"))
    assert minutes_of(log, run) == pytest.approx(2.8)  # twice 84 s
    assert instruction(speed, run).startswith("repeat some rows")
