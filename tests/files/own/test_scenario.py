"""Scenario files: sections here or in files of their own, knowledge collected, every name checked."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.plate import PLATE, edited, line_of
from vcmm.core.errors import DataError
from vcmm.files.own.library import example as shipped
from vcmm.files.own.scenario import load_scenario
from vcmm.files.own.schemas import MODELS, json_schema

SHIPPED = shipped("plate").parent


def _split(folder: Path) -> Path:
    """The same scenario with machine, part, plan and environment in files of their own."""
    sections = {"machine": "[machine]", "part": "[part]", "plan": "[plan]", "environment": "[environment]"}
    order = ["[machine]", "[part]", "[pose]", "[plan]", "[environment]", "[job]"]
    lines = ['vcmm = "scenario/1"', *(f'{k} = "{k}.toml"' for k in sections)]
    for key, start in sections.items():
        begin = PLATE.index(f"\n{start}\n") + 1
        stop = order[order.index(start) + 1]
        body = PLATE[begin : PLATE.index(f"\n{stop}\n") + 1].replace(f"{start}\n", "", 1)
        body = body.replace(f"[{key}.", "[").replace(f"[[{key}.", "[[")
        (folder / f"{key}.toml").write_text(f'vcmm = "{key}/1"\n{body}')
    pose = PLATE[PLATE.index("[pose]") : PLATE.index("[plan]")]
    path = folder / "split.toml"
    path.write_text("\n".join(lines) + "\n" + pose + PLATE[PLATE.index("[job]") :])
    return path


def test_one_file_or_several_are_the_same_job(tmp_path):
    one, several = load_scenario(edited(tmp_path)), load_scenario(_split(tmp_path))
    assert [e.id for e in one.machine.effects] == [e.id for e in several.machine.effects]
    assert [i.id for i in one.inputs] == [i.id for i in several.inputs]
    assert one.constants == several.constants
    first, second = one.task().touches.run, several.task().touches.run
    assert np.array_equal(first.q("X"), second.q("X"))
    assert one.settings == several.settings


def test_problems_of_a_named_file_carry_its_name_and_line(tmp_path):
    path = _split(tmp_path)
    plan = tmp_path / "plan.toml"
    plan.write_text(plan.read_text().replace('"grid", n = [3, 2]', '"gird", n = [3, 2]'))
    with pytest.raises(DataError) as caught:
        load_scenario(path)
    line = line_of(plan.read_text(), "gird")
    assert str(caught.value).startswith(f"{plan}:{line}: [steps 3.points] A plane has no strategy")


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = _split(tmp_path)
    (tmp_path / "part.toml").write_text((tmp_path / "plan.toml").read_text())
    with pytest.raises(DataError, match=r'part.toml:1: vcmm = "plan/1", but expected a part file'):
        load_scenario(path)


def test_temperatures_become_columns_and_inputs(tmp_path):
    scenario = load_scenario(edited(tmp_path))
    assert scenario.constants["temp_part_C"] == 21.2
    assert scenario.constants["reading_part_C"] == 21.2
    assert scenario.constants["temp_scale_y_C"] == 20.0
    known = {i.id: i.law.u for i in scenario.inputs}
    assert known["channel.temp_part_C"] == pytest.approx(0.1)
    assert known["part_expansion.alpha"] == pytest.approx(1e-6)


def test_gradient_as_in_the_contract(tmp_path):
    for text in ("0.1 degC", "0.1 K"):
        path = edited(tmp_path, ('scale_x = "20.4 degC" }', f'scale_x = "20.4 degC", gradient = "{text}" }}'))
        assert load_scenario(path).constants["temp_gradient_C"] == pytest.approx(0.1)


def test_settings(tmp_path):
    settings = load_scenario(edited(tmp_path)).settings
    assert (settings.trials, settings.seed, settings.p, settings.kind) == (20000, 0, 0.95, "symmetric")


def test_scenario_effects_join_those_of_the_machine(tmp_path):
    more = '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "2 urad"\n[[effects]]\neffect = "tip_radius"\nstylus = "down"\ndr = "0.3 um"\n'
    scenario = load_scenario(edited(tmp_path, ("[job]\n", more + "[job]\n")))
    square = [e for e in scenario.machine.effects if e.name == "squareness"]
    assert len(square) == 1
    assert square[0].angle == pytest.approx(5e-6)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('u_temperature = { part = "0.1 K" }', 'u_temperature = { scale_x = "0.2 K" }', ["channel.temp_scale_x_C has an input already (temperature sensor of scale X)"]),
        ('u_temperature = { part = "0.1 K" }', 'u_temperature = { prat = "0.1 K" }', ['unknown temperature "prat". Did you mean "part"']),
        ('u_temperature = { part = "0.1 K" }', 'u_temperature = { part = "0.1 K" }\npart = { u_sensor = "0.1 K" }', ["say the same thing"]),
        ("[job]\n", '[[effects]]\neffect = "thermal_drift"\ndirection = "z"\nsensor = "ari"\n[job]\n', ['needs the temperature "ari". Did you mean "air"']),
        ("[job]\n", '[[effects]]\neffect = "tip_radius"\nstylus = "dwon"\n[job]\n', ['stylus = "dwon" is not a stylus of the plan. Did you mean "down"']),
        ("[job]\n", '[[inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "1 urad"\n[job]\n', ["has an input already"]),
        ('rule = "probability 95 %"', 'rule = "guard band"', ['unknown rule "guard band". Did you mean "guard band U"']),
        ("trials = 20000", "trials = 10", ["10 trials are too few"]),
        ("trials = 20000", "trials = 1e5", ["trials = 100000.0 must be a whole number"]),
        ("trials = 20000", "seed = -1", ["seed = -1"]),
        ("trials = 20000", "p = 95", ["between 0.5 and 0.999999"]),
    ],
)  # fmt: skip
def test_what_is_refused(tmp_path, old, new, words):
    path = edited(tmp_path, (old, new))
    with pytest.raises(DataError) as caught:
        load_scenario(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:")
    assert all(word in message for word in words), message


def test_the_effect_that_names_no_sensor_is_shown_where_it_stands(tmp_path):
    drift = '[[effects]]\neffect = "thermal_drift"\ndirection = "z"\nsensor = "{}"\n'
    path = edited(tmp_path, ("[job]\n", drift.format("air") + drift.format("prat") + "[job]\n"))
    with pytest.raises(DataError) as caught:
        load_scenario(path)
    line = line_of(path.read_text(), 'sensor = "prat"')
    assert str(caught.value).startswith(f"{path}:{line}: ")


def test_points_from_a_file(tmp_path):
    (tmp_path / "front.csv").write_text(
        "x_mm,y_mm,z_mm,nx,ny,nz\n-30,-40,5,0,-1,0\n30,-40,5,0,-1,0\n0,-40,15,0,-1,0\n"
    )
    path = edited(
        tmp_path, ('points = { strategy = "grid", n = [3, 2], margin = "4 mm" }', 'points = "front.csv"')
    )
    points = load_scenario(path).plan.steps[2].points
    assert points.tolist() == [[-30.0, -40.0, 5.0], [30.0, -40.0, 5.0], [0.0, -40.0, 15.0]]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("x_mm,y_mm,z_mm\n-30,-40,5\n30,-40,5\n0,-39,15\n", 4, ["point 3 lies -1 mm from the nominal surface"]),
        ("x_mm,y_mm,z_mm,nx,ny,nz\n-30,-40,5,0,-1,0\n# note\n30,-40,5,0,1,0\n0,-40,15,0,-1,0\n", 4, ["points into the material"]),
        ("x_mm,y_mm,z\n-30,-40,5\n", 1, ['"z" is there; rename it to "z_mm"']),
        ("x_mm,y_mm,z_mm\n-30,-40,nan\n1,-40,5\n2,-40,5\n", 2, ["is not finite"]),
        ("x_mm,y_mm,z_mm,nx\n-30,-40,5,0\n", 1, ["the column ny is missing"]),
        ("x_mm,y_mm,z_mm\n-30,-40,5\n30,-40,5\n", 1, ["3"]),
    ],
)  # fmt: skip
def test_bad_point_files(tmp_path, text, line, words):
    (tmp_path / "front.csv").write_text(text)
    path = edited(
        tmp_path, ('points = { strategy = "grid", n = [3, 2], margin = "4 mm" }', 'points = "front.csv"')
    )
    with pytest.raises(DataError) as caught:
        load_scenario(path)
    message = str(caught.value)
    assert f"{tmp_path}/front.csv:{line}: " in message, message
    assert all(word in message for word in words), message


def _references(value):
    if isinstance(value, dict):
        if "$ref" in value:
            yield value["$ref"]
        for inner in value.values():
            yield from _references(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from _references(inner)


@pytest.mark.parametrize("kind", MODELS)
def test_json_schema_is_whole(kind):
    schema = json.loads(json.dumps(json_schema(kind)))
    assert schema["title"] == f"vcmm {kind}/1"
    assert schema["properties"]["vcmm"] == {"const": f"{kind}/1"}
    found = set(_references(schema))
    assert all(
        ref.startswith("#/$defs/") and ref.removeprefix("#/$defs/") in schema["$defs"] for ref in found
    )
    assert "$defs" not in json.dumps(schema["properties"]).replace("#/$defs/", "")


@pytest.mark.parametrize("file", sorted(p.relative_to(SHIPPED) for p in SHIPPED.rglob("*.toml")), ids=str)
def test_shipped_files_are_valid_by_their_schema(file):
    data = tomllib.loads((SHIPPED / file).read_text(encoding="utf-8"))
    found = validator(data["vcmm"].partition("/")[0]).iter_errors(data)
    assert [f"{list(e.absolute_path)}: {e.message}" for e in found] == []


@pytest.mark.parametrize(
    ("edit", "at"),
    [
        ({"vcmm": "scenario/2"}, ["vcmm"]),
        ({"plan": None}, []),
        ({"nmae": "x"}, []),
        ({"pose": {"shift": 3}}, ["pose"]),
    ],
)
def test_a_schema_refuses_what_the_reader_refuses(edit, at):
    data = tomllib.loads((SHIPPED / "plate.toml").read_text(encoding="utf-8")) | edit
    found = list(validator("scenario").iter_errors({k: v for k, v in data.items() if v is not None}))
    assert found
    assert list(found[0].absolute_path)[: len(at)] == at


@cache
def validator(kind):
    jsonschema = pytest.importorskip(
        "jsonschema", reason="jsonschema comes with nbformat: pip install vcmm[notebook]"
    )
    return jsonschema.Draft202012Validator(json_schema(kind))


def test_json_schema_knows_effects_and_features():
    schema = json_schema("scenario")
    effects = {e["properties"]["effect"]["const"]: e for e in schema["$defs"]["effect"]["oneOf"]}
    assert effects["backlash"]["required"] == ["effect", "axis"]
    assert set(effects["screw_pitch"]["properties"]) >= {"axis", "amplitude", "period", "harmonic"}
    inside = schema["properties"]["part"]["anyOf"][1]["properties"]["features"]["additionalProperties"][
        "oneOf"
    ]
    assert {f["properties"]["type"]["const"] for f in inside} >= {"plane", "cylinder", "torus"}


def test_one_absolute_limit_is_refused_with_the_deviation(tmp_path):
    # bore of 30 mm: "30.011 mm" is no deviation that a bore of 30 mm could have
    path = edited(tmp_path, ('limits = ["0 mm", "0.021 mm"]', 'limits = ["0 mm", "30.011 mm"]'))
    with pytest.raises(DataError, match=r'write limits = \["0 mm", "0.011 mm"\]'):
        load_scenario(path)


def test_a_point_is_touched_where_it_is_drawn(tmp_path: Path) -> None:
    """strategy = "nominal" of a point: itself, once; another strategy is refused with that word."""
    point = 'corner = { type = "point", point = "10 5 20 mm", normal = [0, 0, 1] }\n[[part.characteristics]]\nname = "bore diameter"'
    step = '[[plan.steps]]\nfeature = "corner"\nstylus = "down"\npoints = { strategy = "nominal" }\n[[plan.steps]]\nfeature = "bore"'
    edits = (
        ('[[part.characteristics]]\nname = "bore diameter"', point),
        ('[[plan.steps]]\nfeature = "bore"', step),
    )
    task = load_scenario(edited(tmp_path, *edits)).task()
    assert task.touches.points[task.touches.rows["corner"]].tolist() == [[10.0, 5.0, 20.0]]
    with pytest.raises(DataError, match=r'A point has no strategy "grid"\. Allowed: nominal'):
        load_scenario(edited(tmp_path, edits[0], (edits[1][0], step.replace("nominal", "grid"))))


@pytest.mark.parametrize("kind", ["line", "plane", "circle", "cylinder"])
def test_a_step_without_points_is_told_what_its_feature_takes(kind):
    """A point feature was told to write a grid, which is refused for a point; it has one place only, and needs no word."""
    from vcmm.files.own.plan import POINTS
    from vcmm.task.measuring.strategies import PATTERNS

    (strategy,) = [w for w in PATTERNS[kind] if f'"{w}"' in POINTS[kind]]
    assert strategy in PATTERNS[kind]
