"""Virtual machining end to end: what a known machine error does to a known part, and what bad input is told.

The surface over all features: how densely, and what errors do to it.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import VcmmError
from vcmm.face.cli import run as command
from vcmm.shop.machining import job as cutting
from vcmm.shop.machining.job import cut, finished_part, surface_map
from vcmm.shop.machining.preparation import set_up

SQUARENESS = '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "20 urad"\n'


def height(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Departure of the surface (n,) mm and angle of each point (n,)."""
    (patch,) = surface_map(set_up(vcmm.load_cut(path)))
    points = patch.net.points
    return patch.height, np.arctan2(points[:, 1], points[:, 0])


def test_a_perfect_machine_cuts_the_nominal_part(tmp_path):
    found, _ = height(shop.write(tmp_path))
    assert np.abs(found).max() < 1e-9


def test_squareness_makes_an_ellipse_of_a_circle(tmp_path):
    found, angle = height(shop.write(tmp_path, SQUARENESS))
    # C0Y = +c shifts the tip by (-c y, 0, 0); the centre of the cutter runs on 60 mm, the work zero was set on the machine:
    # along n = (cos, sin) the surface moves by -c 60 sin cos = -20e-6 x 60 / 2 sin 2a, 0.6 um either way
    # (to first order; the second, e^2 over the radii, is 0.07 nm)
    assert found == pytest.approx(-0.6e-3 * np.sin(2 * angle), abs=1e-7)


def test_size_form_and_budget(tmp_path):
    inputs = '[[inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "5 urad"\n'
    scenario = shop.SCENARIO.replace("[part.features]", '[cut.tools.1]\nu_radius = "3 um"\n[part.features]')
    found = cut(vcmm.load_cut(shop.write(tmp_path, SQUARENESS + inputs, scenario)))
    size, form = found.characteristics
    assert size.value == pytest.approx(100.0, abs=1e-6)
    assert size.u == pytest.approx(
        6e-3, rel=1e-6
    )  # twice the radius of the cutter; squareness leaves the size alone
    assert form.value == pytest.approx(
        1.2e-3, abs=0.02e-3
    )  # 24 angles do not all hit the extremes of the ellipse
    assert found.shares["diameter"]["tool"] == pytest.approx(1.0, abs=1e-6)
    assert found.shares["form"]["machine"] == pytest.approx(1.0, abs=1e-3)
    # one number: `value` is the deviation that the tables state, and lies where the trials lie; known errors stand in the bias
    assert form.value == pytest.approx(form.mean, abs=1e-12)
    assert form.interval[0] < form.value < form.interval[1]
    assert form.bias == pytest.approx(1.2e-3, abs=0.02e-3)
    assert size.coverage_shown
    assert size.decision.text == "conforms"
    # 2 lines of 30 and 20 mm, a circle of 2 pi 60 mm and lines of 20 and 30 mm at 600 mm/min: 47.7 s, and the rapids
    assert 47.7 < found.seconds < 60


def test_probing_on_the_same_machine_does_not_see_its_errors(tmp_path):
    plan = """\
[inspection]
machine = "same"
[plan]
styli.probe = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
[[plan.steps]]
feature = "boss"
stylus = "probe"
points = { strategy = "levels", at = ["2 mm", "4 mm"], n = 8 }
[job]
"""
    inputs = '[[inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "5 urad"\n'
    scenario = shop.SCENARIO.replace("[job]\n", plan)
    found = cut(vcmm.load_cut(shop.write(tmp_path, SQUARENESS + inputs, scenario)))
    form = found.own_reading.characteristics[1]
    # cut at 60 mm, probed at 51 mm from the middle: of the 1.2 um only 9/60 is seen, 0.18 um
    assert form.value == pytest.approx(1.2e-3 * 9 / 60, rel=0.05)
    assert form.u < 0.1e-3
    # interval and decision are about the part: 8 angles meet the extremes of sin 2a, 1.2 um, and 5 urad x 60 mm = 0.3 um
    # in each of two directions that add up to the ellipse
    form = found.characteristics[1]
    assert form.value == pytest.approx(1.2e-3, rel=0.02)
    assert form.u > 0.3e-3
    assert "of +1." in next(w for w in found.warnings if w.startswith("form: the machine errs in probing"))


def test_what_its_own_machine_reads_is_not_what_the_part_is(tmp_path):
    """A scale of 280 um/m too long: the boss, cut on a circle of 120 mm, is out by 33.6 um, of which probing on 102 mm sees 5 um."""
    scale = '[[effects]]\neffect = "scale_factor"\naxis = "%s"\nk = "280 um/m"\n'
    plan = (
        '[inspection]\nmachine = "same"\n[plan]\nstyli.probe = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }\n'
        '[[plan.steps]]\nfeature = "boss"\nstylus = "probe"\npoints = { strategy = "levels", at = ["2 mm", "4 mm"], n = 8 }\n[job]\n'
    )
    path = shop.write(tmp_path, scale % "X" + scale % "Y", shop.SCENARIO.replace("[job]\n", plan))
    found = cut(vcmm.load_cut(path))
    size = found.characteristics[0]
    assert size.value - size.nominal == pytest.approx(33.6e-3, rel=1e-3)
    assert size.decision.text == "does not conform"  # 20 um are allowed
    seen = found.own_reading.characteristics[0]
    assert seen.value - seen.nominal == pytest.approx(280e-6 * (120 - 102), rel=1e-3)
    assert any("diameter: the machine errs in probing" in w for w in found.warnings)


def test_another_machine_adds_its_own_errors(tmp_path):
    plan = """\
[inspection]
machine = "cmm.toml"
pose = { shift = "200 200 -100 mm" }
[plan]
styli.probe = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
[[plan.steps]]
feature = "boss"
stylus = "probe"
points = { strategy = "levels", at = ["2 mm", "4 mm"], n = 8 }
[job]
"""
    cmm = shop.MACHINE.replace("\"w X' Y' b Z t\"", '"w b Y X Z t"').replace("machine-tool", "cmm")
    cmm += '[repeatability]\nu = "1 um"\n'
    path = shop.write(tmp_path, '[repeatability]\nu = "2 um"\n', shop.SCENARIO.replace("[job]\n", plan))
    (tmp_path / "cmm.toml").write_text(cmm)
    found = cut(vcmm.load_cut(path))
    size = found.characteristics[0]
    lines = {b.input: b.u for b in size.budget}
    # measured at 16 points, each on its own: u = 2 x 1 / sqrt(16) = 0.5 um. Cut in one pass: two levels are one, 8 places
    # 47.1 mm apart on the way of the tool, neighbours correlated by exp(-(47.1 / 20)^2 / 2) = 0.062:
    # u = 2 x 2 sqrt((1 + 2 x 0.062) / 8) = 1.50 um
    assert lines["scatter.value"] == pytest.approx(1.50e-3, rel=0.01)
    assert lines["mill: scatter.value"] == pytest.approx(0.5e-3, rel=1e-3)
    assert found.shares["diameter"]["measurement"] == pytest.approx(0.1, rel=2e-2)


@pytest.mark.thorough
def test_json_and_files(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(cutting, "MOST_ACROSS", 41)  # the largest departure is at an edge
    path = shop.write(tmp_path, SQUARENESS)
    assert command(["cut", str(path), "--json", "--out", str(tmp_path / "out")]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "vcmm.cut/1"
    assert set(document["surface"]) >= {"max_um", "rms_um", "uncut", "gouges"}
    assert document["surface"]["max_um"] == pytest.approx(0.6, rel=1e-3)
    assert document["time_s"] > 0
    assert {"name", "value_mm", "u_mm", "budget", "groups"} <= set(document["characteristics"][0])
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000
    assert (tmp_path / "out" / "surface.csv").read_text().startswith("feature,x_mm")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"setup": shop.SETUP.replace("[tools.1]", "[tools.2]")}, "tool 1"),
        ({"setup": shop.SETUP.replace('diameter = "20 mm"\n', "")}, "diameter"),
        ({"setup": shop.SETUP.replace('"300 mm"', '"50 mm"')}, "travel"),
        ({"scenario": shop.SCENARIO + '[pose]\nshift = "500 250 -350 mm"\n'}, "cuts 0 of its"),
        ({"scenario": shop.SCENARIO.replace('"part.nc"', '"parts.nc"')}, "parts.nc"),
        ({"scenario": shop.SCENARIO.replace("[cut]", "[cut]\nfeed = 3")}, "feed"),
        ({"scenario": shop.SCENARIO.replace('machine = "mill.toml"\n', "")}, "no machine"),
        ({"program": shop.PROGRAM.replace("G2 X0 Y60. I0 J-60.", "G2 X0 Y60. I0 J-60. A10. ")}, "A"),
    ],
)  # fmt: skip
def test_bad_input_says_what_and_where(tmp_path, change, words):
    with pytest.raises(VcmmError, match=words):
        cut(vcmm.load_cut(shop.write(tmp_path, **change)))


def test_a_gouge_is_reported_with_its_line(tmp_path):
    found = cut(vcmm.load_cut(shop.write(tmp_path, program=shop.PROGRAM.replace("X20. Y60.", "X20. Y50."))))
    # the way out now leads through the part: at x = 10 to y = 55, where the circle of the cutter's centre has 59.2
    note = next(w for w in found.warnings if "gouges" in w)
    assert "line 11" in note
    assert found.surface.gouges > 0
    assert found.characteristics[0].decision.text == "does not conform"


def test_a_measuring_command_on_a_cutting_scenario_points_to_cut(tmp_path):
    with pytest.raises(VcmmError, match="vcmm cut"):
        vcmm.load_scenario(shop.write(tmp_path))


def test_what_setting_errs_by_is_in_the_part_though_it_was_set_here(tmp_path):
    found = finished_part(set_up(vcmm.load_cut(shop.write(tmp_path))))[1].influences()
    shift = next(f for f in found if f.input.id == "work_offset[x].shift")
    # 1 um of the zero in x moves the surface by n_x um along n, and the response stands along n: n_x n
    angle = 0.05 + np.arange(24) * 2 * np.pi / 24
    assert shift.response[:24, 0, 0] == pytest.approx(np.cos(angle) ** 2, abs=1e-9)
    assert shift.response[:24, 1, 0] == pytest.approx(np.cos(angle) * np.sin(angle), abs=1e-9)


def test_a_stylus_rests_on_the_cusps(tmp_path):
    # a ball of radius 5 mm in rows 1 mm apart: crests of 5 - sqrt(25 - 0.25) = 25.06 um between the rows; over the middle of a
    # row a tip of radius 20 mm sinks 20 - sqrt(400 - 0.25) = 6.25 um below the crests it rests on: 18.81 um
    rows = "\n".join(f"G1 Y{y}.\nG1 X{x}. Y{y}." for y, x in zip(range(-6, 7), [20, -20] * 7))
    program = f"%\nG21 G17 G90 G94 G40 G49\nT1 M6\nG54 G0 X-20. Y-6. S3000 M3\nG43 H1 Z5.\nG1 Z-1. F600\n{rows}\nG0 Z50.\nM30\n%\n"
    setup = shop.SETUP.replace('diameter = "20 mm"', 'diameter = "10 mm"\nshape = "ball"')
    scenario = (
        shop.SCENARIO[: shop.SCENARIO.index("[part.features]")]
        + """\
[inspection]
machine = "cmm.toml"
pose = { shift = "300 250 -350 mm" }
[part.features]
floor = { type = "plane", point = "0 0 -1 mm", normal = [0, 0, 1], size = "20 4 mm" }
[[part.characteristics]]
name = "flat"
type = "flatness"
of = "floor"
[plan]
styli.large = { offset = "0 0 -100 mm", tip_diameter = "40 mm" }
[[plan.steps]]
feature = "floor"
stylus = "large"
points = { strategy = "grid", n = [3, 3], margin = "1 mm" }
"""
    )
    path = shop.write(tmp_path, "", scenario, program, setup)
    cmm = shop.MACHINE.replace("\"w X' Y' b Z t\"", '"w b Y X Z t"').replace("machine-tool", "cmm")
    (tmp_path / "cmm.toml").write_text(cmm)
    task = finished_part(set_up(vcmm.load_cut(path)))[0]
    assert task.touches.points[:, 1] == pytest.approx(
        np.repeat([-1.0, 0.0, 1.0], 3), abs=1e-12
    )  # over the rows
    crest, sunk = 5 - np.sqrt(24.75), 20 - np.sqrt(399.75)
    assert task.form == pytest.approx(np.full(9, crest - sunk), abs=1e-5)


def test_a_part_cut_beside_its_place_keeps_its_size(tmp_path):
    # scale 200 um/m, set elsewhere: at X = 300 everything lies 60 um off, and 60^2 / 2R must not show as size
    stretched = '[[effects]]\neffect = "scale_factor"\naxis = "X"\nk = "200 um/m"\n'
    scenario = shop.SCENARIO.replace(
        'work_offset = { u = "2 um" }', 'work_offset = { set_on = "elsewhere", u = "2 um" }'
    )
    found = cut(vcmm.load_cut(shop.write(tmp_path, stretched, scenario)))
    # the cutter's centre runs on 60 mm: the boss is an ellipse, its mean diameter 100 mm + 12 um
    assert found.characteristics[0].value == pytest.approx(100.012, abs=2e-5)


def test_a_floor_is_cut_by_the_deepest_point_of_the_disc(tmp_path):
    # EZX falls by 100 um/m x X: a flat cutter of radius 10 that passes over a point is lowest 10 mm further on, by 1 um
    program = shop.PROGRAM.replace("G1 X-20. Y60. F600", "G1 X-100. Y0 Z-10. F600\nG1 X100. Y0")
    slope = (
        '[[effects]]\neffect = "component_polynomial"\ncomponent = "EZX"\ncoefficients = ["0 um", "100 um"]\n'
    )
    scenario = shop.SCENARIO
    a, b = scenario.index("boss ="), scenario.index('[[part.characteristics]]\nname = "form"')
    flat = """\
floor = { type = "plane", point = "0 0 -10 mm", normal = [0, 0, 1], size = "100 0.02 mm" }
[[part.characteristics]]
name = "flat"
type = "flatness"
of = "floor"
zone = "0.02 mm"
"""
    lines = program.splitlines()
    keep = [line for line in lines if not line.startswith(("G1 X0 Y60", "G2", "G1 X20"))]
    path = shop.write(
        tmp_path, slope, scenario[:a] + flat + scenario[scenario.index("[job]") :], "\n".join(keep) + "\n"
    )
    assert b > a
    (patch,) = surface_map(set_up(vcmm.load_cut(path)))
    x = patch.net.points[:, 0]
    # X carries the work: with EZX = +100 um/m X of the table the work rises, the tool is lower there by 0.1 um/mm x X;
    # the point at x gets the cut of x + 10 mm (as far as the path leads), 1 um deeper than the tool over it
    middle = np.abs(x) < 40
    assert patch.height[middle] == pytest.approx(-1e-4 * (x[middle] + 9.99), abs=1e-6)


def test_the_deepest_cut_at_a_rounded_corner_lies_between_steps(tmp_path):
    """The tangent point of a wall in a pocket corner, tool R 10, rounding 10 um: 0.1224 um are left.

    Both moves overlap from d = 8 x 0.010 / sqrt 2 = 0.05657 mm before the corner (vcmm.shop.motion.overlap): at u = t / T the tool is at
    a = d (1 - u)^3 before the corner and b = d u^3 off the wall, and leaves b + a^2 / 2R at the tangent point. Least where
    u^2 = d / R (1 - u)^5, u = 0.0638: 0.0147 + 0.1077 um.
    The nearest steps, 0.05 and 0.1 mm before the corner, leave 0.125 and 0.1^2 / 20 = 0.5 um.
    """
    program = shop.PROGRAM[: shop.PROGRAM.index("G54")] + "G54 G0 X60. Y0. S3000 M3\nG43 H1 Z5.\nZ-10.\n"
    program += "G1 X0. Y0. F6000\nG1 Y60.\nG0 Z50.\nM30\n%\n"
    start, end = shop.SCENARIO.index("boss ="), shop.SCENARIO.index("[job]")
    wall = """\
wall = { type = "plane", point = "0 -10 -8 mm", normal = [0, 1, 0], size = "0.02 2 mm" }
[[part.characteristics]]
name = "flat"
type = "flatness"
of = "wall"
zone = "0.02 mm"
"""
    path = shop.write(tmp_path, "", shop.SCENARIO[:start] + wall + shop.SCENARIO[end:], program)
    (patch,) = surface_map(set_up(vcmm.load_cut(path)))
    x = patch.net.points[:, 0]
    assert patch.height[np.abs(x) < 1e-9] == pytest.approx(0.1224e-3, abs=0.0001e-3)
    d, u = 0.010 * 8 / np.sqrt(2), np.linspace(0.0, 0.5, 20001)
    a, b = d * (1 - u) ** 3, d * u**3
    left = (b + 10 - np.sqrt(100 - (a - x[:, None]) ** 2)).min(axis=1)
    assert patch.height == pytest.approx(left, abs=1e-9)


def test_a_machine_of_which_everything_is_known_is_cut_too(tmp_path, capsys):
    """Nothing uncertain: U is zero, the deviations are those of the known errors, and the part is judged by them."""
    scenario = shop.SCENARIO.replace('work_offset = { u = "2 um" }\n', "")
    path = shop.write(tmp_path, SQUARENESS, scenario)
    assert command(["cut", str(path), "--json"]) == 0
    size, form = json.loads(capsys.readouterr().out)["characteristics"]
    assert size["u_mm"] == 0.0
    assert size["interval_mm"] == pytest.approx([100.0, 100.0], abs=1e-6)
    assert form["value_mm"] == pytest.approx(1.2e-3, abs=0.02e-3)
    assert (size["decision"], size["p_conform"]) == ("conforms", 1.0)


def test_as_dense_as_a_picture_of_all_features_can_be(tmp_path, monkeypatch):
    """One cylinder: 41 across, so 81 angles by 20 heights; a fixture of this room asks for less elsewhere."""
    monkeypatch.setattr(cutting, "MOST_ACROSS", 41)
    job = set_up(vcmm.load_cut(shop.write(tmp_path)))
    (one,) = cutting.surface_map(job)
    assert one.height.shape == (81 * 20,)
    assert np.abs(one.height).max() < 1e-9
    assert one.nominal == pytest.approx(one.height, abs=1e-12)


def test_places_that_no_cutter_reaches_have_no_height(tmp_path):
    """The boss reaches down to -2 mm; drawn up to +4 mm, its upper part was never cut."""
    scenario = shop.SCENARIO.replace('point = "0 0 -8 mm"', 'point = "0 0 -30 mm"')
    job = set_up(vcmm.load_cut(shop.write(tmp_path, scenario=scenario)))
    (one,) = cutting.surface_map(job)
    assert np.isnan(one.height).all()
