"""Gaps of sensors: blank cells and logs that end early cost the rows that they touch, and no more."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.job import diagnose

MACHINE = """vcmm = "machine/1"
structure = "w b Z t"
[axes.Z]
travel = ["-1 mm", "300 mm"]
[repeatability]
law = "normal"
u = "1 um"
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "displacement"
history = "none"
[nuisance]
zero = ""
"""
LOG = RECORDING.replace("[nuisance]", '[[series]]\ndata = "log.csv"\n[nuisance]')


def written(
    folder: Path, temperatures: list[str] | None, log: str = "", n: int = 100, step: float = 10.0
) -> Path:
    """n rows at Z = 10 mm, every `step` seconds, d = row number in um."""
    head = "Z_mm,nx,ny,nz,d_um,time_s" + (",temp_frame_C" if temperatures else "")
    rows = [f"10,0,0,1,{k},{step * k:g}" + (f",{temperatures[k]}" if temperatures else "") for k in range(n)]
    (folder / "data.csv").write_text("\n".join([head, *rows]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(LOG if log else RECORDING)
    (folder / "log.csv").write_text(log)
    return folder / "recording.toml"


def test_a_blank_between_readings_is_linear_in_time_and_one_at_the_end_sets_its_row_aside(tmp_path):
    # 20.0, 20.1 ... ; rows 4 and 5 blank: between 20.3 (30 s) and 20.6 (60 s) it is 20.4 and 20.5
    cells = [f"{20 + 0.1 * k:.1f}" for k in range(100)]
    cells[4] = cells[5] = cells[99] = ""
    found, _ = load_recording(written(tmp_path, cells), gaps=True)
    assert found.run.columns["temp_frame_C"][[4, 5]] == pytest.approx([20.4, 20.5])
    assert found.m == 99
    assert found.value[-1] == pytest.approx(0.098)
    (note,) = found.notes
    assert "temp_frame_C is blank in 3 of 100 rows (lines 6 to 101)" in note
    assert "2 are interpolated" in note
    assert "1 have no reading on both sides and are set aside" in note


def test_who_would_not_tell_refuses_the_gap(tmp_path):
    cells = ["20"] * 99 + [""]
    with pytest.raises(DataError, match="temp_frame_C is blank in 1 of 100 rows"):
        load_recording(written(tmp_path, cells))


def test_a_sensor_that_was_read_in_less_than_half_of_the_rows_is_set_aside_and_no_row(tmp_path):
    cells = ["20", "21", *[""] * 98]
    found, _ = load_recording(written(tmp_path, cells), gaps=True)
    assert found.m == 100
    assert "temp_frame_C" not in found.run.columns
    assert "not testable" in found.notes[0]


def test_rows_beyond_the_end_of_a_log_are_set_aside(tmp_path):
    # entries every 10 s until 970 s: good until 980 s, so that of the rows until 990 s one lies beyond
    log = "time_s,temp_frame_C\n" + "".join(f"{10 * k},{20 + 0.01 * k}\n" for k in range(98))
    found, _ = load_recording(written(tmp_path, None, log), gaps=True)
    assert found.m == 99
    assert "1 of 100 rows lie beyond it" in found.notes[0]
    assert np.isfinite(found.run.lag("frame", 60.0)).all()


def test_a_blank_entry_of_a_log_is_no_entry(tmp_path):
    log = "time_s,temp_frame_C,temp_room_C\n" + "".join(
        f"{10 * k},{'' if k % 2 else 20 + k},21\n" for k in range(101)
    )
    found, _ = load_recording(written(tmp_path, None, log))
    # entries at 0, 20, 40 s ... of 20, 22, 24 degC: at 10 s 21
    assert found.run.columns["temp_frame_C"][1] == pytest.approx(21.0)
    assert len(found.run.series["frame"].time) == 51
    assert len(found.run.series["room"].time) == 101


def test_a_diagnosis_says_what_was_set_aside(tmp_path):
    cells = [f"{20 + 0.1 * k:.1f}" for k in range(99)] + [""]
    recording, machine = load_recording(written(tmp_path, cells), gaps=True)
    found = diagnose(recording, machine)
    assert any("1 have no reading on both sides" in w for w in found.warnings)
