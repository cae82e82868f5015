"""A machine file tested on what it was not made from, and the file of the compensated machine."""

from __future__ import annotations

import json
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest

from tests.learn.calibration.drawn import STRUCTURE, bare, draw, laser_and_plates, recorded
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.face.cli import run
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.verification import check_independent, put_to_test, remainder
from vcmm.task.instruments.laser import line
from vcmm.task.instruments.laying import simulate_reading


def another_line(rng: np.random.Generator, machine: Machine):
    """A laser along X with another tip than that of the calibration, at other positions."""
    at = {"Y": 250.0, "Z": -200.0}
    layout = line(bare(), "X", np.linspace(20.0, 580.0, 15), at, np.array([0.0, 150.0, -280.0]), "X", 0.2e-3)
    return simulate_reading(replace(layout, name="another line"), machine, rng)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Six errors of X calibrated, the residual file beside it, the line as a file, and the document that was printed."""
    folder = tmp_path_factory.mktemp("tested")
    rng = np.random.default_rng(7)
    machine = draw(rng)
    files = []
    for one in recorded(machine, laser_and_plates(bare())[:6], rng):
        save_recording(one, folder / f"{one.name}.toml", "unused.toml")
        files.append(str(folder / f"{one.name}.toml"))
    save_recording(another_line(rng, machine), folder / "another.toml", "unused.toml")
    words = ["calibrate", *files, "--structure", STRUCTURE, "--out", str(folder / "machine.toml")]
    words += ["--residual", str(folder / "left.toml"), "--test", str(folder / "another.toml"), "--json"]
    with redirect_stdout(StringIO()) as out:
        assert run(words) == 0
    return folder, files, words, machine, json.loads(out.getvalue())


def test_a_gain_is_told_on_another_line(done):
    """The line with another tip shows EXX and the pitch and yaw of X; the file predicts it to the noise."""
    folder, _, _, _, document = done
    (told,) = document["tests"]
    assert told["rms_after"] < 0.5 < 1.0 < told["rms_before"]
    assert told["inside"] >= 0.8
    one, _ = load_recording(folder / "another.toml", load_machine(folder / "machine.toml"))
    assert put_to_test(one, bare(), load_machine(folder / "machine.toml")).after * 1e3 == pytest.approx(
        told["rms_after"]
    )
    again = put_to_test(one, bare(), load_machine(folder / "machine.toml"))
    assert again.gain == pytest.approx(1.0 - told["rms_after"] / told["rms_before"])


def test_the_compensated_machine_has_no_table_and_the_same_covariance(done):
    folder = done[0]
    machine, left = load_machine(folder / "machine.toml"), load_machine(folder / "left.toml")
    assert (left.state, left.compensation) == ("residual", ("machine_errors.csv",))
    for effect in left.effects:
        if effect.about.table_parameter and effect.about.is_calibrated:
            assert np.asarray(effect.values) == pytest.approx(0.0)
    (one,), (other,) = machine.inputs, left.inputs
    assert one.law.u == pytest.approx(other.law.u)
    recording, _ = load_recording(folder / "another.toml", machine)
    _, spread = remainder(recording, machine)
    _, again = remainder(recording, left)
    assert again == pytest.approx(spread, abs=1e-12)


def test_compensated_with_its_table_the_drawn_machine_stays_within_the_residual_band(done):
    """The drawn machine less the table, seen by the laser line: nothing is left but the band that the residual file states."""
    folder, _, _, truth, _ = done
    rng = np.random.default_rng(1)
    table = load_machine(folder / "machine.toml")
    seen = another_line(rng, truth)
    compensated = replace(seen, value=remainder(seen, table)[0])
    told = put_to_test(compensated, bare(), load_machine(folder / "left.toml"))
    assert told.inside >= 0.8
    assert told.u < 0.5e-3


def test_the_covariance_of_what_is_left_by_hand():
    """Two readings of u = 3 and 4 um and a zero: half their difference is left, with variance (9 + 16) / 4 = 2.5^2 um^2."""
    layout = line(bare(), "X", np.array([0.0, 600.0]), {"Y": 250.0, "Z": -200.0}, np.zeros(3), "X", 1e-3)
    one = simulate_reading(layout, bare(), np.random.default_rng(0)).take(np.array([0, 1]))
    two = replace(one, value=np.array([1e-3, 5e-3]), u=np.array([3e-3, 4e-3]), noise=None)
    left, spread = remainder(two, bare())
    assert left == pytest.approx([-2e-3, 2e-3])
    assert np.sqrt(spread[0, 0]) == pytest.approx(2.5e-3)
    assert spread[0, 1] == pytest.approx(-(2.5e-3**2))


def test_the_training_readings_are_no_test(done, capsys):
    folder, files, *_ = done
    words = ["calibrate", *files, "--structure", STRUCTURE, "--out", str(folder / "m.toml")]
    assert run([*words, "--test", files[0]]) == 2
    assert "holds the same readings as" in capsys.readouterr().err
    one, _ = load_recording(folder / "another.toml", bare())
    check_independent(one, [one.take(np.arange(5))])
    with pytest.raises(UsageError, match="state the gain on a separate"):
        check_independent(one, [one])
