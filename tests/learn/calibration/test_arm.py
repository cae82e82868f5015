"""Arms from poses: a planar arm by pencil, drawn six-axis arms against least squares that share nothing with the package."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tools.arm_least_squares import ARM, Poses, draw, drawn_parameters, fit, lines_of, placed, rms_left, write
from vcmm.core.errors import DataError, UsageError
from vcmm.face.cli import run
from vcmm.face.cli.calibrate_arm import remarks
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_data import load_poses
from vcmm.learn.calibration.arm import _Problem, fit_arm
from vcmm.learn.calibration.arm_geometry import link_numbers
from vcmm.learn.calibration.arm_terms import load_patterns
from vcmm.learn.calibration.pose_tests import put_to_poses
from vcmm.task.response.volumetric import field

NAMES = ["C1", "B2", "B3", "A4", "B5", "A6"]
PLANAR = """vcmm = "machine/1"
name = "planar arm"
kind = "machine-tool"
structure = "w b C1 C2 t"
[axes.C1]
travel = ["-180 deg", "180 deg"]
[axes.C2]
travel = ["-180 deg", "180 deg"]
centre = "300 0 0 mm"
"""
RECORDING = 'vcmm = "recording/1"\nmachine = "arm.toml"\nkind = "pose"\ndata = "{}.csv"\n'


def _recording(folder: Path, name: str, more: str = "") -> Path:
    file = folder / f"{name}.toml"
    file.write_text(RECORDING.format(name) + more)
    return file


@pytest.fixture
def planar(tmp_path: Path) -> Path:
    """Two links, by pencil: the first is 300.2 mm long where 300 are stated; joint 2 is 2 mrad off its zero; the target sits 200 mm out.

    x = 300.2 cos q1 + 200 cos(q1 + q2 + 0.002), y with sines, z = 0; the tracker's axes are those of the arm.
    """
    (tmp_path / "arm.toml").write_text(PLANAR)
    q1, q2 = (
        a.ravel()
        for a in np.meshgrid(np.radians([-120.0, -50, 10, 70, 130]), np.radians([-100.0, -40, 30, 80]))
    )
    end = q1 + q2 + 2e-3
    x, y = 300.2 * np.cos(q1) + 200 * np.cos(end), 300.2 * np.sin(q1) + 200 * np.sin(end)
    rows = [
        f"{a:.12f},{b:.12f},{c:.9f},{d:.9f},0" for a, b, c, d in zip(np.degrees(q1), np.degrees(q2), x, y)
    ]
    (tmp_path / "poses.csv").write_text("\n".join(["C1_deg,C2_deg,x_mm,y_mm,z_mm", *rows]) + "\n")
    return tmp_path


def test_a_planar_arm_by_pencil(planar: Path):
    machine = load_machine(planar / "arm.toml")
    found = fit_arm([load_poses(_recording(planar, "poses"), machine)], machine)
    length = next(n for n in link_numbers(found.machine, machine) if n.quantity == "link length a")
    assert length.value == pytest.approx(300.2, abs=1e-5)
    # the offset of the last joint is where the target sits: 200 mm at 2 mrad from the stated centre, 0.4 mm to the side, and no number of the arm
    assert "C0C2" in {r.name for r in found.redundant}
    assert found.placements[0].offset[:2] - [300.0, 0.0] == pytest.approx(
        [200 * np.cos(2e-3), 200 * np.sin(2e-3)], abs=1e-4
    )
    assert found.rms[0] < 1e-6


def _two_links(folder: Path, name: str, seed: int) -> Path:
    """30 poses of two links of 400.25 and 300 mm with 10 um of noise: x = 400.25 cos q1 + 300 cos(q1 + q2), y with sines; the target lies 700 mm from
    where the axes meet the origin.
    """
    rng = np.random.default_rng(seed)
    q1, q2 = np.radians(rng.uniform(-90, 90, 30)), np.radians(rng.uniform(-120, 120, 30))
    seen = np.stack(
        [
            400.25 * np.cos(q1) + 300 * np.cos(q1 + q2),
            400.25 * np.sin(q1) + 300 * np.sin(q1 + q2),
            np.zeros(30),
        ],
        axis=1,
    ) + rng.normal(0.0, 0.01, (30, 3))
    rows = np.column_stack([np.degrees(q1), np.degrees(q2), seen])
    np.savetxt(
        folder / f"{name}.csv",
        rows,
        "%.9f",
        delimiter=",",
        header="C1_deg,C2_deg,x_mm,y_mm,z_mm",
        comments="",
    )
    return _recording(folder, name)


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_other_poses_of_a_planar_arm_find_tracker_and_target(tmp_path: Path, seed: int):
    (tmp_path / "arm.toml").write_text(PLANAR.replace("300 0 0", "400 0 0"))
    machine = load_machine(tmp_path / "arm.toml")
    found = fit_arm([load_poses(_two_links(tmp_path, "poses", 1), machine)], machine)
    others = load_poses(_two_links(tmp_path, "others", seed), machine)
    test = put_to_poses(others, machine, found.machine, found.placements[0])
    # 0.25 mm of 400: less than 0.25 / sqrt(3) = 0.14 mm per coordinate are left of the nominal arm, about the noise of 10 um of the calibrated one
    assert 0.05 < test.before < 0.14
    assert test.after < 0.012
    assert test.in_place is not None
    assert test.after <= test.in_place  # found anew is the least that any place leaves
    assert test.after_turn is None


@pytest.mark.parametrize(
    ("columns", "lacking"), [("r11 r12 r13 r21 r22 r23 r31 r32", "r33"), ("qw qx qy qzz", "qz")]
)
def test_orientations_that_lack_a_column_are_not_dropped(planar: Path, columns: str, lacking: str):
    names = ["C1_deg", "C2_deg", "x_mm", "y_mm", "z_mm", *columns.split()]
    (planar / "poses.csv").write_text(
        "\n".join([",".join(names), *[",".join("1" for _ in names)] * 3]) + "\n"
    )
    with pytest.raises(DataError, match=f"there is no column {lacking}"):
        load_poses(_recording(planar, "poses"), load_machine(planar / "arm.toml"))


def test_a_column_that_nothing_uses_is_refused_unless_it_is_ignored_by_name(planar: Path):
    """rx ry rz may be orientations under other names: they must not be dropped in silence."""
    machine = load_machine(planar / "arm.toml")
    rows = "\n0,0,500,0,0,1,2,3\n0,10,400,9,0,1,2,3\n"
    (planar / "poses.csv").write_text("C1_deg,C2_deg,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg" + rows)
    with pytest.raises(
        DataError, match=r"poses.csv:1: nothing uses the columns rx_deg ry_deg rz_deg; name orientations"
    ):
        load_poses(_recording(planar, "poses"), machine)
    words = '[poses]\nignore = ["rx_deg", "ry_deg", "rz_deg"]\n'
    assert load_poses(_recording(planar, "poses", words), machine).orientation is None
    with pytest.raises(DataError, match="ignore names rx, which is no column"):
        load_poses(_recording(planar, "poses", words.replace("rz_deg", "rx")[:-2] + ', "rz_deg"]\n'), machine)


def test_a_joint_outside_its_travel_is_told_as_what_a_recording_may_hold(planar: Path):
    (planar / "poses.csv").write_text("C1_deg,C2_deg,x_mm,y_mm,z_mm\n0,0,500,0,0\n0,190,100,0,0\n")
    with pytest.raises(
        DataError, match=r"poses.csv:3.*axis C2 = 190 deg is outside .*check the order, the unit and"
    ) as told:
        load_poses(_recording(planar, "poses"), load_machine(planar / "arm.toml"))
    assert "move the part" not in str(told.value)


@pytest.mark.thorough
def test_few_poses_that_fit_too_well_are_told(tmp_path: Path):
    """Six poses of six joints have 36 coordinates for more than 30 numbers: they fit to a tenth of the noise, and predict one another badly."""
    _drawn(tmp_path, 0, 1)
    machine = load_machine(tmp_path / "arm.toml")
    poses = load_poses(_recording(tmp_path, "fit", '[noise]\nlaw = "normal"\nu = "20 um"\n'), machine)
    assert not any("too few or too alike" in r for r in remarks(fit_arm([poses], machine)))
    assert any("too few or too alike" in r for r in remarks(fit_arm([poses.take(range(6))], machine)))


def test_a_level_joint_carries_its_link_and_the_forearm(tmp_path: Path):
    (tmp_path / "arm.toml").write_text(ARM)
    # C1 stands upright, B2 and B3 lie level and parallel; A4 turns B5 out of the level
    assert load_patterns(load_machine(tmp_path / "arm.toml")) == [
        ("B2", "B2"),
        ("B2", "B2 B3"),
        ("B3", "B2 B3"),
    ]


def _drawn(folder: Path, seed: int, others: int) -> tuple[Poses, Poses]:
    (folder / "arm.toml").write_text(ARM)
    lines, rng = lines_of(folder / "arm.toml"), np.random.default_rng(seed)
    x = drawn_parameters(rng)
    out = draw(x, lines, 40, rng), draw(x, lines, others, rng)
    for name, poses in zip(("fit", "others"), out):
        write(folder / f"{name}.csv", poses, NAMES)
    return out


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [11, 12])
def test_3600_poses_are_predicted_as_by_plain_least_squares(tmp_path: Path, seed: int):
    here, there = _drawn(tmp_path, seed, 3600)
    machine = load_machine(tmp_path / "arm.toml")
    found = fit_arm([load_poses(_recording(tmp_path, "fit"), machine)], machine)
    test = put_to_poses(
        load_poses(_recording(tmp_path, "others"), machine), machine, found.machine, found.placements[0]
    )
    lines = lines_of(tmp_path / "arm.toml")
    start = placed(here, lines, np.array([970.0, 30.0, 1160.0]))
    x = fit(here, lines, True, start, np.array([970.0, 30.0, 1160.0]), np.array([0.02, 5e-5]))
    best = rms_left(x, there, lines, True, start) * 1e-3
    assert test.in_place is not None
    assert test.in_place < 1.05 * best
    assert {t.name for t in found.terms if t.size == 2} >= {"elastic_joint[B2,B2]", "elastic_joint[B3,B2 B3]"}


@pytest.mark.thorough
def test_the_command_writes_a_file_that_predicts(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    _drawn(tmp_path, 5, 60)
    noise = '[noise]\nlaw = "normal"\nu = "20 um"\n'
    here, there = _recording(tmp_path, "fit", noise), _recording(tmp_path, "others", noise)
    out = tmp_path / "found.toml"
    assert (
        run(
            [
                "calibrate",
                "fit",
                str(here),
                "--machine",
                str(tmp_path / "arm.toml"),
                "--out",
                str(out),
                "--test",
                str(there),
                "--json",
            ]
        )
        == 0
    )
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "vcmm.arm/1"
    assert found["tests"][0]["rms_after_um"] < 24.0  # 20 um of noise, and what 40 poses leave open
    names = {(one["joint"], one["quantity"]) for one in found["links"]}
    assert {
        ("B2", "joint offset"),
        ("B2", "link length a"),
        ("B2", "twist beta"),
        ("A4", "link offset d"),
    } <= names
    assert {one["name"] for one in found["redundant"]} >= {"C0C1", "A0A6"}
    # such errors are of no first order, and the map says by what it was computed
    assert field(load_machine(out), load_poses(there, load_machine(tmp_path / "arm.toml")).run).exact
    # compare reads the file back and predicts the same poses with tracker and target placed anew
    assert run(["compare", str(there), "--machine", str(out), "--json"]) == 0
    compared = json.loads(capsys.readouterr().out)["machines"][-1]
    assert compared["rms_um"] == pytest.approx(found["tests"][0]["rms_after_um"], rel=0.02)


def test_files_of_others_are_read(tmp_path: Path):
    # two files, one heading for joints, none for the tracker; a quaternion of 90 deg about z is (cos 45, 0, 0, sin 45)
    (tmp_path / "arm.toml").write_text(ARM)
    (tmp_path / "poses.csv").write_text("q1,q2,q3,q4,q5,q6\n10,20,30,40,50,60\n0,0,0,0,0,0\n5,5,5,5,5,5\n")
    (tmp_path / "tracker.csv").write_text(
        "1.5,0,0.25,0.70710678,0,0,0.70710678\n1,1,1,1,0,0,0\n2,2,2,0,0,0,1\n"
    )
    more = (
        '[poses]\nmeasured = "tracker.csv"\njoints = ["q1", "q2", "q3", "q4", "q5", "q6"]\nposition = ["1", "2", "3"]\nlength = "m"\n'
        'orientation = ["4", "5", "6", "7"]\norientation_as = "quaternion wxyz"\n'
    )
    poses = load_poses(_recording(tmp_path, "poses", more), load_machine(tmp_path / "arm.toml"))
    assert poses.position[0] == pytest.approx([1500.0, 0.0, 250.0])
    assert poses.run.q("B3")[0] == pytest.approx(np.pi / 6)
    assert poses.orientation is not None
    assert poses.orientation[0] == pytest.approx(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), abs=1e-7)
    # euler xyz turns about fixed x, y, z in that order: 90 about x, then 90 about z takes y to z to z
    (tmp_path / "tracker.csv").write_text("x,y,z,rx,ry,rz\n0,0,0,90,0,90\n1,1,1,0,0,0\n2,2,2,0,0,0\n")
    more = (
        more.split("position")[0]
        + 'position = ["x", "y", "z"]\norientation = ["rx", "ry", "rz"]\norientation_as = "euler xyz"\n'
    )
    turned = load_poses(_recording(tmp_path, "poses", more), load_machine(tmp_path / "arm.toml")).orientation
    assert turned is not None
    assert turned[0] @ [0, 1, 0] == pytest.approx([0, 0, 1], abs=1e-12)
    assert turned[0] @ [1, 0, 0] == pytest.approx([0, 1, 0], abs=1e-12)


def test_joints_in_another_order_are_no_arm_that_errs(tmp_path: Path):
    _drawn(tmp_path, 3, 3)
    text = (tmp_path / "fit.csv").read_text().replace("C1_deg,B2_deg,B3_deg", "C1_deg,B3_deg,B2_deg", 1)
    (tmp_path / "fit.csv").write_text(text)
    machine = load_machine(tmp_path / "arm.toml")
    with pytest.raises(
        UsageError, match=r"misses the positions by .* check the order and the unit of the joint columns"
    ):
        fit_arm([load_poses(_recording(tmp_path, "fit"), machine)], machine)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ('[poses]\nposition = ["a", "b", "c"]\n', "there is no column a b c"),
        ('[poses]\norientation = ["x_mm", "y_mm", "z_mm"]\n', "orientation_as does not say what they are"),
        ('[nuisance]\nrigid = ""\n', "poses take none"),
        ('[poses]\njoints = ["C1_deg"]\n', "the arm has 6 joints"),
    ],
)
def test_words_that_poses_do_not_take(tmp_path: Path, more: str, told: str):
    _drawn(tmp_path, 3, 3)
    with pytest.raises((DataError, UsageError), match=told):
        load_poses(_recording(tmp_path, "fit", more), load_machine(tmp_path / "arm.toml"))


def test_a_machine_with_linear_axes_is_no_arm(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    _drawn(tmp_path, 3, 3)
    mill = 'vcmm = "machine/1"\nname = "mill"\nkind = "machine-tool"\nstructure = "w X\' b Z t"\n[axes.X]\ntravel = ["0 mm", "1 mm"]\n[axes.Z]\ntravel = ["0 mm", "1 mm"]\n'
    (tmp_path / "mill.toml").write_text(mill)
    file = _recording(tmp_path, "fit")
    assert run(["calibrate", "fit", str(file), "--machine", str(tmp_path / "mill.toml")]) == 2
    assert "a chain of joints that carry the tool" in capsys.readouterr().err
    assert run(["calibrate", "fit", str(file), "--structure", "w b C1 B2 t"]) == 2
    assert "poses need the nominal arm" in capsys.readouterr().err


def test_positions_of_poses_are_a_recording_of_displacements(planar: Path):
    # the stated arm is 0.2 mm short in its first link; whatever tracker and target do, something of that is left
    recording, _ = load_recording(_recording(planar, "poses"))
    assert recording.kind == "displacement"
    assert dict(recording.nuisance) == {"rigid": "", "tool": ""}
    assert 0.0 < float(np.abs(recording.value).max()) < 1.0


def test_two_recordings_have_a_place_of_the_tracker_each(planar: Path):
    """The arm of the fixture, twelve of its poses again by a tracker whose zero lies 100 mm, -50 mm, 20 mm from the first one's: read that much less."""
    head, *rows = (planar / "poses.csv").read_text().splitlines()
    q1, q2, *seen = np.array([[float(v) for v in row.split(",")] for row in rows[3:15]]).T
    np.savetxt(
        planar / "moved.csv",
        np.column_stack([q1, q2, np.array(seen).T - [100.0, -50.0, 20.0]]),
        "%.12f",
        delimiter=",",
        header=head,
        comments="",
    )
    machine = load_machine(planar / "arm.toml")
    both = [load_poses(_recording(planar, name), machine) for name in ("poses", "moved")]
    found = fit_arm(both, machine)
    length = next(n for n in link_numbers(found.machine, machine) if n.quantity == "link length a")
    assert length.value == pytest.approx(300.2, abs=1e-5)
    assert max(found.rms) < 1e-6
    apart = found.placements[0].shift - found.placements[1].shift
    assert apart == pytest.approx([100.0, -50.0, 20.0], abs=1e-4)
    # rows of one recording say nothing of the tracker of the other: 20 and 12 poses are 60 and 36 rows, 9 columns of placing each
    free = _Problem(both, machine, []).columns(found.placements, (1.0, 1.0))[0]
    each = [_Problem([r], machine, []).columns([p], (1.0, 1.0))[0] for r, p in zip(both, found.placements)]
    assert [block.shape for block in each] == [(60, 9), (36, 9)]
    assert np.array_equal(free, np.block([[each[0], np.zeros((60, 9))], [np.zeros((36, 9)), each[1]]]))
