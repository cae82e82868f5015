"""Long recordings: the choice of rows, candidates screened in some rows, names fitted to all rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.answer.evaluation.gaussian import whitener
from vcmm.core.run import Run
from vcmm.learn.diagnosis import engine
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.evidence import dictionary, scorer
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.result import diagnosis_json
from vcmm.learn.diagnosis.row_order import sort_rows
from vcmm.learn.diagnosis.thinning import (
    best_options,
    choose_rows,
    one_per_stretch,
    size_loss,
    take_rows,
    thin_problem,
)


def run_of(n: int, **columns: np.ndarray) -> Run:
    labels = {k: v for k, v in columns.items() if v.dtype.kind == "U"}
    numbers = {k: v for k, v in columns.items() if v.dtype.kind != "U"}
    return Run({"X": np.arange(float(n))}, np.zeros((n, 3)), numbers, labels)


def test_one_row_of_every_stretch():
    rows = one_per_stretch(100, 25)
    assert np.array_equal(rows // 4, np.arange(25))  # one of 0 to 3, one of 4 to 7 ...
    assert len(np.unique(rows % 4)) == 4  # at random: no wave of four rows is lost or folded


def test_every_pose_and_sense_keeps_its_share_and_rare_rows_stay():
    pose = np.repeat(np.array(["a", "b", "rare"]), [600, 390, 10])
    sense = np.where(np.arange(1000) % 7 == 0, -1.0, 1.0)
    since = np.full(1000, 50.0)
    since[::250] = 0.01  # four rows just after a reversal
    out = choose_rows(run_of(1000, pose=pose, sense_X=sense, since_reversal_X_mm=since), 0.2)
    assert abs(out[pose == "a"].sum() - 120) <= 12
    assert abs(out[pose == "b"].sum() - 78) <= 12
    assert out[pose == "rare"].all()
    assert out[since < 1].all()
    assert abs(out[sense < 0].mean() - 0.2) < 0.05
    assert 200 <= out.sum() <= 220


def test_neither_words_of_labels_nor_units_nor_the_order_of_the_file_choose():
    case = make.make((), 0.0, 3, replace(make.RICH, n=300)).recording
    machine = make.machine()
    shuffle = np.random.default_rng(1).permutation(300)
    run = case.run.take(shuffle)
    words = {k: np.array([f"z{9 - int(v[1:])}" for v in run.labels[k]]) for k in run.labels}
    other = replace(
        case, run=replace(run, labels=words), value=case.value[shuffle], direction=case.direction[shuffle]
    )
    kept = []
    for one in (case, other):
        problem = make_problem(sort_rows(one, machine), machine)
        kept.append(problem.recording.value[choose_rows(problem.run, 0.3)])
    assert np.array_equal(*kept)
    ways = {c: v * 25.4 for c, v in case.run.columns.items() if c.startswith("since_reversal_")}
    assert np.array_equal(choose_rows(case.run, 0.3), choose_rows(case.run.with_columns(ways), 0.3))


def test_rows_that_are_gone_leave_second_ends_and_lines_right():
    case = make.make((), 0.0, 3, replace(make.RICH, n=10)).recording
    run = case.run.take(np.arange(4))
    recording = replace(
        case, kind="length", run=run, value=np.arange(4.0), row=np.arange(4), other=np.array([-1, 0, 0, 1]),
        direction=case.direction[:4], lines=np.arange(10, 14),
    )  # fmt: skip
    some = take_rows(recording, np.array([False, False, True, True]))
    assert list(some.value) == [2.0, 3.0]
    assert list(some.row) == [2, 3]
    assert list(some.other) == [0, 1]
    assert list(some.lines) == [10, 11, 12, 13]
    assert some.run.n == 4


def test_logs_and_reversals_are_those_of_all_rows():
    case = make.make((), 0.0, 3, replace(make.RICH, n=900)).recording
    whole = make_problem(sort_rows(case, make.machine()), make.machine())
    some = thin_problem(whole, 100)
    assert whole.nuisance.shape[1] == 39
    assert 390 <= some.m <= 480
    assert thin_problem(whole, 900) is whole
    assert some.run.series["air"].time.size == whole.run.series["air"].time.size
    at = np.searchsorted(whole.run.column("time_s"), some.run.column("time_s"))
    lagged = whole.run.lag("air", 1800.0)[at]
    assert np.allclose(some.run.lag("air", 1800.0), lagged, atol=1e-12)


def test_what_is_dropped_keeps_its_share_of_the_prior():
    rng = np.random.default_rng(2)
    white = whitener(np.ones(50), np.zeros((50, 0)), np.zeros((50, 0)))
    columns = rng.standard_normal((50, 8))
    options = tuple(Option(None, columns[:, [k]], np.ones(1), (str(k),), -float(np.log(8))) for k in range(8))
    found = dictionary([Family("one", {}, options, -1.0)], white)
    y = 3.0 * columns[:, 6] + 0.1 * rng.standard_normal(50)
    best = best_options(found, 0, [scorer(found).options(y[:, None])[:, 0]])
    assert len(best.options) == 5
    assert any(o.labels == ("6",) for o in best.options)
    assert best.log_prior == pytest.approx(-1.0 + np.log(5 / 8))
    again = dictionary([best], white)
    assert scorer(again).scores(y[:, None])[0, 0] == pytest.approx(
        scorer(found).scores(y[:, None])[0, 0], abs=1e-6
    )


@pytest.fixture(scope="module")
def three_ways() -> list:
    """All 500 rows at once; candidates screened in 200 of them; names searched in 250 and fitted to all."""
    case = make.make(("lost_motion",), 18.0, 12, replace(make.RICH, n=500, poses=2, styli=2))
    out = []
    with pytest.MonkeyPatch.context() as patch:
        for screen, largest in ((10**6, 10**6), (200, 10**6), (10**6, 250)):
            patch.setattr(engine, "MOST_SCREENED", screen)
            patch.setattr(engine, "LARGEST", largest)
            out.append(diagnose_recording(case.recording, make.machine(), 1, 100))
    return out


@pytest.mark.thorough
def test_the_answer_is_that_of_all_rows(three_ways):
    plain, screened, half = three_ways
    names = [[a.id for a in d.found] for d in three_ways]
    assert names[0] == names[1] == names[2]
    assert names[0][0].startswith("lost_motion")
    for d in (screened, half):
        for key, e in plain.found[0].parameters.items():
            assert d.found[0].parameters[key].value == pytest.approx(e.value, abs=0.3 * e.u)
            assert d.found[0].parameters[key].u == pytest.approx(e.u, rel=0.15)
        assert d.fit.after == pytest.approx(plain.fit.after, rel=2e-3)
        assert [h.fold for h in d.fit.held_out] == [h.fold for h in plain.fit.held_out]


@pytest.mark.thorough
def test_what_thinning_loses_is_said(three_ways):
    plain, screened, half = (diagnosis_json(d) for d in three_ways)
    whole = {"observations": 500, "of": 500, "recorded": 500, "loss": 1.0}
    assert plain["searched"] == screened["searched"] == whole
    told = half["searched"]
    assert 250 <= told["observations"] < 360
    assert told["of"] == 500
    assert told["loss"] == pytest.approx(size_loss(told["observations"], 500))
    assert size_loss(25, 100) == 2.0
    (warning,) = (w for w in three_ways[2].warnings if "searched in" in w)
    assert f"{told['observations']} of 500" in warning
    assert "of all rows" in warning
    assert not [w for d in three_ways[:2] for w in d.warnings if "searched in" in w]
