"""The size of a curve is that of the part that rows tell: what an alignment takes up has no size of its own."""

from __future__ import annotations

import json

import numpy as np
import pytest

from vcmm.face.cli import run
from vcmm.learn.diagnosis.estimates import invisible_directions

MACHINE = """vcmm = "machine/1"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "800 mm"]
[axes.Y]
travel = ["0 mm", "600 mm"]
[axes.Z]
travel = ["-500 mm", "0 mm"]
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "displacement"
observed = "actual - commanded"
[nuisance]
zero = ""
alignment = ""
[noise]
law = "normal"
u = "0.4 um"
"""


def test_a_line_is_unseen_where_zero_and_slope_are_free():
    s = np.linspace(-1.0, 1.0, 21)
    columns = np.column_stack([np.ones(21), s, (3 * s**2 - 1) / 2])  # Legendre polynomials
    free = np.column_stack([np.ones(21), 5.0 * s])
    unseen = invisible_directions(free, columns)
    assert unseen.shape == (3, 2)
    assert np.abs(unseen[2]).max() == pytest.approx(0.0, abs=1e-12)  # the parabola is seen
    assert np.linalg.matrix_rank(unseen[:2]) == 2  # a constant and a line are not
    assert invisible_directions(np.zeros((21, 0)), columns).shape == (3, 0)
    nothing = np.column_stack([s, np.zeros(21)])  # the second number does nothing to these rows
    assert np.abs(invisible_directions(np.zeros((21, 0)), nothing)).ravel() == pytest.approx([0.0, 1.0])


@pytest.mark.thorough
def test_a_straightness_under_a_free_alignment_has_a_size_and_is_written(tmp_path, capsys):
    rng = np.random.default_rng(3)
    there = np.sort(np.linspace(10, 570, 30) + rng.uniform(-6, 6, 30))
    y = np.tile(np.concatenate([there, there[::-1]]), 3)
    sense = np.tile(np.repeat([1, -1], 30), 3)
    w = (y - 300) / 300
    curve = 4.0 * (w**3 - 0.6 * w) + 1.5 * (w**2 - 0.33)
    across = curve + 0.01 * y + 3.0 + rng.normal(0, 0.4, len(y))
    along = -0.5 * 2.1 * sense + rng.normal(0, 0.4, len(y))
    rows = [
        f"{t},400,{a:.4f},-200,{k},{p:.4f},{q:.4f}"
        for t, (a, k, p, q) in enumerate(zip(y, sense, across, along))
    ]
    head = "time_s,X_mm,Y_mm,Z_mm,sense_Y,dx_um,dy_um"
    (tmp_path / "data.csv").write_text("\n".join([head, *rows]) + "\n")
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "recording.toml").write_text(RECORDING)
    assert run(["diagnose", str(tmp_path / "recording.toml"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    [straightness] = [a for a in found["answer"] if a["where"] == {"component": "EXY"}]
    line = np.column_stack([np.ones(len(y)), y])  # by numpy alone: what is left of the curve beside its line
    rest = curve - line @ np.linalg.lstsq(line, curve, rcond=None)[0]
    size = straightness["parameters"]["rms"]
    assert not straightness["doubtful"]
    assert size["u"] < 0.06  # 180 readings of 0.4 um: 0.4 / sqrt(180) = 0.03
    assert abs(size["value"] - np.sqrt((rest**2).mean())) < 3 * size["u"]
    assert found["fit"]["rms_after_um"] < 0.45  # of 0.4 um of noise; 0.61 with the play alone
