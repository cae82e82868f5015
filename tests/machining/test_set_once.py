"""What is set once is drawn once: work offsets one by one, each tool for the whole set-up of the machine."""

from __future__ import annotations

import pytest

import vcmm
from tests.machining import lathe, shop
from tests.machining.test_turning_job import plain
from vcmm.core.errors import UsageError
from vcmm.machining.job import cut, finished_part
from vcmm.machining.preparation import set_up

TURNING = '[tools.9]\nlength = "60 mm"\nshape = "turning"\nnose_radius = "0.8 mm"\norientation = 3\n'  # never called


def test_a_turning_tool_that_is_never_called_leaves_the_work_offset_alone(tmp_path):
    milled = vcmm.load_cut(shop.write(tmp_path))
    listed = vcmm.load_cut(shop.write(tmp_path, setup=shop.SETUP + TURNING))
    expected = [f"work_offset[{d}].shift" for d in "xyz"]
    assert [i.id for i in milled.inputs] == expected
    assert [i.id for i in listed.inputs] == expected
    assert {e.id for e in milled.machine.effects} <= {e.id for e in listed.machine.effects}


SLAB = """%
O1
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-50. Y-60. S3000 M3
G43 H1 Z5.
Z-10.
G1 Y60. F600
G0 Z50.
G55
G0 X50. Y60.
Z-10.
G1 Y-60. F600
G0 Z50.
M30
%
"""
TWO = shop.SETUP.replace("[tools.1]", 'G55 = ["300 mm", "250 mm", "-350 mm"]\n[tools.1]')
SIDES = """\
left = { type = "plane", point = "-40 0 -8 mm", normal = [-1, 0, 0], size = "40 4 mm" }
right = { type = "plane", point = "40 0 -8 mm", normal = [1, 0, 0], size = "40 4 mm" }
[[part.characteristics]]
name = "width"
type = "distance"
between = ["left", "right"]
limits = ["-0.02 mm", "0.02 mm"]
"""
PROBED = """\
[inspection]
machine = "same"
[plan]
styli.probe = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
"""
STEP = '[[plan.steps]]\nfeature = "%s"\nstylus = "probe"\npoints = { strategy = "grid", n = [4, 3], margin = "0.5 mm" }\n'


def slab(tmp_path, offset="", tool="", more="", program=SLAB, features=SIDES):
    """A slab of 80 mm, its left side cut under G54, its right side under G55, both by tool 1."""
    head = (
        f'vcmm = "scenario/1"\nmachine = "mill.toml"\n[cut]\nprogram = "part.nc"\nsetup = "setup.toml"\n{offset}{tool}'
        f"[part.features]\n{features}{more}[job]\ntrials = 20000\n"
    )
    return vcmm.load_cut(shop.write(tmp_path, program=program, setup=TWO, scenario=head))


U_TOOL = 'tools = { 1 = { u_radius = "3 um" } }\n'
U_OFFSET = 'work_offset = { u = "2 um" }\n'
BOTH_SIDES = PROBED + STEP % "left" + STEP % "right"


def test_a_tool_has_one_radius_under_all_work_offsets(tmp_path):
    found = cut(slab(tmp_path, tool=U_TOOL))
    (width,) = found.characteristics
    # 3 um of radius on either side, the same: 6 um; drawn twice it would be 3 sqrt 2 = 4.24 um
    assert width.u == pytest.approx(6e-3, rel=0.02)
    assert found.shares["width"]["tool"] == pytest.approx(1.0, abs=1e-6)
    assert found.repeats["width"] == pytest.approx(width.u)  # all parts of this set-up have it
    assert [line.redraw for line in width.budget] == ["setup"]


def test_every_work_offset_is_set_on_its_own(tmp_path):
    found = cut(slab(tmp_path, offset=U_OFFSET))
    # 2 um in X for the left side, another 2 um for the right: 2 sqrt 2 = 2.83 um
    assert found.characteristics[0].u == pytest.approx(2.828e-3, rel=0.02)
    assert found.shares["width"]["setup"] == pytest.approx(1.0, abs=1e-6)


def test_a_turned_journal_has_one_tool_offset(tmp_path):
    program = "G54\nG0 X44. Z2.\nX40.\nG1 Z-28. F0.1\nG55\nZ-60.\nX52.\n"
    setup = lathe.SETUP.replace("[tools.1]", 'G55 = ["0 mm", "0 mm", "200 mm"]\n[tools.1]')
    path = plain(tmp_path, program=program, setup=setup)
    u = 'tools = { 1 = { u_offset_x = "5 um" } }'
    path.write_text(path.read_text().replace("[cut]", f"[cut]\n{u}"))
    diameter, form = cut(vcmm.load_cut(path), trials=1000).characteristics
    # 5 um of radius is 10 um of diameter; drawn per work offset 28 of the mm would move without the others
    assert diameter.u == pytest.approx(10e-3, rel=0.1)
    assert form.u < 0.1e-3


@pytest.mark.parametrize("where", ["this machine", "elsewhere"])
def test_probed_here_each_side_is_read_from_its_own_work_offset(tmp_path, where):
    offset = f'work_offset = {{ u = "2 um", set_on = "{where}" }}\n'
    scenario = slab(tmp_path, offset, U_TOOL, BOTH_SIDES)
    # an offset set wrongly shifts cut and reading alike; the radius of the tool remains, 6 um
    assert cut(scenario).characteristics[0].u == pytest.approx(6e-3, rel=0.02)
    exact = cut(scenario, engine="exact", trials=1000).characteristics[0]
    assert exact.u == pytest.approx(6e-3, rel=0.07)  # 1000 trials: standard error 2.2 %


def test_a_work_offset_beside_the_probed_points_has_no_part_in_them(tmp_path):
    # from y = 19.6 mm on, 0.1 mm beyond the last points, the left side is cut under G55, all that is probed under G54
    beside = SLAB.replace("G1 Y60. F600\n", "G1 Y19.6 F600\nG55\nG1 Y60.\n").replace("G55\nG0", "G54\nG0")
    scenario = slab(tmp_path, U_OFFSET, U_TOOL, BOTH_SIDES, beside)
    _, world, _ = finished_part(set_up(scenario))
    assert set(world.tool.run.labels["work_offset"]) == {"G54", "G55"}
    assert set(world.measuring.run.labels["work_offset"]) == {"G54"}
    exact = cut(scenario, engine="exact", trials=1000).characteristics[0]
    assert exact.u == pytest.approx(6e-3, rel=0.07)


def test_a_side_that_two_work_offsets_share_is_not_probed_from_one(tmp_path):
    half = SLAB.replace("G1 Y60. F600\n", "G1 Y0. F600\nG55\nG1 Y60.\n")
    with pytest.raises(
        UsageError, match=r"feature left is cut under G54 and G55.* cut it under one work off"
    ):
        cut(slab(tmp_path, U_OFFSET, U_TOOL, BOTH_SIDES, half))
    found = cut(slab(tmp_path, "", U_TOOL, BOTH_SIDES, half))
    assert found.characteristics[0].u == pytest.approx(6e-3, rel=0.02)
