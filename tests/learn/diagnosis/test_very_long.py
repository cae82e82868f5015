"""Very long recordings: which observations are taken, what they keep, and that it is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.core.run import Run, Series
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.result import diagnosis_json
from vcmm.learn.diagnosis.thinning import average_log, limit_observations, limit_together, thinning_notes
from vcmm.show.pages.diagnosis import diagnosis_page
from vcmm.task.response.joining import join_recordings
from vcmm.task.response.recording import Recording


def axis_log(n: int = 1000, setups: int = 2) -> Recording:
    """One axis to and fro over time, an observation per row whose value is the number of the row in um."""
    time = np.arange(float(n))
    x = 10.0 * np.abs((time / 50.0) % 2.0 - 1.0)
    columns = {"time_s": time, "sense_X": np.where((time // 50) % 2 == 0, -1.0, 1.0)}
    labels = {"setup": np.array([f"s{k}" for k in (np.arange(n) * setups // n)])}
    log = {"air": Series(time, 20.0 + 0.01 * time), "accel_X_mm_s2": Series(time, time)}
    run = Run({a: x * (a == "X") for a in "XYZ"}, np.zeros((n, 3)), columns, labels, log)
    direction = np.tile([1.0, 0.0, 0.0], (n, 1))
    none = np.full(n, -1)
    return Recording("log", "displacement", run, time * 1e-3, True, np.arange(n), direction, none)


def test_about_so_many_are_taken_evenly_and_keep_what_they_know():
    some = limit_observations(axis_log(), 100)
    row = np.round(some.value * 1e3).astype(int)
    assert some.chosen_from == 1000
    assert 100 <= some.m <= 110
    assert np.array_equal(some.run.column("time_s"), row)
    assert (
        np.diff(row).max() <= 40
    )  # one of each 20 of a set-up and sense: never further apart than two stretches
    assert {0, 500} <= set(row)  # from these the lengths of the two set-ups are counted
    assert abs((some.run.columns["sense_X"] > 0).mean() - 0.5) < 0.05
    assert limit_observations(some, 200) is some
    assert limit_observations(some, 50).chosen_from == 1000


def test_the_order_of_the_file_does_not_choose():
    whole = axis_log()
    shuffle = np.random.default_rng(3).permutation(whole.m)
    other = replace(
        whole, kind="probe", run=replace(whole.run.take(shuffle), series={}), value=whole.value[shuffle]
    )
    some = limit_observations(replace(whole, kind="probe"), 100)
    assert sorted(limit_observations(other, 100).value) == sorted(some.value)


def test_several_take_the_same_share_of_each():
    long, short = axis_log(3000), replace(axis_log(1000), name="other")
    some = limit_together([long, short], 400)
    assert [r.chosen_from for r in some] == [3000, 1000]
    assert [round(r.m, -1) for r in some] == [300, 100]
    assert join_recordings(some, make.machine()).recording.chosen_from == 4000
    both = [axis_log(100), replace(axis_log(100), name="other")]
    assert limit_together(both, 200) is both
    assert join_recordings(both, make.machine()).recording.chosen_from == 0


def test_a_log_becomes_means_of_stretches():
    log = average_log(Series(np.array([0.0, 1.0, 2.0, 3.0, 4.0]), np.array([1.0, 3.0, 5.0, 7.0, 12.0])), 2)
    assert log.time.tolist() == [0.5, 3.0]  # (0 + 1) / 2, (2 + 3 + 4) / 3
    assert log.value.tolist() == [2.0, 8.0]
    plain = Series(np.arange(3.0), np.arange(3.0))
    assert average_log(plain, 3) is plain


def test_temperatures_are_averaged_and_what_rings_is_not(monkeypatch):
    monkeypatch.setattr(average_log, "__defaults__", (10,))
    series = limit_observations(axis_log(), 100).run.series
    assert len(series["air"].time) == 10
    assert np.allclose(series["air"].value, 20.0 + 0.01 * series["air"].time)
    assert len(series["accel_X_mm_s2"].time) == 1000


def test_what_was_taken_is_told():
    assert thinning_notes(axis_log()) == ()
    (said,) = thinning_notes(replace(axis_log(101), chosen_from=2525))
    assert "of 2525 observations 101 were taken" in said
    assert "1 s apart" in said
    assert "5.0 times as wide" in said  # sqrt(2525 / 101)


@pytest.mark.thorough
def test_the_diagnosis_of_the_taken_is_that_of_a_recording_of_these(monkeypatch):
    case = make.make(("backlash",), 25.0, 5, replace(make.RICH, n=900, poses=1, styli=1))
    monkeypatch.setattr(limit_observations, "__defaults__", (400,))
    found = diagnose(case.recording, make.machine(), seed=1)
    some = limit_observations(case.recording)
    same = diagnose_recording(some, make.machine(), seed=1)
    assert [a.id for a in found.found] == [a.id for a in same.found] == [f"backlash[{case.where[0]}]"]
    assert found.fit == same.fit
    monkeypatch.setattr("vcmm.show.pages.diagnosis.MOST_DRAWN", 100)
    page = diagnosis_page(some, make.machine(), found)
    assert f"of {some.m} observations, evenly over the rows" in page
    told_of = diagnosis_json(found)["searched"]
    assert told_of["recorded"] == 900
    assert told_of["of"] == some.m
    assert told_of["loss"] == pytest.approx((900 / some.m) ** 0.5)
    assert found.warnings[0].startswith(f"of 900 observations {some.m} were taken")
