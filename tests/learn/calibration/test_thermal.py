"""Thermal models: amounts and lags of drawn recordings, the file read back, sensors that say nothing, ranges."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.face.cli import run
from vcmm.files.learned.thermal_terms import thermal_text, written_terms
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.learn.calibration.thermal import thermal_model
from vcmm.learn.calibration.thermal_search import repeating
from vcmm.learn.calibration.thermal_terms import standing_out
from vcmm.learn.calibration.verification import put_to_test

MACHINE = 'vcmm = "machine/1"\nname = "mill"\nkind = "machine-tool"\nstructure = "w b Y X Z t"\n' + "".join(
    f'[axes.{a}]\ntravel = ["-10 mm", "500 mm"]\n' for a in "XYZ"
)
RECORDING = 'vcmm = "recording/1"\ndata = "{0}.csv"\nmachine = "machine.toml"\nkind = "displacement"\nobserved = "actual - commanded"\n[nuisance]\nzero = ""\n[noise]\nlaw = "normal"\nu = "0.5 um"\n'


def lagged(time: np.ndarray, temperature: np.ndarray, tau: float) -> np.ndarray:
    """tau y' + y = T by small steps of Euler: no code of the package."""
    fine = np.arange(time[0], time[-1] + 1.0, 1.0)
    y = np.empty(len(fine))
    y[0] = temperature[0]
    drive = np.interp(fine, time, temperature)
    for i in range(1, len(fine)):
        y[i] = y[i - 1] + (drive[i] - y[i - 1]) / tau
    return np.interp(time, fine, y)


def warm_up(folder: Path, name: str, seed: int, hot: float = 12.0) -> Path:
    """Two hours: the spindle housing warms and cools again, the air only wanders. Tip: 2.5 um/K of it behind 700 s, along z."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 7200.0, 90.0)
    housing = 22.0 + hot * (1 - np.exp(-time / 1100.0)) * np.where(
        time < 4500, 1.0, np.exp(-(time - 4500) / 1500.0)
    )
    air = 21.0 + 0.8 * np.sin(time / 900.0 + seed)
    z = 2.5 * (lagged(time, housing, 700.0) - 20.0) + 0.5 * rng.standard_normal(len(time))
    z[40] += 60.0 * (name == "first")  # somebody leant on the table
    rows = [f"100,0,0,0,0,1,{v:.4f},{t:g},{h:.4f},{a:.4f}" for v, t, h, a in zip(z, time, housing, air)]
    head = "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,time_s,temp_housing_C,temp_air_C"
    (folder / f"{name}.csv").write_text("\n".join([head, *rows]) + "\n")
    (folder / f"{name}.toml").write_text(RECORDING.format(name))
    (folder / "machine.toml").write_text(MACHINE)
    return folder / f"{name}.toml"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thermal")
    recording, machine = load_recording(warm_up(folder, "first", 1))
    return folder, recording, machine, thermal_model([recording], machine)


def test_amount_and_lag_are_found_and_the_other_sensor_is_not_used(found):
    model = found[3]
    assert [t.where for t in model.terms] == [("z", "housing")]
    u = np.sqrt(np.diag(model.covariance))
    assert abs(model.amounts[0] - 2.5e-3) < 4 * u[0] < 4 * 0.05e-3
    assert abs(model.lags[0] - 700.0) < 4 * u[1] < 4 * 20.0
    assert model.after == pytest.approx(0.5e-3, rel=0.25)
    assert model.outliers == 1
    assert model.unused_sensors == {"air": "adds nothing to the others"}


def test_the_file_predicts_another_run_within_its_band(found):
    folder, _, machine, model = found
    target = folder / "warm.toml"
    target.write_text(thermal_text(model, machine, folder / "machine.toml", target, ["first.toml"]))
    later, _ = load_recording(warm_up(folder, "later", 2, hot=10.0))
    said = put_to_test(later, machine, load_machine(target))
    assert said.before > 6e-3
    assert said.after < 0.65e-3
    assert said.inside >= 0.9
    (effect,) = written_terms(model).effects
    assert effect.trained == "22 degC to 33.8 degC"


def test_beyond_the_temperatures_of_the_recording_it_refuses(found, capsys):
    folder = found[0]
    hot = warm_up(folder, "hot", 3, hot=30.0)
    words = ["calibrate", str(folder / "first.toml"), "--machine", str(folder / "machine.toml"), "--thermal"]
    assert run([*words, "--out", str(folder / "m.toml"), "--test", str(hot)]) == 2
    assert "lies beyond the temperatures that it was learnt from" in capsys.readouterr().err


def test_the_command_writes_what_it_shows(found, capsys):
    folder = found[0]
    out = folder / "shown.toml"
    words = ["calibrate", str(folder / "first.toml"), "--machine", str(folder / "machine.toml"), "--thermal"]
    assert run([*words, "--out", str(out), "--json", "--test", str(warm_up(folder, "second", 4))]) == 0
    document = json.loads(capsys.readouterr().out)
    (effect,) = load_machine(out).effects
    shown = {t["parameter"]: t["value"] for t in document["terms"]}
    assert shown["k"] == pytest.approx(effect.k * 1e3, rel=1e-9)
    assert shown["tau"] == pytest.approx(effect.tau, rel=1e-9)
    (joint,) = load_machine(out).inputs
    assert np.sqrt(joint.law.covariance[0, 0]) * 1e3 == pytest.approx(document["terms"][0]["u"], rel=1e-6)
    (test,) = document["tests"]
    assert test["gain"] > 0.9
    assert test["rms_after"] < test["net_rms"] < test["rms_before"]
    assert document["held_out"]["rms_after_um"] < 1.5


def test_a_scale_whose_axis_moves(tmp_path):
    """10 um/(m K): at X = 400 mm and 5 K above 20 degC the tip is 20 um too far."""
    time = np.arange(0.0, 6000.0, 50.0)
    scale, x = 20.0 + 5.0 * time / 6000.0, np.tile([0.0, 200.0, 400.0], 40)
    rng = np.random.default_rng(0)
    d = 10e-3 * x * (scale - 20.0) + 0.3 * rng.standard_normal(len(time))
    rows = [f"{q:g},0,0,1,0,0,{v:.4f},{t:g},{s:.4f}" for q, v, t, s in zip(x, d, time, scale)]
    (tmp_path / "line.csv").write_text(
        "\n".join(["X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,time_s,temp_scale_x_C", *rows]) + "\n"
    )
    (tmp_path / "line.toml").write_text(RECORDING.format("line"))
    (tmp_path / "machine.toml").write_text(MACHINE)
    recording, machine = load_recording(tmp_path / "line.toml")
    model = thermal_model([recording], machine)
    assert [t.where for t in model.terms] == [("X",)]
    u = np.sqrt(model.covariance[0, 0])
    assert model.amounts[0] * 1e6 == pytest.approx(10.0, abs=4 * u * 1e6)
    target = tmp_path / "scale.toml"
    target.write_text(thermal_text(model, machine, tmp_path / "machine.toml", target, ["line.toml"]))
    (one,) = load_machine(target).inputs
    assert (one.id, one.size) == ("scale_expansion[X].alpha", pytest.approx(u, rel=1e-5))


def test_a_spindle_that_runs(tmp_path):
    """18 um behind 1200 s: after 1200 s the tip is 18 (1 - 1/e) = 11.38 um lower. A sensor that only wanders is not used."""
    rng = np.random.default_rng(5)
    time = np.arange(0.0, 6000.0, 75.0)
    air = 21.0 + 0.6 * np.sin(time / 700.0)
    d = -18.0 * -np.expm1(-time / 1200.0) + 0.4 * rng.standard_normal(len(time))
    rows = [f"100,0,0,0,0,1,{v:.4f},{t:g},{t:g},{a:.3f}" for v, t, a in zip(d, time, air)]
    head = "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,time_s,spindle_on_s,temp_air_C"
    (tmp_path / "spindle.csv").write_text("\n".join([head, *rows]) + "\n")
    (tmp_path / "spindle.toml").write_text(RECORDING.format("spindle"))
    (tmp_path / "machine.toml").write_text(MACHINE)
    recording, machine = load_recording(tmp_path / "spindle.toml")
    model = thermal_model([recording], machine)
    target = tmp_path / "warm.toml"
    target.write_text(thermal_text(model, machine, tmp_path / "machine.toml", target, ["spindle.toml"]))
    (effect,) = load_machine(target).effects
    u = np.sqrt(np.diag(model.covariance))
    assert [t.where for t in model.terms] == [("Z",)]
    assert abs(effect.amplitude - 18e-3) < 4 * u[0] < 1e-3
    assert abs(effect.tau - 1200.0) < 4 * u[1] < 200.0
    at = recording.run.take(np.array([0, 16]))
    tip = load_machine(target).tip_error(at)[:, 2]
    assert tip[1] - tip[0] == pytest.approx(-11.38e-3, abs=0.4e-3)


def test_single_readings_stand_out_and_runs_do_not():
    rng = np.random.default_rng(1)
    value = rng.standard_normal(60)
    value[20] += 40.0
    value[35:45] += 40.0
    assert np.flatnonzero(standing_out(value)).tolist() == [20]


def test_what_repeats_itself_counts_once():
    """Every value three times: correlations 2/3 and 1/3 of neighbours, so 1 + 2 (2/3 + 1/3) = 3."""
    once = np.random.default_rng(3).standard_normal(4000)
    assert repeating([np.repeat(once, 3)]) == pytest.approx(3.0, rel=0.05)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--sensors", "housng"], '--sensors names "housng", which no recording has; there are air, housing'),
        (["--test", "{first}", "--out", "{out}"], "holds the same readings as"),
        (
            ["--residual", "{out}", "--errors", "EXX"],
            "--thermal takes no --errors and no --residual; leave them out",
        ),
        (["--compare-interpolations"], "are two jobs"),
        (["--test", "{first}"], "--test asks the file that is written"),
    ],
)
def test_wrong_words(found, more, message, capsys):
    folder = found[0]
    place = {"first": folder / "first.toml", "out": folder / "again.toml"}
    words = ["calibrate", str(folder / "first.toml"), "--machine", str(folder / "machine.toml"), "--thermal"]
    assert run([*words, *(w.format(**place) for w in more)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


def test_a_file_that_has_the_term_already(found):
    folder, recording, machine, model = found
    target = folder / "twice.toml"
    target.write_text(thermal_text(model, machine, folder / "machine.toml", target, ["first.toml"]))
    with pytest.raises(UsageError, match=r"states .* already"):
        thermal_text(model, load_machine(target), target, folder / "third.toml", ["first.toml"])
    columns = {k: v for k, v in recording.run.columns.items() if k != "time_s"}
    timeless = replace(recording, run=replace(recording.run, columns=columns))
    with pytest.raises(UsageError, match="needs the column time_s"):
        thermal_model([timeless], machine)


def test_a_test_without_a_clock_is_refused_before_anything_is_written(found, capsys):
    folder = found[0]
    rows = [line.split(",") for line in (folder / "first.csv").read_text().splitlines()]
    clock = rows[0].index("time_s")
    (folder / "still.csv").write_text("".join(",".join(r[:clock] + r[clock + 1 :]) + "\n" for r in rows[:-1]))
    (folder / "still.toml").write_text((folder / "first.toml").read_text().replace("first", "still"))
    words = ["calibrate", str(folder / "first.toml"), "--machine", str(folder / "machine.toml"), "--thermal"]
    assert run([*words, "--test", str(folder / "still.toml"), "--out", str(folder / "unwritten.toml")]) == 2
    assert "still: a thermal model needs the column time_s" in capsys.readouterr().err
    assert not (folder / "unwritten.toml").exists()


TASK = """
vcmm = "scenario/1"
machine = "shown.toml"
[part.features]
low = {{ type = "plane", point = "0 0 0 mm", normal = [0, 0, 1], size = "20 20 mm" }}
[[part.characteristics]]
name = "flat"
type = "flatness"
of = "low"
zone = "0.1 mm"
[pose]
shift = "200 0 100 mm"
[plan]
styli.down = {{ offset = "0 0 -50 mm", tip_diameter = "4 mm" }}
[[plan.steps]]
feature = "low"
stylus = "down"
points = {{ strategy = "grid", n = [3, 3], margin = "2 mm" }}
{0}"""


def test_a_job_states_the_sensor_of_the_machine(found, capsys):
    """Without it the message shows the line to write; with a temperature beyond the recording it refuses."""
    folder, _, machine, model = found
    target = folder / "shown.toml"
    target.write_text(thermal_text(model, machine, folder / "machine.toml", target, ["first.toml"]))
    scenario = folder / "task.toml"
    for more, code, message in (
        ("", 2, '[environment] sensors = { housing = "21.5 degC" }'),
        ('[environment]\nsensors = { housing = "28 degC" }\nu_temperature = { housing = "0.2 K" }\n', 0, ""),
        ('[environment]\nsensors = { housing = "45 degC" }\n', 2, "beyond the temperatures"),
        ('[environment]\nsensors = { housing = "28 K" }\n', 2, "takes degC"),
        ('[environment]\nsensors = { air = "21 degC" }\n', 2, "is no sensor of its own"),
    ):
        scenario.write_text(TASK.format(more))
        assert run(["measure", str(scenario)]) == code
        assert message in capsys.readouterr().err


def test_the_field_follows_the_sensor_behind_its_lag(found, capsys):
    """Three hours at 30 degC after 22: 2.5 um/K x 8 K = 20 um more than at the start, z of the tip."""
    folder, _, machine, model = found
    target, at = folder / "field.toml", folder / "at.csv"
    target.write_text(thermal_text(model, machine, folder / "machine.toml", target, ["first.toml"]))
    at.write_text("X_mm,Y_mm,Z_mm,time_s,temp_housing_C\n100,0,0,0,22\n100,0,0,1,30\n100,0,0,10800,30\n")
    assert run(["field", str(target), "--at", str(at), "--json"]) == 0
    tip = json.loads(capsys.readouterr().out)["tip_error_mm"]
    assert tip[2][2] - tip[0][2] == pytest.approx(20e-3, rel=0.03)
