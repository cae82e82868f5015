"""vcmm evaluate --compare: measured on a measuring machine, beside what was predicted of the cut."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.shop.machining import measured_shop
from vcmm.face.cli import run as command

CMM = """\
vcmm = "machine/1"
name = "cmm"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "500 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[repeatability]
u = "0.3 um"
[[effects]]
effect = "scale_factor"
axis = "Y"
k = "0 um/m"
[[inputs]]
effect = "scale_factor"
axis = "Y"
parameter = "k"
u = "3 um/m"
"""
MEASURING = """\
vcmm = "scenario/1"
machine = "cmm.toml"
[pose]
shift = "200 200 -200 mm"
[plan]
[plan.styli.down]
offset = "0 0 -100 mm"
tip_diameter = "2 mm"
"""
RADIUS = '[[effects]]\neffect = "tool_runout"\namplitude = "20 um"\ntool = "1"\n'
PLANE = 'strategy = "grid", n = [3, 3], margin = "1 mm"'
BORE = 'strategy = "levels", at = ["1 mm", "3 mm"], n = 8'


def files(folder, concealed=""):
    points, features = measured_shop.measured(folder, concealed, 1)
    measured_shop.csv(folder / "points.csv", points, features)
    path = measured_shop.write(folder)
    steps = "".join(
        f'[[plan.steps]]\nfeature = "{f}"\nstylus = "down"\npoints = {{ {BORE if f == "bore" else PLANE} }}\n'
        for f in dict.fromkeys(features.tolist())
    )
    (folder / "cmm.toml").write_text(CMM)
    (folder / "measuring.toml").write_text(MEASURING + steps + measured_shop.FEATURES)
    return path, folder / "points.csv"


def asked(arguments, capsys, code=0):
    assert command([str(a) for a in arguments] + ["--json"]) == code
    return json.loads(capsys.readouterr().out)


@pytest.mark.thorough
def test_the_measurement_and_the_cut_are_one_model(tmp_path, capsys):
    """The scale of Y, u = 3 um/m, makes 0.18 um of the length of 60 mm: it is in the difference of the length alone."""
    cut, points = files(tmp_path, RADIUS)
    found = asked(
        ["evaluate", tmp_path / "measuring.toml", "--points", points, "--compare", "--cut", cut], capsys
    )
    plain = asked(["evaluate", cut, "--points", points, "--compare"], capsys)
    assert found["mismatch"][0]["covariate"] in ("tool", "tool radius")
    assert found["recording"].endswith("boss-measured.toml")
    u = [{m["name"]: m["u_difference_mm"] for m in d["measured"]} for d in (found, plain)]
    assert u[0]["length"] > u[1]["length"]
    true = {c["name"]: c for c in found["characteristics"]}["width"]
    assert true["measured_mm"] == pytest.approx(100.0 - 0.040, abs=0.012)
    assert true["U_mm"] > 0
    assert plain["characteristics"] == []
    assert any("no measuring machine is stated" in w for w in plain["warning_texts"])


def test_without_a_measuring_machine_it_is_said_and_written(tmp_path, capsys):
    """[inspection] of the shop names no machine: nothing is said of true values, and the comparison is given all the same."""
    cut, points = files(tmp_path, RADIUS)
    out = tmp_path / "out"
    assert command(["evaluate", str(cut), "--points", str(points), "--compare", "--out", str(out)]) == 0
    told = capsys.readouterr()
    assert "no measuring machine is stated ([inspection] machine and pose)" in told.err
    assert "scatter of a measured point" in told.out
    assert f"wrote {out}/evaluation.json" in told.err
    written = json.loads((out / "evaluation.json").read_text())
    assert written["characteristics"] == []
    assert written["mismatch"]
    assert (out / "boss-measured.toml").is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["measuring.toml", "--points", "points.csv", "--compare"], "add --cut block.toml"),
        (["boss.toml", "--compare"], "add --points points.csv"),
        (["boss.toml", "--points", "points.csv", "--compare", "--cut", "boss.toml"], "leave --cut out"),
        (["boss.toml", "--values", "points.csv", "--compare"], "leave --values out"),
    ],
)
def test_what_is_missing_is_told(tmp_path, monkeypatch, capsys, arguments, words):
    files(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert command(["evaluate", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_points_in_another_unit_are_told_with_their_row(tmp_path, monkeypatch, capsys):
    points, features = measured_shop.measured(tmp_path, "", 1)
    files(tmp_path)
    measured_shop.csv(tmp_path / "inch.csv", np.asarray(points) / 25.4, features)
    monkeypatch.chdir(tmp_path)
    assert command(["evaluate", "boss.toml", "--points", "inch.csv", "--compare"]) == 2
    said = capsys.readouterr().err
    assert "inch.csv:" in said
    assert "inches" in said
