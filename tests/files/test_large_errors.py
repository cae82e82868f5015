"""An error table in micrometres is refused; a machine that really errs by millimetres says so and is calculated exactly."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.run import Run
from vcmm.files.own.machine import load_machine

MACHINE = """vcmm = "machine/1"
structure = "w b X Y Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[errors]
table = "errors.csv"
"""


def write(folder, values: str, more: str = ""):
    (folder / "errors.csv").write_text(f"// drawn\nX EXX ECX\n0 0 0\n600 {values}\n")
    path = folder / "machine.toml"
    path.write_text(MACHINE.replace("[axes.X]", more + "[axes.X]", 1))
    return path


def test_six_millimetres_of_exx_are_refused_with_the_line_of_the_table(tmp_path):
    with pytest.raises(DataError) as caught:
        load_machine(write(tmp_path, "6.0 0.000002"))
    assert "errors.csv:2: EXX reaches 6 mm. Error tables are in mm" in str(caught.value)
    assert "large_errors = true" in str(caught.value)


def test_one_millimetre_is_the_limit(tmp_path):
    load_machine(write(tmp_path, "1.0 0"))
    with pytest.raises(DataError):
        load_machine(write(tmp_path, "1.001 0"))


def test_stated_large_errors_go_through_the_exact_engine(tmp_path):
    # 2 mrad about Z at X = 600, arm of the tool 100 mm in x: exact x = 100 (cos 0.002 - 1) = -0.2 um, y = 100 sin 0.002
    machine = load_machine(write(tmp_path, "6.0 0.002", "large_errors = true\n"))
    run = Run({"X": np.array([600.0]), "Y": np.zeros(1), "Z": np.zeros(1)}, np.array([[100.0, 0.0, 0.0]]))
    error = machine.tip_error(run)[0]
    assert error == pytest.approx([6.0 + 100 * (np.cos(0.002) - 1), 100 * np.sin(0.002), 0.0], abs=1e-12)
    assert machine.tip_error(run, exact=True)[0] == pytest.approx(error, abs=0)


def test_an_effect_of_six_millimetres_is_refused_too(tmp_path):
    path = write(tmp_path, "0 0")
    path.write_text(path.read_text() + '[[effects]]\neffect = "scale_factor"\naxis = "Y"\nk = "12000 um/m"\n')
    run = Run({"X": np.zeros(1), "Y": np.array([500.0]), "Z": np.zeros(1)}, np.zeros((1, 3)))
    with pytest.raises(ModelLimit, match="a translation of 6 mm of link Y exceeds 1 mm"):
        load_machine(path).tip_error(run)


def test_rotations_in_microradians_are_refused_with_their_line(tmp_path):
    with pytest.raises(DataError, match=r"errors.csv:2: ECX reaches 4 rad"):
        load_machine(write(tmp_path, "0 4.0"))


def test_large_errors_of_both_kinds_need_the_exact_engine(tmp_path):
    machine = load_machine(write(tmp_path, "1.2 0.002"))
    run = Run({"X": np.array([600.0]), "Y": np.zeros(1), "Z": np.zeros(1)}, np.zeros((1, 3)))
    with pytest.raises(ModelLimit, match=r"1\.2 mm of link X exceeds 1 mm.*--exact"):
        machine.tip_error(run)
    assert machine.tip_error(run, exact=True)[0, 0] == pytest.approx(1.2, abs=1e-12)
