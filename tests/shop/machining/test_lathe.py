"""Driven tools of a lathe: what every error of the machine does to a cross hole, face holes and a flat, by hand.

Part axes with C at zero are those of the machine. A tool at C = c stands at the angle c of the part: out = (cos c, sin c, 0), round =
(-sin c, cos c, 0). The tip errs against the part by minus what the part errs by.
"""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import driven, lathe
from tests.shop.machining.lathe import effect
from vcmm.core.errors import UsageError
from vcmm.shop.machining.contact_path import surface_at, tool_side
from vcmm.shop.machining.job import cut
from vcmm.shop.machining.lathe import LatheProcess, LatheSurface
from vcmm.shop.machining.preparation import remarks, set_up

UM, URAD = 1e-3, 1e-6
OUT, ROUND = np.array([np.sqrt(0.75), 0.5, 0.0]), np.array([-0.5, np.sqrt(0.75), 0.0])  # of the cross hole


@pytest.fixture(scope="module")
def ready(tmp_path_factory):
    return lathe.shop(driven.write(tmp_path_factory.mktemp("driven")))


def placed(folder, machine, feature, about):
    """Shift (3,) and turn (3,) of a feature as a rigid body about a point, mm and rad."""
    job = lathe.shop(driven.write(folder, machine))
    moved, points = lathe.moved(job, feature)
    n = job.process.net(job, job.scenario.part.features[feature], 15).normals
    rows = np.c_[n, np.cross(points - np.asarray(about), n)]
    found = np.linalg.lstsq(rows, moved, rcond=1e-9)[0]
    return found[:3], found[3:]


def test_turned_and_driven_cuts_stand_side_by_side(ready):
    assert isinstance(ready.process, LatheProcess)
    for name, by_driven in (("seat", False), ("cross", True), ("hole90", True), ("flat", True)):
        over = ready.process.net(ready, ready.scenario.part.features[name], 9)
        surface = ready.process.surface(ready, ready.pose.apply(over.points), over.normals, True)
        assert isinstance(surface, LatheSurface)
        assert (surface.driven == by_driven).all(), name
        assert (surface.status == 0).all()
        assert np.abs(surface.s).max() < 1.7 * UM  # crests of 0.1 mm per turn: 0.1^2 / (8 x 0.8) = 1.56 um
        assert by_driven == (np.abs(surface.s).max() < 1e-9)


def test_the_sweep_of_both_knows_its_moves_and_lines(ready):
    program = ready.program
    lines = {m.tool: m.source.line for m in program.moves if m.kind == "line"}
    first = len(ready.process.turning.sweep)
    assert ready.line_of(0) < ready.line_of(first) <= lines[2]
    tools = [program.moves[i].tool for i in ready.sweep.move]
    assert set(tools[:first]) == {1}
    assert set(tools[first:]) == {2, 3, 4}


def test_positioning_error_of_c_turns_the_hole_about_the_spindle(tmp_path):
    """100 urad sin C: 50 urad at C 30. The part turns on by as much, so the hole lies 50 urad back: 0.662 um at r 13.24 mm, and leans alike."""
    machine = effect("rotary_cyclic", component="ECC", coefficients='["0 rad", "100 urad"]')
    shift, turn = placed(tmp_path, machine, "cross", 13.24 * OUT + [0, 0, -20])
    assert shift == pytest.approx(-50 * URAD * 13.24 * ROUND, abs=2e-6)
    assert turn[2] == pytest.approx(-50 * URAD, abs=0.05 * URAD)


def test_positioning_error_of_c_at_a_flat_and_a_face_hole(tmp_path):
    """At C 90 the whole 100 urad: the flat is turned by it, the hole on 12 mm lies 1.2 um beside its place along x."""
    machine = effect("rotary_cyclic", component="ECC", coefficients='["0 rad", "100 urad"]')
    (tmp_path / "a").mkdir()
    _, turn = placed(tmp_path / "a", machine, "flat", [0, 18, -45])
    assert turn[2] == pytest.approx(-100 * URAD, abs=0.05 * URAD)
    shift, _ = placed(tmp_path, machine, "hole90", [0, 12, -6])
    assert shift == pytest.approx([1.2 * UM, 0, 0], abs=5e-6)


def test_the_spindle_beside_the_plane_of_the_tools(tmp_path):
    """Y0C = 10 um: nobody sets Y by a trial cut, so the hole misses the axis by 10 um; what is turned does not feel it (2nd order)."""
    machine = effect("rotary_location", component="Y0C", offset="10 um")
    shift, _ = placed(tmp_path, machine, "cross", 13.24 * OUT + [0, 0, -20])
    assert shift == pytest.approx(-10 * UM * ROUND, abs=5e-5)
    seat, _ = lathe.moved(lathe.shop(driven.write(tmp_path, machine)), "seat")
    assert (
        np.abs(seat).max() < 1e-5
    )  # sqrt(20^2 + 0.01^2) - 20 = 2.5 nm, of which the trial cut has taken a part


def test_the_spindle_nearer_to_the_tools_is_in_their_offsets(tmp_path):
    machine = effect("rotary_location", component="X0C", offset="10 um")
    job = lathe.shop(driven.write(tmp_path, machine))
    for name in ("seat", "cross", "hole90", "flat"):
        assert np.abs(lathe.moved(job, name)[0]).max() < 1e-6


def test_the_spindle_out_of_parallel_with_z_tilts_a_face_hole(tmp_path):
    machine = effect("rotary_location", component="B0C", tilt="50 urad")
    _, turn = placed(tmp_path, machine, "hole0", [12, 0, -6])
    assert turn[1] == pytest.approx(-50 * URAD, abs=0.1 * URAD)


def test_x_out_of_square_leans_the_cross_hole_by_half(tmp_path):
    """e_z = -50 urad x of the tip: one side of a drilled wall is left where the tool arrives, the other where it stands deepest."""
    _, turn = placed(
        tmp_path, effect("squareness", pair="B0X", angle="50 urad"), "cross", 13.24 * OUT + [0, 0, -20]
    )
    assert turn @ ROUND == pytest.approx(25 * URAD, abs=0.5 * URAD)


def test_y_out_of_square_and_the_scale_of_x_at_the_flat(tmp_path):
    """C0Y = 50 urad moves the tip by -50e-6 y along X, which is the height of the flat; at C 90 y runs along -x of the part: a turn of
    +50 urad. A scale of 50 um/m, set at X 0, leaves 0.9 um at X 18 mm."""
    (tmp_path / "a").mkdir()
    _, turn = placed(tmp_path / "a", effect("squareness", pair="C0Y", angle="50 urad"), "flat", [0, 18, -45])
    assert turn[2] == pytest.approx(50 * URAD, abs=1 * URAD)
    shift, _ = placed(tmp_path, effect("scale_factor", axis="X", k="50 um/m"), "flat", [0, 18, -45])
    assert shift[1] == pytest.approx(0.9 * UM, abs=1e-6)


@pytest.mark.thorough
def test_the_owner_of_a_position_and_its_uncertainty(tmp_path):
    """u(ECC amplitude) 20 urad: at C 30 half of it, at the far end of the axis r 17.24 mm 0.172 um; position is twice that, 0.345 um."""
    known = effect("rotary_cyclic", component="ECC", coefficients='["0 rad", "200 urad"]')
    known += '[[inputs]]\neffect = "rotary_cyclic"\ncomponent = "ECC"\nparameter = "coefficients"\nu = ["0 rad", "20 urad"]\n'
    scenario = driven.SCENARIO.replace(driven.FEATURES, driven.CROSS_HOLE)
    head, tail = scenario.split('[[part.characteristics]]\nname = "diameter"')
    scenario = head + tail[tail.index("[job]") :]
    path = driven.write(tmp_path, known, scenario=scenario)
    found = cut(vcmm.load_cut(path), trials=1000, engine="montecarlo").characteristics[0]
    # known: 100 urad x 17.24 mm = 1.724 um beside its place: the cylinder that holds the axis is 3.45 um wide
    assert found.value == pytest.approx(3.448 * UM, abs=0.05 * UM)
    assert found.u == pytest.approx(0.345 * UM, rel=0.1)


def test_a_driven_tool_has_to_be_named(tmp_path):
    path = driven.write(tmp_path, setup=driven.SETUP.replace('driven = "x"\n', ""))
    with pytest.raises(UsageError, match=r"line 17 .* driven tool: add driven = \"x\".*\[tools.2\]"):
        set_up(vcmm.load_cut(path))


def test_a_drill_without_a_spindle_of_its_own_is_told(tmp_path):
    program = driven.PROGRAM.replace("C30.", "").replace("C0.", "").replace("C90.", "")
    path = driven.write(
        tmp_path,
        program=program,
        setup=driven.SETUP.replace('driven = "x"\n', "").replace('driven = "z"\n', ""),
    )
    assert any(
        "tool 2 is no turning tool; what it cuts is left out" in text for text in remarks(lathe.shop(path))
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("dialect", "program"),
    [("sinumerik", driven.SINUMERIK), ("linuxcnc", driven.LINUXCNC)],
    ids=["SPOS, SETMS and CYCLE83", "C and G83 with G7"],
)
def test_the_same_part_in_other_words(tmp_path, dialect, program):
    """A linuxcnc insert of orientation 2 is one of orientation 3 on Fanuc. 50 urad at r 17.157 mm (2 % from the end of 17.237): 0.858 um."""
    setup = driven.SETUP.replace("fanuc-lathe", dialect)
    setup = setup.replace("orientation = 3", "orientation = 2") if dialect == "linuxcnc" else setup
    machine = effect("rotary_cyclic", component="ECC", coefficients='["0 rad", "100 urad"]')
    job = lathe.shop(driven.write(tmp_path, machine, program=program, setup=setup))
    for name, most in (("cross", 0.858), ("hole0", 0.0), ("hole90", 1.2), ("flat", 0.686)):
        assert np.abs(lathe.nominal(job, name)[0]).max() < 1e-9
        assert np.abs(lathe.moved(job, name)[0]).max() == pytest.approx(most * UM, abs=0.001 * UM), name
    assert not any("refus" in text or "stands still" in text for text in remarks(job))


SUB = driven.PROGRAM.replace("T0303\n", "G55\nT0303\n").replace("T0404\n", "G54\nT0404\n")


def test_the_part_in_the_other_spindle_is_left_out_and_told(tmp_path):
    """The face holes are those of the part in the sub-spindle (G55): the part in the first one has none, and the other way round."""
    setup = driven.SETUP.replace(
        "[offsets]", '[work_spindles]\nG55 = 2\n[offsets]\nG55 = ["0 mm", "0 mm", "200 mm"]'
    )
    job = lathe.shop(driven.write(tmp_path, program=SUB, setup=setup))
    assert np.isnan(lathe.nominal(job, "hole90")[0]).all()
    assert np.abs(lathe.nominal(job, "cross")[0]).max() < 1e-9
    said = [t for t in remarks(job) if "spindle" in t]
    assert [t.split(": ")[0] for t in said] == ["part.nc:20", "part.nc:27", "lines 23 to 24"]
    # two holes from Z2 to Z-15 in pecks of 5: -3, -8, -13, -15
    assert "8 moves cut the part in spindle 2 and are left out; work_spindle = 2 in [cut]" in said[-1]


def test_a_spindle_that_holds_nothing(tmp_path):
    path = driven.write(tmp_path, scenario=driven.SCENARIO.replace("[cut]", "[cut]\nwork_spindle = 2"))
    with pytest.raises(UsageError, match=r"part\.nc: nothing is cut in spindle 2, only in 1"):
        lathe.shop(path)


POLAR = (
    lathe.HEAD
    + driven.TURNED
    + "G98\nT0303\nG0 X60. Z5. C0.\nG12.1\nG1 X50. C0. F500.\nZ-6.\nX38. F200.\nC19.\nX-38.\nC-19.\nX38.\nC0.\n"
    "X60.\nZ5.\nG13.1\nG0 X120. Z50.\nM5\nM30\n%\n"
)
SQUARE = (
    'east = { type = "plane", point = "15 0 -3 mm", normal = [1, 0, 0], size = "24 4 mm" }\n'
    'seat = { type = "cylinder", point = "0 0 -58 mm", axis = [0, 0, 1], diameter = "40 mm", length = "8 mm" }\n'
)


@pytest.mark.thorough
@pytest.mark.parametrize("base", [lathe.MACHINE, driven.BASE], ids=["without Y", "with Y"])
def test_a_square_over_the_face_by_x_and_c(tmp_path, base):
    """Centre path 19 mm out, cutter of 8 mm. A scale of X of 100 um/m leaves 1.9 um at the wall. A spindle 10 um beside the plane of the
    tools shifts the tip by 10 um square to the way to it: on the wall by +10 um y / r, r = hypot(19, y): 5.26 um at y = 11.76 mm."""
    setup = driven.SETUP.replace('shape = "drill"\ndiameter = "5 mm"', 'shape = "flat"\ndiameter = "8 mm"')
    scenario = driven.SCENARIO.replace(driven.FEATURES, SQUARE).replace("place of the cross hole", "side").replace(
        'type = "position"\nof = "cross"', 'type = "flatness"\nof = "east"'
    )  # fmt: skip
    scale, beside = (
        effect("scale_factor", axis="X", k="100 um/m"),
        effect("rotary_location", component="Y0C", offset="10 um"),
    )
    for machine, expected in (
        (scale, lambda y: 1.9 + 0.0 * y),
        (beside, lambda y: 10.0 * y / np.hypot(19.0, y)),
    ):
        job = lathe.shop(
            driven.write(tmp_path, machine, base=base, program=POLAR, setup=setup, scenario=scenario)
        )
        nominal, _ = lathe.nominal(job, "east")
        assert np.abs(nominal).max() < 0.013 * UM  # chords of 0.01 um
        found, points = lathe.moved(job, "east")
        assert found == pytest.approx(UM * expected(points[:, 1]), abs=0.02 * UM)


CYLINDER = (
    "T0404\nG0 X60. Z-45. C0.\nG1 X36. F200.\nG7.1 C18.\nG1 C90. F200.\nG7.1 C0\nG0 X60.\nG0 X120. Z50.\n"
)


def test_a_groove_round_the_part_by_c(tmp_path):
    """G7.1 leads C under a cutter across the spindle: its floor is round at 18 mm, and X 50 um/m too long leaves 0.9 um of it."""
    program = lathe.HEAD + driven.TURNED + "G98\n" + CYLINDER + "M5\nM30\n%\n"
    machine = effect("scale_factor", axis="X", k="50 um/m")
    job = lathe.shop(driven.write(tmp_path, machine, base=lathe.MACHINE, program=program))
    angle = np.radians(np.linspace(5.0, 85.0, 9))
    normals = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(9)])
    surface = surface_at(job, 18.0 * normals + [0, 0, -45], normals)
    assert np.abs(surface.s).max() < 1e-9
    names = np.arange(9).astype(str)
    tool, contacts = tool_side(job, surface, names, names)
    assert contacts.surface(tool.errors()) - contacts.surface(tool.known_error) == pytest.approx(
        0.9 * UM, abs=1e-6
    )
