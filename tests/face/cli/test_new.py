"""vcmm new: an example to edit for everybody who begins, and it runs as it is."""

from __future__ import annotations

import json

import pytest

from vcmm.face.cli import run


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "next_step"),
    [("ring_gauge", "uncertainty"), ("plate", "uncertainty"), ("ballbar", "diagnose"), ("traced_cmm", "calibrate"), ("six_axis_arm", "calibrate"), ("mill", "cut"), ("lathe", "cut")],
)  # fmt: skip
def test_what_new_writes_passes_its_check_and_names_the_next_step(tmp_path, capsys, name, next_step):
    assert run(["new", name, "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert f"vcmm {next_step} {tmp_path / name}.toml" in out
    if next_step != "diagnose":
        assert run(["check", str(tmp_path / f"{name}.toml")]) == 0


def test_an_argument_too_many_is_named_with_what_was_meant(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["new", "ring_gauge", "my_ring.toml"]) == 2
    told = capsys.readouterr().err
    meant = "vcmm new my_ring.toml --from ring_gauge"
    assert f'"my_ring.toml" is one argument too many; {meant} copies ring_gauge under that name' in told
    assert "vcmm new --help says what it takes" in told
    assert run(meant.split()[1:]) == 0
    assert (tmp_path / "my_ring.toml").is_file()
    assert run(["check", "plate", "part1"]) == 2
    assert '"part1" is one argument too many; vcmm check --help' in capsys.readouterr().err
    assert run(["new", "--from", "plate", "one", "two"]) == 2  # no name stands where one is looked for
    assert '"two" is one argument too many; vcmm new --help' in capsys.readouterr().err


def test_a_ring_gauge_by_hand(tmp_path, capsys):
    """Ring of 50 mm: thermometer 0.1 K x 11.5e-6 x 50 = 57.5 nm; the tip of 4 mm travels 46 mm,
    and a scale of 0.6 um/m carries half of it: 13.8 nm each. A diameter from 16 touches: 2 x 0.3 um / 4.
    """
    run(["new", "ring_gauge", "--out", str(tmp_path)])
    capsys.readouterr()
    assert run(["uncertainty", str(tmp_path / "ring_gauge.toml"), "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["characteristics"]
    u = {line["input"]: line["u_mm"] for line in found["budget"]}
    assert u["channel.temp_part_C"] == pytest.approx(57.5e-6, rel=1e-3)
    assert u["scale_factor[X].k"] == pytest.approx(13.8e-6, rel=1e-3)
    assert u["scatter.value"] == pytest.approx(2 * 0.3e-3 / 16**0.5, rel=1e-3)


def test_an_unknown_name_is_told_what_there_is(tmp_path, capsys):
    assert run(["new", "laithe", "--out", str(tmp_path)]) == 2
    assert 'Did you mean "lathe"' in capsys.readouterr().err


def test_a_missing_file_with_the_name_of_an_example_says_how_to_get_it(tmp_path, monkeypatch, capsys):
    from vcmm.face.cli import run as command

    monkeypatch.chdir(tmp_path)
    assert command(["uncertainty", "plate.toml"]) == 2
    assert "vcmm new plate writes an example" in capsys.readouterr().err
    assert command(["uncertainty", "my_own.toml"]) == 2
    assert "vcmm new" not in capsys.readouterr().err
