"""A chain of calibrations over months: what is not read becomes less certain, what is read follows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.learn.calibration.drawn import TRAVEL
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.face.cli import run
from vcmm.files.learned.calibrated_machine import machine_texts
from vcmm.files.own.machine import load_machine
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.result import Calibration
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.task.instruments.laser import line
from vcmm.task.instruments.laying import simulate_reading

ONLY = ("EXX", "EYX")


def bare() -> Machine:
    return Machine("axis", "cmm", parse_structure("w b X t"), {"X": Axis("X", TRAVEL["X"])})


def lines(names: tuple[str, ...], truth: Machine, rng: np.random.Generator) -> list:
    targets = np.linspace(0, 600, 13)
    made = [line(bare(), "X", targets, {}, np.zeros(3), component=n[1], u=0.1e-3) for n in names]
    return [simulate_reading(one, truth, rng) for one in made]


def stored(found: Calibration, folder: Path) -> Machine:
    for name, text in machine_texts(found, folder / "machine.toml", ["r"]).items():
        (folder / name).write_text(text)
    return load_machine(folder / "machine.toml")


def mean_u(found: Calibration, name: str) -> float:
    return float(np.sqrt((found.band(name)[2] ** 2).mean()))


def scale(k: float) -> Machine:
    return bare().with_effect(ComponentPolynomial("EXX", np.array([0.0, k * 1e-3])))


def test_variances_grow_by_the_month_and_readings_bring_them_back(tmp_path):
    rng = np.random.default_rng(1)
    first = calibrate(lines(ONLY, scale(10.0), rng), bare(), only=ONLY)
    old = stored(first, tmp_path)
    # EXX is read again and has grown by 2 um/m (1.2 um over the travel, 0.35 um rms); EYX is not read
    growth = 0.5e-3 * np.sqrt(4)
    later = calibrate(lines(("EXX",), scale(12.0), rng), old, growth=growth)
    assert mean_u(later, "EYX") == pytest.approx(np.hypot(mean_u(first, "EYX"), growth), rel=0.01)
    assert mean_u(later, "EXX") < 0.05 * growth  # 13 targets with 0.1 um
    nodes, value, u = later.band("EXX")
    assert np.abs((value - 12e-6 * (nodes - 300)) / u).max() < 4
    assert later.band("EYX")[1] == pytest.approx(np.interp(nodes, *first.band("EYX")[:2]), abs=5e-5)
    assert "may have changed by u = 1 um (1 urad)" in " ".join(later.warnings)
    assert not any("what happened" in w for w in later.warnings)


def test_nothing_known_cannot_grow():
    read = lines(("EXX",), scale(10.0), np.random.default_rng(1))
    with pytest.raises(UsageError, match="the machine file states none; leave --growth out"):
        calibrate(read, bare(), only=("EXX",), growth=1e-3)


@pytest.mark.thorough
def test_more_change_than_stated_is_said(tmp_path):
    rng = np.random.default_rng(2)
    old = stored(calibrate(lines(ONLY, scale(10.0), rng), bare(), only=ONLY), tmp_path)
    later = calibrate(lines(("EXX",), scale(30.0), rng), old, growth=0.1e-3)
    (said,) = [w for w in later.warnings if "what happened" in w]
    assert said.startswith("EXX: the readings lie")


@pytest.mark.thorough
def test_three_months_of_a_chain_hold_the_truth(tmp_path):
    """A scale that wanders by 0.3 um rms a month, read every month with 0.1 um: the last band holds the last truth."""
    rng = np.random.default_rng(3)
    k, known, scores = 10.0, bare(), []
    for month in range(4):
        found = calibrate(
            lines(ONLY, scale(k), rng),
            known,
            only=ONLY if month == 0 else (),
            growth=0.3e-3 if month else 0.0,
        )
        nodes, value, u = found.band("EXX")
        scores.append((value - k * 1e-6 * (nodes - 300)) / u)
        folder = tmp_path / str(month)
        folder.mkdir()
        known = stored(replace(found), folder)
        k += 0.3 / 0.173 * rng.standard_normal()  # rms of a line of 1 um/m over 600 mm is 0.173 um
    assert np.sqrt((np.concatenate(scores) ** 2).mean()) < 1.6
    assert np.abs(np.concatenate(scores)).max() < 4


def test_growth_on_the_command_line_is_checked(tmp_path, capsys):
    recording = tmp_path / "r.toml"
    recording.write_text("")  # a file that is missing would be named first
    assert run(["calibrate", str(recording), "--structure", "w b X t", "--growth", "0.5 um"]) == 2
    assert "and a machine file with --machine" in capsys.readouterr().err
