"""A name at a place beside which another place explains as much: the other is a rival, with its probability. Rows by numpy alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.job import diagnose

MACHINE = 'vcmm = "machine/1"\nstructure = "w b Y X t"\n[axes.X]\ntravel = ["0 mm", "600 mm"]\n[axes.Y]\ntravel = ["0 mm", "500 mm"]\n[repeatability]\nlaw = "normal"\nu = "0.5 um"\n'
RECORDING = 'vcmm = "recording/1"\ndata = "data.csv"\nmachine = "machine.toml"\nkind = "displacement"\nobserved = "actual - commanded"\n[nuisance]\nzero = ""\n'


def _write(folder: Path, seed: int) -> Path:
    """A lag of Y of 0.1 ms, read along (1, 1): 100 rows on a line at 45 deg, where X and Y run at one speed, and 12 at 40 deg.

    At 40 deg and 33.3 mm/s the lag of X would read 1e-4 x 25.5 x 0.707 = 1.80 um and that of Y 1.51 um: 12 rows of 0.5 um tell them apart by
    12 x (0.29 / 0.5)^2 / 2 = 2 nats.
    """
    rng = np.random.default_rng(seed)
    angle = np.radians(np.repeat([45.0, 40.0], [100, 12]))
    speed = np.where(np.arange(112) < 50, 16.7, 33.3)
    sense = np.where(np.arange(112) % 2, 1.0, -1.0)
    way = rng.uniform(-200, 200, 112)
    vx, vy = sense * speed * np.cos(angle), sense * speed * np.sin(angle)
    d = -1e-4 * vy * 1e3 / np.sqrt(2) + rng.normal(0, 0.5, 112)
    head = "X_mm,Y_mm,speed_X_mm_s,speed_Y_mm_s,sense_X,sense_Y,nx,ny,nz,time_s,d_um"
    rows = [
        f"{300 + w * np.cos(a):.4f},{250 + w * np.sin(a):.4f},{x:.5f},{y:.5f},{s:.0f},{s:.0f},0.70710678,0.70710678,0,{3 * k},{e:.4f}"
        for k, (w, a, x, y, s, e) in enumerate(zip(way, angle, vx, vy, sense, d))
    ]
    (folder / "data.csv").write_text("\n".join([head, *rows]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


@pytest.mark.thorough
def test_the_lag_of_the_other_axis_is_a_rival_with_its_probability(tmp_path: Path):
    found = diagnose(*load_recording(_write(tmp_path, 4)), seed=0)
    answer = found.answer[0]
    assert answer.effect == "servo_lag"
    here = str(answer.where["axis"])
    other = {"X": "Y", "Y": "X"}[here]
    assert f"servo_lag[{other}]" in answer.cannot_be_told_from
    assert f"its place is open: as good at {other} (p " in answer.remark
    # the two share what is certain, but for the odds of a mechanism outside
    assert answer.with_rivals == pytest.approx(0.975, abs=0.02)
    # a rival is followed by what tells the two apart
    assert any(f"servo_lag[{other}]" in step.separates for step in found.next_measurement)
