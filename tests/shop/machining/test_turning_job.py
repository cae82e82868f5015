"""The job of turning end to end: bar, forces, a stylus on feed marks, the shipped shaft, and what bad input is told."""

from __future__ import annotations

import json
import math
import shutil

import numpy as np
import pytest

import vcmm
from tests.shop.machining import lathe
from tests.shop.machining.lathe import BAR, PLAIN, effect, plain
from vcmm.answer.evaluation.uncertainty import EXACT
from vcmm.core.errors import VcmmError
from vcmm.face.cli import run as command
from vcmm.files.own.library import folder
from vcmm.shop.machining.job import cut, finished_part
from vcmm.shop.machining.preparation import remarks, set_up

UM = 1e-3


def test_a_force_bends_the_tool_away(tmp_path):
    machine = effect("tool_deflection", compliance="0.1 um/N")
    found, _ = lathe.moved(lathe.shop(plain(tmp_path, machine, lathe.SETUP + BAR)), "seat")
    # 136 N x 0.1 um/N = 13.6 um of radius (the 81 um across are of second order: 0.081^2 / 40 = 0.16 um; the 34 um along Z move
    # feed marks of 1.6 um)
    assert found.mean() == pytest.approx(13.8 * UM, abs=0.2 * UM)


def test_the_compliance_of_a_turning_tool_bends_it_as_the_effect_does(tmp_path):
    path = plain(tmp_path, setup=lathe.SETUP + BAR)
    path.write_text(
        path.read_text().replace("[part.features]", '[cut.tools.1]\ncompliance = "0.1 um/N"\n[part.features]')
    )
    found, _ = lathe.moved(lathe.shop(path), "seat")
    assert found.mean() == pytest.approx(13.8 * UM, abs=0.2 * UM)  # 136 N x 0.1 um/N and the little of above


def test_a_compliance_without_a_bar_is_refused(tmp_path):
    path = plain(tmp_path)
    path.write_text(
        path.read_text().replace("[part.features]", '[cut.tools.1]\ncompliance = "0.1 um/N"\n[part.features]')
    )
    with pytest.raises(VcmmError, match=r"compliance needs cutting forces: add \[stock\]"):
        vcmm.load_cut(path)


@pytest.mark.thorough
def test_the_shipped_shaft(tmp_path, capsys):
    shutil.copy(folder() / "turned_shaft.toml", tmp_path)
    shutil.copytree(folder() / "turned_shaft", tmp_path / "turned_shaft")
    path = tmp_path / "turned_shaft.toml"
    ready = set_up(vcmm.load_cut(path))
    _task, world, notes = finished_part(ready)
    assert notes == ()
    assert np.abs(world.errors()).max() < 10 * UM
    code = command(["cut", str(path), "--engine", "montecarlo", "--trials", "1000", "--json"])
    body = json.loads(capsys.readouterr().out)
    assert code in (0, 1)
    assert len(body["characteristics"]) == len(ready.scenario.part.characteristics)
    assert body["surface"]["uncut"] == body["surface"]["gouges"] == 0
    assert body["surface"]["recut"]["largest_um"] < 0.01
    for c in body["characteristics"]:
        assert 0.9 < sum(c["groups"].values()) < 1.1 or c["u_mm"] < 1e-6, c["name"]  # one pass is round
    assert body["stock"]["collisions"] == []


def test_the_files_of_a_turned_part(tmp_path):
    path = plain(tmp_path, '[repeatability]\nu = "1 um"\n', setup=lathe.SETUP + BAR)
    assert command(
        ["cut", str(path), "--engine", "montecarlo", "--trials", "1000", "--out", str(tmp_path / "out")]
    ) in (0, 1)
    assert {p.name for p in (tmp_path / "out").iterdir()} >= {
        "report.html",
        "surface.csv",
        "cut.json",
        "stock.stl",
    }


def told(path) -> str:
    with pytest.raises(VcmmError) as caught:
        cut(vcmm.load_cut(path))
    return str(caught.value)


def test_what_bad_input_is_told(tmp_path):
    assert "has no nose radius" in told(
        plain(tmp_path, setup=lathe.SETUP.replace('nose_radius = "0.8 mm"\n', ""))
    )
    stands = plain(tmp_path)
    (tmp_path / "part.nc").write_text(
        (lathe.HEAD + PLAIN + lathe.TAIL)
        .replace("G99", "G98")
        .replace("G97 S1000 M3\n", "")
        .replace("F0.1", "F100")
    )
    assert "turns the part while the spindle does not turn" in told(stands)
    assert "axis C carries the tool" in told(
        plain(tmp_path, base=lathe.MACHINE.replace("w C' b Z X t", "w b Z X C t"))
    )
    high = plain(
        tmp_path, setup=lathe.SETUP.replace('offset_x = "40 mm"', 'offset_x = "40 mm"\noffset_y = "0.2 mm"')
    )
    assert "beside the plane of the spindle axis" in told(high)
    off = plain(tmp_path)
    text = off.read_text().replace("0 0 -50 mm", "1 0 -50 mm")
    off.write_text(text)
    assert "surfaces of revolution" in told(off)
    box = BAR.replace('diameter = "44 mm"\n', "")
    assert "either box" in told(plain(tmp_path, setup=lathe.SETUP + box))
    wrong = BAR.replace("16MnCr5", "Al7075")
    assert "no cutting forces are known" in told(plain(tmp_path, setup=lathe.SETUP + wrong))


def test_threads_are_left_out_of_the_surface(tmp_path):
    ready = lathe.shop(plain(tmp_path, program=PLAIN + "G0 X44. Z2.\nX38.8\nG32 Z-20. F1.5\nG0 X44.\n"))
    assert any("threads are not cut into the surface" in text for text in remarks(ready))
    found, _ = lathe.nominal(ready, "seat")
    assert np.abs(found).max() < 2 * UM


def test_the_back_of_an_insert_is_told(tmp_path):
    """Orientation 4: the tip points to -X and +Z. It turns the journal, but the face of the step needs the side of -Z."""
    path = lathe.write(tmp_path, setup=lathe.SETUP.replace("orientation = 3", "orientation = 4"))
    path.write_text(
        path.read_text().replace('of = "seat"\nzone', 'of = "step"\nzone').replace("cylindricity", "flatness")
    )
    _, _, notes = finished_part(set_up(vcmm.load_cut(path)))
    assert len(notes) == 1
    assert "step: line 13 cuts it with the back of the nose" in notes[0]


def test_a_turned_part_cannot_be_placed(tmp_path):
    from vcmm.shop.machining.placement import place_cut

    with pytest.raises(VcmmError, match="cannot move a turned part"):
        place_cut(vcmm.load_cut(plain(tmp_path)))


def test_a_bore_by_hand(tmp_path):
    """A boring bar, tip to +X and -Z (2): a bore of 30 mm; 5 um of offset missing towards the wall leave 5 um of radius."""
    from dataclasses import replace

    from vcmm.physics.structure.setting import ToolOffset

    setup = lathe.SETUP.replace("orientation = 3", "orientation = 2") + BAR + 'bore = "26 mm"\n'
    program = "G0 X24. Z2.\nX30.\nG1 Z-40. F0.05\nX24.\nG0 Z5.\n"
    path = plain(tmp_path, setup=setup, program=program)
    text = path.read_text().replace(
        'diameter = "40 mm", length = "40 mm"', 'diameter = "30 mm", length = "20 mm", inside = true'
    )
    path.write_text(text.replace("0 0 -50 mm", "0 0 -25 mm"))
    ready = lathe.shop(path)
    found, _ = lathe.nominal(ready, "seat")
    assert found.min() >= -1e-12
    assert found.max() <= 0.39073e-3
    bent = lathe.on_machine(ready, replace(ready.machine, effects=(ToolOffset("1", "x", 5 * UM),)))
    assert lathe.moved(bent, "seat")[0] == pytest.approx(5 * UM, abs=1e-8)
    # height of the tip: its distance from the axis grows, sqrt(15^2 + 0.1^2) - 15 = 0.333 um, so the bore does
    high = lathe.on_machine(ready, replace(ready.machine, effects=(ToolOffset("1", "y", 0.1),)))
    assert lathe.moved(high, "seat")[0] == pytest.approx(-0.3333 * UM, abs=1e-7)
    # the bar is pushed towards the axis; the bore grows from 26 to 30 mm over 40 mm: pi (15^2 - 13^2) 40 = 7.04 cm3
    row = [ready.program.moves[i].kind for i in ready.sweep.move].index("line")
    assert ready.blank.forces[row][0] < -50
    assert ready.blank.removed_volume == pytest.approx(math.pi * (15**2 - 13**2) * 40, rel=0.02)


def test_what_is_left_and_what_is_gouged(tmp_path):
    high = plain(tmp_path, program=PLAIN.replace("X40.", "X45."))
    with pytest.raises(VcmmError, match="cuts 0 of its"):  # 2.5 mm of radius are left
        cut(vcmm.load_cut(high))
    deep = plain(tmp_path, program=PLAIN.replace("X40.", "X39.9"))
    _, _, notes = finished_part(set_up(vcmm.load_cut(deep)))
    assert "seat: the program itself gouges 72 of its 72" in notes[0]
    assert "by 0.050 mm at most (line 10)" in notes[0]


def test_a_rapid_through_the_part_is_a_gouge(tmp_path):
    program = PLAIN + "G0 X39. Z-30.8\nX60.\n"  # the centre of the nose over Z-30
    _, _, notes = finished_part(set_up(vcmm.load_cut(plain(tmp_path, program=program))))
    assert "the program itself gouges" in notes[0]
    assert "0.500 mm at most (line 12)" in notes[0]


def test_m4_winds_the_groove_the_other_way(tmp_path):
    """z = z0 + f phi / 2 pi with M3 (see the geometry), z0 - f phi / 2 pi with M4."""
    ready = lathe.shop(
        lathe.write(tmp_path, program=lathe.HEAD.replace("M3", "M4") + lathe.CONTOUR + lathe.TAIL)
    )
    found, points = lathe.nominal(ready, "journal")
    u = np.sqrt(np.maximum(0.8**2 - (0.8 - found) ** 2, 0.0))
    phi = np.arctan2(points[:, 1], points[:, 0])
    start = (points[:, 2] + 0.05 * phi / (2 * np.pi))[:, None] + np.stack([u, -u], axis=1)
    circular = np.exp(2j * np.pi * start / 0.05)
    assert min(np.abs(np.angle(circular / one)).min(axis=1).max() for one in circular[u.argmin()]) < 1e-4


def test_an_offset_from_elsewhere_keeps_the_error_at_the_zero(tmp_path):
    machine = effect("scale_factor", axis="X", k="50 um/m")
    path = plain(tmp_path, machine)
    path.write_text(
        path.read_text().replace(
            "[part.features]", '[cut.work_offset]\nset_on = "elsewhere"\n[part.features]'
        )
    )
    found, _ = lathe.moved(lathe.shop(path), "seat")
    # axis X stands at 20 + 40 (offset of the tool) mm: 50e-6 x 60 = 3 um
    assert found == pytest.approx(3 * UM, abs=1e-7)


def test_inspection_on_a_measuring_machine(tmp_path):
    """A stylus of 1 mm radius reads the crests: twice 0.08 to 0.39 um on a diameter, a form no larger than the marks."""
    path = plain(tmp_path, program=PLAIN.replace("F0.1", "F0.05"))
    (tmp_path / "cmm.toml").write_text(
        'vcmm = "machine/1"\nname = "cmm"\nstructure = "w b Y X Z t"\n'
        + "".join(f'[axes.{a}]\ntravel = ["-500 mm", "500 mm"]\n' for a in "XYZ")
    )
    plan = """
[inspection]
machine = "cmm.toml"
pose = { shift = "0 0 0 mm" }
[plan]
styli.probe = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
[[plan.steps]]
feature = "seat"
stylus = "probe"
points = { strategy = "levels", at = ["8 mm", "19.37 mm", "30.11 mm"], n = 24 }
[job]
"""
    text = path.read_text().replace("[job]\n", plan)
    path.write_text(text.replace("[part.features]", '[cut.tools.1]\nu_offset_x = "0.01 um"\n[part.features]'))
    size, form = cut(vcmm.load_cut(path)).characteristics
    assert 2 * 0.0782 * UM < size.value - 40.0 < 2 * 0.3907 * UM
    assert form.value < 0.3125 * UM


def test_a_compensated_program_turns_the_right_part(tmp_path):
    """50 urad between Z and the spindle, tool set on a trial cut 90 mm behind the front: rewritten, the shaft is straight."""
    machine = effect("squareness", pair="B0Z", angle="50 urad")
    setup = lathe.SETUP + "compensation = []\n"
    scenario = lathe.SCENARIO.replace(
        'setup = "setup.toml"', 'setup = "setup.toml"\nwork_offset = { at = "20 0 110 mm" }'
    )
    path = lathe.write(tmp_path, machine, setup=setup, scenario=scenario)
    before = lathe.shop(path)
    # at z = -20 the tool stands 69.2 mm before the place of the trial cut: 50e-6 x 69.2 = 3.46 um of radius are left
    middle = np.abs(lathe.nominal(before, "journal")[1][:, 2] + 20) < 0.1
    assert lathe.moved(before, "journal")[0][middle] == pytest.approx(3.46 * UM, abs=0.01 * UM)
    assert command(["compensate", str(path), "--out", str(tmp_path / "better.nc")]) == 0
    shutil.copy(tmp_path / "better.nc", tmp_path / "part.nc")
    after = lathe.shop(path)
    for name in ("journal", "seat"):
        rest = lathe.moved(after, name)[0] + lathe.nominal(after, name)[0]
        # numbers of 0.001 mm of diameter: 0.25 um of radius at the ends of a line, and the feed marks of 0.39 um
        assert np.abs(rest).max() < 1.0 * UM, name


def test_the_force_turns_with_the_feed_along_the_ball(tmp_path):
    """Along the arc the thrust keeps its share across the surface: 10 N pushed straight away in its middle are 10 N everywhere."""
    from vcmm.shop.machining.turning import turning_force_along

    ready = lathe.shop(lathe.write(tmp_path, setup=lathe.SETUP + BAR.replace("90", "130")))
    row = [ready.program.moves[i].kind for i in ready.sweep.move].index("arc")
    c = math.sqrt(0.5)  # in the middle of the quarter the surface looks to (c, c)
    forces = np.zeros((len(ready.sweep), 3))
    forces[row] = [10 * c, 3.0, 10 * c]
    share = np.array([1 / 6, 0.5, 5 / 6])  # 15, 45 and 75 deg from the pole
    found = turning_force_along(forces, ready.sweep, np.full(3, row), share)
    a = np.radians([15.0, 45.0, 75.0])
    # the programmed quarter begins a little before the pole, where the offset contour does: no more than a degree
    assert found[:, 0] == pytest.approx(10 * np.sin(a), abs=0.2)
    assert found[:, 1] == pytest.approx(3.0)
    assert found[:, 2] == pytest.approx(10 * np.cos(a), abs=0.2)


def test_without_an_engine_asked_for_turned_parts_are_computed_exactly(tmp_path):
    path = plain(tmp_path)
    path.write_text(
        path.read_text().replace("[part.features]", '[cut.tools.1]\nu_offset_x = "3 um"\n[part.features]')
    )
    scenario = vcmm.load_cut(path)
    found = cut(scenario, trials=3000)
    assert {c.tier for c in found.uncertainty.characteristics} == {EXACT}
    assert any("2000 exact trials" in w for w in found.warnings)
    assert not any("linear model errs" in w for w in found.warnings)
    linear = cut(scenario, trials=3000, engine="montecarlo")
    assert EXACT not in {c.tier for c in linear.uncertainty.characteristics}
    # the tool stands 3 um of radius off: 6 um of diameter either way
    for one in (found, linear):
        assert one.uncertainty.characteristics[0].u == pytest.approx(6 * UM, rel=0.08)


def test_a_milling_tool_that_is_never_called_does_not_make_x_a_set_zero(tmp_path):
    path = plain(tmp_path, setup=lathe.SETUP + '[tools.7]\nlength = "80 mm"\ndiameter = "8 mm"\n')
    path.write_text(path.read_text().replace("[cut]", '[cut]\nwork_offset = { u = "2 um" }'))
    assert [i.id for i in vcmm.load_cut(path).inputs] == ["work_offset[z].shift"]


def test_a_driven_tool_is_refused_by_its_line(tmp_path):
    """Polar and cylindrical interpolation turn C while the tool cuts: that takes a driven tool, which the set-up has not."""
    for on, off, line in (("G12.1", "G13.1", 22), ("G7.1 C20.", "G7.1 C0", 22)):
        driven = f"G98\n{on}\nG1 X60. F100\nC10.\n{off}\nG99\n"
        path = lathe.write(tmp_path, program=lathe.HEAD + lathe.CONTOUR + driven + lathe.TAIL)
        with pytest.raises(VcmmError, match=rf"{line}(?::| of the program) .*driven tool"):
            lathe.shop(path)
