"""Waves whose period stands on no list, on uneven rows; data by numpy alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.diagnosis.sharpen import spectrum_of
from vcmm.physics.catalogue.pitch import ScrewPitch

MACHINE = """vcmm = "machine/1"
structure = "w b X t"
[axes.X]
travel = ["0 mm", "600 mm"]
[repeatability]
law = "normal"
u = "1 um"
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "displacement"
observed = "actual - commanded"
history = "none"
[nuisance]
zero = ""
"""


def written(folder: Path, x: np.ndarray, d: np.ndarray) -> Path:
    rows = [f"{a:.5f},1,0,0,{v:.4f}" for a, v in zip(x, d)]
    (folder / "data.csv").write_text("\n".join(["X_mm,nx,ny,nz,d_um", *rows]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


def uneven(folder: Path, period: float, size: float, n: int = 100) -> Path:
    """n rows at random places of 590 mm, a wave and a scatter of 1 um."""
    rng = np.random.default_rng(3)
    x = np.sort(rng.uniform(0, 590, n))
    return written(folder, x, size * np.sin(2 * np.pi * x / period) + rng.normal(0, 1, n))


def problem_of(path: Path) -> Problem:
    return make_problem(*load_recording(path))


def test_the_nats_of_a_line_are_those_of_least_squares(tmp_path):
    """-dof / 2 ln(what a constant, a sine and a cosine leave / what a constant leaves), by numpy at the highest line."""
    problem = problem_of(uneven(tmp_path, 7.493, 3.0))
    white = problem.whitener()
    spectrum = spectrum_of(ScrewPitch("X", 0.0, 0.0, 10.0), problem, white)
    assert spectrum is not None
    nats = spectrum.nats(white.apply(problem.residual))
    best = float(spectrum.frequency[int(np.argmax(nats))])
    assert 1.0 / best == pytest.approx(7.493, rel=0.25 * 7.493 / 590)  # within a quarter of a line
    x, d = problem.run.q("X"), problem.residual
    columns = np.column_stack([np.ones(100), np.sin(2 * np.pi * best * x), np.cos(2 * np.pi * best * x)])
    left = d - columns @ np.linalg.lstsq(columns, d, rcond=None)[0]
    due = -0.5 * 99 * np.log(np.sum(left**2) / np.sum((d - d.mean()) ** 2))
    assert float(nats.max()) == pytest.approx(due, rel=0.05)  # bins lose up to 2.5 % of an amplitude


def test_the_price_is_the_ln_of_the_independent_lines(tmp_path):
    """590 mm down to 1 mm are 590 waves: between one and four lines each, ln 590 = 6.4 and ln 2360 = 7.8 (finer places are searched)."""
    problem = problem_of(uneven(tmp_path, 7.493, 0.0))
    spectrum = spectrum_of(ScrewPitch("X", 0.0, 0.0, 10.0), problem, problem.whitener())
    assert spectrum is not None
    assert np.log(590) - 0.5 < spectrum.price < np.log(2360) + 0.5


@pytest.mark.thorough
@pytest.mark.parametrize(("period", "name"), [(7.493, "screw_pitch"), (0.0254, "encoder_interpolation")])
def test_a_period_on_no_list_is_found(tmp_path, period, name):
    """100 uneven places tell 50 waves of 590 mm apart by the grid; beyond it 8 mm and 0.02 mm were the nearest that were tried."""
    found = diagnose(*load_recording(uneven(tmp_path, period, 3.0)), seed=0)
    (wave,) = (a for a in found.answer if not a.doubtful)
    assert wave.effect == name
    assert wave.parameters["period"].value == pytest.approx(period, rel=0.001)
    assert wave.parameters["amplitude"].value == pytest.approx(3.0, abs=0.5)
    assert found.verdict == "explained"


def test_aliases_are_rivals_by_name(tmp_path):
    """10 mm every 7.3 mm is 1 / (1 / 7.3 - 1 / 10) = 27.04 mm; 1 / (1 / 7.3 + 1 / 27.04) = 5.75 mm."""
    x = np.tile(np.arange(0, 600, 7.3), 3)
    d = 5 * np.sin(2 * np.pi * x / 10) + np.random.default_rng(3).normal(0, 1, len(x))
    found = diagnose(*load_recording(written(tmp_path, x, d)), seed=0)
    (wave,) = (a for a in found.answer if not a.doubtful)
    assert wave.parameters["period"].value == pytest.approx(27.04, rel=0.002)
    assert wave.cannot_be_told_from[:2] == ("screw_pitch of 10 mm", "screw_pitch of 5.75 mm")
