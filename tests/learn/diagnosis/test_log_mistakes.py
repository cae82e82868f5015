"""Mistakes of the log: two columns exchanged, a sign, a unit; told as such and not as physics."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run

MACHINE = """vcmm = "machine/1"
structure = "w b Z t"
[axes.Z]
travel = ["-1 mm", "300 mm"]
[repeatability]
law = "normal"
u = "1 um"
[[effects]]
effect = "thermal_drift"
direction = "z"
sensor = "frame"
k = "4 um/K"
tau = "0 s"
[[effects]]
effect = "thermal_drift"
direction = "z"
sensor = "table"
k = "-2.5 um/K"
tau = "0 s"
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "displacement"
observed = "actual - commanded"
history = "none"
[nuisance]
zero = ""
"""


def written(folder: Path, frame: np.ndarray, table: np.ndarray, value: np.ndarray) -> Path:
    time = np.arange(len(value)) * 60.0
    rows = [f"10,0,0,1,{d:.4f},{t:g},{a:.4f},{b:.4f}" for d, t, a, b in zip(value, time, frame, table)]
    head = "Z_mm,nx,ny,nz,d_um,time_s,temp_frame_C,temp_table_C"
    (folder / "data.csv").write_text("\n".join([head, *rows]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


def courses() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frame and table, degC, and what the machine of MACHINE does: 4 um/K of the frame, -2.5 um/K of the table, scatter 1 um."""
    time = np.arange(150) * 60.0
    frame = 20 + 3 * np.sin(2 * np.pi * time / 7200) + time / 9000
    table = 20 + 4 * (1 - np.exp(-time / 2500))
    scatter = np.random.default_rng(11).normal(0, 1.0, 150)
    return frame, table, 4.0 * (frame - 20) - 2.5 * (table - 20) + scatter


def answer(path: Path, capsys: pytest.CaptureFixture[str]) -> dict:
    assert run(["diagnose", str(path), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.thorough
def test_exchanged_sensors_are_told_as_a_mistake_of_the_log(tmp_path, capsys):
    frame, table, value = courses()
    found = answer(written(tmp_path, table, frame, value), capsys)
    first = found["answer"][0]
    assert (first["effect"], first["mistake"]) == ("log_mistake", "columns_exchanged")
    assert first["where"] == {"columns": "temp_frame_C and temp_table_C"}
    assert first["probability"] > 0.95
    assert found["mistake"] is None  # that key is of the stored table
    assert [a["effect"] for a in found["answer"] if not a["doubtful"]] == ["log_mistake"]


@pytest.mark.thorough
def test_a_temperature_in_fahrenheit_is_a_unit(tmp_path, capsys):
    frame, table, value = courses()
    found = answer(written(tmp_path, 32 + 1.8 * frame, table, value), capsys)
    first = found["answer"][0]
    assert (first["effect"], first.get("mistake")) == ("log_mistake", "unit")
    assert first["where"] == {"columns": "temp_frame_C"}


def test_a_log_that_is_right_has_no_mistake(tmp_path, capsys):
    found = answer(written(tmp_path, *courses()), capsys)
    assert found["answer"] == []
    assert found["verdict"] == "nothing missing"
