"""Faces scanned on the machine that made them: maps by pencil, and the program that follows. Heights in mm unless a name says um."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import vcmm
from vcmm import effects as fx
from vcmm.face.cli import run as command

FACES = vcmm.faces
RIM = 20.0  # mm
SQUARE = 25e-6  # rad


def spiral(profile, slide, *, both=True, noise=0.0, radius=0.0, seed=1, n=7200):
    """A scan by the rule of the module, written anew: the part p(r), the slide s(X), readings p(|X|) + s(X)."""
    x = np.linspace(RIM, -RIM if both else 0.02, n)
    c = 2 * np.pi * np.arange(n) / 72
    d = profile(np.abs(x)) + slide(x) + noise * np.random.default_rng(seed).standard_normal(n)
    return FACES.FaceScan("face", True, x, c, d, np.full(n, ""), radius=radius)


def figure(found, name):
    return next(f for f in found.figures if f.name == name)


def test_a_squareness_is_a_cone_that_the_other_side_of_the_centre_shows():
    # s = -phi X cuts p = phi r: nothing to be read on the cut side, 2 phi r on the other. Half of that is the cone.
    scan = spiral(lambda r: SQUARE * r, lambda x: -SQUARE * x)
    assert np.abs(scan.reading[scan.x > 0]).max() < 1e-12
    found = FACES.map_face(scan)
    assert figure(found, "cone").value == pytest.approx(SQUARE, rel=1e-3)
    assert figure(found, "squareness of X to the spindle").value == pytest.approx(SQUARE, rel=1e-3)
    # from the centre to the rim 25 urad x 20 mm = 0.5 um; its zero is the mean over the area, 2/3 of the rim: -0.333 and +0.167 um
    assert found.profile[-1] - found.profile[0] == pytest.approx(0.5e-3, rel=2e-3)
    assert found.at(np.array([RIM]), np.array([0.0]))[0] == pytest.approx(0.1667e-3, rel=5e-3)
    assert np.nanmax(np.abs(found.height)) < 0.335e-3  # no side of the map shows the machine


def test_one_side_alone_does_not_see_it_and_says_so():
    found = FACES.map_face(spiral(lambda r: SQUARE * r, lambda x: -SQUARE * x, both=False))
    assert abs(figure(found, "cone").value) < 1e-9
    assert found.odd is None
    assert "not seen" in found.warnings[0]


def test_a_machine_file_gives_what_one_side_does_not_see():
    machine = lathe(fx.RotaryLocation("B0C", tilt=SQUARE))
    rise = -machine.tip_error(
        vcmm.Run({"X": np.array([10.0]), "C": np.zeros(1), "Z": np.zeros(1)}, np.zeros((1, 3)))
    )[0, 2]
    slope = rise / 10.0
    found = FACES.map_face(spiral(lambda r: -slope * r, lambda x: slope * x, both=False), machine)
    assert abs(slope) == pytest.approx(SQUARE, rel=1e-6)
    assert figure(found, "cone").value == pytest.approx(-slope, rel=1e-3)


def test_an_even_error_of_the_slide_stays_in_the_part_and_is_told():
    # a dish of the slide, s = a X^2: cut as p = -a r^2, read as nothing on both sides
    a = 1e-6
    found = FACES.map_face(spiral(lambda r: -a * r**2, lambda x: a * x**2))
    assert abs(figure(found, "dish at the rim").value) < 1e-9
    assert "even error" in found.warnings[0]


def test_a_tool_beside_the_centre_is_a_cone_on_a_sphere():
    # z = -r^2 / (2 R); a tip that stands d too far out leaves z(r - d) - z(r) = r d / R - d^2 / (2 R): d = 10 um, R = 250 mm: 40 urad
    d, big = 0.010, 250.0
    made = spiral(lambda r: (r**2 - (r - d) ** 2) / (2 * big), lambda x: 0.0 * x, radius=big)
    found = FACES.map_face(made)
    assert figure(found, "cone").value == pytest.approx(40e-6, rel=1e-3)
    assert figure(found, "tool beside the centre").value == pytest.approx(d, rel=1e-3)


def test_a_tool_off_height_is_a_known_horn_at_the_centre_of_a_cone():
    # z = -r tan a; a tip h beside the plane of the axis cuts at r = sqrt(x^2 + h^2): too high by tan a (r - sqrt(r^2 - h^2)).
    # h = 0.2 mm, a = 45 deg: at r = 5 mm 5 - sqrt(24.96) = 4.0016 um, at r = 15 mm 15 - sqrt(224.96) = 1.3334 um: 2.6682 um between them.
    # Rings 0.5 mm apart blunt it by h^2 / r^3 x 0.5^2 / 8 = 10 nm at r = 5 mm, which is 0.4 %; nearer to the centre by more
    h = 0.2
    found = FACES.map_face(spiral(lambda r: r - np.sqrt(np.maximum(r**2 - h**2, 0.0)), lambda x: 0.0 * x))
    five, fifteen = found.at(np.array([5.0, 15.0]), np.zeros(2))
    assert five - fifteen == pytest.approx(2.6682e-3, rel=0.01)


def test_the_stated_uncertainty_of_the_cone_is_its_scatter():
    # 24 scans with 20 nm of white noise: the rms of z = error / u is 1 within 4 standard errors (1 / sqrt(48))
    z = []
    for seed in range(24):
        one = figure(
            FACES.map_face(
                spiral(lambda r: SQUARE * r, lambda x: -SQUARE * x, noise=2e-5, seed=seed, n=1440)
            ),
            "cone",
        )
        z.append((one.value - SQUARE) / one.u)
    assert np.sqrt(np.mean(np.square(z))) == pytest.approx(1.0, abs=4 / np.sqrt(48))


def test_a_raster_less_its_plane_and_less_the_machine():
    # a saddle of 1 um at the corners, a plane, and a slide that sags by 2 um at X = +-30, which cut and scan alike hold
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-30, 30, 61), np.linspace(-20, 20, 41)))
    saddle = 1e-3 * x * y / 600
    machine = mill(
        fx.ComponentTable("EZX", ("X",), (np.array([-50.0, 0.0, 50.0]),), np.array([0.0, 2e-3, 0.0]))
    )
    rise = -machine.tip_error(vcmm.Run({"X": x, "Y": y, "Z": 0 * x}, np.zeros((len(x), 3))))[:, 2]
    scan = FACES.FaceScan("face", False, x, y, saddle + rise + 1e-3 + 5e-5 * x, np.full(len(x), ""))
    found = FACES.map_face(scan, machine)
    at = found.at(np.array([15.0, -15.0, 15.0]), np.array([10.0, 10.0, -10.0]))
    assert at == pytest.approx([0.25e-3, -0.25e-3, -0.25e-3], rel=0.03)
    assert FACES.map_face(replace(scan)).warnings


def lathe(*effects):
    axes = {
        "X": vcmm.Axis("X", (-50.0, 50.0)), "C": vcmm.Axis("C", (-1e4, 1e4), error_frame="fixed"), "Z": vcmm.Axis("Z", (-50.0, 50.0)),
    }  # fmt: skip
    return vcmm.Machine("lathe", "lathe", vcmm.kinematics.parse_structure("w C' X' b Z t"), axes, effects)


def mill(*effects):
    axes = {a: vcmm.Axis(a, (-50.0, 50.0)) for a in "XYZ"}
    return vcmm.Machine("mill", "mill", vcmm.kinematics.parse_structure("w Y' X' b Z t"), axes, effects)


MACHINE = """vcmm = "machine/1"
name = "lathe"
kind = "lathe"
structure = "w C' b Z X t"
[axes.X]
travel = ["-50 mm", "300 mm"]
[axes.Z]
travel = ["-100 mm", "600 mm"]
[axes.C]
travel = ["-36000 deg", "36000 deg"]
error_frame = "fixed"
"""
SETUP = """vcmm = "setup/1"
machine = "lathe.toml"
dialect = "fanuc-lathe"
reference = ["250 mm", "0 mm", "550 mm"]
[offsets]
G54 = ["0 mm", "0 mm", "200 mm"]
[tools.1]
length = "60 mm"
offset_x = "40 mm"
shape = "turning"
nose_radius = "0.8 mm"
orientation = 3
[control]
tolerance = "0 um"
compensation = []
"""
PROGRAM = """%
O1 (FACE)
G21 G18 G40 G99
G28 U0 W0
G50 S3000
T0101
G97 S1000 M3
G0 X44. Z2.
Z0.
G1 X-1.6 F0.05
G0 Z2.
X44.
Z-10.
G1 X42. Z-20.
G0 X120. Z50.
M5
M30
%
"""


@pytest.fixture
def folder(tmp_path):
    scan = spiral(lambda r: SQUARE * r, lambda x: -SQUARE * x)
    rows = [
        f"{x:.6f},{np.degrees(c):.4f},{1e3 * d:.7f}" for x, c, d in zip(scan.x, scan.across, scan.reading)
    ]
    (tmp_path / "scan.csv").write_text("\n".join(["X_mm,C_deg,d_um", *rows]) + "\n", encoding="utf-8")
    (tmp_path / "scan.toml").write_text(
        'vcmm = "scan/1"\nkind = "spiral"\ndata = "scan.csv"\n', encoding="utf-8"
    )
    for name, text in (("lathe.toml", MACHINE), ("setup.toml", SETUP), ("face.nc", PROGRAM)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_from_the_command_line_a_corrected_program(folder, capsys):
    out = folder / "out"
    code = command(
        ["calibrate", "face", str(folder / "scan.toml"), "--program", str(folder / "face.nc"), "--setup", str(folder / "setup.toml"),
         "--decimals", "5", "--tolerance", "0.005 um", "--out", str(out), "--json"]
    )  # fmt: skip
    told = json.loads(capsys.readouterr().out)
    assert code == 0
    assert told["schema"] == "vcmm.face/1"
    # 5 nm of tolerance; of the last decimal (10 nm) half for rounding and half for the rounding carried from the block before
    assert told["program"]["deviation"]["after"]["max_um"] <= 0.005 + 0.005 + 0.005
    # the nose touches the face 0.8 mm outside its tip, so faces the very centre: there the part is 0.333 um too low, so the tip goes
    # 0.33 um higher; at the rim, too high by 0.167 um, it goes 0.17 um deeper
    lines = (out / "face-compensated.nc").read_text(encoding="utf-8").splitlines()
    assert any(line.startswith("Z-0.00017") for line in lines)
    centre = next(line for line in lines if line.startswith("X-1.6"))
    assert float(centre.partition("Z")[2]) == pytest.approx(0.333e-3, abs=0.011e-3)
    assert "G1 X42. Z-20." in lines  # another surface
    assert {p.name for p in out.iterdir()} == {
        "face.json",
        "face.html",
        "map.csv",
        "profile.csv",
        "face-compensated.nc",
    }


def test_lines_that_pass_over_no_face_are_refused(folder, capsys):
    code = command(
        ["calibrate", "face", str(folder / "scan.toml"), "--program", str(folder / "face.nc"), "--setup", str(folder / "setup.toml"),
         "--lines", "12-14", "--out", str(folder / "out")]
    )  # fmt: skip
    assert code == 2
    assert "no feed move in lines 12 to 14" in capsys.readouterr().err


def test_a_scan_without_its_column_names_it(folder, capsys):
    (folder / "scan.csv").write_text("X_mm,C_deg\n1,2\n", encoding="utf-8")
    assert command(["calibrate", "face", str(folder / "scan.toml")]) == 2
    assert "d_um is missing" in capsys.readouterr().err


def test_what_a_scan_does_not_use_is_refused(folder, capsys):
    (folder / "scan.csv").write_text("X_mm,C_deg,d_um,temp_air_C\n1,2,3,20\n", encoding="utf-8")
    assert command(["calibrate", "face", str(folder / "scan.toml")]) == 2
    assert "nothing uses the column temp_air_C" in capsys.readouterr().err
    (folder / "scan.toml").write_text(
        'vcmm = "scan/1"\nkind = "spiral"\nlevel = "plane"\ndata = "scan.csv"\n', encoding="utf-8"
    )
    assert command(["calibrate", "face", str(folder / "scan.toml")]) == 2
    assert "level belongs to" in capsys.readouterr().err


def test_one_squareness_is_one_uncertainty_of_all_rings():
    # one side, no noise, squareness known to 5 urad: p = -s, so the cone is known to 5 urad, the dish exactly. A profile whose zero is its mean
    # over the area, 2/3 of the rim: the rim to 5 urad x 20 mm / 3 = 33.3 nm, the centre to 66.7 nm, both of one sign each: between them 100 nm
    machine = replace(
        lathe(fx.RotaryLocation("B0C")),
        inputs=(vcmm.Input("rotary_location", "B0C", "tilt", vcmm.laws.Normal(5e-6)),),
    )
    one = FACES.map_face(spiral(lambda r: 0 * r, lambda x: 0 * x, both=False), machine)
    assert figure(one, "cone").u == pytest.approx(5e-6, rel=1e-3)
    assert figure(one, "dish at the rim").u < 1e-9
    assert one.u_profile[[0, -1]] == pytest.approx([66.7e-6, 33.3e-6], rel=5e-3)
    between = np.zeros(len(one.r))
    between[[0, -1]] = -1.0, 1.0
    assert np.sqrt(between @ one.covariance @ between) == pytest.approx(100e-6, rel=5e-3)
    # flatness of the map: two of its cells, at most the 100 nm of the whole range
    assert 50e-6 < np.nanmax(one.u) < 70e-6
    # with the other side the cone is measured, whatever the file says of the squareness
    both = FACES.map_face(spiral(lambda r: 0 * r, lambda x: 0 * x), machine)
    assert figure(both, "cone").u < 1e-9
    assert np.nanmax(both.u) < 1e-9


def test_what_moves_a_raster_together_is_one_uncertainty():
    # the slide may sag by u = 1 um at X = 0 between knees at +-50 (0 there): s = -u (1 - |x| / 50). Less its plane on x = -30 to 30: the mean
    # of |x| over whole numbers from -30 to 30 is 930 / 61 = 15.246, so (15.246 - |x|) / 50 um. Cells of 2.4 mm: that of the middle holds -1, 0, 1
    # (mean of |x| 0.667): 0.2916 um; the first -30, -29, -28: -0.2751 um. From one to the other 0.5667 um; cells taken as independent would say 0.40
    table = fx.ComponentTable("EZX", ("X",), (np.array([-50.0, 0.0, 50.0]),), np.zeros(3))
    covariance = np.zeros((3, 3))
    covariance[1, 1] = 1e-6
    one = vcmm.Input("component_table", "EZX", "values", vcmm.laws.MultivariateNormal(covariance))
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-30, 30, 61), np.linspace(-20, 20, 41)))
    wave = 1e-3 * (np.abs(x) == 30) - 1e-3 * (np.abs(x) < 1)
    found = FACES.map_face(
        FACES.FaceScan("face", False, x, y, wave, np.full(len(x), "")),
        replace(mill(table), inputs=(one,)),
    )
    middle = np.abs(found.x).argmin()
    pure = FACES.map_face(FACES.FaceScan("face", False, x, y, wave, np.full(len(x), "")), mill(table))
    known = np.sqrt(found.u**2 - pure.u**2)[5]
    assert known[[middle, 0]] == pytest.approx([0.2916e-3, 0.2751e-3], rel=1e-3)
    ends = [figure(f, "flatness of the map, peak to valley").u for f in (found, pure)]
    assert np.sqrt(ends[0] ** 2 - ends[1] ** 2) == pytest.approx(0.5667e-3, rel=1e-3)


MILL = """vcmm = "machine/1"
name = "mill"
kind = "machine-tool"
structure = "w Y' X' b Z t"
axes.X = { travel = ["-50 mm", "50 mm"] }
axes.Y = { travel = ["-50 mm", "50 mm"] }
axes.Z = { travel = ["-50 mm", "100 mm"] }
[errors]
table = "errors.csv"
state = "residual"
"""
MILL_SETUP = """vcmm = "setup/1"
machine = "mill.toml"
dialect = "fanuc"
[offsets]
G54 = ["0 mm", "0 mm", "0 mm"]
[tools.1]
length = "50 mm"
diameter = "6 mm"
[control]
tolerance = "0 um"
compensation = []
"""


def milled(lines, rise, x, y):
    """The face that a flat end mill leaves where its axis passes, mm: Z of the nearest pass, straight between its points, less how the slide rises."""
    at, cuts = np.zeros(3), []
    for line in lines:
        words = {w[0]: float(w[1:]) for w in line.split() if w[0] in "XYZ" and w[1:]}
        to = np.array([words.get(k, v) for k, v in zip("XYZ", at)])
        if line.startswith(("G1", "X", "Y", "Z")) and to[2] < 1.0 and abs(to[1] - at[1]) < 1e-9:
            cuts.append((at, to))
        at = to
    z = np.full(len(x), np.nan)
    for i, (px, py) in enumerate(zip(x, y)):
        near = [
            (a, b)
            for a, b in cuts
            if abs(a[1] - py) < 1e-6 and min(a[0], b[0]) - 1e-9 <= px <= max(a[0], b[0]) + 1e-9
        ]
        (a, b) = near[-1]
        z[i] = a[2] + (b[2] - a[2]) * (px - a[0]) / (b[0] - a[0]) if b[0] != a[0] else b[2]
    return z - rise(x)


def test_a_milled_face_is_cut_better_by_its_corrected_program(tmp_path, capsys):
    # The slide X carries the part and rises by 2 um at the middle, in straight lines from nothing at +-50: cut and scan alike follow it. Beside it the face has a saddle of 1 um at the corners that the machine does not repeat. Part before: saddle - rise.
    def rise(x):  # s: how the surface under the probe seems to rise = -(tip error along Z)
        return 2e-3 * (1 - np.abs(x) / 50)

    passes = []
    for k, y in enumerate(np.arange(-20.0, 20.1, 4.0)):
        ends = (-30.0, 30.0) if k % 2 == 0 else (30.0, -30.0)
        passes += [f"G1 Y{y:.1f} F200", *(f"X{v:.1f}" for v in np.linspace(*ends, 13))]
    program = [
        "%",
        "O2 (FACE)",
        "G21 G17 G40 G90 G94",
        "T1 M6",
        "G54 G0 X-34. Y-24. S3000 M3",
        "G43 H1 Z20.",
        "G1 Z0. F100",
        "X-30. Y-20.",
    ]
    program += [*passes, "G0 Z20.", "M5", "M30", "%"]
    (tmp_path / "face.nc").write_text("\n".join(program) + "\n")
    (tmp_path / "mill.toml").write_text(MILL)
    (tmp_path / "errors.csv").write_text("X EZX\n-50 0\n0 0.002\n50 0\n")
    (tmp_path / "setup.toml").write_text(MILL_SETUP)
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-30, 30, 61), np.arange(-20.0, 20.1, 4.0)))
    saddle = 1e-3 * x * y / 600

    def scanned(lines):
        """(part mm, readings mm): what the probe of the same machine reads of it."""
        part = milled(lines, rise, x, y) + saddle
        return part, part + rise(x)

    def written(reading):
        rows = [f"{a:.6f},{b:.6f},{1e3 * d:.7f}" for a, b, d in zip(x, y, reading)]
        (tmp_path / "scan.csv").write_text("\n".join(["X_mm,Y_mm,d_um", *rows]) + "\n")
        (tmp_path / "scan.toml").write_text(
            'vcmm = "scan/1"\nkind = "raster"\nlevel = "offset"\ndata = "scan.csv"\n'
        )

    def asked(*more):
        words = [
            "calibrate",
            "face",
            str(tmp_path / "scan.toml"),
            "--machine",
            str(tmp_path / "mill.toml"),
            *more,
            "--json",
        ]
        assert command(words) == 0
        return json.loads(capsys.readouterr().out)

    before, reading = scanned(program)
    assert np.ptp(before) == pytest.approx(
        2.0e-3, rel=0.35
    )  # the rise is 1.2 um within +-30 mm, the saddle 2 um between corners
    written(reading)
    told = asked("--program", str(tmp_path / "face.nc"), "--setup", str(tmp_path / "setup.toml"), "--decimals", "5",
                 "--tolerance", "0.05 um", "--out", str(tmp_path / "out"))  # fmt: skip
    assert told["figures"][0]["value"] > 1.5
    after, again = scanned((tmp_path / "out" / "face-compensated.nc").read_text().splitlines())
    # 671 readings make 12 x 12 cells of 5 x 3.3 mm; beyond the middle of the last one its value is held: at a corner of the face the saddle is missed by
    # 2.5 mm x 20 / 600 + 1.67 mm x 30 / 600 = 0.083 + 0.083 um, the slide by 2.5 mm x 0.04 = 0.1 um: 0.27 um, up at two corners, down at two
    assert np.ptp(after) < 0.54e-3
    assert np.std(after) < 0.27e-3 / 2
    written(again)
    assert asked()["figures"][0]["value"] < 0.54 + 0.05
