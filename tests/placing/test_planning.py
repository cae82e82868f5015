"""The best plan under a budget: the curve, files that read back, bad input."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.build import DIAMETER
from tests.build import scenario as job
from tests.plate import edited
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.files.scenario import load_scenario
from vcmm.measuring.plan import Plan, Step, Stylus
from vcmm.placing.planfiles import plan_files, plan_json
from vcmm.placing.planning import optimise_plan


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    scenario = load_scenario(edited(tmp_path_factory.mktemp("plan")))
    return scenario, optimise_plan(scenario, 30.0)


def test_the_curve_falls_and_beats_the_present_plan(planned):
    _, result = planned
    seconds = [p.seconds for p in result.pareto]
    worth = [p.objective for p in result.pareto]
    assert seconds == sorted(seconds)
    assert worth == sorted(worth, reverse=True)
    assert result.chosen.seconds <= 30.0
    quicker = [p for p in result.pareto if p.seconds <= result.present.seconds]
    assert min(p.objective for p in quicker) < result.present.objective


def test_the_chosen_plan_reads_back_and_takes_the_time_it_says(planned, tmp_path: Path):
    scenario, result = planned
    for name, text in plan_files(result.plan, scenario.qualifications).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    source = edited(tmp_path).read_text(encoding="utf-8")
    head, rest = source.split("[plan]\n")
    tail = rest[rest.index("[environment]") :]
    lines = head.splitlines()
    at = lines.index("[machine]")
    (tmp_path / "again.toml").write_text(
        "\n".join([*lines[:at], 'plan = "plan.toml"', *lines[at:]]) + "\n" + tail
    )
    again = load_scenario(tmp_path / "again.toml")
    assert [s.feature for s in again.plan.steps] == [s.feature for s in result.plan.steps]
    for ours, theirs in zip(result.plan.steps, again.plan.steps):
        assert np.allclose(ours.points, theirs.points, atol=1e-8)
    assert again.plan.touch == scenario.plan.touch
    assert again.plan.alignment == scenario.plan.alignment
    time = again.task().touches.run.column("time_s")[-1]
    assert time == pytest.approx(result.chosen.seconds, rel=1e-6)  # one stylus: no changes


def test_json_says_what_was_found(planned):
    scenario, result = planned
    body = plan_json(scenario, result)
    assert body["chosen"]["minutes"] == pytest.approx(result.chosen.seconds / 60.0)
    assert sum(body["chosen"]["points"].values()) == body["chosen"]["touches"]
    assert body["pareto"][0]["characteristics"][0]["U_mm"] > 0


def test_bad_input_is_named():
    scenario = job(characteristics=(DIAMETER,))
    with pytest.raises(UsageError, match='unknown characteristic "diametre"'):
        optimise_plan(scenario, 60.0, weights={"diametre": 1.0})
    with pytest.raises(UsageError, match="criterion"):
        optimise_plan(scenario, 60.0, criterion="E")
    with pytest.raises(ModelLimit, match=r"the shortest plan takes .* s, the budget is 1 s"):
        optimise_plan(scenario, 1.0)


def test_a_feature_that_no_stylus_reaches_is_named():
    scenario = job()
    side = Stylus("side", np.array([0.0, 0.0, 100.0]), 2.0, 100.0)  # points up
    steps = tuple(Step(s.feature, "side", s.points, s.normals) for s in scenario.plan.steps)
    with pytest.raises(ModelLimit, match=r"can be touched|no stylus"):
        optimise_plan(replace(scenario, plan=Plan(steps, {"side": side})), 60.0)


def test_a_second_stylus_is_taken_where_it_serves_better():
    """One stylus is too short to go down the bore (its head of 60 mm does not): the long one takes over."""
    scenario = job(characteristics=(DIAMETER,))
    short = Stylus("short", np.array([0.0, 0.0, -4.0]), 2.0, 4.0)
    plan = scenario.plan
    steps = tuple(replace(s, stylus="short") for s in plan.steps if s.feature == "bore")
    found = optimise_plan(replace(scenario, plan=Plan(steps, {"short": short, **plan.styli})), 20.0, most=10)
    assert found.styli == {"bore": "down"}
    assert {s.stylus for s in found.plan.steps} == {"down"}
