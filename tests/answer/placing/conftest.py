"""One placement and one plan that several tests look at."""

from __future__ import annotations

import pytest

import vcmm
from tests.answer.placing.cases import plate, with_field
from tests.plate import edited
from vcmm.answer.placing.planning import optimise_plan
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.fixture import Goal


@pytest.fixture(scope="session")
def placed(tmp_path_factory):
    scenario = with_field(plate(tmp_path_factory.mktemp("plate")), 3)
    goal = Goal({"U": 1.0}, {"bore diameter": 0.5, "bore to front": 0.5})
    return vcmm.place(scenario, goal=goal, evaluations=800, scanned=256, trials=10_000, constraints=())


@pytest.fixture(scope="session")
def planned(tmp_path_factory):
    scenario = load_scenario(edited(tmp_path_factory.mktemp("plan")))
    return scenario, optimise_plan(scenario, 30.0)
