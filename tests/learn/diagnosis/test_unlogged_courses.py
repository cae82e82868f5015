"""Courses of time that nothing logs stand against steps and straight drifts; data by numpy alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.result import Diagnosis

pytestmark = pytest.mark.thorough  # whole jobs, minutes of processor

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


def of_course(folder: Path, course) -> Diagnosis:
    """200 rows in two hours, scatter 1 um, X at random; course(t) in um."""
    rng = np.random.default_rng(1)
    time, x = np.linspace(0, 7200, 200), rng.uniform(0, 600, 200)
    d = course(time) + rng.normal(0, 1, 200)
    rows = [f"{a:.4f},1,0,0,{v:.4f},{t:.1f}" for a, v, t in zip(x, d, time)]
    (folder / "data.csv").write_text("\n".join(["X_mm,nx,ny,nz,d_um,time_s", *rows]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return diagnose(*load_recording(folder / "recording.toml"), seed=0)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "course",
    [
        lambda t: 8 * np.exp(-(((t - 3000) / 900) ** 2)),  # warms and cools again
        lambda t: 20 * -np.expm1(-np.maximum(t - 2000, 0) / 1500),  # a lag that begins with nothing
    ],
    ids=["hump", "lag"],
)
def test_a_smooth_course_is_no_step(tmp_path, course):
    """The smooth course was told as a step and written; now nothing is a finding, and that time says it is told."""
    found = of_course(tmp_path, course)
    assert [a.effect for a in found.answer if not a.doubtful] == []
    assert found.verdict == "unexplained"
    assert found.unknown is not None
    assert found.unknown.covariates == ("time",)


@pytest.mark.thorough
@pytest.mark.parametrize("size", [2.0, 20.0])
def test_a_step_stays_one(tmp_path, size):
    (step,) = (a for a in of_course(tmp_path, lambda t: size * (t > 3100)).answer if not a.doubtful)
    assert step.effect == "step_change"
    assert step.parameters["a"].value == pytest.approx(size, abs=4 * step.parameters["a"].u)
    assert step.probability > 0.95
