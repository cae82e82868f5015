"""vcmm diagnose from the command line: a backlash concealed in a log of touches, made by hand here."""

from __future__ import annotations

import json

import numpy as np
import pytest

from vcmm.face.cli import run

MACHINE = """vcmm = "machine/1"
name = "bridge"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[repeatability]
law = "t"
scale = "0.5 um"
dof = 6
"""
RECORDING = """vcmm = "recording/1"
data = "touches.csv"
machine = "machine.toml"
kind = "probe"
[nuisance]
rigid = "pose"
"""


@pytest.fixture
def folder(tmp_path):
    """240 touches in three placements; Y stops 2 um short after reversing: indicated - true = +1 um x sense x n_y."""
    rng = np.random.default_rng(3)
    n = 240
    position = rng.uniform([50, 50, -350], [550, 450, -50], (n, 3))
    normal = rng.normal(size=(n, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    sense = rng.choice([-1, 1], (n, 3))
    pose = np.repeat(["a", "b", "c"], n // 3)
    d = 1.0 * sense[:, 1] * normal[:, 1] + 0.5 * rng.standard_t(6, n)
    header = "X_mm,Y_mm,Z_mm,nx,ny,nz,sense_X,sense_Y,sense_Z,pose,d_um,time_s"
    rows = [
        ",".join(
            [
                *(f"{v:.6f}" for v in (*position[i], *normal[i])),
                *(str(s) for s in sense[i]),
                pose[i],
                f"{d[i]:.6f}",
                f"{10 * i}",
            ]
        )
        for i in range(n)
    ]
    (tmp_path / "touches.csv").write_text("\n".join([header, *rows]) + "\n")
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "recording.toml").write_text(RECORDING)
    return tmp_path


@pytest.mark.thorough
def test_backlash_is_found_written_and_gone(folder, capsys):
    out = folder / "result"
    assert run(["diagnose", str(folder / "recording.toml"), "--json", "--seed", "1", "--out", str(out)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "vcmm.diagnosis/1"
    assert found["verdict"] == "explained"
    (answer,) = found["answer"]
    assert (answer["effect"], answer["where"]) == ("backlash", {"axis": "Y"})
    gap = answer["parameters"]["gap"]
    # tip error -1/2 gap sense; indicated - true = +1/2 gap sense = 1 um: gap = 2 um
    assert gap["interval95"][0] < 2.0 < gap["interval95"][1]
    assert gap["unit"] == "um"
    assert found["improved_machine"] == str(out / "machine.toml")
    assert {p.name for p in out.iterdir()} == {"machine.toml", "diagnosis.json", "report.html"}
    page = (out / "report.html").read_text()
    assert "http:" not in page
    assert "https:" not in page
    # the improved machine is accepted and nothing is missing any more
    assert run(["check", str(out / "machine.toml")]) == 0
    capsys.readouterr()
    words = [
        "diagnose",
        str(folder / "recording.toml"),
        "--machine",
        str(out / "machine.toml"),
        "--json",
        "--seed",
        "1",
    ]
    assert run(words) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["verdict"] == "nothing missing"
    assert again["answer"] == []


@pytest.mark.thorough
def test_keys_of_the_document(folder, capsys):
    assert run(["diagnose", str(folder / "recording.toml"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    wanted = {
        "schema", "version", "seed", "inputs", "warnings", "warning_texts", "verdict", "answer", "unknown", "location", "mistake", "noise",
        "fit", "not_testable", "invisible", "detectable", "next_measurement", "improved_machine", "failed", "verdict_reasons",
        "calibration_pulls", "searched", "stable", "second_opinion", "transfer",
    }  # fmt: skip
    assert set(found) == wanted
    keys = {"effect", "where", "parameters", "probability", "share", "cannot_be_told_from", "evidence_nats"}
    assert keys <= set(found["answer"][0])
    assert {"rms_before_um", "rms_after_um", "candidates_rms_um", "noise_um", "held_out"} == set(found["fit"])
    assert "part_expansion" in found["not_testable"]  # no temperature column


def test_bad_input_and_own_effects(folder, capsys):
    assert run(["diagnose", str(folder / "nothing.toml"), "--json"]) == 2
    assert run(["diagnose", str(folder / "recording.toml"), "--effect", "no_such_module:Thing"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert "module:Class" in told.err
