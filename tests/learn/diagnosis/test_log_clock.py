"""Clocks of logs, labels that slipped, stretches that stand twice: mistakes of the log with data made by numpy alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vcmm
from tests.learn.diagnosis.test_log_mistakes import MACHINE, RECORDING, answer
from vcmm.learn.diagnosis.assembly import mistake_on_all_rows
from vcmm.learn.diagnosis.mistakes import find_mistake
from vcmm.learn.diagnosis.problem import make_problem

LOGGED = RECORDING.replace("[nuisance]", '[[series]]\ndata = "log.csv"\n[nuisance]')
N = 150  # rows, one a minute


def frame(t: np.ndarray) -> np.ndarray:
    return 20 + 3 * np.sin(2 * np.pi * t / 5400) + 2 * np.exp(-(((t - 3000) / 900) ** 2))


def table(t: np.ndarray) -> np.ndarray:
    return 20 + 4 * (1 - np.exp(-np.maximum(t, 0) / 2500))


def logged(folder: Path, written_time: np.ndarray, true_time: np.ndarray) -> Path:
    """The machine of MACHINE: 4 um/K of the frame, -2.5 um/K of the table, scatter 1 um; a log whose clock shows written_time."""
    t = np.arange(N) * 60.0
    d = 4.0 * (frame(t) - 20) - 2.5 * (table(t) - 20) + np.random.default_rng(3).normal(0, 1.0, N)
    rows = [f"10,0,0,1,{v:.4f},{s:g}" for v, s in zip(d, t)]
    (folder / "data.csv").write_text("\n".join(["Z_mm,nx,ny,nz,d_um,time_s", *rows]) + "\n")
    log = [f"{w:.3f},{a:.4f},{b:.4f}" for w, a, b in zip(written_time, frame(true_time), table(true_time))]
    (folder / "log.csv").write_text("\n".join(["time_s,temp_frame_C,temp_table_C", *log]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(LOGGED)
    return folder / "recording.toml"


@pytest.mark.thorough
def test_a_log_whose_clock_is_20_minutes_late_is_told_with_the_minutes(tmp_path, capsys):
    true = np.arange(-3000.0, 13000.0, 45.0)
    found = answer(logged(tmp_path, true + 1200.0, true), capsys)
    first = found["answer"][0]
    assert (first["effect"], first["mistake"]) == ("log_mistake", "clock_offset")
    text = first["where"]["columns"]
    assert "late" in text
    assert float(text.split(", ")[1].split()[0]) == pytest.approx(1200.0, abs=30.0)
    assert first["probability"] > 0.95
    assert [a["effect"] for a in found["answer"] if not a["doubtful"]] == ["log_mistake"]


@pytest.mark.thorough
def test_a_log_whose_clock_is_early_is_told_too(tmp_path, capsys):
    true = np.arange(-3000.0, 13000.0, 45.0)
    first = answer(logged(tmp_path, true - 900.0, true), capsys)["answer"][0]
    assert first["mistake"] == "clock_offset"
    assert float(first["where"]["columns"].split(", ")[1].split()[0]) == pytest.approx(900.0, abs=30.0)
    assert "early" in first["where"]["columns"]


@pytest.mark.thorough
def test_a_clock_that_runs_too_fast_is_a_drift(tmp_path, capsys):
    # 15 % too fast: at the last row, 149 min after the first, 22.35 min = 1341 s late
    true = np.arange(0.0, 13000.0, 45.0)
    first = answer(logged(tmp_path, 1.15 * true, true), capsys)["answer"][0]
    assert (first["effect"], first["mistake"]) == ("log_mistake", "clock_drift")
    assert float(first["where"]["columns"].split(", ")[1].split()[0]) == pytest.approx(1341.0, rel=0.15)


def test_a_right_clock_has_no_mistake(tmp_path, capsys):
    true = np.arange(-3000.0, 13000.0, 45.0)
    assert answer(logged(tmp_path, true, true), capsys)["answer"] == []


PLATE = """vcmm = "machine/1"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[repeatability]
law = "normal"
u = "0.7 um"
"""


def styli(folder: Path, slip: int) -> Path:
    """120 touches in blocks of 12 by turns with two styli, whose offsets are 0 and (30, -20, 15) um; labels slipped by rows."""
    rng = np.random.default_rng(8)
    n = 120
    which = (np.arange(n) // 12) % 2
    normal = rng.normal(size=(n, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    d = normal @ np.array([30.0, -20.0, 15.0]) * which + rng.normal(0, 0.7, n)
    said = which[np.clip(np.arange(n) - slip, 0, n - 1)]
    place = rng.uniform([0, 0, -400], [600, 500, 0], (n, 3))
    rows = [
        f"{p[0]:.2f},{p[1]:.2f},{p[2]:.2f},{v[0]:.8f},{v[1]:.8f},{v[2]:.8f},{r:.4f},{'AB'[k]},{i}"
        for i, (p, v, r, k) in enumerate(zip(place, normal, d, said))
    ]
    (folder / "data.csv").write_text("\n".join(["X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,stylus,time_s", *rows]) + "\n")
    (folder / "machine.toml").write_text(PLATE)
    (folder / "recording.toml").write_text(
        'vcmm = "recording/1"\ndata = "data.csv"\nmachine = "machine.toml"\nkind = "probe"\nhistory = "none"\n[nuisance]\noffset = "stylus"\n'
    )
    return folder / "recording.toml"


@pytest.mark.thorough
def test_labels_that_slipped_by_a_row_are_told(tmp_path, capsys):
    found = answer(styli(tmp_path, 1), capsys)
    first = found["answer"][0]
    assert (first["effect"], first["mistake"]) == ("log_mistake", "labels_exchanged")
    assert first["where"] == {"columns": "stylus, 1 row too late"}
    assert [a["effect"] for a in found["answer"] if not a["doubtful"]] == ["log_mistake"]


@pytest.mark.thorough
def test_labels_that_stand_right_are_no_mistake(tmp_path, capsys):
    assert answer(styli(tmp_path, 0), capsys)["answer"] == []


def line(folder: Path, copied: bool, digits: int = 2) -> Path:
    """200 readings along X with a scatter of 1 um; of the second hundred 15 readings are those of rows 21 to 35."""
    rng = np.random.default_rng(4)
    x = np.sort(rng.uniform(0, 600, 200))
    d = np.round(rng.normal(0, 1.0, 200), digits)
    if copied:
        d[120:135] = d[20:35]
    rows = [f"{a:.3f},0,0,1,0,0,{v:.{digits}f},{30 * i}" for i, (a, v) in enumerate(zip(x, d))]
    (folder / "data.csv").write_text("\n".join(["X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,time_s", *rows]) + "\n")
    (folder / "machine.toml").write_text(PLATE.replace("0.7 um", "1 um"))
    (folder / "recording.toml").write_text(
        'vcmm = "recording/1"\ndata = "data.csv"\nmachine = "machine.toml"\nkind = "displacement"\nhistory = "none"\n[nuisance]\nzero = ""\n'
    )
    return folder / "recording.toml"


@pytest.mark.thorough
def test_a_stretch_of_readings_that_stands_twice_is_told_and_left_out(tmp_path, capsys):
    found = answer(line(tmp_path, copied=True), capsys)
    first = found["answer"][0]
    assert (first["effect"], first["mistake"]) == ("log_mistake", "stretch_repeated")
    # row 121 stands on line 122 of the file, and 12 more are not named one by one
    assert first["where"]["columns"].startswith("the readings of lines 122, 123")
    assert found["searched"]["observations"] == 185
    assert found["verdict"] == "explained"


@pytest.mark.thorough
@pytest.mark.parametrize(
    "digits", [2, 0]
)  # in whole um 15 equal neighbours are still 1 in 10^6 of chance; none are made
def test_readings_that_were_not_copied_are_no_stretch(tmp_path, capsys, digits):
    assert answer(line(tmp_path, copied=False, digits=digits), capsys)["answer"] == []


def test_seconds_found_in_some_rows_are_those_of_all_rows(tmp_path):
    """A clock at its best lies between the trial values: 1200 s late, as written."""
    true = np.arange(-3000.0, 13000.0, 45.0)
    whole = make_problem(*vcmm.load_recording(logged(tmp_path, true + 1200.0, true)))
    white = whole.whitener()
    found = find_mistake(whole, white, white.apply(whole.residual), 5.0)
    assert found is not None
    assert found.clock is not None
    assert found.clock.value == pytest.approx(1200.0, abs=30.0)
    again, _ = mistake_on_all_rows(found, whole)
    assert again is not None
    assert again.component == found.component
    assert again.departure == pytest.approx(found.departure)


def test_a_slip_found_in_some_rows_has_the_number_of_rows_of_the_file(tmp_path):
    """In some of the rows a label that slipped by one row of the file may look as if it had slipped by two."""
    whole = make_problem(*vcmm.load_recording(styli(tmp_path, 1)))
    white = whole.whitener()
    found = find_mistake(whole, white, white.apply(whole.residual), 5.0)
    assert found is not None
    in_some = replace(
        found, component=found.component.replace("1 row", "2 rows"), departure=found.departure[:9]
    )
    again, repaired = mistake_on_all_rows(in_some, whole)
    assert again is not None
    assert again.component == found.component
    assert "1 row too" in found.component
    assert repaired.residual == pytest.approx(whole.residual - found.departure)
