"""What the documentation of version 0.1.0 imported is importable still, and is one object under both names."""

from __future__ import annotations

import importlib

import pytest

from vcmm.former_paths import FORMER

# module -> names that README, CONTRIBUTING and docs of 0.1.0 imported from it
NAMED = {
    "vcmm.compensating.job": "compensate",
    "vcmm.cutting.contactmap": "audit contact_map",
    "vcmm.cutting.envelope": "surface_left",
    "vcmm.cutting.sweeps": "join lines",
    "vcmm.cutting.tools": "ball",
    "vcmm.diagnosis.improve": "improved",
    "vcmm.effect": "Effect at motion param parameter_fields place_fields",
    "vcmm.effects": "ALL",
    "vcmm.errors": "ModelLimit",
    "vcmm.files.scenario": "load_scenario",
    "vcmm.fixture": "Fixture Freedom Goal pose_of six_of",
    "vcmm.kinematics": "Axis parse_structure",
    "vcmm.laws": "Normal StudentT",
    "vcmm.library": "path",
    "vcmm.machine": "Machine",
    "vcmm.machining.job": "finished_part",
    "vcmm.machining.shop": "set_up",
    "vcmm.nc.dialects": "register",
    "vcmm.nc.interpret": "interpret",
    "vcmm.nc.limits": "Control",
    "vcmm.nc.moves": "Move Source",
    "vcmm.nc.radius": "centre_path",
    "vcmm.nc.setup": "Setup Tool",
    "vcmm.nc.tokens": "tokenize",
    "vcmm.nc.toolpath": "summary toolpath",
    "vcmm.pages.shown": "text",
    "vcmm.pages.test_piece": "tables",
    "vcmm.placing.planfiles": "plan_files",
    "vcmm.placing.planning": "optimise_plan",
    "vcmm.placing.reach": "Feasibility",
    "vcmm.placing.relax": "relaxation",
    "vcmm.run": "Array Run",
    "vcmm.twins": "abbe_milling gaska2014 marin2004 test_piece_errors",
    "vcmm.twins.marin2004_day": "PARAMETERS UNITS",
    "vcmm.twins.virtual_cut": "departure",
    "vcmm.units": "EXAMPLES dimension_of parse_unit",
}


@pytest.mark.parametrize("module", NAMED)
def test_what_was_documented_is_importable(module):
    for name in NAMED[module].split():
        exec(f"from {module} import {name}", {})


@pytest.mark.parametrize("former", FORMER)
def test_a_former_path_is_the_module_of_today(former):
    today = importlib.import_module(FORMER[former])
    assert importlib.import_module(former) is today
    assert today.__spec__ is not None
    assert today.__spec__.name == FORMER[former]
