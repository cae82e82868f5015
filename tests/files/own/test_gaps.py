"""Gaps of sensors: blank cells and logs that end early cost the effects of that sensor the rows that they touch, and no more."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.files import large_tables
from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.sensor_gaps import rows_with_all_readings

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


def test_a_blank_between_readings_is_linear_in_time_and_one_at_the_end_names_its_row(tmp_path):
    # 20.0, 20.1 ... ; rows 4 and 5 blank: between 20.3 (30 s) and 20.6 (60 s) it is 20.4 and 20.5
    cells = [f"{20 + 0.1 * k:.1f}" for k in range(100)]
    cells[4] = cells[5] = cells[99] = ""
    found, _ = load_recording(written(tmp_path, cells), gaps=True)
    assert found.run.columns["temp_frame_C"][[4, 5]] == pytest.approx([20.4, 20.5])
    assert found.m == 100
    ((name, rows),) = found.unread
    assert (name, list(np.flatnonzero(rows))) == ("temp_frame_C", [99])
    read = rows_with_all_readings(found)
    assert read.m == 99
    assert read.value[-1] == pytest.approx(0.098)
    (note,) = found.notes
    assert "temp_frame_C is blank in 3 of 100 rows (lines 6 to 101)" in note
    assert "2 are interpolated" in note
    assert "1 have no reading on both sides" in note


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


def test_rows_beyond_the_end_of_a_log_are_named(tmp_path):
    # entries every 10 s until 970 s: good until 980 s, so that of the rows until 990 s one lies beyond
    log = "time_s,temp_frame_C\n" + "".join(f"{10 * k},{20 + 0.01 * k}\n" for k in range(98))
    found, _ = load_recording(written(tmp_path, None, log), gaps=True)
    assert found.m == 100
    assert rows_with_all_readings(found).m == 99
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


@pytest.mark.parametrize("shape", ["small", "large", "parquet"])
def test_large_tables_and_parquet_have_the_gaps_of_small_ones(tmp_path, monkeypatch, shape):
    cells = [f"{20 + 0.1 * k:.1f}" for k in range(100)]
    cells[4] = cells[5] = cells[99] = ""
    file = written(tmp_path, cells)
    if shape == "large":
        monkeypatch.setattr(large_tables, "LARGE", 0)
        monkeypatch.setattr(large_tables, "PIECE", 7)  # pieces with and without blanks
    if shape == "parquet":
        pyarrow = pytest.importorskip("pyarrow")
        from pyarrow import parquet

        lines = [line.split(",") for line in (tmp_path / "data.csv").read_text().splitlines()]
        columns = {
            name: pyarrow.array([float(c) if c else None for c in column], pyarrow.float64())
            for name, *column in zip(*lines)
        }
        parquet.write_table(pyarrow.table(columns), tmp_path / "data.parquet")
        file.write_text(file.read_text().replace("data.csv", "data.parquet"))
    found, _ = load_recording(file, gaps=True)
    assert found.run.columns["temp_frame_C"][[3, 4, 5, 6, 99]] == pytest.approx(
        [20.3, 20.4, 20.5, 20.6, 29.8]
    )
    assert [list(np.flatnonzero(rows)) for _, rows in found.unread] == [[99]]
    with pytest.raises(DataError, match="temp_frame_C is blank in 3 of 100 rows"):
        load_recording(file)


@pytest.mark.parametrize("column", ["Z_mm", "d_um"])
def test_a_blank_that_is_no_temperature_is_refused_in_large_tables_too(tmp_path, monkeypatch, column):
    file = written(tmp_path, ["20"] * 100)
    lines = (tmp_path / "data.csv").read_text().splitlines()
    cells = lines[3].split(",")
    cells[lines[0].split(",").index(column)] = ""
    (tmp_path / "data.csv").write_text("\n".join([*lines[:3], ",".join(cells), *lines[4:]]) + "\n")
    monkeypatch.setattr(large_tables, "LARGE", 0)
    with pytest.raises(DataError, match=f"data.csv:4: .*{column}"):
        load_recording(file, gaps=True)


def heating(folder: Path, drift: float, scale: float) -> Path:
    """80 rows over 300 mm, a log that ends after 60 rows: drift um/K x (T - T0) + scale um/m x Z + 1 um of noise.

    The frame follows a sine of two periods, so that it is no drift in time; numbers made here, by numpy alone.
    """
    rng = np.random.default_rng(5)
    k = np.arange(80)
    z, frame = rng.uniform(0, 300, 80), 20 + 2 * np.sin(2 * np.pi * k / 30)
    d = drift * (frame - 20) + scale * 1e-3 * z + rng.normal(0, 1, 80)
    rows = [f"{z[i]:.3f},0,0,1,{d[i]:.3f},{60 * i},{frame[i]:.4f}" if i < 60 else f"{z[i]:.3f},0,0,1,{d[i]:.3f},{60 * i}," for i in k]  # fmt: skip
    (folder / "data.csv").write_text("\n".join(["Z_mm,nx,ny,nz,d_um,time_s,temp_frame_C", *rows]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


@pytest.mark.thorough
def test_rows_without_a_sensor_are_left_to_the_effects_that_need_none(tmp_path):
    recording, machine = load_recording(heating(tmp_path, drift=0.0, scale=60.0), gaps=True)
    found = diagnose(recording, machine)
    assert [a.effect for a in found.found] == ["scale_factor"]
    assert found.search_counts == (80, 80)  # not the 60 with a reading
    assert "thermal_drift" not in found.not_testable  # it was asked, in 60 rows
    assert any("looked for in the 60 observations" in w and "looked for in 80" in w for w in found.warnings)


@pytest.mark.thorough
def test_rows_without_a_sensor_on_which_a_name_depends_are_set_aside(tmp_path):
    recording, machine = load_recording(heating(tmp_path, drift=6.0, scale=0.0), gaps=True)
    found = diagnose(recording, machine)
    assert {a.effect for a in found.found} == {"thermal_drift"}
    assert found.search_counts == (60, 60)
    assert any("20 observations without a reading of temp_frame_C are not used" in w for w in found.warnings)


def test_a_diagnosis_says_what_has_no_reading(tmp_path):
    cells = [f"{20 + 0.1 * k:.1f}" for k in range(99)] + [""]
    recording, machine = load_recording(written(tmp_path, cells), gaps=True)
    found = diagnose(recording, machine)
    assert any("1 have no reading on both sides" in w for w in found.warnings)
