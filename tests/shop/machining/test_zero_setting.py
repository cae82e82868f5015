"""What is set once is drawn once: work offsets one by one, each tool for the whole set-up of the machine."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import lathe, shop
from tests.shop.machining.lathe import plain
from vcmm.core.errors import DataError, UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.pose import Pose
from vcmm.core.run import Run
from vcmm.shop.machining.job import cut, finished_part, patch
from vcmm.shop.machining.maps import net
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.zero_setting import SETTING, ZeroRows, join_runs, setting_rows, ways_of_setting
from vcmm.task.response.influence import Influence
from vcmm.task.response.trials import Draws

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
    found = cut(scenario)
    assert found.own_reading.characteristics[0].u == pytest.approx(6e-3, rel=0.02)
    # the part itself has both: 6 um of the tool, 2 sqrt 2 um of the two offsets
    assert found.characteristics[0].u == pytest.approx(np.hypot(6e-3, 2e-3 * np.sqrt(2)), rel=0.02)
    exact = cut(scenario, engine="exact", trials=1000).own_reading.characteristics[0]
    assert exact.u == pytest.approx(6e-3, rel=0.07)  # 1000 trials: standard error 2.2 %


def test_a_work_offset_beside_the_probed_points_has_no_part_in_them(tmp_path):
    # from y = 19.6 mm on, 0.1 mm beyond the last points, the left side is cut under G55, all that is probed under G54
    beside = SLAB.replace("G1 Y60. F600\n", "G1 Y19.6 F600\nG55\nG1 Y60.\n").replace("G55\nG0", "G54\nG0")
    scenario = slab(tmp_path, U_OFFSET, U_TOOL, BOTH_SIDES, beside)
    _, world, _ = finished_part(set_up(scenario))
    assert set(world.tool.run.labels["work_offset"]) == {"G54", "G55"}
    assert set(world.measuring.run.labels["work_offset"]) == {"G54"}
    exact = cut(scenario, engine="exact", trials=1000).own_reading.characteristics[0]
    assert exact.u == pytest.approx(6e-3, rel=0.07)


def test_a_side_that_two_work_offsets_share_is_not_probed_from_one(tmp_path):
    half = SLAB.replace("G1 Y60. F600\n", "G1 Y0. F600\nG55\nG1 Y60.\n")
    with pytest.raises(
        UsageError, match=r"feature left is cut under G54 and G55.* cut it under one work off"
    ):
        cut(slab(tmp_path, U_OFFSET, U_TOOL, BOTH_SIDES, half))
    found = cut(slab(tmp_path, "", U_TOOL, BOTH_SIDES, half))
    assert found.characteristics[0].u == pytest.approx(6e-3, rel=0.02)


def rows(*first: int) -> np.ndarray:
    """The same row of setting for X, Y and Z."""
    return np.repeat(np.array(first)[:, None], 3, axis=1)


def test_the_mean_of_the_angles_of_setting_is_taken_off():
    """One cut and three angles of setting: 10 - (1 + 2 + 6) / 3 = 7; responses likewise, where the draws are one."""
    zero = ZeroRows(rows(1, -1, -1, -1), count=3)
    errors = np.array([10.0, 1.0, 2.0, 6.0])[:, None] * [1.0, 0.0, 0.0]
    assert zero.off_errors(errors)[:, 0] == pytest.approx([7.0, 1.0, 2.0, 6.0])
    assert zero.off_response(errors[..., None], np.zeros(4, dtype=np.intp))[0, 0, 0] == pytest.approx(7.0)
    assert zero.off_response(errors[..., None], np.array([0, 1, 1, 1]))[0, 0, 0] == pytest.approx(10.0)


def test_x_and_y_come_from_one_row_of_setting_and_z_from_another():
    """Set with the first tool (row 1) in X and Y, with its own (row 2) in Z; what is drawn apart in Z stays."""
    zero = ZeroRows(np.array([[1, 1, 2], [-1] * 3, [-1] * 3]))
    errors = np.array([[10.0, 20.0, 30.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    assert zero.off_errors(errors)[0] == pytest.approx([9.0, 18.0, 24.0])
    codes = np.array([0, 0, 1], dtype=np.intp)
    assert zero.off_response(errors[..., None], codes)[0, :, 0] == pytest.approx([9.0, 18.0, 30.0])


def test_what_is_in_a_zero_turns_with_the_table():
    """Taken into the zero along X; the table has turned by 90 deg since, so it comes off along Y."""
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    zero = ZeroRows(rows(1, -1), turn=np.array([quarter, np.eye(3)]))
    errors = np.array([[5.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    assert zero.off_errors(errors)[0] == pytest.approx([5.0, -2.0, 0.0])


def test_draws_that_only_setting_has_count_as_nothing():
    """Copies: the cut has 0, its setting 1. The second belongs to the uncertainty of the zero."""
    one = Influence(
        Input("scale_factor", "X", "k", Normal(1.0)), np.ones((2, 3, 1)), ("a", "b"), np.array([0, 1])
    )
    drawn = Draws(one, np.ones((1, 2, 1)), np.array([[[3.0], [4.0]]]))
    quiet = ZeroRows(rows(1, -1)).quiet(drawn)
    assert quiet.departures.ravel() == pytest.approx([3.0, 0.0])


def test_rows_of_setting_are_at_rest():
    """The tool with an offset of 100 mm stands with its tip at Z -350, so the axis at -250; cold, unmoving, marked."""
    run = Run(
        {"X": np.array([1.0]), "Y": np.array([2.0]), "Z": np.array([3.0])}, np.array([[0.0, 0, -100.0]]),
        {"time_s": np.array([60.0]), "nz": np.array([0.0]), "temp_part_C": np.array([23.0])},
        {"tool": np.array(["7"]), "touch": np.array(["p"])},
    )  # fmt: skip
    at = np.array([[300.0, 250.0, -350.0]])
    rows = setting_rows(
        run, np.array([0]), np.array([[0.0, 0.0, -100.0]]), at, Pose(np.eye(3), np.array([300.0, 0, 0]))
    )
    assert [float(rows.position[a][0]) for a in "XYZ"] == [300.0, 250.0, -250.0]
    columns = {name: float(values[0]) for name, values in rows.columns.items()}
    assert columns["time_s"] == 0.0
    assert (columns["nz"], columns["temp_part_C"], columns["setting"]) == (1.0, 23.0, 1.0)
    assert columns["part_y_mm"] == 250.0
    assert (rows.labels["tool"][0], rows.labels["touch"][0]) == ("7", SETTING)
    assert join_runs(run.with_columns({n: np.zeros(1) for n in columns}), rows).n == 2


def test_ways_of_setting_differ_by_tool_not_by_point():
    labels = {"tool": np.array(["1", "2", "1"]), "touch": np.array(["a", "b", "c"])}
    run = Run({"X": np.zeros(3)}, np.zeros((3, 3)), {}, labels)
    first, number = ways_of_setting(run)
    assert first.tolist() == [0, 1]
    assert number.tolist() == [0, 1, 0]


TILTED = '[errors]\ntable = "errors.csv"\nstate = "raw"\n'
BORES = """%
O1
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-20. Y0 S3000 M3
G43 H1 Z5.
G1 Z-15. F200
G0 Z100.
T2 M6
G54 G0 X20. Y0 S3000 M3
G43 H2 Z5.
G1 Z-15. F200
G0 Z50.
M30
%
"""
PAIR = """\
one = { type = "cylinder", point = "-20 0 -12 mm", axis = [0, 0, 1], diameter = "20 mm", length = "10 mm", inside = true }
two = { type = "cylinder", point = "20 0 -12 mm", axis = [0, 0, 1], diameter = "10 mm", length = "10 mm", inside = true }
[[part.characteristics]]
name = "apart"
type = "distance"
between = ["one", "two"]
"""
TOOLS = '[tools.1]\nlength = "120 mm"\ndiameter = "20 mm"\n[tools.2]\nlength = "200 mm"\ndiameter = "10 mm"\n'


def bores(tmp_path, setup="", offset=""):
    """Two bores 40 mm apart in X, by tools of 120 and 200 mm, on a head tilted by 20 urad about B."""
    head = f'vcmm = "scenario/1"\nmachine = "mill.toml"\n[cut]\nprogram = "part.nc"\nsetup = "setup.toml"\n{offset}'
    (tmp_path / "errors.csv").write_text("Z EBZ\n-500 20e-6\n0 20e-6\n")
    table = setup + shop.SETUP[: shop.SETUP.index("[tools")] + TOOLS
    path = shop.write(
        tmp_path,
        TILTED,
        program=BORES,
        setup=table,
        scenario=f"{head}[part.features]\n{PAIR}[job]\ntrials = 1000\n",
    )
    return vcmm.load_cut(path)


@pytest.mark.parametrize("more", ["", "set_with = 2\n"])
def test_x_and_y_of_a_work_offset_come_from_the_tool_that_set_it(tmp_path, more):
    """The longer tool hangs 80 mm lower: -80 mm x 20 urad = -1.6 um in X, whichever tool set the zero."""
    (apart,) = cut(bores(tmp_path, more)).characteristics
    assert (apart.value - apart.nominal) * 1e3 == pytest.approx(-1.6, abs=0.01)


def test_which_tool_set_the_offset_says_which_bore_is_off_its_place(tmp_path):
    by_first, by_second = (surface_of(bores(tmp_path, more), "one") for more in ("", "set_with = 2\n"))
    # set with the tool that drills it, only the lean of the tool is left: 20 urad over at most 12.9 mm, 0.258 um
    assert np.abs(by_first).max() * 1e3 == pytest.approx(0.258, abs=1e-3)
    # set with the tool of 200 mm, the bore of the tool of 120 mm stands +1.6 um in X
    assert np.abs(by_second - by_first).max() * 1e3 == pytest.approx(1.6, abs=1e-3)


def surface_of(scenario, feature):
    """How far the surface of a feature is moved by errors of the machine (n,) mm."""
    ready = set_up(scenario)
    found = patch(ready, net(scenario.part.features[feature], 9))
    return found.height - found.nominal


def test_a_tool_that_set_the_offset_must_be_known(tmp_path):
    with pytest.raises(DataError, match=r"setup.toml:1: tool 7 is not in the set-up"):
        bores(tmp_path, "set_with = 7\n")
