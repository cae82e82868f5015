"""No cutting forces beside rotary axes: a table that turns under a tool along +Z has F in degrees per minute."""

from __future__ import annotations

import pytest

from tests.shop.machining import rotary_shop as rs
from vcmm.core.errors import ModelLimit
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import remarks
from vcmm.shop.machining.rotary_milling import RotaryMillingProcess

TABLE = "w C' X' Y' b Z t"
BOSS = 'boss = { type = "cylinder", point = "0 0 -8 mm", axis = [0, 0, 1], diameter = "20 mm", length = "6 mm" }\n'
TOOL = 'diameter = "10 mm"\nteeth = 3\n[stock]\nbox = ["50 mm", "50 mm", "20 mm"]\nmaterial = "Al7075"\n'
START = "G0 X15. Y-30.\nG43 H1 Z5.\nZ-10.\nG1 Y0. F471\n"
BENDS = '[[effects]]\neffect = "tool_deflection"\ncompliance = "0.1 um/N"\n'


def written(tmp_path, program, effects="", tool=TOOL):
    return rs.write(tmp_path, rs.machine(TABLE, rs.axis("C") + effects), program, BOSS, tool)


@pytest.mark.parametrize(
    ("program", "line"),
    [
        (START + "G1 C-360. F1800\nG0 Z50.\n", 10),
        ("G0 C90.\n" + START + "G0 Z50.\n", 10),  # it stands at 90 deg while the tool cuts
    ],
)
def test_a_table_off_zero_leaves_no_forces(tmp_path, program, line):
    shop = rs.shop_of(written(tmp_path, program))
    assert (
        abs(shop.sweep.axis - [0, 0, 1]) < 1e-12
    ).all()  # the tool stands along +Z of the part all the same
    assert shop.blank.forces is None
    assert shop.blank.kept_as == "map of heights"
    said = f"line {line} cuts with a rotary axis off zero: no cutting forces are computed"
    assert said in remarks(shop)


def test_forces_remain_where_the_table_turns_in_rapids_only(tmp_path):
    program = START + "G0 Z50.\nG0 C90.\n"
    shop = rs.shop_of(written(tmp_path, program))
    assert isinstance(shop.process, RotaryMillingProcess)
    assert abs(shop.blank.forces).max() > 1.0


@pytest.mark.parametrize("bends", ["effect", "stick_out"])
def test_what_bends_by_forces_is_refused_there(tmp_path, bends):
    program = START + "G1 C-360. F1800\nG0 Z50.\n"
    tool = TOOL.replace("teeth", 'stick_out = "30 mm"\nteeth') if bends == "stick_out" else TOOL
    path = written(tmp_path, program, BENDS if bends == "effect" else "", tool)
    with pytest.raises(ModelLimit, match=r"tool_deflection.* line 10 of the program cuts with a rotary axis"):
        rs.shop_of(path)


def test_a_force_log_stands_in_for_them(tmp_path):
    """100 N along x of the workpiece all the time at 0.1 um/N: the tool is 10 um off along x wherever the table stands."""
    path = written(tmp_path, START + "G1 C-360. F1800\nG0 Z50.\n", BENDS)
    (tmp_path / "forces.csv").write_text("time_s,force_x_N,force_y_N,force_z_N\n0,100,0,0\n10000,100,0,0\n")
    path.write_text(path.read_text().replace("[cut]", '[cut]\nforce_log = "forces.csv"', 1))
    _, world, _ = finished_part(rs.shop_of(path))
    row, _ = world.contacts.deepest(world.tool_errors)
    assert world.tool_errors[row, 0] == pytest.approx(10e-3, abs=1e-6)
    assert world.tool_errors[row, 1] == pytest.approx(0.0, abs=1e-6)
