"""Tables for controls read back, and measured points corrected, by hand-worked numbers."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.compensating.mill import mill
from vcmm.cli import run as vcmm
from vcmm.compensating.tables import control_tables
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.effects.backlash import Backlash
from vcmm.effects.scale import ScaleFactor
from vcmm.effects.squareness import Squareness
from vcmm.files.machine import load_machine

MACHINE = """vcmm = "machine/1"
kind = "machine-tool"
structure = "w X' Y' b Z t"
[axes.X]
travel = ["0 mm", "400 mm"]
[axes.Y]
travel = ["0 mm", "300 mm"]
[axes.Z]
travel = ["-200 mm", "0 mm"]
"""
KNOWN = """[errors]
table = "e.csv"
state = "raw"
"""
TABLE = "X EXX EYX ECX\n0 0 0 0\n200 0.004 -0.002 0.00001\n400 0.012 0 0\n#\nZ EXZ EZZ\n-200 0.001 -0.003\n0 0 0\n#\nC0Y B0Z\n2e-05 -1e-05\n"


def machine(folder):
    (folder / "m.toml").write_text(MACHINE + KNOWN)
    (folder / "e.csv").write_text(TABLE)
    return folder / "m.toml"


def test_isg_tables_read_back_as_the_same_machine(tmp_path):
    first = load_machine(machine(tmp_path))
    found = control_tables(first, "isg", nodes=41)
    assert found.left_out == ()
    (tmp_path / "e.csv").write_text(found.files["errors.csv"])
    second = load_machine(tmp_path / "m.toml")
    rng = np.random.default_rng(1)
    at = {a: rng.uniform(*first.axes[a].travel, 200) for a in "XYZ"}
    run = Run(at, np.tile([0.0, 0.0, -80.0], (200, 1)))
    assert np.abs(first.tip_error(run)).max() > 5e-3
    assert second.tip_error(run) == pytest.approx(first.tip_error(run), abs=1e-9)


def test_linuxcnc_file_holds_the_axis_along_itself():
    # scale +100 um/m: at X 400 the axis stands at 400.04; backlash of 6 um: 3 um short forwards, 3 um beyond backwards
    it = mill(ScaleFactor("X", 100e-6), Backlash("X", 6e-3), Squareness("C0Y", 1e-5), travel=400.0)
    found = control_tables(it, "linuxcnc", nodes=3)
    assert found.files["comp_x.txt"].splitlines()[-1] == "400.000000 400.037000 400.043000"
    assert found.files["comp_y.txt"].splitlines()[0] == "-400.000000 -400.000000 -400.000000"
    assert any("squareness[C0Y]" in text for text in found.left_out)


def test_heidenhain_columns(tmp_path):
    found = control_tables(load_machine(machine(tmp_path)), "heidenhain", nodes=3)
    lines = found.files["X.com"].splitlines()
    assert lines[1] == "NR AXISPOS BACKLASH C1 C2 C3"
    assert lines[3] == "1 +200.000000 +0.000000 +0.004000 -0.002000 +0.000000"
    assert any("ECX" in text for text in found.left_out)


def test_unknown_format():
    with pytest.raises(UsageError, match="heidenhain"):
        control_tables(mill(), "siemens")


def test_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = machine(tmp_path)
    (tmp_path / "p.csv").write_text("X_mm,Y_mm,Z_mm\n200,0,0\n")
    assert vcmm(["compensate", str(path), "--points", "p.csv", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "vcmm.compensated-points/1"
    # X carries the part: EXX 4 um makes the tip 4 um short; EYX -2 um is +2 um, ECX 1e-5 x 200 mm is -2 um: 0 in Y
    assert found["corrected_mm"][0] == pytest.approx([199.996, 0.0, 0.0], abs=1e-9)
    assert (tmp_path / "p-corrected.csv").read_text().splitlines()[1].startswith("199.996000,")
    assert vcmm(["compensate", str(path), "--table", "linuxcnc", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["files"]) == 3
    assert all((tmp_path / f).is_file() for f in found["files"])
    assert vcmm(["compensate", str(path), "--table", "nonsense"]) == 2
