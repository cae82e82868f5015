"""Positioning runs: laser files (.rtl), ISO 230-2 tables, ecmc data files; all become the same recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.core.errors import DataError
from vcmm.files.foreign.iso230 import read_iso230
from vcmm.files.foreign.rtl import read_rtl
from vcmm.files.own.recording import load_recording
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.task.response.observe import baseline
from vcmm.task.response.recording import Recording

RTL = """HEADER::
File Type: linear
TARGET DATA::
Target-count: 3
Targets :
0.000 100.000
200.000
Flags: 0 0 2 0
USER-TEXT::
Axis: X
RUNS::
Run-count: 2
DEVIATIONS::
Run Target Data:
1 1 0.0
1 2 1.5
1 3 3.0
2 3 4.0
2 2 2.5
2 1 1.0
ENVIRONMENT::
Air temp : 20.10
Mat temp 1 : 20.0
Mat temp 2 : 20.5
EOF::
"""
MACHINE = """vcmm = "machine/1"
structure = "w X' b Y Z t"
[axes.X]
travel = ["-10 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
"""
LINE = '[line]\nat = { Y = "250 mm", Z = "-100 mm" }\noffset = "0 0 -80 mm"\n'
KEYS = 'vcmm = "recording/1"\nmachine = "machine.toml"\nkind = "displacement"\n'


def load(folder: Path, data: str, text: str) -> Recording:
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(KEYS + f'data = "{data}"\n' + text)
    return load_recording(folder / "recording.toml")[0]


def rtl(folder: Path, text: str = RTL) -> Path:
    path = folder / "x.rtl"
    path.write_text(text, newline="\r\n")
    return path


def test_runs_of_a_laser_file(tmp_path):
    runs = read_rtl(rtl(tmp_path))
    assert runs.target.tolist() == [0, 100, 200, 200, 100, 0]
    assert runs.deviation == pytest.approx([0.0, 1.5e-3, 3e-3, 4e-3, 2.5e-3, 1e-3])
    assert runs.direction.tolist() == [1, 1, 1, -1, -1, -1]
    assert runs.run.tolist() == ["1", "1", "1", "2", "2", "2"]
    assert runs.axis == "X"
    assert runs.columns["temp_air_C"].tolist() == [20.1] * 6
    assert runs.columns["temp_material_C"].tolist() == [20.25] * 6


def test_a_laser_file_as_a_recording(tmp_path):
    """Deviations are actual - target; indicated - true is the opposite. The table X' goes the commanded way, seen by the tool."""
    rtl(tmp_path)
    rec = load(tmp_path, "x.rtl", LINE)
    assert rec.measuring
    assert rec.kind == "displacement"
    assert rec.value == pytest.approx([0.0, -1.5e-3, -3e-3, -4e-3, -2.5e-3, -1e-3])
    assert rec.direction.tolist() == [[1.0, 0.0, 0.0]] * 6
    assert rec.run.column("sense_X").tolist() == [1, 1, 1, -1, -1, -1]
    assert rec.run.column("since_reversal_X_mm").tolist() == [0, 100, 200, 0, 100, 200]
    assert rec.run.q("Y").tolist() == [250.0] * 6
    assert rec.run.offset.tolist() == [[0.0, 0.0, -80.0]] * 6
    assert rec.run.labels["run"].tolist() == ["1", "1", "1", "2", "2", "2"]
    machining = load(tmp_path, "x.rtl", 'observed = "actual - commanded"\n' + LINE)
    assert machining.value == pytest.approx(-rec.value)


def test_scale_and_backlash_explain_the_laser_file(tmp_path):
    """Deviation 15 um/m q and, coming back, 1 um more: scale +15 um/m, gap 1 um (ISO 230-2: B = -1 um), zero 0.5 um."""
    rtl(tmp_path)
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "recording.toml").write_text(KEYS + 'data = "x.rtl"\n' + LINE)
    rec, machine = load_recording(tmp_path / "recording.toml")
    predicted = baseline(rec, machine.with_effect(ScaleFactor("X", 15e-6), Backlash("X", 1e-3)))
    assert rec.value - predicted == pytest.approx([-0.5e-3] * 6)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("File Type: linear", "File Type: angular", 1, 'File Type "angular" cannot be read'),
        ("HEADER::", "", 2, "begins with HEADER::"),
        ("RUNS::", "RANS::", 11, 'the section "RANS" is not known'),
        ("TARGET DATA::", "HEADER::", 3, 'the section "HEADER" is twice'),
        ("DEVIATIONS::\n", "", 1, "DEVIATIONS:: is missing"),
        ("Target-count: 3", "Target-count: 4", 5, "3 targets, where Target-count says 4"),
        ("100.000", "100,000", 6, "holds no finite numbers"),
        ("1 3 3.0", "1 4 3.0", 17, "target 4 does not exist; there are 3"),
        ("1 3 3.0", "1 3", 17, "is not a row of run, target, deviation"),
        ("1 3 3.0", "1 3 x", 17, "holds no finite numbers"),
        ("Run-count: 2", "Run-count: 3", 13, "2 runs, where Run-count says 3"),
        ("Air temp : 20.10", "Air temp : warm", 22, "holds no finite numbers"),
    ],
)
def test_mistakes_in_a_laser_file(tmp_path, old, new, line, words):
    assert old in RTL
    with pytest.raises(DataError) as caught:
        read_rtl(rtl(tmp_path, RTL.replace(old, new)))
    assert words in str(caught.value)
    if words[0] not in "23":
        assert f"x.rtl:{line}: " in str(caught.value)


def test_the_constructed_sample(tmp_path):
    """Two bidirectional runs of six targets; mean of the first target, both ways: (0.064 - 0.846 + 0 - 0.818) / 4 um."""
    runs = read_rtl(data_file("data/formats/constructed/renishaw_linear.rtl"))
    assert len(runs.target) == 24
    assert runs.deviation[runs.target == 0].mean() == pytest.approx(-0.4e-3)
    assert runs.direction[:6].tolist() == [1.0] * 6
    assert runs.direction[6:12].tolist() == [-1.0] * 6
    assert runs.axis == "X"
    assert sorted(runs.columns) == ["humidity_pct", "pressure_hPa", "temp_air_C", "temp_material_C"]
    up, down = (runs.deviation[(runs.direction == d) & (runs.target == 500)].mean() for d in (1, -1))
    assert up - down == pytest.approx((3.602 + 3.719 - 2.749 - 2.810) / 2 * 1e-3)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("", "where the other axes stood is missing"),
        ('[line]\nat = { Y = "250 mm" }\n', 'add at = { Z = "0 mm" }'),
        ('[line]\nat = { Y = "250", Z = "0 mm" }\n', "has no unit"),
        ('[line]\naxis = "Y"\nat = { X = "0 mm", Y = "1 mm", Z = "0 mm" }\n', 'at names axis "Y"'),
        ('[line]\naxis = "A"\nat = {}\n', 'write kind = "angle"'),
        (LINE.replace("-100", "-900"), "axis Z = -900 mm is outside its travel"),
    ],
)
def test_mistakes_in_the_line(tmp_path, line, words):
    rtl(tmp_path)
    with pytest.raises(DataError) as caught:
        load(tmp_path, "x.rtl", line)
    assert words in str(caught.value)


TABLE = "target_mm,run,direction,deviation_um,temp_air_C\n0,1,up,0,20\n100,1,up,2,20\n100,1,down,-1,20\n0,1,down,-3,21\n"


def test_a_table_of_runs(tmp_path):
    (tmp_path / "runs.csv").write_text(TABLE)
    rec = load(
        tmp_path, "runs.csv", 'format = "iso230"\n[line]\naxis = "X"\n' + LINE.removeprefix("[line]\n")
    )
    assert rec.value == pytest.approx([0.0, -2e-3, 1e-3, 3e-3])
    assert rec.run.column("sense_X").tolist() == [1, 1, -1, -1]
    assert rec.run.column("temp_air_C").tolist() == [20, 20, 20, 21]
    with pytest.raises(DataError, match=r'does not name its axis; add \[line\] with axis = "X"'):
        load(tmp_path, "runs.csv", 'format = "iso230"\n' + LINE)


def test_actual_positions_and_arc_seconds(tmp_path):
    (tmp_path / "a.csv").write_text("target_mm;actual_mm;run;direction\n100;100.002;1;+\n100;99.999;1;-\n")
    assert read_iso230(tmp_path / "a.csv").deviation == pytest.approx([2e-3, -1e-3])
    (tmp_path / "c.csv").write_text("target_deg,deviation_arcsec,run,direction\n90,2,1,forward\n")
    runs = read_iso230(tmp_path / "c.csv")
    assert runs.rotary
    assert runs.target == pytest.approx([np.pi / 2])
    assert runs.deviation == pytest.approx([2 * 4.848136811e-6])


def test_a_rotary_axis_gives_angles(tmp_path):
    """The table C turns 10 urad too far, seen by the tool: actual - target = +10 urad about z."""
    axes = MACHINE.replace("X' b", "C' X' b") + '[axes.C]\ntravel = ["-1 deg", "360 deg"]\n'
    (tmp_path / "machine.toml").write_text(axes)
    (tmp_path / "c.csv").write_text("target_deg,deviation_urad,run,direction\n0,0,1,up\n90,10,1,up\n")
    (tmp_path / "r.toml").write_text(
        KEYS.replace("displacement", "angle")
        + 'data = "c.csv"\nformat = "iso230"\nobserved = "actual - commanded"\n'
        + '[line]\naxis = "C"\nat = { X = "0 mm", Y = "0 mm", Z = "0 mm" }\n'
    )
    rec, machine = load_recording(tmp_path / "r.toml")
    assert rec.value == pytest.approx([0.0, 1e-5])
    assert rec.direction == pytest.approx(np.array([[0.0, 0.0, 1.0]] * 2))
    found = baseline(rec, machine.with_effect(Backlash("C", -2e-5)))
    assert found == pytest.approx([1e-5, 1e-5])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "deviation_um",
            "deviation",
            'unknown column "deviation" of positioning runs. Did you mean "deviation_um"',
        ),
        ("deviation_um", "deviation_urad", "deviation_urad does not fit the unit of the targets"),
        ("up,2", "upp,2", 'runs.csv:3: direction "upp" is not understood'),
        ("100,1,up,2", "100,1,up,two", 'runs.csv:3: "two"'),
        ("run,", "cycle,", "the column run is missing"),
        ("temp_air_C", "actual_mm", "deviation_um and actual_mm are both there"),
    ],
)
def test_mistakes_in_a_table_of_runs(tmp_path, old, new, words):
    (tmp_path / "runs.csv").write_text(TABLE.replace(old, new))
    with pytest.raises(DataError) as caught:
        read_iso230(tmp_path / "runs.csv")
    assert words in str(caught.value)


ECMC = """UNIT=mm
# two targets, one cycle
TGT_DATA[1]=10
REF_DATA_FWD[1,1]=10.001
TGT_DATA[2]=20
REF_DATA_FWD[2,1]=20.002
REF_DATA_BWD[1,1]=9.999
REF_DATA_BWD[2,1]=19.998
"""


def test_assignments_of_a_test_script(tmp_path):
    path = tmp_path / "axis.dat"
    path.write_text(ECMC)
    runs = read_iso230(path)
    assert runs.target.tolist() == [10, 20, 20, 10]
    assert runs.direction.tolist() == [1, 1, -1, -1]
    assert runs.deviation == pytest.approx([1e-3, 2e-3, -2e-3, -1e-3])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("UNIT=mm", "UNIT=um", 'UNIT = "um" is not known'),
        ("=10.001", "=ten", 'axis.dat:4: "ten" is no finite number'),
        ("TGT_DATA[2]=20\n", "", "TGT_DATA[2] is missing"),
        ("# two", "two", "axis.dat:2: not understood"),
        ("REF_DATA_FWD[2,1]", "REF_DATA_UP[2,1]", "axis.dat:6: not understood"),
    ],
)
def test_mistakes_in_a_test_script(tmp_path, old, new, words):
    path = tmp_path / "axis.dat"
    path.write_text(ECMC.replace(old, new))
    with pytest.raises(DataError) as caught:
        read_iso230(path)
    assert words in str(caught.value)


def test_a_real_axis_whose_reversal_depends_on_the_place():
    """Its notes give the reversal (forward - backward) of five targets, about -33, +12, +10, -12, -43 um, first run left out."""
    runs = read_iso230(data_file("data/recordings/iso230_2_linear_axis/mcu1025_ISO230.dat"))
    assert len(runs.target) == 50
    kept = runs.run != "1"
    found = [
        np.subtract(
            *(runs.deviation[kept & (runs.target == t) & (runs.direction == d)].mean() for d in (1, -1))
        )
        for t in np.unique(runs.target)
    ]
    assert np.array(found) * 1e3 == pytest.approx([-33, 12, 10, -12, -43], abs=3)


def test_an_empty_axis_is_not_the_same_as_none(tmp_path):
    (tmp_path / "runs.csv").write_text(TABLE)
    with pytest.raises(DataError, match=r"axis is empty; write the letter of the axis"):
        load(tmp_path, "runs.csv", 'format = "iso230"\n[line]\naxis = ""\n' + LINE.removeprefix("[line]\n"))
