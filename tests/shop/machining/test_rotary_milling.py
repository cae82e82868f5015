"""Indexed rotary axes: lines and arcs in turned planes, errors of the table, of the zero and of a tilted head, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vcmm
from tests.shop.machining import rotary_shop as rs
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.physics.structure.residual import CorrelatedField
from vcmm.shop.machining.blank import notes
from vcmm.shop.machining.contact_path import surface_at
from vcmm.shop.machining.job import cut, finished_part
from vcmm.shop.machining.placement import place_cut
from vcmm.shop.machining.preparation import set_up

STRUCTURE = "w B' Z' b X Y t"  # a horizontal machining centre: the spindle is Z, the pallet turns about the vertical Y
ELSEWHERE = 'work_offset = { set_on = "elsewhere" }'
# a face of 40 x 40 mm at 40 mm from the centre of the pallet, cut at B = 0, 90, 180 and 270 deg with the bottom of the cutter
FACE = "G0 B{b}. \nG0 X-45. Y-10.\nG43 H1 Z60.\nZ40.\nG1 X45. F600\nG1 Y10.\nG1 X-45.\nG0 Z200.\n"
CUTTER = 'diameter = "24 mm"\n'
FRONT = 'front = { type = "plane", point = "0 0 40 mm", normal = [0, 0, 1], size = "40 40 mm" }\n'
RIGHT = 'right = { type = "plane", point = "40 0 0 mm", normal = [1, 0, 0], size = "40 40 mm" }\n'
BACK = 'back = { type = "plane", point = "0 0 -40 mm", normal = [0, 0, -1], size = "40 40 mm" }\n'
LEFT = 'left = { type = "plane", point = "-40 0 0 mm", normal = [-1, 0, 0], size = "40 40 mm" }\n'


def hmc(effects: str = "") -> str:
    return rs.machine(STRUCTURE, rs.axis("B") + effects)


def location(component: str, um: float) -> str:
    return f'[[effects]]\neffect = "rotary_location"\ncomponent = "{component}"\noffset = "{um} um"\n'


def heights(path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Feature -> points and departures in um."""
    return {name: (p.net.points, p.height * 1e3) for name, p in rs.patches(path).items()}


def test_four_faces_of_a_perfect_pallet_are_nominal(tmp_path):
    program = "".join(FACE.format(b=b) for b in (0, 90, 180, 270))
    found = heights(rs.write(tmp_path, hmc(), program, FRONT + RIGHT + BACK + LEFT, CUTTER))
    # at B = q the pallet has turned by -q about Y, so the spindle points along (sin q, 0, cos q) of the part
    assert set(found) == {"front", "right", "back", "left"}
    for _, height in found.values():
        assert np.abs(height).max() < 1e-6  # um


def test_an_arc_in_a_turned_plane_is_a_round_boss(tmp_path):
    program = "G0 B90. X0 Y80.\nG43 H1 Z60.\nG0 Z30.\nG1 X0 Y40. F600\nG2 X0 Y40. I0 J-40.\nG1 X20. Y40.\nG0 Z200.\n"
    boss = 'boss = { type = "cylinder", point = "30 0 0 mm", axis = [1, 0, 0], diameter = "60 mm", length = "10 mm" }\n'
    path = rs.write(tmp_path, hmc(), program, boss, 'diameter = "20 mm"\n')
    # centre path 40 mm, cutter 10 mm: a boss of 60 mm about X of the part, 10 mm high over the floor at x = 30
    assert np.abs(heights(path)["boss"][1]).max() < 1e-6
    sweep = rs.shop_of(path).sweep
    assert (sweep.kind == 1).sum() == 1  # the arc is still one arc


def test_location_of_the_table_axis_shifts_what_is_cut_at_ninety_degrees(tmp_path):
    # the centre line stands 5 um too far in Z: at B = 90 the part is 5 um nearer to the spindle, which takes 5 um more
    found = heights(rs.write(tmp_path, hmc(location("Z0B", 5)), FACE.format(b=90), RIGHT, CUTTER, ELSEWHERE))
    assert found["right"][1] == pytest.approx(np.full(len(found["right"][1]), -5.0), abs=1e-6)
    # 5 um too far in X is along that face at B = 90 (-z of the part): nothing
    found = heights(rs.write(tmp_path, hmc(location("X0B", 5)), FACE.format(b=90), RIGHT, CUTTER, ELSEWHERE))
    assert np.abs(found["right"][1]).max() < 1e-6


def test_a_zero_set_on_the_machine_follows_the_table(tmp_path):
    # the zero was probed on the part at B = 0 and holds the 5 um; turned about the shifted axis the part still lies 5 um off
    # in Z of the machine, as the zero says: nothing is left
    found = heights(rs.write(tmp_path, hmc(location("Z0B", 5)), FACE.format(b=90), RIGHT, CUTTER))
    assert np.abs(found["right"][1]).max() < 1e-6
    # a Z axis that is long by 100 um/m errs by nothing of its own: at the zero Z stands at -300 mm (-30 um), at the face at -260 mm
    # (-26 um): the table comes 4 um less near, the tool leaves ... the table's own motion, so its sign is turned
    scale = '[[effects]]\neffect = "scale_factor"\naxis = "Z"\nk = "100 um/m"\n'
    found = heights(rs.write(tmp_path, hmc(scale), FACE.format(b=90), RIGHT, CUTTER))
    assert found["right"][1] == pytest.approx(np.full(len(found["right"][1]), 4.0), abs=1e-6)


def test_what_was_taken_into_the_zero_stays_along_the_machine_axes(tmp_path):
    # EXZ = 3 um wherever Z stands, X of the spindle; EXB = 6 um at B = 180 deg and 0 at 0 (c0 + c1 cos q: 3 - 3 cos q)
    cyclic = '[[effects]]\neffect = "rotary_cyclic"\ncomponent = "EZB"\ncoefficients = ["-3 um", "0 um"]\n'
    found = heights(rs.write(tmp_path, hmc(cyclic), FACE.format(b=180), BACK, CUTTER))
    # EZB moves with the table: at 0 deg the part lies 3 um too low along its own z, the tool 3 um too high; the zero takes it.
    # At 180 deg EZB = +3 um: the part is shifted by +3 um along its z, the tool by -3 um z = +3 um along n = -z.
    # The zero holds +3 um of the tool along Z of the machine, which is n at 180 deg: 3 - 3 = 0
    assert np.abs(found["back"][1]).max() < 1e-6
    found = heights(rs.write(tmp_path, hmc(cyclic), FACE.format(b=180), BACK, CUTTER, ELSEWHERE))
    assert found["back"][1] == pytest.approx(np.full(len(found["back"][1]), 3.0), abs=1e-6)


def test_a_zero_set_where_it_is_used_holds_the_error_of_that_angle(tmp_path):
    # EZB = 4 um sin B: 4 um of the pallet along its z at B = 90 deg, along the face x = 40; EXB = 6 um sin B along its normal
    cyclic = "".join(
        f'[[effects]]\neffect = "rotary_cyclic"\ncomponent = "{c}"\ncoefficients = ["0 um", "{v} um"]\n'
        for c, v in (("EXB", 6), ("EZB", 4))
    )
    scale = '[[effects]]\neffect = "scale_factor"\naxis = "Z"\nk = "100 um/m"\n'
    at_zero = heights(rs.write(tmp_path, hmc(cyclic), FACE.format(b=90), RIGHT, CUTTER))["right"][1]
    # the pallet 6 um nearer to the spindle along x of the part: 6 um deeper; a zero set at B = 0 knows nothing of it
    assert at_zero == pytest.approx(np.full(len(at_zero), -6.0), abs=1e-6)
    as_cut = 'work_offset = { rotary = "as cut" }'
    found = heights(rs.write(tmp_path, hmc(cyclic), FACE.format(b=90), RIGHT, CUTTER, as_cut))["right"][1]
    assert np.abs(found).max() < 1e-6
    # what is not at the zero stays: 4 um between Z = -300 and -260 mm, as above
    found = heights(rs.write(tmp_path, hmc(cyclic + scale), FACE.format(b=90), RIGHT, CUTTER, as_cut))[
        "right"
    ][1]
    assert found == pytest.approx(np.full(len(found), 4.0), abs=1e-6)
    both = rs.write(
        tmp_path, hmc(cyclic), FACE.format(b=0) + FACE.format(b=90), FRONT + RIGHT, CUTTER, as_cut
    )
    with pytest.raises(UsageError, match=r"G54 cuts with the rotary axes in several places \(line 18\)"):
        heights(both)


@pytest.mark.thorough
def test_positioning_error_of_the_table_turns_the_faces_of_a_square(tmp_path):
    # EBB = 50 urad sin q: +50 urad at 90 deg, -50 urad at 270, nothing at 0 and 180
    cyclic = (
        '[[effects]]\neffect = "rotary_cyclic"\ncomponent = "EBB"\ncoefficients = ["0 urad", "50 urad"]\n'
    )
    more = "".join(
        f'[[part.characteristics]]\nname = "{a}"\ntype = "{kind}"\nof = "{a}"\ndatums = ["{b}"]\ncriterion = "G"\nzone = "0.01 mm"\n'
        for kind, a, b in (("perpendicularity", "right", "front"), ("parallelism", "left", "right"), ("parallelism", "back", "front"))
    )  # fmt: skip
    program = "".join(FACE.format(b=b) for b in (0, 90, 180, 270))
    path = rs.write(
        tmp_path,
        hmc(cyclic),
        program,
        FRONT + RIGHT + BACK + LEFT,
        CUTTER,
        'work_offset = { u = "1 um" }',
        more,
    )
    found = heights(path)
    # the table has turned too far by +50 urad about Y: seen from the part the tool is turned by -50 urad, its tip shifted by
    # -50e-6 y x p, along n = +x that is -50e-6 z; at 270 deg n = -x and the sign of EBB is turned as well: -50e-6 z again
    for name in ("right", "left"):
        points, height = found[name]
        assert height == pytest.approx(
            -0.05 * points[:, 2], abs=1e-3
        )  # + the disc of the cutter, second order
    by_name = {c.name: c for c in cut(vcmm.load_cut(path)).characteristics}
    # 50 urad over the 40 mm of the face, of which its associated plane speaks (the touches span less): 2 um; from 90 to 270 deg the table turns by 180 deg less
    # 100 urad, so left and right are a wedge: 4 um; back to front nothing
    assert by_name["right"].value == pytest.approx(2e-3, rel=0.01)
    assert by_name["left"].value == pytest.approx(4e-3, rel=0.01)
    assert by_name["back"].value == pytest.approx(0.0, abs=1e-6)


HEADED = "w X' Y' b Z B t"  # a head that swivels about Y, its pivot 150 mm over the spindle nose
PIVOT = rs.axis("B", "0 0 150")


def tilted(tmp_path, effects: str = "", cut_lines: str = ELSEWHERE):
    """A line along Y with a ball of radius 5 mm at B = 30 deg: floor at z = 0, x = 0, L + h = 100 + 150 mm from tip to pivot."""
    s, c = np.sin(np.pi / 6), np.cos(np.pi / 6)
    # the tip swings by 250 (-s, 0, 1 - c), its ball has the centre 5 (s, 0, c) beyond; that centre shall be at (0, y, 5)
    x, z = 250 * s - 5 * s, 5 - 250 * (1 - c) - 5 * c
    program = f"G0 B30. X{x:.9f} Y-30.\nG43 H1 Z50.\nG1 Z{z:.9f} F600\nG1 Y30.\nG0 Z100.\nG0 B0\n"
    floor = 'floor = { type = "plane", point = "0 0 0 mm", normal = [0, 0, 1], size = "0.0001 40 mm" }\n'
    more = '[[part.characteristics]]\nname = "flat"\ntype = "flatness"\nof = "floor"\nzone = "0.01 mm"\n'
    mill = rs.machine(HEADED, PIVOT + effects)
    return rs.write(tmp_path, mill, program, floor, 'diameter = "10 mm"\nshape = "ball"\n', cut_lines, more)


def test_a_ball_on_a_tilted_head_touches_under_its_centre(tmp_path):
    assert np.abs(heights(tilted(tmp_path))["floor"][1]).max() < 1e-6  # beside the line at most 0.05 um


def test_errors_of_a_tilted_head_have_their_lever(tmp_path):
    turned = '[[effects]]\neffect = "component_polynomial"\ncomponent = "EBB"\ncoefficients = ["20 urad"]\n'
    # the centre of the ball lies 245 mm from the pivot along -(s, 0, c); turned by e about Y it moves by e y x r, in z by
    # -e r_x = 20e-6 x 245 x 0.5 = 2.45 um (and the contact under it does not move up or down against the centre)
    found = heights(tilted(tmp_path, turned))["floor"][1]
    # sideways it moves by 20e-6 x 245 x 0.866 = 4.24 um, which lowers a ball of 5 mm by 4.24^2 / 10 mm = 1.8 nm seen from beside
    assert found == pytest.approx(np.full(len(found), 2.4518), abs=2e-4)


def test_a_long_tool_on_a_tilted_head_is_long_along_its_axis(tmp_path):
    path = tilted(tmp_path, "", 'tools = { 1 = { u_length = "4 um", u_radius = "3 um" } }')
    found = {f.input.id: f.response for f in finished_part(rs.shop_of(path))[1].influences()}
    length, radius = (
        next(v for k, v in found.items() if k.startswith(n)) for n in ("tool_length", "tool_radius")
    )
    # 1 um along the tool axis is cos 30 deg along z; a larger ball grows about its centre, its tip stays: 1 - cos 30 deg
    assert length[:, 2, 0] == pytest.approx(np.full(len(length), -np.cos(np.pi / 6)), abs=1e-5)
    assert radius[:, 2, 0] == pytest.approx(np.full(len(radius), -(1 - np.cos(np.pi / 6))), abs=1e-5)


def test_a_wrong_work_offset_lies_along_the_machine_axes(tmp_path):
    cutting = 'work_offset = { u = "2 um" }'
    more = '[[part.characteristics]]\nname = "flat"\ntype = "flatness"\nof = "right"\nzone = "0.01 mm"\n'
    path = rs.write(tmp_path, hmc(), FACE.format(b=90), RIGHT, CUTTER, cutting, more)
    found = {f.input.id: f.response for f in finished_part(rs.shop_of(path))[1].influences()}
    z, x = (found[f"work_offset[{d}].shift"][:, 0, 0] for d in "zx")
    # at B = 90 deg Z of the machine is x of the part, along the normal of the face; X is -z of the part, along it
    assert z == pytest.approx(np.ones(len(z)), abs=1e-9)
    assert x == pytest.approx(np.zeros(len(x)), abs=1e-9)


def test_without_a_pose_the_drawing_lies_where_the_zero_is_when_it_first_cuts(tmp_path):
    path = rs.write(tmp_path, hmc(), FACE.format(b=90), RIGHT, CUTTER)
    setup = (
        (tmp_path / "setup.toml")
        .read_text()
        .replace('G54 = ["0 mm", "0 mm", "-400 mm"]', 'G54 = ["1 mm", "2 mm", "-397 mm"]')
    )
    (tmp_path / "setup.toml").write_text(setup)
    shop = rs.shop_of(path)
    # turned back by 90 deg about Y through (0, 0, -400): (x, y, z) from there in the machine is (z, y, -x) in the part
    assert shop.pose.shift == pytest.approx([3.0, 2.0, -401.0], abs=1e-12)
    points = np.array([[40.0, 0, 0]])
    assert surface_at(shop, points, np.array([[1.0, 0, 0]])).s == pytest.approx([0.0], abs=1e-9)


# ------------------------------------------------------------------------------- what cannot be done, and end to end
ONE = '[[part.characteristics]]\nname = "flat"\ntype = "flatness"\nof = "right"\nzone = "0.01 mm"\n'


def test_placing_is_refused_with_the_line(tmp_path):
    path = rs.write(tmp_path, hmc(), FACE.format(b=90), RIGHT, CUTTER, 'work_offset = { u = "1 um" }', ONE)
    with pytest.raises(ModelLimit, match=r"line 6 .*turns a rotary axis"):
        place_cut(vcmm.load_cut(path), trials=1000)


def test_a_field_over_workpiece_axes_is_refused(tmp_path):
    field = CorrelatedField(nodes=np.array([[0.0, 0, 0], [1, 0, 0]]), deviation=np.zeros((2, 3)))
    scenario = vcmm.load_cut(rs.write(tmp_path, hmc(), FACE.format(b=90), RIGHT, CUTTER))
    with pytest.raises(ModelLimit, match=r"correlated_field.*rotary axes stand off zero.*line 6"):
        set_up(replace(scenario, machine=scenario.machine.with_effect(field)))


def test_rotary_travel_is_checked(tmp_path):
    short = hmc().replace('["-400 deg", "400 deg"]', '["-10 deg", "80 deg"]')
    with pytest.raises(ModelLimit, match=r"line 7 .*axis B = 90 deg"):
        rs.shop_of(rs.write(tmp_path, short, FACE.format(b=90), RIGHT, CUTTER))


@pytest.mark.thorough
def test_a_stock_cut_from_two_sides(tmp_path):
    program = FACE.format(b=0) + FACE.format(b=90)
    path = rs.write(tmp_path, hmc(), program, FRONT + RIGHT, CUTTER)
    stock = '[stock]\nbox = ["100 mm", "100 mm", "100 mm"]\ncorner = ["-50 mm", "-50 mm", "-50 mm"]\n'
    (tmp_path / "setup.toml").write_text((tmp_path / "setup.toml").read_text() + stock)
    blank = rs.shop_of(path).blank
    # each face: 100 mm wide, 44 mm of the height, 10 mm deep; the edge between them counts once
    assert blank.removed_volume == pytest.approx(2 * 100 * 44 * 10 - 10 * 10 * 44, rel=0.03)
    assert blank.kept_as == "rays along X, Y and Z"
    assert "several sides" in " ".join(notes(blank))
    setup = (tmp_path / "setup.toml").read_text().replace("[tools.1]\n", "[tools.1]\nteeth = 3\n")
    (tmp_path / "setup.toml").write_text(setup + 'material = "Al7075"\n')
    blank = rs.shop_of(path).blank
    assert "no cutting forces are computed" not in " ".join(notes(blank))
    side = blank.pieces.sweep.axis[:, 2] < 0.5
    # the tool presses from both sides, across its axis alone but for the axial part of its edges
    for rows in (side, ~side):
        assert np.abs(blank.forces[rows]).max() > 10.0


def test_probed_on_the_same_machine_with_the_pallet_at_zero(tmp_path):
    # cut and probed on a machine whose pallet stands 5 um too near at every angle: the zero holds it, so does the probing
    more = ONE + (
        '[inspection]\nmachine = "same"\n[plan]\nstyli.probe = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }\n'
        '[[plan.steps]]\nfeature = "right"\nstylus = "probe"\npoints = { strategy = "grid", n = [4, 4], margin = "4 mm" }\n'
    )
    path = rs.write(
        tmp_path,
        hmc(location("Z0B", 5)),
        FACE.format(b=90),
        RIGHT,
        CUTTER,
        'work_offset = { u = "1 um" }',
        more,
    )
    _task, world, _ = finished_part(rs.shop_of(path))
    assert np.abs(world.errors()).max() < 1e-9
    # elsewhere: 5 um too deep at B = 90; at B = 0 the part is 5 um too near too, along the face: nothing is read of it
    path = rs.write(tmp_path, hmc(location("Z0B", 5)), FACE.format(b=90), RIGHT, CUTTER, ELSEWHERE, more)
    _, world, _ = finished_part(rs.shop_of(path))
    found = np.einsum("ni,ni->n", world.errors(), world.measuring.task.touches.run.normal)
    assert found * 1e3 == pytest.approx(np.full(16, -5.0), abs=1e-6)
