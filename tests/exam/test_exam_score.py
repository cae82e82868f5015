"""Scoring of answers: names, sets, mistakes, intervals, bounds; one small case from concealment to score."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.exam import baselines, blocks
from benchmarks.exam.case import Concealed
from benchmarks.exam.observe import Hidden
from benchmarks.exam.run import Job, numbers_of, run_case, seconds_of
from benchmarks.exam.score import (
    bound,
    confusion,
    intervals,
    mistake_right,
    rate,
    rivals,
    score,
    summarise,
    unit_value,
)

BACKLASH = Concealed("backlash", lambda k: Hidden(), lambda k: {"gap": (k, "um")}, {"axis": "X"})


def _found(effect: str = "backlash", **more):
    interval = {"value": 2.1, "interval95": [1.9, 2.3], "unit": "um"}
    answer = {"effect": effect, "where": {"axis": "X"}, "parameters": {"gap": interval}, "probability": 0.97}
    return {
        "verdict": "explained",
        "answer": [answer | {"cannot_be_told_from": more.get("rivals", [])}],
        "unknown": None,
    }


def _truth(**more) -> blocks.Truth:
    row = {"items": (BACKLASH,), "amplitudes": (2.0,), "deltas": (10.0,), "simple": ((),)} | more
    return blocks.Truth("A", 1, 0, "probe rich", "t6", **row)


def test_units() -> None:
    assert unit_value("um/(m K)") == pytest.approx(1e-6)
    assert unit_value("urad/(m/s^2)") == pytest.approx(1e-6)
    assert unit_value("um at 50 mm") == pytest.approx(1e-6)
    assert unit_value("furlong") is None


def test_clopper_pearson_bounds() -> None:
    # none in 20: upper bound 1 - 0.05^(1/20) = 0.1391; all in 20: lower bound 0.05^(1/20) = 0.8609
    assert bound(0, 20, lower=False) == pytest.approx(0.1391, abs=1e-4)
    assert bound(20, 20, lower=True) == pytest.approx(0.8609, abs=1e-4)
    assert rate([{"a": True}, {"a": False}, {"a": None}], "a")["rate"] == 0.5


def test_right_name_interval_and_set() -> None:
    row = score(_truth(), _found(rivals=["tip_form", "lost_motion[axis=X]"]), 1.0)
    assert row["right"]
    assert row["in_set"]
    assert row["place_right"]
    assert row["exact"]
    assert row["set_size"] == 3
    assert row["extra"] == 0
    assert row["intervals"][0]["inside"]
    assert row["intervals"][0]["ratio"] == pytest.approx(1.05)
    assert rivals(_found(rivals=["lost_motion[axis=X]"])["answer"][0]) == ["backlash", "lost_motion"]


def test_wrong_name_that_holds_the_truth_among_its_rivals() -> None:
    row = score(_truth(), _found("tip_form", rivals=["backlash"]), 1.0)
    assert not row["right"]
    assert row["in_set"]
    assert row["extra"] == 1
    assert not row["wrong_confident"]
    assert score(_truth(), _found("tip_form"), 1.0)["wrong_confident"]


def test_simpler_name_counts_where_no_more_can_be_resolved() -> None:
    lost = Concealed("lost_motion", lambda k: Hidden())
    assert score(_truth(items=(lost,), simple=(("backlash",),)), _found(), 1.0)["right"]
    assert not score(_truth(items=(lost,)), _found(), 1.0)["right"]


def test_interval_in_another_unit_and_of_a_free_sign() -> None:
    wave = Concealed("screw_pitch", lambda k: Hidden(), lambda k: {"amplitude": (k, "um")}, sign_free=True)
    said = {"amplitude": {"value": -0.002, "interval95": [-0.0025, -0.0015], "unit": "mm"}}
    found = {"answer": [{"effect": "screw_pitch", "parameters": said}]}
    assert intervals(wave, 2.0, found)[0]["inside"]
    assert not intervals(wave, 3.0, found)[0]["inside"]


def test_mistakes_are_exact_or_wrong() -> None:
    swap = Concealed(
        "map_mistake",
        lambda k: Hidden(),
        where={"component": "EXX", "what": "swapped with EYX"},
        also=("EYX:swapped with EXX",),
    )
    assert mistake_right(swap, {"mistake": {"component": "EYX", "what": "swapped with EXX"}})
    assert not mistake_right(swap, {"mistake": {"component": "EXX", "what": "sign"}})
    assert not mistake_right(swap, {"mistake": None})


def test_false_alarms_are_counted_by_world() -> None:
    quiet = {"verdict": "nothing missing", "answer": [], "unknown": None}
    rows = [
        score(blocks.Truth("B", 1, i, "probe rich", w), f, 1.0)
        for i, (w, f) in enumerate([("t6", quiet), ("t3", _found())])
    ]
    out = summarise(rows)
    assert out["false_alarm"]["rate"] == 0.5
    assert out["false_alarm_by_world"]["t6"]["rate"] == 0.0
    assert confusion(rows) == {"(nothing)": {"nothing": 1, "backlash": 1}}


def test_command_line_words() -> None:
    assert numbers_of("3") == [0, 1, 2]
    assert numbers_of("7,9-10") == [7, 9, 10]
    assert seconds_of("10min") == 600
    with pytest.raises(ValueError, match="--budget"):
        seconds_of("soon")


def test_baselines_find_a_column_of_their_own_library(tmp_path) -> None:
    case = blocks.build("A", 3, 0, tmp_path, rows=200)
    names, columns = zip(*baselines.library(case.design))
    pick = names.index("trigger_delay")
    values = columns[pick] / np.linalg.norm(columns[pick]) * 0.05 + 1e-3 * np.random.default_rng(1).normal(
        size=200
    )
    said = baselines.all_names(case.design, values)
    assert said["stepwise"] == said["lasso"] == "trigger_delay"
    assert said["gp"] in (None, "unknown")


@pytest.mark.thorough
def test_a_strong_scale_factor_goes_through_the_whole_exam() -> None:
    number = next(
        i for i in range(len(blocks.RICH)) if blocks.plan("A", i)[:2] == ("laser", ("scale_factor",))
    )
    row = run_case(Job("A", 3, number, 25.0, 160, None, rivals=True))
    assert not row.get("error")
    assert row["in_set"]
    assert row["baselines"].keys() == {"stepwise", "lasso", "refit", "stlsq", "gp"}
