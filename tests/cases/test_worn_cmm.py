"""The twin with two concealed faults: mechanisms by hand, files as shipped, truth beside the answer."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from vcmm_twins.worn_cmm import page, twin

import vcmm
from vcmm.core.run import Run, Series
from vcmm.face.cli import run as command
from vcmm.files.own.library import companions, example, folder
from vcmm.files.own.machine import load_machine
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.structure.thermal import ThermalDrift
from vcmm.show.tables.table import text

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"


@pytest.fixture(scope="module")
def recording():
    return vcmm.load_recording(example("worn_cmm"))


@pytest.fixture(scope="module")
def result(recording):
    return twin.run(*recording, vcmm.load_scenario(example("plate")))


def one_row(**columns) -> Run:
    return Run({"Y": np.array([10.0])}, np.zeros((1, 3)), {k: np.array([v]) for k, v in columns.items()})


def test_play_by_hand():
    """The drive comes down from 15 to 10: the carriage stays half a gap of 1.4 um behind, above the drive: +0.7 um."""
    assert twin.play(one_row(before_Y=15.0))[0] == pytest.approx([0.0, 0.7e-3, 0.0], abs=1e-12)
    assert twin.play(one_row(before_Y=5.0))[0] == pytest.approx([0.0, -0.7e-3, 0.0], abs=1e-12)


def test_a_carriage_is_not_moved_inside_the_gap():
    """Up to 10, then back to 9.999, by less than the gap: the carriage stands at 10 less half the gap."""
    rows = Run({"Y": np.array([10.0, 9.999])}, np.zeros((2, 3)), {"before_Y": np.array([5.0, 9.9995])})
    place = twin.play(rows)[:, 1] + rows.position["Y"]
    assert place[0] == pytest.approx(10.0 - 0.7e-3, abs=1e-12)
    assert place[1] == pytest.approx(place[0], abs=1e-12)


def test_ram_by_hand():
    """Air steps from 20 to 22 degC and stays: after one LAG 1 - 1/e of 2 um, downwards."""
    time = np.arange(0.0, 3 * twin.LAG, 10.0)
    run = one_row(time_s=twin.LAG + 10.0)
    run = Run(
        run.position, run.offset, run.columns, {}, {"air": Series(time, np.where(time < 5.0, 20.0, 22.0))}
    )
    assert twin.ram(run)[0, 2] == pytest.approx(-2e-3 * (1 - np.exp(-1)), abs=5e-6)


def test_signs_of_what_is_seen():
    """A tip that stands too low by 1 um lets the top of a plate appear 1 um too high."""
    assert twin.seen(np.array([[0, 0, -1e-3]]), np.array([[0, 0, 1.0]]))[0] == pytest.approx(1e-3)


def test_the_shipped_files_are_what_the_code_makes():
    machine = load_machine(folder() / "worn_cmm" / "machine.toml")
    for name, made in twin.texts(machine).items():
        assert (folder() / "worn_cmm" / name).read_text(encoding="utf-8") == made
    assert set(companions("worn_cmm")) == {f"worn_cmm/{n}" for n in ("machine.toml", *twin.texts(machine))}


def test_the_machine_is_that_of_the_plate(recording):
    """The job of the twin adds what the room does; the machine itself is one."""
    plate = {e.id: e for e in vcmm.load_scenario(example("plate")).machine.effects}
    for effect in recording[1].effects:
        if effect.name in ("scale_factor", "squareness", "component_polynomial"):
            assert np.array_equal(
                [vars(effect)[k] for k in ("k", "angle", "coefficients") if k in vars(effect)],
                [vars(plate[effect.id])[k] for k in ("k", "angle", "coefficients") if k in vars(effect)],
            )


@pytest.mark.thorough
def test_both_faults_are_named_and_their_intervals_hold_the_truth(result):
    assert result.diagnosis.verdict == "explained"
    assert len(result.diagnosis.answer) == len(twin.CONCEALED)
    for hidden in twin.CONCEALED:
        answer = twin.answer_to(result.diagnosis, hidden)
        assert answer is not None
        assert hidden.effect not in answer.cannot_be_told_from
        for name, (true, unit) in hidden.parameters.items():
            low, high = answer.parameters[name].interval95
            assert low < true < high
            assert answer.parameters[name].unit == unit


@pytest.mark.thorough
def test_rows_never_fitted_are_predicted_better(result):
    folds = result.diagnosis.fit.held_out
    assert len(folds) >= 8
    assert all(f.rms_after < f.rms_before for f in folds)


@pytest.mark.thorough
def test_the_job_is_predicted_better_and_u_knows_the_new_parameters(result):
    """A worn Y shifts the front face by half the gap: the distance is 0.7 um too short by the file, see the sign above."""
    rows = {m.name: m for m in result.job}
    for name in ("bore diameter", "bore to front"):
        moved = rows[name]
        assert abs(moved.after[0] - moved.true) < 0.2 * abs(moved.before[0] - moved.true)
        assert moved.after[1] > moved.before[1]
    assert {i.effect for i in result.better.inputs} >= {"backlash", "thermal_drift"}


@pytest.mark.thorough
def test_documentation_shows_what_the_command_prints(result):
    written = (DOCS / "worn_cmm.md").read_text(encoding="utf-8")
    for shown in page.tables(result):
        assert text(shown) in written, shown.title
        assert shown.caption in written


@pytest.mark.thorough
def test_demo_new_check_and_diagnose(tmp_path, capsys, monkeypatch, recording, result):
    """The command diagnoses the embedded recording and does the job of the plate; the answer to that is `result`."""

    def run(given, machine, job, *, progress):
        assert np.array_equal(given.value, recording[0].value)
        assert [e.id for e in machine.effects] == [e.id for e in recording[1].effects]
        assert job.name == vcmm.load_scenario(example("plate")).name
        return result

    monkeypatch.setattr(twin, "run", run)
    out = tmp_path / "demo"
    assert command(["demo", "--twin", "worn_cmm", "--out", str(out), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["twin"] == "worn_cmm"
    assert document["concealed"][0]["parameters"]["gap"]["true"] == 1.4
    assert "What was concealed" in (out / "report.html").read_text()
    assert command(["demo", "--twin", "worn_cmm", "--draws", "3"]) == 2
    capsys.readouterr()
    assert command(["new", "mine", "--from", "worn_cmm", "--out", str(tmp_path)]) == 0
    assert f"vcmm diagnose {tmp_path}/mine.toml --out mine-report" in capsys.readouterr().out
    assert command(["check", str(tmp_path / "mine.toml"), "--json"]) == 0
    understood = json.loads(capsys.readouterr().out)["understood"]
    assert understood["recording"] == "probe, 400 observations, indicated - true"
    assert understood["labels"] == "pose: 5, stylus: 2"


def test_a_steady_temperature_needs_no_log():
    """20 min behind a room that stood at 21.5 degC all along: -1 um/K * 1.5 K. A column that changes needs its log."""
    drift = ThermalDrift(direction="z", sensor="air", k=-1e-3, tau=1200.0)
    run = Run({"X": np.zeros(2)}, np.zeros((2, 3)), {"temp_air_C": np.array([21.5, 21.5])})
    assert drift.error_motion(run)[:, 2] == pytest.approx([-1.5e-3, -1.5e-3])
    with pytest.raises(vcmm.core.errors.ModelLimit, match="needs a log of temp_air_C"):
        drift.error_motion(run.with_columns({"temp_air_C": np.array([21.5, 21.6])}))


def test_the_sense_of_backlash_is_that_of_play():
    """Own code and catalogue agree in sign: coming down, sense -1, the carriage is +gap/2 off."""
    run = one_row(sense_Y=-1.0)
    assert Backlash(axis="Y", gap=twin.GAP).error_motion(run)[0, 1] == pytest.approx(0.7e-3)
