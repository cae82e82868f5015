"""vcmm diagnose is never without an answer: large turns, rows in any order, a later step that fails."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit
from vcmm.face.cli import run

MOUNT = """vcmm = "machine/1"
structure = "w b C B t"
[axes.C]
travel = ["-180 deg", "180 deg"]
[axes.B]
travel = ["-180 deg", "180 deg"]
[repeatability]
law = "normal"
u = "1 um"
"""
POINTING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "angle"
observed = "actual - commanded"
history = "none"
[nuisance]
index = ""
[noise]
u = "20 urad"
"""
HEATED = """vcmm = "machine/1"
structure = "w b Z t"
[axes.Z]
travel = ["-1 mm", "300 mm"]
[repeatability]
law = "normal"
u = "1 um"
"""
HEAT = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "displacement"
history = "none"
[nuisance]
zero = ""
"""


def written(folder: Path, machine: str, recording: str, header: str, rows: np.ndarray) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    lines = [",".join(f"{v:.9g}" for v in row) for row in rows]
    (folder / "data.csv").write_text("\n".join([header, *lines]) + "\n")
    (folder / "machine.toml").write_text(machine)
    (folder / "recording.toml").write_text(recording)
    return folder / "recording.toml"


def document(capsys: pytest.CaptureFixture[str], *words: object) -> dict:
    assert run(["diagnose", *map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def turned(axis: str, angle: np.ndarray) -> np.ndarray:
    """(n, 3, 3): right-handed turns about z (C) or y (B)."""
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    rows = [[c, -s, o], [s, c, o], [o, o, i]] if axis == "C" else [[c, o, s], [o, i, o], [-s, o, c]]
    return np.moveaxis(np.array(rows), -1, 0)


@pytest.fixture
def mount(tmp_path: Path) -> Path:
    """Pointings along x of the tool, C carries B; C turns 0.4 % too far: at 90 deg 6.3 mrad, six times what first order carries."""
    rng = np.random.default_rng(4)
    c, b = np.radians(rng.uniform(-90, 90, 120)), np.radians(rng.uniform(-60, 60, 120))
    seen = turned("C", c * 1.004) @ turned("B", b) @ np.array([1.0, 0.0, 0.0])
    seen = seen + rng.normal(0, 20e-6, seen.shape)
    offset = np.tile([1000.0, 0.0, 0.0], (120, 1))
    header = "C_deg,B_deg,offset_x_mm,offset_y_mm,offset_z_mm,pointed_x,pointed_y,pointed_z"
    return written(
        tmp_path, MOUNT, POINTING, header, np.column_stack([np.degrees(c), np.degrees(b), offset, seen])
    )


@pytest.mark.thorough
def test_an_improved_machine_with_turns_above_1_mrad_is_read_back_and_compared(mount, tmp_path, capsys):
    out = tmp_path / "out"
    found = document(capsys, mount, "--out", out)
    assert found["failed"] == []
    assert found["answer"][0]["where"] in ({"axis": "C"}, {"component": "ECC"})
    assert found["fit"]["rms_before_urad"] > 500
    assert found["fit"]["rms_after_urad"] < 40  # noise 20
    assert run(["compare", str(mount), "--machine", str(out / "machine.toml"), "--json"]) == 0
    own, new = json.loads(capsys.readouterr().out)["machines"]
    assert (own["engine"], new["engine"]) == ("first-order", "exact")
    assert new["rms_urad"] == pytest.approx(found["fit"]["rms_after_urad"], rel=1e-6)


def heat_rows() -> np.ndarray:
    """A table that warms to +10 K with 900 s; the tip follows it with 3 um/K after 600 s: x' = (T - x) / 600."""
    rng = np.random.default_rng(5)
    time = np.arange(120) * 60.0
    table = 10.0 * (1.0 - np.exp(-time / 900.0))
    late = 10.0 * (1.0 - (900.0 * np.exp(-time / 900.0) - 600.0 * np.exp(-time / 600.0)) / 300.0)
    d = 3.0 * late + rng.normal(0, 1.0, 120)
    fixed = np.tile([0.0, 0.0, 0.0, 1.0], (120, 1))
    return np.column_stack([fixed, d, time, 20.0 + table])


HEAT_HEADER = "Z_mm,nx,ny,nz,d_um,time_s,temp_table_C"


@pytest.mark.thorough
def test_the_order_of_the_rows_does_not_change_the_answer(tmp_path, capsys):
    rows = heat_rows()
    mixed = rows[np.random.default_rng(6).permutation(len(rows))]
    one = written(tmp_path / "a", HEATED, HEAT, HEAT_HEADER, rows)
    other = written(tmp_path / "b", HEATED, HEAT, HEAT_HEADER, mixed)
    first = document(capsys, one, "--out", tmp_path / "a" / "out")
    second = document(capsys, other, "--out", tmp_path / "b" / "out")
    assert first["answer"][0]["effect"] == "thermal_drift"
    assert first["answer"][0]["parameters"]["tau"]["value"] == pytest.approx(600, rel=0.1)
    for key in ("verdict", "answer", "fit", "failed", "next_measurement", "location"):
        assert first[key] == second[key], key


@pytest.mark.thorough
def test_a_shuffled_table_has_the_history_of_its_clock(tmp_path, capsys):
    """There and back over 20 places, five times, without senses in the file: Z stops 4 um short; the clock alone tells the sense."""
    there = np.linspace(10, 200, 20)
    z = np.tile(np.concatenate([there, there[::-1]]), 5)
    sense = np.concatenate([[1.0], np.sign(np.diff(z))])
    sense[sense == 0] = np.roll(sense, 1)[sense == 0]  # at the ends it stays where it came
    d = 0.5 * 4.0 * sense + np.random.default_rng(12).normal(0, 1.0, 200)  # indicated - true
    fixed = np.tile([0.0, 0.0, 1.0], (200, 1))
    rows = np.column_stack([z, fixed, d, np.arange(200) * 5.0])
    mixed = rows[np.random.default_rng(13).permutation(200)]
    recording = HEAT.replace('history = "none"\n', "")
    header = "Z_mm,nx,ny,nz,d_um,time_s"
    first = document(capsys, written(tmp_path / "a", HEATED, recording, header, rows))
    second = document(capsys, written(tmp_path / "b", HEATED, recording, header, mixed))
    assert first["answer"][0]["effect"] == "backlash"
    assert first["answer"][0]["parameters"]["gap"]["value"] == pytest.approx(4.0, abs=0.5)
    for key in ("verdict", "answer", "fit", "failed", "next_measurement", "location"):
        assert first[key] == second[key], key
    assert any("order of their clock" in w for w in second["warning_texts"])
    assert run(["calibrate", str(tmp_path / "b" / "recording.toml")]) == 2  # who does not tell refuses


@pytest.mark.thorough
def test_a_later_step_that_fails_is_named_and_the_answer_stays(tmp_path, capsys, monkeypatch):
    def no_machine(*_: object) -> str:
        return 'vcmm = "machine/1"\nstructure = "nonsense"\n'

    monkeypatch.setattr("vcmm.face.cli.diagnose_written.improved_machine", no_machine)
    recording = written(tmp_path, HEATED, HEAT, HEAT_HEADER, heat_rows())
    found = document(capsys, recording, "--out", tmp_path / "out")
    assert [f["step"] for f in found["failed"]] == ["read the machine file back"]
    assert "machine.toml:1" in found["failed"][0]["text"]
    assert found["answer"][0]["effect"] == "thermal_drift"
    assert found["improved_machine"] is None
    assert not (tmp_path / "out" / "machine.toml").exists()
    kept = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert kept["failed"] == found["failed"]


@pytest.mark.thorough
def test_a_comparison_that_fails_leaves_what_was_found(tmp_path, capsys, monkeypatch):
    def beyond(*_: object) -> float:
        raise ModelLimit("beyond what the model holds for")

    monkeypatch.setattr("vcmm.learn.diagnosis.written_machine.rms_under", beyond)
    recording = written(tmp_path, HEATED, HEAT, HEAT_HEADER, heat_rows())
    found = document(capsys, recording)
    assert found["failed"] == [
        {
            "step": "compare the machine as it is written with all rows",
            "text": "beyond what the model holds for",
        }
    ]
    assert found["answer"][0]["effect"] == "thermal_drift"
    assert found["fit"]["rms_before_um"] is None
    assert found["fit"]["rms_after_um"] is None  # not looked at, and no 0
    assert run(["diagnose", str(recording)]) == 0
    assert "failed: compare the machine" in capsys.readouterr().err
