"""Columns of a log that are exchanged, of the wrong sign or in another unit: what the machine would have done less what it did, by pencil."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vcmm
from vcmm.face.cli import run
from vcmm.learn.diagnosis.assembly import mistake_on_all_rows
from vcmm.learn.diagnosis.log_mistakes import Mistake, log_hypotheses
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.result import Answer
from vcmm.learn.diagnosis.units_and_signs import sign_remarks
from vcmm.show.tables.diagnosis import values_text

MACHINE = """vcmm = "machine/1"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "800 mm"]
[axes.Y]
travel = ["0 mm", "600 mm"]
[axes.Z]
travel = ["-500 mm", "0 mm"]
[repeatability]
law = "normal"
u = "0.3 um"
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "path"
observed = "actual - commanded"
history = "none"
[nuisance]
offset = ""
"""
SCALES = """[[effects]]
effect = "scale_expansion"
axis = "X"
alpha = "9 um/(m K)"
[[effects]]
effect = "scale_expansion"
axis = "Y"
alpha = "9 um/(m K)"
"""
LAGS = """[[effects]]
effect = "servo_lag"
axis = "X"
lag = "0.3 ms"
[[effects]]
effect = "servo_lag"
axis = "Y"
lag = "0.12 ms"
"""
PITCH = """[errors]
table = "errors.csv"
"""


def recording_of(folder: Path, effects: str, head: str, rows: np.ndarray) -> Path:
    lines = [",".join(f"{v:.7g}" for v in row) for row in rows]
    (folder / "data.csv").write_text("\n".join([head, *lines]) + "\n")
    (folder / "machine.toml").write_text(MACHINE + effects)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


def hypotheses_of(path: Path) -> dict[tuple[str, str, str], Mistake]:
    tried = log_hypotheses(*vcmm.load_recording(path))
    return {(m.what, m.component, m.words): m for m in tried}


def test_two_scales_whose_thermometers_are_exchanged(tmp_path):
    head = "X_mm,Y_mm,Z_mm,temp_scale_x_C,temp_scale_y_C,dx_um,dy_um,dz_um"
    rows = np.array([[400, 200, -100, 21, 18, 0, 0, 0], [500, 100, -100, 22, 19, 0, 0, 0]], dtype=float)
    exchanged = hypotheses_of(recording_of(tmp_path, SCALES, head, rows))[
        "columns_exchanged", "temp_scale_x_C and temp_scale_y_C", "each stands in the place of the other"
    ]
    # row 1, X: 9 um/(m K) x 0.4 m x (18 - 21) K = -10.8 um; Y: 9 x 0.2 x (21 - 18) = 5.4; row 2: 9 x 0.5 x -3 = -13.5, 9 x 0.1 x 3 = 2.7
    by_pencil = np.array([[-10.8, 5.4, 0], [-13.5, 2.7, 0]]) * 1e-3
    assert exchanged.departure.reshape(2, 3) == pytest.approx(by_pencil, abs=1e-9)


def test_speeds_of_all_axes_in_metres_per_minute(tmp_path):
    head = "X_mm,Y_mm,Z_mm,speed_X_mm_s,speed_Y_mm_s,dx_um,dy_um,dz_um"
    rows = np.array([[400, 200, -100, 0.6, 1.2, 0, 0, 0], [410, 210, -100, 1.2, -0.6, 0, 0, 0]])
    tried = hypotheses_of(recording_of(tmp_path, LAGS, head, rows))
    words = "the values are 1000/60 times too small, as m/min"
    both = tried["unit", "speed_X_mm_s and speed_Y_mm_s", words]
    # 0.6 m/min are 10 mm/s, 9.4 more than was written: X -0.3 ms x 9.4 mm/s = -2.82 um; Y: 20 less 1.2, -0.12 x 18.8 = -2.256
    # row 2: X -0.3 x 18.8 = -5.64, Y -0.12 x -9.4 = 1.128
    by_pencil = np.array([[-2.82, -2.256, 0], [-5.64, 1.128, 0]]) * 1e-3
    assert both.departure.reshape(2, 3) == pytest.approx(by_pencil, abs=1e-9)
    assert ("unit", "speed_X_mm_s", words) in tried


def test_speeds_of_the_linear_axes_alone(tmp_path):
    """Beside a rotary axis in rad/s: X and Y in m/min, -0.3 ms x 9.4 mm/s = -2.82 um and -0.12 x 18.8 = -2.256; C is as it was."""
    turning = LAGS[: LAGS.rindex("[[effects]]")].replace('"X"', '"C"')
    machine = MACHINE.replace("w b Y X Z t", "w C' b Y X Z t") + LAGS + turning
    head = "X_mm,Y_mm,Z_mm,C_deg,speed_X_mm_s,speed_Y_mm_s,speed_C_rad_s,dx_um,dy_um,dz_um"
    rows = np.array(
        [[400, 200, -100, 0, 0.6, 1.2, 0.1, 0, 0, 0], [410, 210, -100, 0, 1.2, -0.6, 0.2, 0, 0, 0]]
    )
    path = recording_of(tmp_path, "", head, rows)
    (tmp_path / "machine.toml").write_text(machine + '[axes.C]\ntravel = ["-360 deg", "360 deg"]\n')
    tried = hypotheses_of(path)
    linear = tried[
        "unit", "speed_X_mm_s and speed_Y_mm_s", "the values are 1000/60 times too small, as m/min"
    ]
    assert linear.departure.reshape(2, 3)[0] == pytest.approx([-2.82e-3, -2.256e-3, 0], abs=1e-9)
    every = "speed_C_rad_s and speed_X_mm_s and speed_Y_mm_s"
    assert ("unit", every, "the values are 60 times too large, as per minute") in tried


def test_a_unit_found_in_some_rows_is_the_same_unit_in_all_rows(tmp_path):
    """Four units of one column have one name; only their words differ. Row 1 of the test above, of X alone: -2.82 um (mm/min: 0.18 um)."""
    head = "X_mm,Y_mm,Z_mm,speed_X_mm_s,speed_Y_mm_s,dx_um,dy_um,dz_um"
    rows = np.array([[400, 200, -100, 0.6, 1.2, 0, 0, 0], [410, 210, -100, 1.2, -0.6, 0, 0, 0]])
    path = recording_of(tmp_path, LAGS, head, rows)
    found = hypotheses_of(path)["unit", "speed_X_mm_s", "the values are 1000/60 times too small, as m/min"]
    in_some = replace(found, departure=found.departure[:3])
    whole = make_problem(*vcmm.load_recording(path))
    again, repaired = mistake_on_all_rows(in_some, whole)
    assert again is not None
    assert again.departure[0] == pytest.approx(-2.82e-3, abs=1e-9)
    assert repaired.residual == pytest.approx(whole.residual - found.departure)


def test_an_offset_of_the_other_sign(tmp_path):
    (tmp_path / "errors.csv").write_text("X EXX EYX EZX EAX EBX ECX\n0 0 0 0 0 2e-5 0\n800 0 0 0 0 6e-5 0\n")
    head = "X_mm,Y_mm,Z_mm,offset_x_mm,offset_y_mm,offset_z_mm,dx_um,dy_um,dz_um"
    rows = np.array([[400, 0, 0, 0, 0, 100, 0, 0, 0], [800, 0, 0, 0, 0, 50, 0, 0, 0]], dtype=float)
    tried = hypotheses_of(recording_of(tmp_path, PITCH, head, rows))
    mirrored = tried["sign", "offset_z_mm", "the sign is the opposite one"]
    # a turn about B moves a point at z by EBX z along x: 40 urad x (-100 - 100) mm = -8 um; 60 x (-50 - 50) = -6
    assert mirrored.departure.reshape(2, 3)[:, 0] == pytest.approx([-8e-3, -6e-3], abs=1e-6)
    # the arm along x instead: 40 urad x 100 mm is lost in x, and -40 urad x 100 mm comes along z
    exchanged = tried[
        "columns_exchanged", "offset_x_mm and offset_z_mm", "each stands in the place of the other"
    ]
    assert exchanged.departure.reshape(2, 3)[0] == pytest.approx([-4e-3, 0, -4e-3], abs=1e-6)


def circle_in(folder: Path, times: float, pause: float = 0.0) -> list[str]:
    """What is said of a circle of 100 mm at 60 mm/s, there and back with a pause, whose speeds were written `times` as large."""
    half = np.linspace(0, 4 * np.pi, 200)
    angle = np.concatenate([half, half[::-1]])
    turn = 0.6 * np.repeat([1.0, -1.0], 200)  # rad/s
    time = np.arange(400) * (half[1] / 0.6) + np.repeat([0.0, pause], 200)
    x, y = 400 + 100 * np.cos(angle), 300 + 100 * np.sin(angle)
    vx, vy = -100 * turn * np.sin(angle), 100 * turn * np.cos(angle)
    none = np.zeros(400)
    rows = np.column_stack([time, x, y, none - 200, times * vx, times * vy, none, none, none])
    head = "time_s,X_mm,Y_mm,Z_mm,speed_X_mm_s,speed_Y_mm_s,dx_um,dy_um,dz_um"
    recording, _ = vcmm.load_recording(recording_of(folder, "", head, rows))
    return sorted(sign_remarks(recording))


@pytest.mark.parametrize(
    ("times", "unit"), [(60.0, "units per minute"), (0.06, "m/min"), (0.001, "m/s"), (1 / 25.4, "inches")]
)
def test_speeds_that_do_not_fit_the_motion_are_told_with_the_unit(tmp_path, times, unit):
    said = circle_in(tmp_path, times, pause=20.0)
    assert len(said) == 2  # of X and of Y
    assert f"is {times:.3g} times the motion along X" in said[0]
    assert unit in said[0]


def test_stops_approached_at_one_feed_tell_nothing_of_its_unit(tmp_path):
    """17 stops along X, there and back, 25 mm and 15 s apart: 1.67 mm/s on average, 1/60 of the feed of 100 mm/s of each approach."""
    x = np.concatenate([np.arange(0, 425, 25.0), np.arange(400, -25, -25.0)])
    feed = np.repeat([100.0, -100.0], 17)
    rest = np.tile([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (34, 1))
    rows = np.column_stack([np.arange(34) * 15.0, x, feed, rest])
    path = recording_of(tmp_path, "", "time_s,X_mm,speed_X_mm_s,Y_mm,Z_mm,nx,ny,nz,d_um", rows)
    path.write_text(RECORDING.replace('"path"', '"displacement"'))
    assert sign_remarks(vcmm.load_recording(path)[0]) == []


def test_speeds_that_fit_the_motion_are_not_told(tmp_path):
    assert circle_in(tmp_path, 1.0, pause=20.0) == []
    assert circle_in(tmp_path, 1.3) == []  # no unit


def test_the_terminal_says_what_about_a_column_is_wrong():
    one = Answer(
        "log_mistake",
        {"columns": "offset_z_mm"},
        {},
        0.97,
        1.0,
        (),
        9.0,
        mistake="sign",
        remark="the sign is wrong",
    )
    assert values_text(one) == "the sign is wrong"
    assert values_text(replace(one, mistake="", remark="known otherwise")) == "no free parameter"


@pytest.mark.thorough
def test_speeds_in_metres_per_minute_are_no_servo_lag(tmp_path, capsys):
    # a circle of 100 mm at 60 mm/s; lags of 0.3 and 0.12 ms as the file states; speeds written in m/min had been lags of 4.7 and 1.9 ms
    angle = np.linspace(0, 4 * np.pi, 200)
    x, y = 400 + 100 * np.cos(angle), 300 + 100 * np.sin(angle)
    vx, vy = -60 * np.sin(angle), 60 * np.cos(angle)
    scatter = np.random.default_rng(5).normal(0, 0.3, (200, 3))
    seen = np.column_stack([-0.3 * vx, -0.12 * vy, 0 * vx]) + scatter
    head = "X_mm,Y_mm,Z_mm,speed_X_mm_s,speed_Y_mm_s,dx_um,dy_um,dz_um"
    rows = np.column_stack([x, y, 0 * x - 200, 0.06 * vx, 0.06 * vy, seen])
    path = recording_of(tmp_path, LAGS, head, rows)
    assert run(["diagnose", str(path), "--json"]) == 0
    answers = [a for a in json.loads(capsys.readouterr().out)["answer"] if not a["doubtful"]]
    assert [(a["effect"], a["mistake"], a["where"]["columns"]) for a in answers] == [
        ("log_mistake", "unit", "speed_X_mm_s and speed_Y_mm_s")
    ]
    assert "m/min" in answers[0]["remark"]
