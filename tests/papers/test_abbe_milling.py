"""The twin on Abbe's principle: reflectors, arms, drawn tables and the slot against numbers made by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from vcmm_twins.abbe_milling import page, twin
from vcmm_twins.abbe_milling.spline_slot import Slot, contour, program

import vcmm
from tests.documented import DOCS, instead
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.face.cli import run as command
from vcmm.files.own.library import example, folder
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness
from vcmm.shop.machining.cut_nets import departure
from vcmm.show.tables.table import text


@pytest.fixture(scope="module")
def scenario():
    return vcmm.load_cut(example("abbe_milling"))


def bare(structure: str, *effects) -> Machine:
    """A machine of the twin with these errors alone, arms from the reflectors."""
    return replace(twin.machine(1, structure), effects=effects)


@pytest.mark.parametrize(
    ("structure", "expected"),
    [
        # the tool stands at (0 0 -150) of the Z frame; Y' is the table with X at 750, so the reflector, which lies at
        # x = 750 on the table, is at x = 0 of the frame of Y
        ("w X' Y' b Z t", {"X": (750, 450, -650), "Y": (0, 450, -650), "Z": (0, 0, -150)}),
        # Y carries Z, which stands at -300: the reflector on the tool is at -300 - 150 in the frame of Y
        ("w X' b Y Z t", {"X": (750, 450, -650), "Y": (0, 0, -450), "Z": (0, 0, -150)}),
        ("w b X Y Z t", {"X": (0, 450, -450), "Y": (0, 0, -450), "Z": (0, 0, -150)}),
    ],
)
def test_reflectors_of_the_three_groups(structure, expected):
    axes = twin.axes_of("corner")
    found = twin.reflectors(structure, axes, twin.table_point(axes))
    for axis, place in expected.items():
        assert found[axis] == pytest.approx(place)


def test_the_arm_of_a_single_axis_with_the_tool_is_zero():
    turning = ComponentTable("EBZ", ("Z",), (np.array([-600.0, 0.0]),), np.array([50e-6, 50e-6]))
    one = bare("w X' Y' b Z t", turning)
    run = Run({"X": np.array([100.0]), "Y": np.array([200.0]), "Z": np.array([-400.0])}, twin.TOOL[None, :])
    assert one.tip_error(run)[0] == pytest.approx([0, 0, 0], abs=1e-12)
    # from the axis frame the arm is (0 0 -150): (0 b 0) x (0 0 -150) = (-150 b, 0, 0) = -7.5 um
    assert twin.conventional(one).tip_error(run)[0] == pytest.approx([-7.5e-3, 0, 0], abs=1e-12)


def test_what_is_counted_twice_is_rotation_times_the_place_of_the_reflector():
    turning = ComponentTable("EBX", ("X",), (np.array([0.0, 1500.0]),), np.array([0.0, 20e-6]))
    one = bare("w b X Y Z t", turning)
    run = Run({"X": np.array([750.0]), "Y": np.array([100.0]), "Z": np.array([-200.0])}, twin.TOOL[None, :])
    # at X = 750: b = 10 urad; (0 b 0) x m with m = (0 450 -450) is (-450 b, 0, 0) = -4.5 um
    assert (twin.conventional(one).tip_error(run) - one.tip_error(run))[0] == pytest.approx(
        [-4.5e-3, 0, 0], abs=1e-12
    )


def test_a_rigid_slide_moves_its_reflector():
    apart, rigid = (twin.draw_tables(5, "w X' Y' b Z t", kind) for kind in (twin.APART, twin.RIGID))
    for axis, arm in (
        ("X", 250.0),
        ("Z", -250.0),
    ):  # reflector above the guide of a table, below that of the tool
        # (a b c) x (0 0 h) = (b h, -a h, 0)
        assert rigid[f"EX{axis}"] - apart[f"EX{axis}"] == pytest.approx(apart[f"EB{axis}"] * arm)
        assert rigid[f"EY{axis}"] - apart[f"EY{axis}"] == pytest.approx(-apart[f"EA{axis}"] * arm)
        assert rigid[f"EZ{axis}"] == pytest.approx(apart[f"EZ{axis}"])
        assert apart[f"EX{axis}"][0] == 0.0  # counted from where the laser began


def test_arms_from_the_reflector_give_the_rigid_slide_back():
    """A slide that only turns about its guide: the consistent model is that turn, the conventional one is not."""
    arm, reflector = np.array([0.0, 0.0, -250.0]), np.array([0.0, 450.0, -450.0])
    nodes = np.array([0.0, 1500.0])
    turn = np.array([[0.0, 0.0, 0.0], [12e-6, -20e-6, 16e-6]])
    seen = np.cross(turn, arm)  # what the laser reads
    tables = [ComponentTable(f"E{d}X", ("X",), (nodes,), seen[:, i]) for i, d in enumerate("XYZ")]
    tables += [ComponentTable(f"E{d}X", ("X",), (nodes,), turn[:, i]) for i, d in enumerate("ABC")]
    one = bare("w b X Y Z t", *tables)
    run = Run({"X": np.array([600.0]), "Y": np.array([100.0]), "Z": np.array([-350.0])}, twin.TOOL[None, :])
    # at X = 600 the slide has turned by 0.4 of the last node; the tip stands at (0 100 -500) of the frame of X
    truth = np.cross(0.4 * turn[1], np.array([0.0, 100.0, -500.0]) - (reflector - arm))
    assert one.tip_error(run)[0] == pytest.approx(truth, abs=1e-12)
    # (4.8 -8 6.4) urad x (0 450 -450) mm = (3600 - 2880, 2160, 2160) nm
    assert twin.conventional(one).tip_error(run)[0] - truth == pytest.approx(
        [0.72e-3, 2.16e-3, 2.16e-3], abs=1e-12
    )


def test_the_files_of_the_scenario_are_what_the_twin_makes(scenario):
    assert (folder() / "abbe_milling" / "slot.nc").read_text() == program()
    assert (folder() / "abbe_milling" / "errors.csv").read_text() == twin.errors_csv()
    drawn = twin.machine(1)
    kept = tuple(e for e in scenario.machine.effects if e.name in ("component_table", "squareness"))
    of_file = replace(scenario.machine, effects=kept, inputs=())
    run = vcmm.field(drawn, nodes=3).run
    assert of_file.tip_error(run) == pytest.approx(drawn.tip_error(run), abs=1e-9)
    assert twin.conventional(of_file).tip_error(run) == pytest.approx(
        twin.conventional(drawn).tip_error(run), abs=1e-9
    )
    assert {a: x.measured_at for a, x in of_file.axes.items()} == {
        a: x.measured_at for a, x in drawn.axes.items()
    }


def test_the_reduction_is_that_of_the_means():
    one = twin.machine(4, "w b X Y Z t", "middle", twin.APART)
    assert twin.reduction(4, "w b X Y Z t", "middle", twin.APART) == pytest.approx(
        1 - twin.mean_error(one) / twin.mean_error(twin.conventional(one))
    )
    assert parse_structure("w b X Y Z t").tool == ("X", "Y", "Z")
    assert one.axes["X"].travel == (-750.0, 750.0)


def test_the_contour_stays_within_its_chord_tolerance():
    slot = Slot()
    path_of_centre = contour(slot)
    middles = (path_of_centre[1:] + path_of_centre[:-1]) / 2
    dense = slot.point(np.linspace(0, slot.length, 20_001))
    apart = np.linalg.norm(middles[:, None, :] - dense[None, ::10, :], axis=2).min(axis=1)
    # the centre runs (20 - 12) / 2 = 4 mm beside the spline, at the ends round a circle of 4 mm
    assert np.abs(apart - 4.0).max() < 1.5 * slot.chord  # the 0.13 mm between the dense points: 0.5 um more
    assert np.linalg.norm(np.diff(path_of_centre, axis=0), axis=1).max() < 5.0
    with pytest.raises(UsageError, match="too tight"):
        contour(Slot(knots=((-20, -25), (0, 30), (20, -25))))


def test_slot_of_a_perfect_machine_and_of_a_skew_one(scenario):
    views = twin.look_at(scenario, twin.PLACES["centre"])
    for view in views:
        programmed = view.contacts.surface(view.tool.known_error)
        assert np.abs(programmed).max() < 4e-3  # chords, and corners rounded by the control
    skew = replace(bare("w X' Y' b Z t", Squareness("C0Y", 20e-6)))
    wall = views[0]
    n, p = wall.net.normals, wall.net.points
    # C0Y = +c moves the tip by (-c y, 0, 0), y that of the cutter's centre, 6 mm from the wall; zero where the offset was set
    expected = -20e-6 * (p[:, 1] + 6.0 * n[:, 1]) * n[:, 0]
    assert departure(wall, skew) == pytest.approx(expected, abs=3e-5)
    assert departure(views[2], skew) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.thorough
def test_effect_on_the_floor_grows_with_the_rotation(scenario):
    rising = ComponentTable("EBX", ("X",), (np.array([0.0, 1500.0]),), np.array([0.0, 20e-6]))
    one = bare("w X' Y' b Z t", rising)
    means = {}
    for place in ("centre", twin.FAR):
        floor = twin.look_at(scenario, twin.PLACES[place])[2]
        means[place] = (departure(floor, twin.conventional(one), False) - departure(floor, one, False)).mean()
    # own motion of the table: tip -(0 b 0) x m with m = (750 450 -650), so z: +750 b; b = 10 urad at X = 750, 18 at 1350
    assert means["centre"] == pytest.approx(7.5e-3, rel=0.01)
    assert means[twin.FAR] == pytest.approx(13.5e-3, rel=0.01)


@pytest.fixture(scope="module")
def result(scenario):
    return twin.run(scenario, draws=3)


@pytest.mark.thorough
def test_documentation_of_the_slots(result):
    """The slots belong to the scenario's machine, so they do not depend on the number of draws."""
    written = (DOCS / "abbe_milling.md").read_text(encoding="utf-8")
    _, _, slots, _ = page.tables(result)
    assert text(slots) in written
    assert "smaller prediction" in written


@pytest.mark.thorough
def test_demo_of_abbe_milling_prints_the_paper_beside_ours(result, tmp_path, capsys, monkeypatch):
    instead(monkeypatch, twin, "abbe_milling", result, draws=3)
    assert command(["demo", "--twin", "abbe_milling", "--draws", "3", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "24.7%" in out
    assert "range of 3 draws" in out
    assert "vcmm cut abbe_milling.toml" in out or "cut abbe_milling.toml" in out
    page = (tmp_path / "report.html").read_text()
    assert "smaller prediction" in page
    figures = json.loads((tmp_path / "demo.json").read_text())
    assert figures["paper_reduction"] == 0.247
    assert len(figures["reductions"]) == 12
    assert len(figures["validation"]) == 3 * 2 * 3  # draws, alignments, slots
    assert "Predicted against milled and measured" in page
