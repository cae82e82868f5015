"""[record] of a scenario, a machine file or a recording stands at the head of the report of cut, calibrate, diagnose and track."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.files.learned.calibrated_machine import bare_text
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.show.pages.header import OF_MACHINES, facts
from vcmm.task.response.joining import joined_record

MACHINE = """vcmm = "machine/1"
name = "mill"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[record]
machine_serial = "SN 4711"
by = "the maker"
"""
RECORDING = """vcmm = "recording/1"
data = "r.csv"
machine = "m.toml"
kind = "probe"
date = "2026-11-22"
[record]
by = "A. Person"
"""
ROWS = "X_mm,Y_mm,Z_mm,value_um\n10,20,-30,1\n20,30,-40,2\n30,20,-50,1\n"


def test_machine_and_recording_together(tmp_path: Path) -> None:
    """The machine gives its serial number, the recording day and operator; what both state is that of the recording."""
    (tmp_path / "m.toml").write_text(MACHINE)
    (tmp_path / "r.toml").write_text(RECORDING)
    (tmp_path / "r.csv").write_text(ROWS.replace("value_um", "dx_um"))
    recording, machine = load_recording(tmp_path / "r.toml")
    shown = dict(facts("", machine.name, {**machine.record, **recording.record}, expected_names=OF_MACHINES))
    assert shown["machine"] == "mill, serial number SN 4711"
    assert shown["operator"] == "A. Person"
    assert shown["date"] == "2026-11-22"
    assert "not stated" not in shown


def test_what_is_open_is_said_in_words_of_the_job() -> None:
    """A diagnosis has no drawing and no order; a part has."""
    assert dict(facts("", "mill", {}, expected_names=OF_MACHINES))["not stated"].startswith(
        "date, operator, serial number of the machine (table [record]"
    )
    assert "drawing" in dict(facts("part", "mill", {}))["not stated"]


def test_several_recordings_have_one_head() -> None:
    found = joined_record(
        [{"machine_serial": "7"}, {"date": "2026-02-01", "by": "A"}, {"date": "2026-01-05", "by": "B"}]
    )
    assert found == {"machine_serial": "7", "by": "A; B", "date": "2026-01-05 to 2026-02-01"}


def test_a_calibrated_machine_keeps_its_record(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(MACHINE)
    (tmp_path / "again.toml").write_text(bare_text(load_machine(tmp_path / "m.toml")))
    assert load_machine(tmp_path / "again.toml").record == {"machine_serial": "SN 4711", "by": "the maker"}


def test_an_unknown_word_is_refused(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(MACHINE + 'serial = "7"\n')
    with pytest.raises(DataError, match=r"m.toml:13.*serial"):
        load_machine(tmp_path / "m.toml")
