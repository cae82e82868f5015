"""A gap that goes with the speed is named so, and one that does not stays a plain play. Rows by numpy alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.job import diagnose

MACHINE = 'vcmm = "machine/1"\nstructure = "w b X t"\n[axes.X]\ntravel = ["0 mm", "600 mm"]\n[repeatability]\nlaw = "normal"\nu = "0.4 um"\n'
RECORDING = 'vcmm = "recording/1"\ndata = "data.csv"\nmachine = "machine.toml"\nkind = "displacement"\nobserved = "actual - commanded"\nhistory = "none"\n[nuisance]\nzero = ""\n'


def _write(folder: Path, power: float, seed: int) -> Path:
    """240 approaches at 5, 20, 50 and 100 mm/s; a gap of 3 um at 5 mm/s times (v / 5)^power; noise 0.4 um."""
    rng = np.random.default_rng(seed)
    n = 240
    x, sense, speed = rng.uniform(0, 500, n), rng.choice([-1, 1], n), rng.choice([5.0, 20.0, 50.0, 100.0], n)
    d = -0.5 * 3.0 * (speed / 5.0) ** power * sense + rng.normal(0, 0.4, n)
    rows = [
        f"{a:.3f},{b},{b * c},{10 * k},1,0,0,{e:.4f}"
        for k, (a, b, c, e) in enumerate(zip(x, sense, speed, d))
    ]
    (folder / "data.csv").write_text(
        "\n".join(["X_mm,sense_X,speed_X_mm_s,time_s,nx,ny,nz,d_um", *rows]) + "\n"
    )
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


@pytest.mark.thorough
def test_a_gap_that_grows_with_speed_is_named_with_its_power(tmp_path: Path):
    # from 5 to 100 mm/s the gap grows 2.4-fold: power ln 2.4 / ln 20 = 0.2922; at 1000 mm/min = 16.667 mm/s it is 3 x 3.3333^0.2922 = 4.265 um
    found = diagnose(*load_recording(_write(tmp_path, np.log(2.4) / np.log(20.0), 21)), seed=0)
    (answer,) = found.found
    assert (answer.effect, answer.where) == ("lost_motion_speed", {"axis": "X"})
    assert answer.probability > 0.9
    assert found.verdict == "explained"
    power, gap = answer.parameters["power"], answer.parameters["gap"]
    assert power.value == pytest.approx(0.2922, abs=4 * power.u)
    assert gap.value == pytest.approx(4.265, abs=4 * gap.u)


@pytest.mark.thorough
def test_a_gap_that_is_the_same_at_every_speed_stays_a_backlash(tmp_path: Path):
    found = diagnose(*load_recording(_write(tmp_path, 0.0, 22)), seed=0)
    (answer,) = found.found
    assert answer.effect == "backlash"
    assert answer.family_probability > 0.9
    assert answer.parameters["gap"].value == pytest.approx(3.0, abs=4 * answer.parameters["gap"].u)
