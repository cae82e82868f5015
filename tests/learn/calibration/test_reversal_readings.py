"""Reversals beside other recordings: one joint fit, the sign of either side of the chain, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.face.cli import run
from vcmm.files.own.recording_writer import save_recording
from vcmm.files.own.reversal import load_reversal
from vcmm.learn.calibration.job import bare_machine, calibrate
from vcmm.learn.calibration.reversal_readings import reversed_recordings
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.task.instruments.laser import line
from vcmm.task.instruments.laying import simulate_reading

PLACES = np.linspace(0.0, 100.0, 11)
REVERSAL = """vcmm = "recording/1"
data = "turned.csv"
kind = "displacement"
[reversal]
test = "straightness"
error = "EZX"
"""


def slide(x: np.ndarray) -> np.ndarray:
    """1 um in the middle, a parabola: mm."""
    return 1e-3 * (1 - ((x - 50) / 50) ** 2)


@pytest.fixture
def turned(tmp_path: Path) -> Path:
    """Three scans each of the slide against a straightedge of 2 um, noise 10 nm."""
    rng = np.random.default_rng(4)
    rows = ["X_mm,setup,run,d_um"]
    for setup, sign in (("normal", 1), ("reversed", -1)):
        for scan in range(3):
            form = 2 * np.sin(PLACES / 20) + 0.05 * scan + 0.003 * PLACES
            read = form + sign * slide(PLACES) * 1e3 + 0.01 * rng.standard_normal(len(PLACES))
            rows += [f"{x:g},{setup},{scan},{v:.6f}" for x, v in zip(PLACES, read)]
    (tmp_path / "turned.csv").write_text("\n".join(rows))
    (tmp_path / "turned.toml").write_text(REVERSAL)
    return tmp_path / "turned.toml"


@pytest.mark.parametrize("structure", ["w b X t", "w X' b t"])
def test_the_separated_curve_is_what_a_joint_fit_finds(turned, structure):
    machine = bare_machine(structure)
    recordings, covariance = reversed_recordings([load_reversal(turned)], machine)
    found = calibrate(recordings, machine, only=("EZX",), correlated=covariance)
    nodes, value, u = found.band("EZX")
    fine = np.linspace(0, 100, 2001)
    true = slide(nodes) - slide(fine).mean()  # the line of a parabola over the travel is its mean: 2/3 um
    assert slide(fine).mean() == pytest.approx(2e-3 / 3, rel=1e-3)
    assert np.abs(value - true).max() < 15e-6
    assert 1e-6 < np.sqrt((u**2).mean()) < 10e-6
    assert (np.abs(value - true) < 2.5 * u).mean() > 0.85


def test_a_reversal_and_a_laser_in_one_call(turned, tmp_path, capsys):
    """The laser sees 10 um/m of X, and Z of it with 0.3 um of noise; of the straightness the reversal knows 30 times more."""
    truth = bare_machine("w b X t").with_effect(
        ComponentPolynomial("EXX", np.array([0.0, 10e-3])),
        ComponentPolynomial("EZX", np.array([0.0, 0.0, 0.0])),
    )
    rng = np.random.default_rng(1)
    for name, u in (("X", 0.05e-3), ("Z", 0.3e-3)):
        meant = line(truth, "X", PLACES, {}, np.zeros(3), name, u)
        read = simulate_reading(meant, truth, rng)
        at = read.run.q("X")[read.row]
        curve = slide(at) * read.sign if name == "Z" else 0.0
        object.__setattr__(read, "value", read.value + curve)
        save_recording(read, tmp_path / f"laser_{name}.toml", "unused.toml")
    lasers = [str(tmp_path / f"laser_{n}.toml") for n in "XZ"]
    words = ["--structure", "w b X t", "--errors", "EXX EZX", "--json"]
    found = {}
    for which, files in (("laser", lasers), ("both", [*lasers, str(turned)])):
        out = tmp_path / which / "machine.toml"
        assert run(["calibrate", *files, *words, "--out", str(out)]) == 0
        document = json.loads(capsys.readouterr().out)
        found[which] = {f["error"]: f for f in document["identified"]}
        assert [r["recording"] for r in document["residuals"]][-1] == ("turned" if which == "both" else "EZX")
    assert found["both"]["EXX"]["u"] == pytest.approx(found["laser"]["EXX"]["u"], rel=0.15)
    assert found["both"]["EZX"]["u"] < found["laser"]["EZX"]["u"] / 8
    assert found["both"]["EZX"]["high"] - found["both"]["EZX"]["low"] == pytest.approx(1.0, abs=0.03)


def test_other_reversals_beside_a_laser_are_told_to_go_alone(turned, tmp_path, capsys):
    text = turned.read_text().replace('"straightness"', '"half-turn"').replace('"EZX"', '"B0C"')
    (tmp_path / "half.toml").write_text(text)
    lathe = bare_machine("w C' X' b Z t")
    meant = line(lathe, "X", PLACES, {"Z": 0.0, "C": 0.0}, np.zeros(3), "X", 1e-4)
    save_recording(
        simulate_reading(meant, lathe, np.random.default_rng(0)), tmp_path / "laser.toml", "unused.toml"
    )
    words = ["calibrate", str(tmp_path / "laser.toml"), "--structure", "w C' X' b Z t"]
    assert run([*words, str(tmp_path / "half.toml")]) == 2
    assert "Calibrate it alone with --out spindle.toml" in capsys.readouterr().err
    assert run([*words, str(turned), "--thermal", "--machine", str(turned)]) == 2
    assert "a reversal takes no --thermal" in capsys.readouterr().err
    with pytest.raises(UsageError, match='is about axis X, which structure = "w b Y t" lacks'):
        reversed_recordings([load_reversal(turned)], bare_machine("w b Y t"))


def test_a_key_that_is_too_long_takes_its_table_out_and_is_told(turned):
    turned.write_text(REVERSAL.replace("test =", f'"{"k" * 10_000}" ='))
    with pytest.raises(DataError, match=r"turned\.toml"):
        load_reversal(turned)
