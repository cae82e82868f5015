"""A plan as files reads back to the same plan; the curve as JSON."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.answer.placing.planfiles import plan_files, plan_json
from vcmm.files.own.scenario import load_scenario


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
    assert time == pytest.approx(result.choice.seconds, rel=1e-6)  # one stylus: no changes


def test_json_says_what_was_found(planned):
    scenario, result = planned
    body = plan_json(scenario, result)
    assert body["chosen"]["minutes"] == pytest.approx(result.choice.seconds / 60.0)
    assert sum(body["chosen"]["points"].values()) == body["chosen"]["touches"]
    assert body["pareto"][0]["characteristics"][0]["U_mm"] > 0
