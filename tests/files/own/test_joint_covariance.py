"""The joint covariance of an error table: read, refused, and the same in Monte Carlo and in first order."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.core.inputs import JointCovariance
from vcmm.core.run import Run
from vcmm.files.own.joint_covariance import covariance_text, read_joint_covariance
from vcmm.files.own.machine import load_machine
from vcmm.task.response.influence import influences

ERRORS = "X EXX EBX\n0 0.001 0\n100 0.002 1e-5\n200 0.001 0\n#\nC0Y\n3e-6\n"
MACHINE = """vcmm = "machine/1"
structure = "w b Y X Z t"
[axes]
X = { travel = ["0 mm", "200 mm"] }
Y = { travel = ["0 mm", "200 mm"] }
Z = { travel = ["-100 mm", "0 mm"] }
[errors]
table = "errors.csv"
interpolation = "cubic"
covariance = "covariance.csv"
"""
NAMES = ("EXX", "EXX", "EXX", "C0Y")
POSITION = np.array([0.0, 100.0, 200.0, np.nan])
MATRIX = 1e-8 * np.array(
    [[4.0, 1.0, 0.0, 2e-3], [1.0, 9.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [2e-3, 0.0, 0.0, 4e-6]]
)


def _folder(tmp_path: Path, matrix: np.ndarray = MATRIX, machine: str = MACHINE) -> Path:
    (tmp_path / "errors.csv").write_text(ERRORS)
    (tmp_path / "covariance.csv").write_text(covariance_text(JointCovariance(NAMES, POSITION, matrix)))
    (tmp_path / "machine.toml").write_text(machine)
    return tmp_path / "machine.toml"


def test_round_trip(tmp_path: Path):
    _folder(tmp_path)
    again = read_joint_covariance(tmp_path / "covariance.csv")
    assert again.errors == NAMES
    assert again.matrix == pytest.approx(MATRIX, rel=1e-7)
    assert again.factor @ again.factor.T == pytest.approx(MATRIX, rel=1e-6, abs=1e-16)


def test_the_covariance_of_the_tip_is_that_of_hand_computation(tmp_path: Path):
    # at X = 100, Y = 150: error in x = EXX(100) - 150 C0Y, so the variance is 9e-8 + 150^2 4e-14 = 9.09e-8 mm^2;
    # at X = 0 it is 4e-8 + 9e-10 - 2 * 150 * 2e-11 = 3.49e-8 mm^2; common to both: 1e-8 + 9e-10 - 150 * 2e-11 = 0.79e-8
    machine = load_machine(_folder(tmp_path))
    run = Run(
        {"X": np.array([100.0, 0.0]), "Y": np.array([150.0, 150.0]), "Z": np.zeros(2)}, np.zeros((2, 3))
    )
    (found,) = influences(machine, machine.prepare(run), machine.inputs)
    covariance = found.response[:, 0] @ found.response[:, 0].T
    assert found.input.id == "calibration_modes[*].modes"
    assert covariance == pytest.approx(np.array([[9.09e-8, 0.79e-8], [0.79e-8, 3.49e-8]]), rel=1e-6)
    assert machine.tip_error(run)[0, 0] == pytest.approx(0.002 - 150 * 3e-6, abs=1e-12)


@pytest.mark.parametrize(
    ("matrix", "machine", "said"),
    [
        (MATRIX - np.diag([0, 1e-7, 0, 0]), MACHINE, "below zero"),
        (
            np.where(np.eye(4) > 0, MATRIX, 2 * MATRIX) * [1, 1, 1, 1]
            + 8e-8 * np.fliplr(np.diag([0, 1, 1, 0])),
            MACHINE,
            "eigenvalue",
        ),
        (MATRIX + np.eye(4, k=1) * 1e-8, MACHINE, "not symmetric"),
        (MATRIX, MACHINE + 'uncertainty = { translation = "1 um" }\n', "keep one of them"),
    ],
)
def test_refused(tmp_path: Path, matrix: np.ndarray, machine: str, said: str):
    with pytest.raises(DataError, match=said):
        load_machine(_folder(tmp_path, matrix, machine))


def test_nodes_that_the_table_does_not_have_are_refused(tmp_path: Path):
    path = _folder(tmp_path)
    text = covariance_text(JointCovariance(NAMES, np.array([0.0, 90.0, 200.0, np.nan]), MATRIX))
    (tmp_path / "covariance.csv").write_text(text)
    with pytest.raises(DataError, match="positions of EXX are not those"):
        load_machine(path)
