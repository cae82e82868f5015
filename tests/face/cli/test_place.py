"""vcmm place on the command line: the document of the contract, files that read back, machines, bad input."""

from __future__ import annotations

import contextlib
import io
import json

import numpy as np
import pytest

from tests.answer.placing.cases import written
from vcmm.face.cli import run
from vcmm.files.own.placement_writer import placed_text
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.fixture import pose_of, six_of

FAST = ["--evaluations", "60", "--scan", "32", "--trials", "1000"]


def document(capsys, *words):
    assert run([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture
def source(tmp_path):
    return written(tmp_path, '\n[placement]\nobjective = "U"\nweights = { "bore to front" = 1.0 }\n')


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    """(scenario, document, folder) of one placement."""
    folder = tmp_path_factory.mktemp("placed")
    more = '\n[placement]\nobjective = "U"\nweights = { "bore to front" = 1.0 }\n'
    source = written(folder, more, ('shift = "300 250 -300 mm"', 'shift = "300 250 -300 mm"   # on the left'))
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        assert run(["place", str(source), *FAST, "--json", "--out", str(folder / "out")]) == 0
    return source, json.loads(said.getvalue()), folder / "out"


def test_document_of_the_contract(answered):
    source, found, _ = answered
    assert found["schema"] == "vcmm.place/1"
    keys = {
        "pose",
        "objective",
        "present",
        "median",
        "worst",
        "certificate",
        "map",
        "flat",
        "why",
        "confirmation",
    }
    assert keys <= set(found)
    assert found["objective"]["value"] <= found["median"]["value"] <= found["worst"]["value"]
    assert found["objective"]["weights"] == {"bore to front": 1.0}
    chart = found["map"]
    assert np.array(chart["objective"], dtype=float).shape == (len(chart["y_mm"]), len(chart["x_mm"]))
    assert found["pose"]["turn_deg"] == pytest.approx(np.degrees(found["pose"]["turn_rad"]))
    scenario = load_scenario(source)
    six = np.concatenate([found["pose"]["shift_mm"], found["pose"]["turn_rad"]])
    scenario.at(pose_of(six)).task()  # within the travels


def test_folder_with_a_scenario_that_reads_back(answered):
    _, found, out = answered
    assert sorted(p.name for p in out.iterdir()) == ["place.json", "placed.toml", "report.html"]
    pose = json.loads((out / "place.json").read_text())["pose"]
    assert pose == found["pose"]
    back = load_scenario(out / "placed.toml")
    assert six_of(back.pose)[:3] == pytest.approx(pose["shift_mm"], abs=1e-5)
    assert "# on the left" in (out / "placed.toml").read_text()
    page = (out / "report.html").read_text()
    assert "Which influence" in page or "which influence shrinks" in page


def test_round_numbers_stand_in_a_comment(tmp_path):
    source = written(tmp_path)
    found, rounded = (
        np.array([101.237, 120.5, -300.0, 0.0, 0.0, 0.5]),
        np.array([100.0, 120, -300, 0, 0, 0.5]),
    )
    target = tmp_path / "placed.toml"
    target.write_text(placed_text(source, target, found, convenient=rounded))
    assert 'nearly as good: shift = "100 120 -300 mm"' in target.read_text()
    assert six_of(load_scenario(target).pose)[0] == pytest.approx(101.237)


def test_placed_text_keeps_everything_else(tmp_path):
    """Only the two values change; a missing key is added, an inline table replaced, file names follow the folder."""
    source = written(tmp_path)
    six = np.array([100.0, 120.5, -300.0, 0.0, 0.0, np.pi / 2])
    new = placed_text(source, tmp_path / "placed.toml", six).splitlines()
    old = source.read_text().splitlines()
    changed = [(a, b) for a, b in zip(old, new) if a != b]
    assert [b for _, b in changed] == ['shift = "100 120.5 -300 mm"', 'turn = "0 0 90 deg"']
    for edit in (
        ('turn = "0 0 30 deg"\n', ""),
        ('[pose]\nshift = "300 250 -300 mm"\nturn = "0 0 30 deg"\n', ""),
    ):
        one = written(tmp_path, "", edit)
        (tmp_path / "placed.toml").write_text(placed_text(one, tmp_path / "placed.toml", six))
        assert np.allclose(six_of(load_scenario(tmp_path / "placed.toml").pose), six, atol=1e-9)
    inner = tmp_path / "inner"
    inner.mkdir()
    machine = tmp_path / "m.csv"
    machine.write_text("x")
    text = source.read_text() + '[extra]\nnames = ["m.csv", "other.csv"]  # "m.csv" was here\n'
    source.write_text(text)
    moved = placed_text(source, inner / "placed.toml", six)
    assert 'names = ["../m.csv", "other.csv"]  # "m.csv" was here' in moved


def machine_file(folder, name, u, travel=600):
    path = folder / f"{name}.toml"
    axes = "".join(
        f'[axes.{a}]\ntravel = ["{lo} mm", "{hi} mm"]\n'
        for a, lo, hi in (("X", 0, travel), ("Y", 0, 500), ("Z", -400, 0))
    )
    path.write_text(
        f'vcmm = "machine/1"\nname = "{name}"\nstructure = "w b Y X Z t"\n{axes}[repeatability]\nlaw = "normal"\nu = "{u} um"\n'
    )
    return str(path)


@pytest.mark.thorough
def test_choice_of_machine(source, tmp_path, capsys):
    """The one with the smaller scatter wins, one without room is named."""
    text = source.read_text().replace('temperature = { part = "21.2 degC", scale_x = "20.4 degC" }', "")
    source.write_text(text.replace('u_temperature = { part = "0.1 K" }', ""))
    files = [
        machine_file(tmp_path, "coarse", 1.0),
        machine_file(tmp_path, "fine", 0.2),
        machine_file(tmp_path, "tiny", 0.1, 50),
    ]
    out = tmp_path / "chosen"
    found = document(capsys, "place", str(source), "--machines", *files, *FAST, "--out", str(out))
    assert found["machine"] == files[1]
    assert [m["name"] for m in found["machines"]] == ["fine", "coarse", "tiny"]
    # u of the distance is scatter times a factor of the plan: five times the scatter, five times the value
    assert found["machines"][1]["value"] / found["machines"][0]["value"] == pytest.approx(5.0, rel=0.05)
    assert "larger than the machine" in found["machines"][2]["why"]
    back = load_scenario(out / "placed.toml")  # the table [machine] of the source has given way to the file
    assert back.machine.name == "fine"
    assert six_of(back.pose)[:3] == pytest.approx(found["pose"]["shift_mm"], abs=1e-5)
    assert "[machine" not in (out / "placed.toml").read_text()


def test_another_machine_takes_the_place_of_a_named_one(tmp_path):
    text = placed_text(written(tmp_path), tmp_path / "placed.toml", np.zeros(6), tmp_path / "a.toml")
    (tmp_path / "named.toml").write_text(text)
    again = placed_text(tmp_path / "named.toml", tmp_path / "placed.toml", np.zeros(6), tmp_path / "b.toml")
    assert [line for line in again.splitlines() if line.startswith("machine =")] == ['machine = "b.toml"']


@pytest.mark.thorough
def test_choices_of_the_fixture_that_cannot_be_used_are_named(tmp_path, capsys):
    more = '\n[placement]\nx = ["200 mm", "400 mm"]\nfaces_down = ["-z", "+z"]\nobjective = "U"\n'
    path, out = written(tmp_path, more), tmp_path / "out"
    assert run(["place", str(path), *FAST, "--out", str(out)]) == 0
    err = capsys.readouterr().err
    # the plan touches the top with a stylus that points down: with the top on the table it leans 180 degrees
    assert "1 of 2 choices of the fixture cannot be reached and were left out: +z down" in err
    assert "leans 180 deg" in err
    assert "Objective" in (out / "report.html").read_text()  # one freedom: a curve and no map


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (["--budget", "3 min"], "--budget"),
        (["--plan", "--scan", "5"], "--scan"),
        (["--plan", "--machines", "."], "--machines"),
        (["--draws", "5"], "--draws"),
    ],
)
def test_an_option_without_meaning_is_refused(source, capsys, words, option):
    assert run(["place", str(source), *words]) == 2
    assert f"{option}: " in capsys.readouterr().err


def test_what_the_fixture_forbids_is_said_of_the_fixture(tmp_path, capsys):
    path = written(tmp_path, '\n[placement]\nz = "-900 mm"\n')
    assert run(["place", str(path), *FAST]) == 2
    line = path.read_text().splitlines().index("[placement]") + 1
    assert f"{path.name}:{line}: no pose of the fixture" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ('[placement]\nz = "-900 mm"\n', "no pose of the fixture can be reached"),
        ('[placement]\nx = ["500 mm", "100 mm"]\n', "the range of x is empty"),
        ('[placement]\nweights = { "bore" = 1.0 }\n', 'the part has no characteristic "bore"'),
        ('[placement]\nobjective = "risk"\nweights = { "bore to front" = 1.0 }\n', "has no two-sided tolerance"),
    ],
)  # fmt: skip
def test_bad_input_is_refused_with_one_line(tmp_path, capsys, more, text):
    path = written(tmp_path, "\n" + more)
    assert run(["place", str(path), "--json", *FAST]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert text in err
    assert "plate.toml" in err


@pytest.mark.thorough
def test_a_plan_is_chosen_written_and_reads_back(tmp_path, capsys):
    path, out = written(tmp_path), tmp_path / "chosen"
    assert run(["place", str(path), "--plan", "--budget", "30 s", "--json", "--out", str(out)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "vcmm.plan/1"
    assert "measuring time / min" in (out / "report.html").read_text(encoding="utf-8")
    text = path.read_text(encoding="utf-8")
    again = text[: text.index("[plan]")].replace("[machine]", 'plan = "chosen/plan.toml"\n[machine]', 1)
    later = text[text.index("[environment]") :]
    (tmp_path / "planned.toml").write_text(again + later, encoding="utf-8")
    assert run(["check", str(tmp_path / "planned.toml")]) == 0
