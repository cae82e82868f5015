"""demo --twin, and new and check for cutting scenarios with files beside them."""

from __future__ import annotations

import json

import pytest

from vcmm.face.cli import run
from vcmm.files.own.library import companions, scenarios

CUTTING = ("abbe_milling", "marin2004", "test_piece")


def test_draws_belong_to_twins_that_draw(tmp_path, capsys):
    assert run(["demo", "--twin", "marin2004", "--draws", "3", "--out", str(tmp_path)]) == 2
    assert "--draws is of no use to marin2004" in capsys.readouterr().err
    assert run(["demo", "--twin", "marin"]) == 2


@pytest.mark.thorough
@pytest.mark.parametrize("name", CUTTING)
def test_new_brings_program_and_set_up_along(tmp_path, capsys, name):
    assert run(["new", "mine", "--from", name, "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert f"vcmm cut {tmp_path}/mine.toml --out mine-report" in out
    assert "vcmm measure" not in out
    for one in companions(name):
        copied = tmp_path / one.replace(f"{name}/", "mine/")
        assert copied.is_file()
    assert f"{name}/" not in (tmp_path / "mine.toml").read_text()
    assert run(["check", str(tmp_path / "mine.toml"), "--json"]) == 0
    understood = json.loads(capsys.readouterr().out)["understood"]
    assert "moves" in understood["program"]
    assert understood["tool 1"].startswith("flat, length")


def test_new_overwrites_no_companion(tmp_path, capsys):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "setup.toml").write_text("mine")
    assert run(["new", "mine", "--from", "test_piece", "--out", str(tmp_path)]) == 2
    assert "setup.toml exists already" in capsys.readouterr().err
    assert (tmp_path / "mine" / "setup.toml").read_text() == "mine"
    assert not (tmp_path / "mine.toml").exists()


def test_new_of_a_measuring_scenario_is_one_file(tmp_path, capsys):
    assert run(["new", "plate", "--out", str(tmp_path)]) == 0
    assert "vcmm uncertainty" in capsys.readouterr().out
    assert [p.name for p in tmp_path.iterdir()] == ["plate.toml"]


@pytest.mark.thorough
def test_check_of_a_cutting_scenario_finds_what_is_not_cut(tmp_path, capsys):
    run(["new", "mine", "--from", "test_piece", "--out", str(tmp_path)])
    file = tmp_path / "mine.toml"
    file.write_text(file.read_text().replace('point = "80 0 -25 mm"', 'point = "75 0 -25 mm"'))
    capsys.readouterr()
    assert run(["check", str(file)]) == 2
    assert "feature east: the program cuts 0 of its 49" in capsys.readouterr().err


def test_every_cutting_scenario_is_listed():
    assert set(CUTTING) < set(scenarios())
    assert set(companions("test_piece")) == {"test_piece/part.nc", "test_piece/setup.toml"}
    assert companions("plate") == {}
