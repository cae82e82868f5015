"""Cutting forces beside rotary axes: those that the part sees, whichever axis stands or turns under the tool."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shop.machining import rotary_shop as rs
from vcmm.core.errors import ModelLimit
from vcmm.shop.machining.job import finished_part

TABLE = "w C' X' Y' b Z t"
BOSS = 'boss = { type = "cylinder", point = "0 0 -8 mm", axis = [0, 0, 1], diameter = "20 mm", length = "6 mm" }\n'
TOOL = 'diameter = "10 mm"\nteeth = 3\n[stock]\nbox = ["50 mm", "50 mm", "20 mm"]\nmaterial = "Al7075"\n'
START = "G0 X15. Y-30.\nG43 H1 Z5.\nZ-10.\nG1 Y0. F471\n"
BENDS = '[[effects]]\neffect = "tool_deflection"\ncompliance = "0.1 um/N"\n'


def written(tmp_path, program, effects="", tool=TOOL):
    return rs.write(tmp_path, rs.machine(TABLE, rs.axis("C") + effects), program, BOSS, tool)


def cut_at(folder, mill, program, features, tool):
    """(force (rows, 3) N and errors of the tool (rows, 3) mm in the axes of the part, place in the part (rows, 3)), of the rows that make the part."""
    folder.mkdir()
    _, world, _ = finished_part(rs.shop_of(rs.write(folder, mill, program, features, tool)))
    row = world.contacts.deepest(world.tool_errors)[0]
    run = world.tool.run
    names = [f"part_{c}_mm" for c in "xyz"]
    return (
        run.vector("force_x_N", "force_y_N", "force_z_N")[row],
        world.tool_errors[row],
        run.vector(*names)[row],
    )


WALL = 'wall = { type = "plane", point = "0 10 -5 mm", normal = [0, 1, 0], size = "16 6 mm" }\n'
BLOCK = 'diameter = "10 mm"\nteeth = 3\n[stock]\nbox = ["50 mm", "24 mm", "20 mm"]\nmaterial = "Al7075"\n'
ALONG = "G43 H1 Z5.\nZ-10.\nG1 X-40. F600\nG0 Z50.\n"


@pytest.fixture(params=["effect", "stick_out"])
def bends(request):
    """(effects of the machine file, lines of the tool): any direction alike, or a rod."""
    return (BENDS, "") if request.param == "effect" else ("", 'stick_out = "30 mm"\n')


def test_a_table_that_stands_turned_leaves_the_forces_that_the_part_sees(tmp_path, bends):
    """One cut of a wall, with the table at C0, and at C90, where the tool stands over the part as Rz(90) of the machine: (x, y) of the part is reached at
    (y, -x). The part sees the same tool on the same way, so force and bending in its axes are the same."""
    effects, stick_out = bends
    mill, tool = rs.machine(TABLE, rs.axis("C") + effects), BLOCK.replace("teeth", stick_out + "teeth")
    still = cut_at(tmp_path / "still", mill, "G0 X40. Y15.\n" + ALONG, WALL, tool)
    way = "G0 C90.\nG0 X15. Y-40.\nG43 H1 Z5.\nZ-10.\nG1 Y40. F600\nG0 Z50.\n"
    turned = cut_at(tmp_path / "turned", mill, way, WALL, tool)
    assert turned[2] == pytest.approx(still[2], abs=1e-6)
    assert np.abs(still[0]).max() > 20.0
    assert np.abs(still[1]).max() > 1e-4
    assert turned[0] == pytest.approx(still[0], abs=1e-6 * np.abs(still[0]).max())
    assert turned[1] == pytest.approx(still[1], abs=1e-7)


def test_a_tool_that_comes_from_the_side_presses_as_from_above(tmp_path, bends):
    """The same with a table at B90: the tool stands along +X of the part, which lies turned by Ry(90): what is (x, y, z) from above is (z, y, -x), and so
    are force and bending. Both stocks are good to a few percent (600 and 300 rays)."""
    effects, stick_out = bends
    mill, tool = (
        rs.machine("w B' X' Y' b Z t", rs.axis("B") + effects),
        BLOCK.replace("teeth", stick_out + "teeth"),
    )
    above = cut_at(tmp_path / "above", mill, "G0 X40. Y15.\n" + ALONG, WALL, tool)
    side = tool.replace(
        '["50 mm", "24 mm", "20 mm"]', '["20 mm", "24 mm", "50 mm"]\ncorner = ["-20 mm", "-12 mm", "-25 mm"]'
    )
    lying = WALL.replace("0 10 -5 mm", "-5 10 0 mm").replace("16 6", "6 6")
    beside = cut_at(tmp_path / "side", mill, "G0 B90.\nG0 X40. Y15.\n" + ALONG, lying, side)
    turn = lambda v: np.column_stack([v[:, 2], v[:, 1], -v[:, 0]])  # noqa: E731
    forces, bent = turn(above[0]).mean(axis=0), turn(above[1]).mean(axis=0)
    assert np.abs(forces).max() > 20.0
    assert beside[0].mean(axis=0) == pytest.approx(forces, abs=0.05 * np.abs(forces).max())
    assert beside[1].mean(axis=0) == pytest.approx(bent, abs=0.05 * np.abs(bent).max())
    if stick_out:
        assert np.abs(beside[1][:, 0]).max() < 1e-9  # a rod is stiff along its axis, X of the part


def test_a_second_direction_meets_what_the_first_has_left(tmp_path):
    """From above 6 of 12 mm in y are taken away 10 mm deep; from the side the same tool then runs along that wall: it meets the block below only."""
    mill = rs.machine("w B' X' Y' b Z t", rs.axis("B"))
    first = "G0 X40. Y11.\n" + ALONG
    # from +X, 10 mm deep into the part (x = 25 to 15), along z of the part from -30 to 20, beside the wall at y = 6
    second = "G0 B90.\nG0 X-40. Y11.\nG43 H1 Z30.\nZ15.\nG1 X40. F600\nG0 Z60.\n"
    alone = rs.shop_of(rs.write(_folder(tmp_path, "alone"), mill, second, WALL, BLOCK))
    both = rs.shop_of(rs.write(_folder(tmp_path, "both"), mill, first + second, WALL, BLOCK))
    cuts = [
        np.abs(shop.blank.forces).sum(axis=1) * (shop.blank.pieces.sweep.axis[:, 0] > 0.5)
        for shop in (alone, both)
    ]
    # 20 mm of height alone; 10 of them are gone
    lengths = [np.count_nonzero(c > 1.0) for c in cuts]
    assert lengths[1] == pytest.approx(lengths[0] / 2, rel=0.2)
    assert cuts[1].max() == pytest.approx(cuts[0].max(), rel=0.05)


def _folder(tmp_path, name):
    (tmp_path / name).mkdir()
    return tmp_path / name


def test_the_feed_of_a_table_that_turns_is_that_over_the_part(tmp_path):
    """1800 deg/min at 15 mm: 10 pi rad/min x 15 mm = 471.2 mm/min, over 3000/min and 3 teeth 0.05236 mm each."""
    shop = rs.shop_of(written(tmp_path, START + "G1 C-360. F1800\nG0 Z50.\n"))
    moves = [shop.program.moves[i] for i in shop.blank.pieces.sweep.move.tolist()]
    turning = np.array([m.source.line == 10 and m.kind != "rapid" for m in moves])
    chips = shop.blank.teeth.chip[turning]
    assert np.median(chips) == pytest.approx(10 * np.pi * 15 / 3000 / 3, rel=1e-3)
    assert abs(shop.blank.forces[turning]).max() > 1.0


TILTING = "G0 X0. Y-30.\nG43 H1 Z5.\nZ-10.\nG1 X1. B60. F600\nG0 Z50.\n"


def test_a_tool_that_tilts_while_it_cuts_has_no_forces(tmp_path):
    mill = rs.machine("w B' X' Y' b Z t", rs.axis("B") + BENDS)
    with pytest.raises(ModelLimit, match=r"tool_deflection.* line 9 of the program .* too many directions"):
        rs.shop_of(rs.write(tmp_path, mill, TILTING, BOSS, TOOL))


def test_a_force_log_stands_in_for_them(tmp_path):
    """100 N along x of the workpiece all the time at 0.1 um/N: the tool is 10 um off along x wherever the table stands."""
    path = written(tmp_path, START + "G1 C-360. F1800\nG0 Z50.\n", BENDS)
    (tmp_path / "forces.csv").write_text("time_s,force_x_N,force_y_N,force_z_N\n0,100,0,0\n10000,100,0,0\n")
    path.write_text(path.read_text().replace("[cut]", '[cut]\nforce_log = "forces.csv"', 1))
    _, world, _ = finished_part(rs.shop_of(path))
    row, _ = world.contacts.deepest(world.tool_errors)
    assert world.tool_errors[row, 0] == pytest.approx(10e-3, abs=1e-6)
    assert world.tool_errors[row, 1] == pytest.approx(0.0, abs=1e-6)


def test_a_bore_from_behind_meets_what_the_one_from_before_has_left(tmp_path):
    """Bores of 20 mm, 25 mm deep from either side of a block 50 mm thick. Rays along the axis of the first leave its circles at once (they crept out of an
    arc by nanometres, for minutes), and nothing of its own stands before the second but its 25 mm."""
    mill = rs.machine("w B' X' Y' b Z t", rs.axis("B"))
    bore = "G0 X0. Y0.\nG43 H1 Z30.\nG1 Z0.5 F200\nG3 X10. Y0. I5. J0. F300\nG3 X10. Y0. I-10. J0.\nG0 Z60.\n"
    block = BLOCK.replace(
        '["50 mm", "24 mm", "20 mm"]', '["50 mm", "50 mm", "50 mm"]\ncorner = ["-25 mm", "-25 mm", "-25 mm"]'
    )
    shop = rs.shop_of(
        rs.write(tmp_path, mill, bore + "G0 B180.\n" + bore, WALL.replace("0 10 -5", "0 15 0"), block)
    )
    up = shop.blank.pieces.sweep.axis[:, 2]
    sides = [np.abs(shop.blank.forces[(up * sign) > 0.5]).max() for sign in (1, -1)]
    assert sides[0] > 10.0
    assert sides[1] == pytest.approx(sides[0], rel=0.05)
