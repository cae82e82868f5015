"""From recording files to a machine file and back, on the command line; real positioning runs predict one another."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import data_file
from tests.learn.calibration.drawn import bare, draw, laser_and_plates, recorded
from vcmm.face.cli import run
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer

X_ONLY = ("EXX", "EYX", "EZX", "EAX", "EBX", "ECX")


@pytest.fixture(scope="module")
def recorded_x(tmp_path_factory: pytest.TempPathFactory):
    """Six errors of X as files, and the machine they were read on."""
    folder = tmp_path_factory.mktemp("x")
    rng = np.random.default_rng(3)
    machine = draw(rng)
    files = []
    for one in recorded(machine, laser_and_plates(bare())[:6], rng):
        save_recording(one, folder / f"{one.name}.toml", "unused.toml")
        files.append(str(folder / f"{one.name}.toml"))
    return folder, files, machine


def document(capsys, words: list[str]) -> dict:
    code = run(words)
    out, err = capsys.readouterr()
    assert code == 0, err
    return json.loads(out)


@pytest.mark.thorough
def test_recordings_to_a_machine_file_and_back(recorded_x, capsys):
    folder, files, _ = recorded_x
    out = folder / "m" / "machine.toml"
    report = folder / "m" / "report.html"
    words = [
        "calibrate",
        *files,
        "--structure",
        "w b Y X Z t",
        "--out",
        str(out),
        "--json",
        "--report",
        str(report),
    ]
    found = document(capsys, words)
    assert found["machine"] == str(out)
    assert {f["error"] for f in found["identified"]} >= set(X_ONLY)
    assert found["not_identified"] == []
    assert 0.1 < found["residual_um"] < 0.4
    assert found["condition"] > 1
    assert ">EYX<" in report.read_text()
    assert "EAX: residuals and 95 % of the noise" in report.read_text()
    again = load_machine(out)
    assert [i.id for i in again.inputs] == ["calibration_modes[*].modes"]
    # a straightness recording less the file's prediction is the noise of 0.3 um, before and after the round trip
    one, _ = load_recording(files[1], again)
    nuisance, _ = nuisance_columns(one, again)
    e = one.value - Observer(one, again).baseline()
    e -= nuisance @ np.linalg.lstsq(nuisance, e, rcond=None)[0]
    stated = next(r for r in found["residuals"] if r["recording"] == "EYX")
    assert np.sqrt((e**2).mean()) * 1e3 == pytest.approx(stated["rms"], rel=0.02)


def test_the_written_file_is_tested_and_mapped(recorded_x, capsys):
    folder, files, _ = recorded_x
    out = folder / "m2" / "machine.toml"
    assert run(["calibrate", *files, "--structure", "w b Y X Z t", "--out", str(out)]) == 0
    capsys.readouterr()
    figures = {
        f["name"]: f
        for f in document(capsys, ["test", str(out), "--iso", "230-2", "--limit", "E = 1 mm", "--json"])[
            "figures"
        ]
    }
    assert figures["E X"]["u_um"] > 0.01
    assert figures["E X"]["p_pass"] == 1.0
    assert document(capsys, ["field", str(out), "--json"])["points"] > 0
    assert (
        document(capsys, ["diagnose", files[0], "--machine", str(out), "--json"])["verdict"]
        == "nothing missing"
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["calibrate"], "calibrate needs recordings"),
        (["calibrate", "r.toml"], "name either --structure"),
        (["test", "m.toml", "--iso", "230-9"], "does not exist"),
    ],
)
def test_wrong_command_lines(words, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "r.toml").write_text('vcmm = "recording/1"\n')  # a file that is missing would be named first
    assert run(words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('name = "lasr linear"', 'Did you mean "laser linear"'),
        ('name = "tracker"', 'this one is of kind "displacement"'),
        ('name = "laser linear"\nu = { gain = "1 %" }', 'has no error "gain"'),
        ('name = "laser linear"\nu = { scale = "1 um" }', "scale"),
        ('name = "laser linear"\nredraw = "setup"', 'no label column "setup"'),
        (
            'name = "laser linear"\ncompensated = ["air"]',
            "compensation of air is claimed, but the data have no temp_air_C",
        ),
    ],
)
def test_wrong_instruments(recorded_x, table, message, capsys):
    folder, files, _ = recorded_x
    path = folder / "wrong.toml"
    path.write_text(Path(files[0]).read_text() + f"[instrument]\n{table}\n")
    assert run(["calibrate", str(path), "--structure", "w b Y X Z t"]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert "wrong.toml:" in err


def _cycles(text: str, keep: set[int]) -> str:
    lines = []
    for line in text.splitlines():
        match = re.match(r"REF_DATA_(FWD|BWD)\[(\d+),(\d+)\]", line)
        if match is None or int(match[3]) in keep:
            lines.append(line)
    return "\n".join(lines) + "\n"


def _runs(folder: Path, name: str, file: str, text: str) -> Path:
    (folder / file).write_text(text)
    path = folder / f"{name}.toml"
    head = f'vcmm = "recording/1"\nname = "{name}"\ndata = "{file}"\nformat = "iso230"\nkind = "displacement"\nhistory = "none"\n'
    path.write_text(head + '[line]\naxis = "X"\n[nuisance]\nzero = ""\n')
    return path


def _rest(recording, machine) -> tuple[float, float]:
    """rms (um) of a recording about its zero before and after the prediction of a machine file."""
    nuisance, _ = nuisance_columns(recording, machine)
    out = []
    for value in (recording.value, recording.value - Observer(recording, machine).baseline()):
        rest = value - nuisance @ np.linalg.lstsq(nuisance, value, rcond=None)[0]
        out.append(float(np.sqrt((rest**2).mean()) * 1e3))
    return out[0], out[1]


def test_cycles_2_and_3_of_a_real_axis_predict_cycles_4_and_5(tmp_path):
    """Stepper axis mcu1025, position-dependent reversal of 40 um: 22.6 um of cycles never fitted become 1.9 um."""
    text = data_file("data/recordings/iso230_2_linear_axis/mcu1025_ISO230.dat").read_text()
    first = _runs(tmp_path, "cycles 2 3", "a.dat", _cycles(text, {2, 3}))
    later = _runs(tmp_path, "cycles 4 5", "b.dat", _cycles(text, {4, 5}))
    assert run(["calibrate", str(first), "--structure", "w b X t", "--out", str(tmp_path / "m.toml")]) == 0
    machine = load_machine(tmp_path / "m.toml")
    before, after = _rest(load_recording(later, machine)[0], machine)
    assert before == pytest.approx(22.6, abs=0.2)
    assert after < 2.5  # noise of the sensor about 2.4 um


def test_the_accuracy_run_of_a_slit_axis_predicts_its_repeatability_run(tmp_path):
    """Slit axis 2: 12 targets once each way predict 3 targets ten times each way; 1.32 um become 0.10 um."""
    with data_file("data/recordings/iso230_2_linear_axis/slit_11358_axis2_tidy.csv").open() as file:
        table = [r for r in csv.DictReader(file) if r["resolver_mm"]]
    paths = {}
    for test in ("accuracy", "repeatability"):
        rows = [
            f"{r['target_mm']},{r['run']},{r['approach']},{r['resolver_mm']}"
            for r in table
            if r["test"] == test
        ]
        text = "\n".join(["target_mm,run,direction,actual_mm", *rows]) + "\n"
        paths[test] = _runs(tmp_path, test, f"{test}.csv", text)
    assert (
        run(
            ["calibrate", str(paths["accuracy"]), "--structure", "w b X t", "--out", str(tmp_path / "m.toml")]
        )
        == 0
    )
    machine = load_machine(tmp_path / "m.toml")
    before, after = _rest(load_recording(paths["repeatability"], machine)[0], machine)
    assert before == pytest.approx(1.32, abs=0.02)
    assert after < 0.15


def test_a_recalibrated_file_keeps_what_its_owner_wrote(recorded_x, capsys):
    """Comments, other effects and names of files stay; [errors] and single components give way to the new table."""
    folder, files, _ = recorded_x
    old = folder / "old"
    old.mkdir()
    (old / "errors.csv").write_text("X EXX\n0 0.001\n300 0.002\n600 0.001\n")
    (old / "machine.toml").write_text(
        'vcmm = "machine/1"\nname = "mine"\nstructure = "w b Y X Z t"\n# bought in 1998\n'
        + "".join(f'[axes.{a}]\ntravel = ["-1000 mm", "1000 mm"]\n' for a in "XYZ")
        + '[errors]\ntable = "errors.csv"\n[errors.uncertainty]\ntranslation = "1 um"\n'
        '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "3 urad"\n'
        '[[effects]]\neffect = "backlash"  # since spring\naxis = "Y"\ngap = "2 um"\n'
        '[[inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nlaw = "normal"\nu = "1 urad"\n'
    )
    out = folder / "new" / "machine.toml"
    assert run(["calibrate", *files, "--machine", str(old / "machine.toml"), "--out", str(out)]) == 0
    text = out.read_text()
    assert "# bought in 1998" in text
    assert 'effect = "backlash"  # since spring' in text
    assert text.count("[errors]") == 1
    assert "[errors.uncertainty]" not in text
    assert "squareness" not in text
    machine = load_machine(out)
    assert [e.angle for e in machine.effects if e.id == "squareness[C0Y]"] == [pytest.approx(3e-6)]
    assert [e.gap for e in machine.effects if e.id == "backlash[Y]"] == [2e-3]
    assert [i.id for i in machine.inputs] == ["calibration_modes[*].modes"]
