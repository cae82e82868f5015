"""Recording files: every column and unit, mistakes with their line, logs, history, other formats, round trip."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests import build
from tests.conftest import data_file
from tests.recordings.convert import plug_plate
from vcmm.core.errors import DataError
from vcmm.core.laws import Normal, StudentT
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.response.observe import Observer, baseline, nuisance_columns
from vcmm.task.response.recording import Recording

MACHINE = """vcmm = "machine/1"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[repeatability]
law = "t"
scale = "0.7 um"
dof = 6
"""
HEAD = 'vcmm = "recording/1"\ndata = "data.csv"\nmachine = "machine.toml"\n'


def write(folder: Path, text: str, data: str, **files: str) -> Path:
    """A recording file with its data, the machine and further files (name_csv -> name.csv)."""
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "data.csv").write_text(data, encoding="utf-8")
    for name, content in files.items():
        (folder / name.replace("_csv", ".csv")).write_text(content)
    path = folder / "recording.toml"
    path.write_text(HEAD + text, encoding="utf-8")
    return path


def read(folder: Path, text: str, data: str, **files: str) -> Recording:
    return load_recording(write(folder, text, data, **files))[0]


def refused(folder: Path, text: str, data: str, **files: str) -> str:
    with pytest.raises(DataError) as caught:
        read(folder, text, data, **files)
    return str(caught.value)


PROBE = 'kind = "probe"\n'
TOUCHES = """X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um,pose,probe_angle_deg,offset_z_mm
10,20,-30,1,0,0,1.5,0.5,a,90,-50
11,20,-30,0,0.6,0.8,-2,0.5,b,180,-50
"""


# the contract's columns ---------------------------------------------------------------------------------------------


def test_touches_along_their_normals(tmp_path):
    rec = read(tmp_path, PROBE + '[nuisance]\nrigid = "pose"\n[noise]\nu = "0.8 um"\n', TOUCHES)
    assert rec.name == "recording"
    assert rec.measuring
    assert rec.value.tolist() == [1.5e-3, -2e-3]
    assert rec.u is not None
    assert rec.u.tolist() == [0.5e-3, 0.5e-3]
    assert rec.row.tolist() == [0, 1]
    assert rec.other.tolist() == [-1, -1]
    assert rec.direction.tolist() == [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]]
    assert rec.run.column("probe_angle_rad") == pytest.approx([np.pi / 2, np.pi])
    assert rec.run.offset[:, 2].tolist() == [-50.0, -50.0]
    assert rec.run.column("probe_lateral") == pytest.approx([1.0, 0.6])  # across a stylus that hangs down
    assert rec.run.labels["pose"].tolist() == ["a", "b"]
    assert rec.nuisance == {"rigid": "pose"}
    assert rec.noise == Normal(0.8e-3)
    assert not {"d_um", "u_um"} & set(rec.run.columns)


def test_the_angle_of_touch_follows_from_the_normals_of_an_upright_stylus(tmp_path):
    data = "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,offset_x_mm,offset_z_mm\n10,20,-30,0,1,0,1,0,-50\n11,20,-30,0.6,0,0.8,2,0,-50\n"
    assert read(tmp_path, PROBE, data).run.column("probe_angle_rad") == pytest.approx([np.pi / 2, 0.0])
    aside = data.replace("1,0,-50", "1,30,-50")  # a star stylus: its seats cannot be known
    assert "probe_angle_rad" in read(tmp_path, PROBE, aside).missing
    unknown = "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n10,20,-30,0,1,0,1\n"
    assert "probe_angle_rad" in read(tmp_path, PROBE, unknown).missing


def test_a_normal_noise_may_say_scale(tmp_path):
    assert read(tmp_path, PROBE + '[noise]\nscale = "0.3 um"\n', TOUCHES).noise == Normal(0.3e-3)
    assert "does not belong" in refused(
        tmp_path, PROBE + '[noise]\nu = "0.3 um"\nscale = "0.3 um"\n', TOUCHES
    )


def test_x_y_z_of_a_point_are_three_observations(tmp_path):
    data = "X_mm,Y_mm,Z_mm,dx_um,dy_um,dz_um,u_dz_um,u_um\n1,2,-3,10,20,30,2,1\n4,5,-6,40,50,60,2,1\n"
    rec = read(tmp_path, PROBE, data)
    assert rec.value == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
    assert rec.row.tolist() == [0, 0, 0, 1, 1, 1]
    assert rec.direction[3:].tolist() == np.eye(3).tolist()
    assert rec.u == pytest.approx([1e-3, 1e-3, 2e-3] * 2)
    plane = read(tmp_path, PROBE, "X_mm,Y_mm,Z_mm,dx_um,dy_um\n1,2,-3,10,20\n")
    assert plane.direction.tolist() == np.eye(3)[:2].tolist()


def test_an_angle_in_urad(tmp_path):
    data = "X_mm,Y_mm,Z_mm,nx,ny,nz,d_urad,u_d_urad\n0,0,0,0,1,0,3,0.5\n"
    rec = read(tmp_path, 'kind = "angle"\n[noise]\nlaw = "t"\nscale = "0.1 arcsec"\ndof = 5\n', data)
    assert rec.value.tolist() == [3e-6]
    assert rec.u is not None
    assert rec.u.tolist() == [0.5e-6]
    assert isinstance(rec.noise, StudentT)
    assert rec.noise.scale == pytest.approx(0.1 * np.pi / 648000)


@pytest.mark.parametrize(
    ("text", "measuring"),
    [
        ('kind = "path"\n', False),
        ('kind = "displacement"\n', True),
        ('kind = "path"\nobserved = "indicated - true"\n', True),
        ('kind = "probe"\nobserved = "actual - commanded"\n', False),
    ],
)
def test_the_sense_and_its_default(tmp_path, text, measuring):
    assert read(tmp_path, text, TOUCHES).measuring is measuring


def test_the_second_end_of_a_length_is_a_row_of_its_own(tmp_path):
    """Tip 50 mm below the ram: the first tip is at (400, 100, -150), the second at (100, 100, -150)."""
    data = (
        "X_mm,Y_mm,Z_mm,offset_z_mm,from_x_mm,from_y_mm,from_z_mm,d_um,temp_part_C\n"
        "400,100,-100,-50,100,100,-150,2,21\n"
    )
    rec, machine = load_recording(write(tmp_path, 'kind = "length"\n', data))
    assert rec.run.n == 2
    assert rec.row.tolist() == [0]
    assert rec.other.tolist() == [1]
    assert rec.direction.tolist() == [[1.0, 0.0, 0.0]]
    assert [float(rec.run.q(a)[1]) for a in "XYZ"] == pytest.approx([100.0, 100.0, -100.0])
    assert rec.run.column("length_mm").tolist() == [300.0, 300.0]
    assert rec.run.column("temp_part_C").tolist() == [21.0, 21.0]
    long = machine.with_effect(ScaleFactor("X", 1e-5))
    assert baseline(rec, long) == pytest.approx([-3e-3])  # 10 um/m over 300 mm, machine travels too far


def test_a_fixed_station_has_no_row(tmp_path):
    data = "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,d_um\n300,400,0,0,0,0,2\n"
    rec = read(tmp_path, 'kind = "length"\n[nuisance]\nstation = ""\n', data)
    assert rec.run.n == 1
    assert rec.other.tolist() == [-1]
    assert rec.direction == pytest.approx(np.array([[0.6, 0.8, 0.0]]))
    bar = read(tmp_path, 'kind = "length"\n', "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n300,400,0,0.6,0.8,0,2\n")
    assert bar.direction.tolist() == [[0.6, 0.8, 0.0]]


def test_the_machine_can_be_given(tmp_path):
    path = write(tmp_path, PROBE, TOUCHES)
    (tmp_path / "machine.toml").write_text("nothing of this is read")
    given = build.machine()
    assert load_recording(path, given)[1] is given
    path.write_text('vcmm = "recording/1"\ndata = "data.csv"\nkind = "probe"\n')
    assert load_recording(path, given)[0].m == 2


def test_what_the_file_does_not_hold_is_named(tmp_path):
    rec = read(tmp_path, PROBE, TOUCHES)
    assert {
        "time_s",
        "sense_X",
        "since_reversal_Y_mm",
        "temp_scale_x_C",
        "temp_gradient_C",
        "stylus",
        "raw_Z_mm",
    } <= set(rec.missing)
    assert not {"nx", "probe_angle_rad", "pose", "sense_A", "speed_C_mm_s", "d_um", "part_x_mm"} & set(
        rec.missing
    )


def test_a_label_that_the_data_lack_means_all_rows(tmp_path):
    rec, machine = load_recording(write(tmp_path, PROBE + '[nuisance]\noffset = "stylus"\n', TOUCHES))
    assert "stylus" in rec.missing
    assert nuisance_columns(rec, machine)[1] == ("offset.shift_x", "offset.shift_y", "offset.shift_z")


def test_placements_per_a_column_that_is_not_there_are_refused(tmp_path):
    data = TOUCHES.replace("pose", "part")
    said = refused(tmp_path, PROBE + '[nuisance]\nrigid = "pose"\n', data)
    assert "recording.toml:" in said
    assert 'no column "pose"' in said
    assert "label columns are part" in said


# mistakes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "line", "words"),
    [
        ("X_mm,Y_mm,Z_mm,nx,ny,nz\n1,2,-3,1,0,0\n", 1, "there is no observation; add the column d_um"),
        ("X_mm,Y_mm,Z_mm,d_um\n1,2,-3,1\n", 1, "d_um needs its direction nx ny nz"),
        ("X_mm,Y_mm,Z_mm,nx,ny,d_um\n1,2,-3,1,0,1\n", 1, "nx ny nz go together; nz is missing"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n1,2,-3,1,1,0,1\n", 2, "has the length 1.414"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n1,2,-3,0,0,0,1\n", 2, "has the length 0"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_urad\n1,2,-3,1,0,0,1\n", 1, 'd_urad does not go with kind = "probe"'),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,dx_um\n1,2,-3,1,0,0,1,1\n", 1, "keep one of them"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um\n1,2,-3,1,0,0,1,1\n1,2,-3,1,0,0,1,0\n", 3, "u_um must be above zero"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n1,2,-3,1,0,0,\n", 2, '"" in column d_um is not a number'),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n1,2,-3,1,0,0,nan\n", 2, "not finite"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,spindle_rpm\n" + "1,2,-3,1,0,0,1,nan\n" * 9 + "1,2,-3,1,0,0,1,20\n", 1, "in 9 of 10 rows: repair the column"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,sense_Y\n1,2,-3,1,0,0,1,-1\n1,2,-3,1,0,0,1,2\n", 3, "sense_Y = 2; the direction"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,sense_Y\n1,2,-3,1,0,0,1,0.5\n1,2,-3,1,0,0,1,0\n", 2, "sense_Y = 0.5; the direction"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,temp_prat_K\n1,2,-3,1,0,0,1,20\n", 1, 'unknown column "temp_prat_K"'),
        ("X_mm,Y_mm,nx,ny,nz,d_um\n1,2,1,0,0,1\n", 1, "the column Z_mm is missing"),
        ("X_mm,Y_mm,Z_mm,C_deg,nx,ny,nz,d_um\n1,2,-3,9,1,0,0,1\n", 2, "the machine has no axis C"),
        ("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n1,2,-3,1,0,0,1\n1,2,3,1,0,0,1\n", 3, "axis Z = 3 mm is outside its travel"),
        ("X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,nx,ny,nz,d_um\n1,2,-3,0,0,0,1,0,0,1\n", 1, "is the second end of a length"),
    ],
)  # fmt: skip
def test_mistakes_in_the_data(tmp_path, data, line, words):
    message = refused(tmp_path, PROBE, data)
    assert f"data.csv:{line}: " in message
    assert words in message


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ('kind = "prob"\n', 4, 'Did you mean "probe"'),
        (PROBE + 'observed = "true - indicated"\n', 5, "Allowed: "),
        (PROBE + '[nuisance]\nrigit = "pose"\n', 6, 'Did you mean "rigid"'),
        (PROBE + '[nuisance]\nrigid = "poze"\n', 6, 'Did you mean "pose"'),
        (PROBE + '[noise]\nlaw = "t"\nscale = "0.7"\ndof = 6\n', 7, "has no unit"),
        (PROBE + '[noise]\nlaw = "t"\nscale = "0.7 um"\n', 5, "needs dof"),
        (PROBE + '[noise]\nu = "0.7 um"\ndof = 6\n', 7, "dof does not belong"),
        (PROBE + '[noise]\nu = "0 um"\n', 6, "must be above zero"),
        (PROBE + '[nuisance]\ndead_path = ""\n', 5, "dead_path needs dead_path_mm"),
        (PROBE + '[line]\naxis = "X"\n', 5, "goes with format"),
        (PROBE + 'history = "path"\n', 5, "no column time_s"),
        (PROBE + "colour = 3\n", 5, 'unknown key "colour"'),
    ],
)
def test_mistakes_in_the_file(tmp_path, text, line, words):
    message = refused(tmp_path, text, TOUCHES)
    assert f"recording.toml:{line}: " in message
    assert words in message


def test_all_problems_at_once(tmp_path):
    path = write(
        tmp_path, 'kind = "probe"\n[nuisance]\nrigit = "pose"\n', "X_mm,Y_m,Z_mm,nx,ny,nz\n1,2,x,1,0,0\n"
    )
    (tmp_path / "machine.toml").write_text(MACHINE.replace("600 mm", "600"))
    with pytest.raises(DataError) as caught:
        load_recording(path)
    text = str(caught.value)
    for word in ("rigit", "Y_m", '"x" in column Z_mm', "there is no observation", "machine.toml:4"):
        assert word in text


def test_a_machine_is_due(tmp_path):
    path = write(tmp_path, PROBE, TOUCHES)
    path.write_text('vcmm = "recording/1"\ndata = "data.csv"\nkind = "probe"\n')
    with pytest.raises(DataError, match='the key "machine" is missing'):
        load_recording(path)
    path.write_text('vcmm = "recording/2"\ndata = "data.csv"\nkind = "probe"\n')
    with pytest.raises(DataError, match="written by a newer vcmm"):
        load_recording(path)


def test_the_second_end_outside_the_travel(tmp_path):
    data = "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,d_um\n40,10,-10,900,100,-150,2\n"
    message = refused(tmp_path, 'kind = "length"\n', data)
    assert "data.csv:2: axis X = 900 mm" in message
    assert 'for a fixed station write [nuisance] station = ""' in message
    same = "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,d_um\n40,10,-10,40,10,-10,2\n"
    assert "both ends of the length are one place" in refused(tmp_path, 'kind = "length"\n', same)


# logs and history ---------------------------------------------------------------------------------------------------

TIMED = "time_s,X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n0,10,0,0,1,0,0,1\n30,20,0,0,1,0,0,1\n60,15,0,0,1,0,0,1\n"
SERIES = PROBE + '[[series]]\ndata = "log.csv"\n'


def test_logs_are_joined_by_time(tmp_path):
    """20 degC rising by 1 K in 40 s: 20.75 at 30 s; steady before the first entry."""
    log = "time_s,temp_air_C,pressure_hPa\n0,20,1000\n40,21,1004\n80,21,1004\n"
    rec = read(tmp_path, SERIES, TIMED, log_csv=log)
    assert rec.run.column("temp_air_C") == pytest.approx([20.0, 20.75, 21.0])
    assert rec.run.column("pressure_hPa") == pytest.approx([1000.0, 1003.0, 1004.0])
    assert rec.run.series["air"].time.tolist() == [0.0, 40.0, 80.0]
    assert rec.run.lag("air", 10.0)[0] == 20.0


def test_temperatures_of_the_rows_are_a_log_too(tmp_path):
    """1 K per 30 s behind a lag of 30 s: 1 - (1 - exp(-1)) = 0.368 K behind after 30 s."""
    data = (
        TIMED.replace("d_um", "d_um,temp_bed_C").replace(",1\n30", ",1,20\n30").replace(",1\n60", ",1,21\n60")
    )
    data = data.removesuffix("\n") + ",22\n"
    rec = read(tmp_path, PROBE, data)
    assert rec.run.lag("bed", 30.0)[1] == pytest.approx(21.0 - (1 - np.exp(-1)))


@pytest.mark.parametrize(
    ("log", "words"),
    [
        ("time_s,temp_air_C\n0,20\n10,21\n", "the log of temp_air_C ends at 10 s, the data at 60 s"),
        ("time_s,temp_air_C\n10,20\n0,21\n", "log.csv:3: time_s goes back"),
        ("temp_air_C\n20\n", "a log needs the column time_s"),
        ("time_s,temp_air\n0,20\n", 'Did you mean "temp_air_C"'),
        ("time_s,temp_air_C\n0,warm\n", 'log.csv:2: "warm"'),
    ],
)
def test_mistakes_in_logs(tmp_path, log, words):
    assert words in refused(tmp_path, SERIES, TIMED, log_csv=log)


def test_logs_need_the_time_of_the_rows(tmp_path):
    assert "have no column time_s" in refused(
        tmp_path, SERIES, TOUCHES, log_csv="time_s,temp_air_C\n0,20\n1,20\n"
    )


def test_history_is_claimed_only_where_rows_follow_one_another(tmp_path):
    """Touches are reached by ways that the rows do not show; a path and the targets of a laser follow one another."""
    probe = read(tmp_path, PROBE, TIMED)
    assert "sense_X" in probe.missing
    assert probe.run.column("travel_X_mm").tolist() == [0.0, 10.0, 15.0]
    path = read(tmp_path, 'kind = "path"\n', TIMED)
    assert path.run.column("sense_X").tolist() == [0.0, 1.0, -1.0]
    assert path.run.column("since_reversal_X_mm").tolist() == [0.0, 10.0, 5.0]
    assert read(tmp_path, 'kind = "displacement"\n', TIMED).run.column("sense_X").tolist() == [1.0, 1.0, -1.0]
    said = read(tmp_path, PROBE + 'history = "rows"\n', TIMED)
    assert said.run.column("sense_X").tolist() == [0.0, 1.0, -1.0]
    dense = read(tmp_path, 'kind = "path"\nhistory = "path"\n', TIMED)
    assert dense.run.column("speed_X_mm_s") == pytest.approx([1 / 3, 1 / 12, -1 / 6])
    none = read(tmp_path, 'kind = "path"\nhistory = "none"\n', TIMED)
    assert "travel_X_mm" not in none.run.columns


def test_a_given_sense_is_kept(tmp_path):
    data = TIMED.replace("d_um", "d_um,sense_X").replace(",1\n30", ",1,-1\n30").replace(",1\n60", ",1,-1\n60")
    rec = read(tmp_path, 'kind = "path"\n', data.removesuffix("\n") + ",-1\n")
    assert rec.run.column("sense_X").tolist() == [-1.0, -1.0, -1.0]


def test_rows_out_of_order(tmp_path):
    back = TIMED.replace("\n60,", "\n20,")
    assert "time_s goes back at row 3" in refused(tmp_path, PROBE, back)
    assert read(tmp_path, PROBE + 'history = "none"\n', back).m == 3


def test_readings_are_the_recorded_temperatures(tmp_path):
    rec = read(tmp_path, PROBE, TOUCHES.replace("offset_z_mm", "temp_scale_x_C"))
    assert rec.run.column("reading_scale_x_C").tolist() == [-50.0, -50.0]


# round trip ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "data"),
    [
        (PROBE + '[nuisance]\nrigid = "pose"\nzero = ""\n[noise]\nlaw = "t"\nscale = "0.7 um"\ndof = 6\n', TOUCHES),
        ('kind = "path"\n[noise]\nu = "0.3 um"\n', "X_mm,Y_mm,Z_mm,dx_um,dy_um,dz_um,u_um\n1,2,-3,1,2,3,1\n4,2,-3,1,2,3,1\n"),
        ('kind = "path"\n', "X_mm,Y_mm,Z_mm,dx_um,dy_um\n1,2,-3,1,2\n4,2,-3,1,2\n"),
        ('kind = "angle"\n', "X_mm,Y_mm,Z_mm,nx,ny,nz,d_urad,u_d_urad,feature\n0,0,0,0,1,0,3,0.5,\"a, b\"\n"),
        ('kind = "length"\n', "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,d_um\n40,10,-10,90,100,-150,2\n50,10,-10,90,100,-150,2\n"),
        ('kind = "length"\n[nuisance]\nstation = "instrument"\n', "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,d_um\n40,10,-10,-90,100,-150,2\n"),
        (SERIES, TIMED),
    ],
)  # fmt: skip
def test_round_trip(tmp_path, text, data):
    path = write(tmp_path, text, data, log_csv="time_s,temp_air_C,pressure_hPa\n0,20,1000\n60,21,1004\n")
    first, machine = load_recording(path)
    save_recording(first, tmp_path / "again" / "copy.toml", machine="../machine.toml")
    again, _ = load_recording(tmp_path / "again" / "copy.toml")
    assert (again.kind, again.measuring, again.nuisance, again.noise) == (
        first.kind,
        first.measuring,
        first.nuisance,
        first.noise,
    )
    assert again.value == pytest.approx(first.value, rel=1e-12)
    assert again.direction == pytest.approx(first.direction, rel=1e-12)
    assert again.row.shape == first.row.shape
    assert (again.u is None) == (first.u is None)
    assert baseline(again, machine.with_effect(ScaleFactor("X", 1e-5))) == pytest.approx(
        baseline(first, machine.with_effect(ScaleFactor("X", 1e-5)))
    )
    assert again.run.n == first.run.n
    for name, values in first.run.columns.items():
        assert again.run.column(name) == pytest.approx(values, rel=1e-12), name
    for label, words in first.run.labels.items():
        assert again.run.labels[label].tolist() == words.tolist()
    assert set(again.run.series) == set(first.run.series)


# point tables and traces --------------------------------------------------------------------------------------------

POINTS = 'kind = "probe"\nformat = "points"\n[pose]\nshift = "100 100 -100 mm"\nturn = "0 0 90 deg"\n'


def test_points_with_normals_are_known_along_them(tmp_path):
    """Nominal (10, 0, 0), normal +x, measured 10.002: +2 um. The part is turned by 90 deg about z: normal +y there."""
    data = "feature;x;y;z;i;j;k;mx;my;mz\nbore;10;0;0;1;0;0;10.002;0.5;0\n"
    rec = read(tmp_path, POINTS + '[stylus]\noffset = "0 0 -50 mm"\ntip_diameter = "4 mm"\n', data)
    assert rec.value == pytest.approx([2e-3])
    assert rec.direction == pytest.approx(np.array([[0.0, 1.0, 0.0]]))
    assert [float(rec.run.q(a)[0]) for a in "XYZ"] == pytest.approx(
        [100.0, 112.0, -50.0]
    )  # 100 + 10 + radius 2
    assert rec.run.part_point == pytest.approx(np.array([[0.0, 10.0, 0.0]]))
    assert rec.run.labels["feature"].tolist() == ["bore"]


def test_centres_of_holes_are_known_in_x_and_y(tmp_path):
    """dx of the part is along +y of the machine, dy along -x."""
    data = "Nom X,Nom Y,Meas X [mm],Meas Y [mm]\n10,20,10.001,20.002\n"
    rec = read(tmp_path, POINTS.replace("probe", "path"), data)
    assert rec.value == pytest.approx([1e-3, 2e-3])
    assert rec.direction == pytest.approx(np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]))
    assert not rec.measuring
    deviations = read(tmp_path, POINTS, "x,y,z,err_x,err_y,err_z\n10,20,0,0.001,0.002,0\n")
    assert deviations.value == pytest.approx([1e-3, 2e-3, 0.0])


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("x,y,z\n1,2,3\n", "there are no measured columns"),
        ("x,y,mx,my,mz\n1,2,1,2,3\n", "its nominal column z is missing"),
        ("x,y,z,i,j,mx,my,mz\n1,2,3,1,0,1,2,3\n", "found i j"),
        ("x,y,z,i,j,k,mx,my,mz\n1,2,3,1,1,1,1,2,3\n", "data.csv:2: i j k has the length 1.732"),
        (
            "x,y,z,mx,my,mz,dx\n1,2,3,1,2,3,0.01\n",
            "data.csv:2: deviation x = 0.01, but measured - nominal is 0",
        ),
        ("x,nom_x,y,z,mx,my,mz\n1,1,2,3,1,2,3\n", '"nom_x" means x, which is there already'),
        ("x,y,z,mx,my,mz,shape\n1,2,3,1,2,3,0\n", 'unknown column "shape"'),
        (
            "Plate\n\n  Meas X   Meas Y   Nom X   Nom Y\n 1.0 2.0 1.0 2.0\n 1.0 2.0 1.0\n",
            "data.csv:5: 3 cells where line 3 names 4",
        ),
        ("x,y,z,mx,my,mz\n900,2,3,900,2,-\n", '"-" in column mz'),
        ("x,y,z,mx,my,mz\n10,900,0,10,900,0\n", "data.csv:2: axis X = -800 mm"),
    ],
)
def test_mistakes_in_point_tables(tmp_path, data, words):
    assert words in refused(tmp_path, POINTS, data)


SCOPE = 'kind = "path"\nformat = "scope"\n[line]\nat = { Y = "100 mm", Z = "-10 mm" }\n'


def test_a_trace(tmp_path):
    """2 mm/s; the axis lags by 0.02 mm: actual - commanded = -20 um while it moves."""
    data = "time_ms,X_commanded_mm,X_actual_um\n500,10,10000\n1000,11,10980\n1500,12,11980\n2000,11,11020\n"
    rec = read(
        tmp_path,
        SCOPE + '[scope]\ntime = "time_ms"\naxes = { X = ["X_commanded_mm", "X_actual_um"] }\n',
        data,
    )
    assert rec.value == pytest.approx([0.0, -0.02, -0.02, 0.02])
    assert not rec.measuring
    assert rec.direction.tolist() == [[1.0, 0.0, 0.0]] * 4
    assert rec.run.column("time_s") == pytest.approx([0.0, 0.5, 1.0, 1.5])
    assert rec.run.column("speed_X_mm_s")[1] == pytest.approx(2.0)
    assert rec.run.column("sense_X").tolist() == [0.0, 1.0, 1.0, -1.0]
    assert rec.run.q("Y").tolist() == [100.0] * 4
    assert rec.run.column("sense_Y").tolist() == [0.0] * 4


def test_two_axes_of_a_trace(tmp_path):
    data = "time_s,X_commanded_mm,X_actual_mm,Y_commanded_mm,Y_actual_mm\n0,1,1.1,5,5\n1,2,2,6,6.2\n"
    rec = read(tmp_path, SCOPE.replace('Y = "100 mm", ', ""), data)
    assert rec.value == pytest.approx([0.1, 0.0, 0.0, 0.2])
    assert rec.row.tolist() == [0, 0, 1, 1]
    assert rec.direction[:2].tolist() == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


@pytest.mark.parametrize(
    ("text", "data", "words"),
    [
        (SCOPE, "time_s,a\n0,1\n", "no axis found"),
        (SCOPE + '[scope]\naxes = { X = ["a"] }\n', "time_s,a\n0,1\n", "X takes two columns"),
        (SCOPE + '[scope]\naxes = { X = ["a", "c"] }\nunit = "mm"\n', "time_s,a,b\n0,1,2\n", 'no column "c"'),
        (SCOPE + '[scope]\naxes = { X = ["a", "b"] }\n', "time_s,a,b\n0,1,2\n", 'the unit of "a" is not stated'),
        (SCOPE, "time_s,X_commanded_mm,X_actual_mm\n0,1,1\n0,1,1\n", "data.csv:3: the time does not increase"),
        (SCOPE, "time_s,X_commanded_mm,X_actual_mm\n0,1,1\n1,1\n", "data.csv:3: expected 3 finite numbers"),
        (SCOPE.replace("path", "probe"), "time_s,X_commanded_mm,X_actual_mm\n0,1,1\n", 'write kind = "path"'),
        (SCOPE.replace('Y = "100 mm", ', ""), "time_s,X_commanded_mm,X_actual_mm\n0,1,1\n", 'at = { Y = "0 mm" }'),
        (SCOPE.replace("Y =", "X ="), "time_s,X_commanded_mm,X_actual_mm\n0,1,1\n", 'at names axis "X"'),
        (SCOPE, "a,b\nc,d\n", "there is no row of numbers"),
    ],
)  # fmt: skip
def test_mistakes_in_traces(tmp_path, text, data, words):
    assert words in refused(tmp_path, text, data)


def test_a_rotary_trace_as_a_controller_exports_it(tmp_path):
    """Rows of remarks above the numbers, semicolons, time in steps of 100 ns; the two branches differ at the same angle
    because of a read-out delay: the difference counter - resolver follows the speed.
    """
    source = data_file("data/recordings/resolver_cyclic_latency/VoltageDividerSineCosCoils.csv")
    axes = MACHINE.replace("X Z t", "X Z C t") + '[axes.C]\ntravel = ["-10 deg", "370 deg"]\n'
    (tmp_path / "machine.toml").write_text(axes)
    (tmp_path / "r.toml").write_text(
        'vcmm = "recording/1"\nmachine = "machine.toml"\nkind = "angle"\nformat = "scope"\n'
        f'data = "{source}"\nobserved = "actual - commanded"\n'
        '[line]\nat = { X = "0 mm", Y = "0 mm", Z = "0 mm" }\n[scope]\ntime = "Name"\ntime_unit = "filetime"\nunit = "deg"\n'
        'axes = { C = ["fActPosition (Internal Counter)", "fActPosition (Resolver)"] }\n'
    )
    rec, _ = load_recording(tmp_path / "r.toml")
    assert rec.m == 3005
    assert rec.run.column("time_s")[1] == pytest.approx(0.01)
    speed = rec.run.column("speed_C_rad_s")
    assert np.degrees(np.abs(speed).max()) == pytest.approx(36.0, rel=0.05)
    turns = np.column_stack(
        [np.cos(k * rec.run.q("C")) for k in range(5)] + [np.sin(k * rec.run.q("C")) for k in range(1, 5)]
    )
    found = np.linalg.lstsq(np.column_stack([speed, turns]), rec.value, rcond=None)[0]
    assert found[0] == pytest.approx(-0.034, abs=0.004)  # the delay, s, that the notes to the data report


def test_a_drilled_plate_tells_scale_and_squareness(tmp_path):
    """650 holes; the notes to the data: rms of the 2-D residual 10.78 um after shift and turn, 5.23 um after the scales
    of X and Y and squareness, with a mean scale of -34.6 um/m and 64 urad.
    """
    source = data_file("data/recordings/sdss_plugplate_cmm/D1597A_redrilled_meas_2011.txt")
    rows = [line.split()[:4] for line in source.read_text().splitlines()[4:] if line.strip()]
    data = "Meas X,Meas Y,Nom X,Nom Y\n" + "".join(",".join(r) + "\n" for r in rows)
    path = write(tmp_path, POINTS.replace("probe", "path") + '[nuisance]\nrigid = ""\n', data)
    path.write_text(
        path.read_text().replace("100 100 -100 mm", "0 0 0 mm").replace("0 0 90 deg", "0 0 0 deg")
    )
    rec, machine = load_recording(path, build.machine())
    rigid, names = nuisance_columns(rec, machine)
    assert names == ("rigid.shift_x", "rigid.shift_y", "rigid.turn_z")
    eye = Observer(rec, machine)
    physics = [(ScaleFactor("X"), "k"), (ScaleFactor("Y"), "k"), (Squareness("C0Y"), "angle")]
    everything = np.column_stack([rigid, *(eye.of_parameter(e, p) for e, p in physics)])

    def fit(columns: np.ndarray) -> tuple[float, np.ndarray]:
        x = np.linalg.lstsq(columns, rec.value, rcond=None)[0]
        rest = (rec.value - columns @ x).reshape(-1, 2)
        return float(np.sqrt((rest**2).sum(axis=1).mean()) * 1e3), x

    assert rec.m == 1300
    assert fit(rigid)[0] == pytest.approx(10.78, abs=0.01)
    rms, found = fit(everything)
    assert rms == pytest.approx(5.23, abs=0.01)
    assert found[3:5].mean() == pytest.approx(-34.6e-6, abs=1e-6)
    assert abs(found[5]) == pytest.approx(64.2e-6, abs=1.5e-6)


def test_a_direction_that_no_column_of_the_run_holds_is_written(tmp_path):
    first = read(tmp_path, PROBE, TOUCHES)
    columns = {name: values for name, values in first.run.columns.items() if name not in ("nx", "ny", "nz")}
    bare = replace(first, run=replace(first.run, columns=columns))
    save_recording(bare, tmp_path / "again" / "copy.toml", machine="../machine.toml")
    again, _ = load_recording(tmp_path / "again" / "copy.toml")
    assert again.direction == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]]))


def test_a_printed_list_of_a_measuring_machine(tmp_path):
    # head, names two blanks apart, a deviation that is measured - nominal once more, diameters and roundness of the holes
    data = (
        "Plug Plate: 1597A\r\nDate: 2003-10-17\r\n\r\n"
        "    Meas X    Meas Y     Nom X     Nom Y     Err X     Err Y  Meas D   Nom D   Round\r\n"
        "   -73.126    21.717   -73.140    21.705     0.014     0.012   2.174   2.167   0.007\r\n"
        "    31.288    24.188    31.279    24.187     0.009     0.001   2.171   2.167   0.018\r\n"
    )
    found = read(tmp_path, POINTS, data)
    assert found.value * 1e3 == pytest.approx([14.0, 12.0, 9.0, 1.0])
    assert found.run.n == 2


def test_a_published_plate_is_read_as_it_was_converted(tmp_path):
    source = data_file("data/recordings/sdss_plugplate_cmm/D1597A_orig_meas_2003.txt")
    known, _ = load_recording(plug_plate(source, tmp_path / "known"))
    (tmp_path / "plate.txt").write_bytes(source.read_bytes())
    (tmp_path / "recording.toml").write_text(
        'vcmm = "recording/1"\ndata = "plate.txt"\nmachine = "known/machine.toml"\nkind = "path"\nformat = "points"\n'
        'history = "none"\n[nuisance]\nrigid = ""\n'
    )
    found, _ = load_recording(tmp_path / "recording.toml")
    assert found.m == known.m == 1300
    assert np.abs(found.value - known.value).max() < 6e-5  # the converter writes 0.1 um
    assert found.run.q("X") == pytest.approx(known.run.q("X"))
