"""Tables for controls read back, and measured points corrected, by hand-worked numbers."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.compensation.mill import mill
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.face.cli import run as vcmm
from vcmm.files.foreign.compensation_tables import control_tables
from vcmm.files.own.machine import load_machine
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import Squareness

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
    assert found.files["comp_x.txt"].splitlines()[2] == "400.000000 400.037000 400.043000"
    assert found.files["comp_y.txt"].splitlines()[0] == "-400.000000 -400.000000 -400.000000"
    assert any("squareness[C0Y]" in text for text in found.left_out)


def test_heidenhain_columns(tmp_path):
    found = control_tables(load_machine(machine(tmp_path)), "heidenhain", nodes=3)
    lines = found.files["X.com"].splitlines()
    assert lines[1] == "NR AXISPOS BACKLASH C1 C2 C3"
    assert lines[3] == "1 +200.000000 +0.000000 +0.004000 -0.002000 +0.000000"
    assert any("ECX" in text for text in found.left_out)


class Control:
    """A control with compensation of its own, written for this test: which command reaches the drive for a position of the program."""

    def __init__(self, errors: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]):
        """Axis -> nodes, how far the tool is seen too far forwards and backwards, mm."""
        self.errors = errors

    def drive(self, axis: str, wanted: float, sense: int) -> float:
        nodes, up, down = self.errors[axis]
        return wanted - float(np.interp(wanted, nodes, up if sense > 0 else down))

    @classmethod
    def linuxcnc(cls, files: dict[str, str]) -> Control:
        """usrmotLoadComp, type 0: triplets until a line has none; forward trim = nominal - forward."""
        out = {}
        for name, text in files.items():
            rows = []
            for line in text.splitlines():
                try:
                    rows.append([float(v) for v in line.split()[:3]])
                except ValueError:
                    break
            n, up, down = np.array(rows).T
            out[name[5].upper()] = n, up - n, down - n
        return cls(out)

    @classmethod
    def own_motions(cls, columns: dict[str, tuple[np.ndarray, np.ndarray]], on_the_table: str) -> Control:
        """HEIDENHAIN, ISG: errors of each axis's own motion; a table that stands too far one way shows the tool too far the other way."""
        out = {}
        for axis, (nodes, error) in columns.items():
            seen = -error if axis in on_the_table else error
            out[axis] = nodes, seen, seen
        return cls(out)


def columns_of(form: str, files: dict[str, str]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    if form == "heidenhain":
        rows = {
            n[0]: [r.split() for r in t.splitlines()[2:-1]] for n, t in files.items() if n.endswith(".com")
        }
        return {
            a: tuple(np.array([[float(r[1]), float(r[3 + "XYZ".index(a)])] for r in v]).T)
            for a, v in rows.items()
        }  # type: ignore[misc]
    out, names = {}, []
    for line in files["errors.csv"].splitlines():
        words = line.replace("#", "").split()
        if line.startswith("//") or not words:
            continue
        if words[0][0].isalpha():
            names = words
        elif len(names[0]) == 1:
            out.setdefault(names[0], []).append(dict(zip(names, map(float, words))))
    return {a: (np.array([r[a] for r in v]), np.array([r[f"E{a}{a}"] for r in v])) for a, v in out.items()}


@pytest.mark.parametrize("form", ["linuxcnc", "heidenhain", "isg"])
def test_a_control_that_reads_its_table_cuts_where_the_program_says(form):
    """X is a table, Z carries the tool; each runs 120 um/m too far: at a drive position d the tool is seen at 1.00012 d over the part.

    15 mm commanded with the table read back must be 15 mm seen: the drive goes to 15 - 0.0018 = 14.9982, seen at 14.9982 x 1.00012 = 15.0000."""
    it = mill(ScaleFactor("X", 120e-6), ScaleFactor("Z", 120e-6), travel=300.0)
    files = control_tables(it, form, nodes=41).files
    control = (
        Control.linuxcnc(files) if form == "linuxcnc" else Control.own_motions(columns_of(form, files), "XY")
    )
    for axis in "XZ":
        for wanted in (15.0, -120.0, 255.0):
            seen = control.drive(axis, wanted, 1) * 1.00012
            assert seen == pytest.approx(
                wanted, abs=1e-5
            )  # 255 x 0.00012^2 = 3.7 nm, and the digits of the file
            assert abs(wanted * 1.00012 - wanted) > 1e-3


def test_backlash_of_a_comp_file_is_read_in_both_senses():
    """A gap of 6 um leaves the axis 3 um short forwards, 3 um beyond backwards: read back, both reach 100."""
    control = Control.linuxcnc(
        control_tables(mill(Backlash("X", 6e-3), travel=300.0), "linuxcnc", nodes=5).files
    )
    for sense in (1, -1):
        assert control.drive("X", 100.0, sense) - sense * 3e-3 == pytest.approx(100.0, abs=1e-9)


def test_a_table_says_whose_motion_it_holds():
    """Table X and tool axis Z, 120 um/m, travel 300: 36 um at the end. LinuxCNC holds the tool over the part, the others the table itself."""
    it = mill(ScaleFactor("X", 120e-6), ScaleFactor("Z", 120e-6), travel=300.0)
    comp = control_tables(it, "linuxcnc", nodes=41).files["comp_x.txt"]
    assert "; whose motion: X carries the part: what counts is the tool seen from the part" in comp
    assert (
        "commanded to X -300.000 forwards, the tool is over X -300.0360 of the part: 36.0 um less far towards +X"
        in comp
    )
    assert "Z carries the tool" in control_tables(it, "linuxcnc", nodes=41).files["comp_z.txt"]
    for form, name in (("heidenhain", "signs.txt"), ("isg", "errors.csv")):
        said = control_tables(it, form, nodes=41).files[name]
        assert "X and Y carry the part: the motion of the table" in said
        assert (
            "EXX = +0.036000 mm: the table is 36.0 um too far towards +X of the machine, so that the tool is seen 36.0 um too far towards -X"
            in said
        )
        assert "EZZ = -0.036000 mm: the axis is 36.0 um too far towards -Z of the machine\n" in said


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
