"""A program that probes its own zero: what the machine errs by at the touch goes into all that follows, by hand."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.shop.machining.job import cut, finished_part
from vcmm.shop.machining.placement import place_cut
from vcmm.shop.machining.preparation import set_up

PROBED = """%
O1
G21 G17 G40 G49 G80 G90 G94
T9 M6
G54 G0 X-80. Y0.
G43 H9 Z20.
Z-6.
G31 X-40. F100.
#5221=#5221+#5061+53.
G0 X-80.
Z20.
T1 M6
G0 X-80. Y-60. S3000 M3
G43 H1 Z20.
Z-10.
G1 X-58. F600.
Y60.
X-80.
G0 Z50.
M30
%
"""
SETUP = """\
vcmm = "setup/1"
dialect = "fanuc"
[offsets]
G54 = ["300 mm", "250 mm", "-350 mm"]
[tools.1]
length = "100 mm"
diameter = "20 mm"
[tools.9]
length = "150 mm"
diameter = "6 mm"
shape = "probe"
[stock]
box = ["100 mm", "80 mm", "40 mm"]
"""
SCENARIO = """\
vcmm = "scenario/1"
machine = "mill.toml"
[cut]
program = "part.nc"
setup = "setup.toml"
[part.features]
wall = { type = "plane", point = "-48 0 -8 mm", normal = [-1, 0, 0], size = "40 2 mm" }
[[part.characteristics]]
name = "flatness"
type = "flatness"
of = "wall"
zone = "0.02 mm"
[job]
trials = 1000
"""
LEAN = '[[effects]]\neffect = "squareness"\npair = "B0Z"\nangle = "20 urad"\n'
LONG = '[[effects]]\neffect = "scale_factor"\naxis = "X"\nk = "100 um/m"\n'
KNOWN = '[[inputs]]\neffect = "squareness"\npair = "B0Z"\nparameter = "angle"\nu = "5 urad"\n'


def files(folder, machine="", program=PROBED, scenario=SCENARIO, setup=SETUP):
    return vcmm.load_cut(shop.write(folder, machine, scenario, program, setup))


def moved(scenario) -> np.ndarray:
    """Error (um, 3) of the tool at the cut wall."""
    world = finished_part(set_up(scenario))[1]
    rows = world.tool.errors()[: len(world.contacts.row[:, 0])]
    return rows.mean(axis=0) * 1e3


@pytest.mark.thorough
def test_what_leans_between_probe_and_cutter_stays(tmp_path):
    # Z stands at -356 + 150 = -206 (ball centre 3 above: -203 of the tip that is asked) while probing, at -360 + 100 = -260 while
    # cutting. B0Z = 20 urad leans X by 20e-6 Z of the axis: 20e-6 (-260 + 206) = -1.08 um
    assert moved(files(tmp_path, LEAN))[0] == pytest.approx(-1.08, abs=0.002)


def test_a_scale_counts_from_the_touch(tmp_path):
    # touched with X at 247, cut with X at 242: 100 um/m over -5 mm
    assert moved(files(tmp_path, LONG))[0] == pytest.approx(-0.5, abs=0.002)


def test_without_probing_it_counts_from_the_zero(tmp_path):
    # the zero at X = 300, the cut at 242: -5.8 um
    plain = PROBED.replace("G31 X-40. F100.\n#5221=#5221+#5061+53.\n", "")
    assert moved(files(tmp_path, LONG, plain))[0] == pytest.approx(-5.8, abs=0.002)


def test_probing_from_elsewhere_sets_what_was_not_set_here(tmp_path):
    away = SCENARIO.replace(
        'setup = "setup.toml"', 'setup = "setup.toml"\nwork_offset = { set_on = "elsewhere" }'
    )
    assert moved(files(tmp_path, LONG, scenario=away))[0] == pytest.approx(-0.5, abs=0.002)


def test_the_mean_of_two_touches_has_half_of_each(tmp_path):
    # the middle between -53 and 53 becomes X0: 247 and 353 were touched, mean 300; the cut at 242: -5.8 um
    both = PROBED.replace(
        "#5221=#5221+#5061+53.\n",
        "#101=#5061\nG0 X-80.\nZ20.\nX80.\nZ-6.\nG31 X40. F100.\n#5221=#5221+[#101+#5061]/2.\nG0 X80.\nZ20.\n",
    )
    assert moved(files(tmp_path, LONG, both))[0] == pytest.approx(-5.8, abs=0.002)


def test_a_uniform_error_is_taken_off_and_the_draws_too(tmp_path):
    scenario = files(tmp_path, LEAN + KNOWN)
    world = finished_part(set_up(scenario))[1]
    found = next(f for f in world.influences() if "B0Z" in f.input.id)
    # d wall / d angle = -54 mm per rad along x, its normal -x: +54 mm
    out = np.einsum("nik,ni->nk", found.response, world.measuring.task.touches.run.normal)
    assert out[:, 0] == pytest.approx(np.full(len(out), 54.0), abs=0.05)
    result = cut(scenario)
    assert result.uncertainty.characteristics[0].u < 1e-4


def test_the_probe_cuts_nothing(tmp_path):
    job = set_up(files(tmp_path))
    assert {t.radius for t in job.sweep.tools} == {10.0}
    assert job.blank is not None
    assert job.blank.collisions == ()


def test_a_program_that_branches_on_what_it_finds_is_refused(tmp_path):
    asks = PROBED.replace("#5221=#5221+#5061+53.\n", "IF[#5061 GT -53.] GOTO 90\nG0 X-75.\nN90 G0 X-80.\n")
    with pytest.raises(ModelLimit, match=r"line 8 probes, and the program goes another way"):
        cut(files(tmp_path, program=asks))


def test_what_is_not_modelled_is_refused(tmp_path):
    with pytest.raises(ModelLimit, match="line 8 of the program probes where the part lies"):
        place_cut(files(tmp_path))
    with pytest.raises(ModelLimit, match="line 8 of the program probes them"):
        cut(
            files(
                tmp_path,
                scenario=SCENARIO
                + '[inspection]\nmachine = "same"\n[plan]\nstyli.a = { offset = "0 0 -50 mm", tip_diameter = "2 mm" }\n[[plan.steps]]\nfeature = "wall"\nstylus = "a"\npoints = { strategy = "grid", n = [3, 3], margin = "0.5 mm" }\n',
            )
        )
    files(tmp_path, setup=SETUP + "[control]\ncompensation = []\n")
    with pytest.raises(ModelLimit, match=r"part.nc:8: the program probes"):
        vcmm.compensate(
            tmp_path / "part.nc", tmp_path / "setup.toml", vcmm.load_machine(tmp_path / "mill.toml")
        )


def test_surfaces_in_the_set_up_are_checked(tmp_path):
    bad = (
        SETUP
        + '[[surfaces]]\npoint = "0 0 0 mm"\n[[surfaces]]\npoint = "0 0 0 mm"\nnormal = [0, 0, 1]\noffset = "G58"\n'
    )
    with pytest.raises(DataError, match=r"setup.toml:\d+: .*plane \(point and normal\)"):
        files(tmp_path, setup=bad)
    with pytest.raises(DataError, match="needs the diameter of its ball"):
        files(tmp_path, setup=SETUP.replace('diameter = "6 mm"\n', ""))


def test_a_zero_that_the_program_types_was_set_by_hand(tmp_path):
    typed = PROBED.replace("#5221=#5221+#5061+53.\n", "").replace("T9 M6\n", "#5221=300.\nT9 M6\n")
    assert moved(files(tmp_path, LONG, typed))[0] == pytest.approx(-5.8, abs=0.002)


def test_a_touch_errs_as_at_its_moment_and_in_its_part(tmp_path):
    """A drift of 3.6 um/h takes 0.001 um/s: between touch and cut of one part some 20 s pass, in the eleventh as in the first."""
    drift = '[[effects]]\neffect = "linear_drift"\ndirection = "x"\nc = "3.6 um/h"\n'
    eleventh = SCENARIO.replace('setup = "setup.toml"', 'setup = "setup.toml"\nbatch_part = 11')
    first, later = moved(files(tmp_path, drift))[0], moved(files(tmp_path, drift, scenario=eleventh))[0]
    assert 0.0 < abs(first) < 0.045
    assert later == pytest.approx(first, abs=1e-6)


def told(folder, text, program=PROBED, setup=SETUP):
    """u (um) of the place of the wall from one entry of [cut] tools, and of work_offset; nothing else is uncertain."""
    said = SCENARIO.replace('setup = "setup.toml"', f'setup = "setup.toml"\n{text}')
    world = finished_part(set_up(files(folder, program=program, scenario=said, setup=setup)))[1]
    normal = world.measuring.task.touches.run.normal
    per = [np.einsum("nik,ni->nk", f.response, normal)[0] for f in world.influences()]
    return {f.input.effect: abs(float(p[0])) for f, p in zip(world.influences(), per)}


def test_what_the_probe_errs_by_goes_into_what_it_sets(tmp_path):
    # one touch sets X: its scatter and the radius of its ball go into the wall as they are; a zero that was set by hand does not
    found = told(
        tmp_path,
        'work_offset = { u = "5 um" }\n[cut.tools]\n9 = { u_touch = "0.5 um", u_radius = "1 um", u_length = "2 um" }\n1 = { u_radius = "1 um" }\n',
    )
    assert found["probe_touch"] == pytest.approx(1.0, abs=1e-9)
    assert found["tool_radius"] == pytest.approx(1.0, abs=1e-9)
    assert found["tool_length"] == pytest.approx(0.0, abs=1e-9)
    assert found["work_offset"] == pytest.approx(0.0, abs=1e-9)


def test_an_offset_that_is_probed_under_another_needs_no_hand(tmp_path):
    other = PROBED.replace(
        "#5221=#5221+#5061+53.\n", "#5241=#5221+#5061+53.\n#5242=#5222\n#5243=#5223\n"
    ).replace("G43 H1 Z20.", "G55 G43 H1 Z20.")
    found = told(
        tmp_path,
        'work_offset = { u = "5 um" }',
        other,
        SETUP.replace("[tools.1]", 'G55 = ["290 mm", "240 mm", "-350 mm"]\n[tools.1]'),
    )
    assert found["work_offset"] == pytest.approx(0.0, abs=1e-9)


BOTH = PROBED.replace(
    "#5221=#5221+#5061+53.\n",
    "#101=#5061\nG0 X-80.\nZ20.\nX80.\nZ-6.\nG31 X40. F100.\n#5221=#5221+[#101+#5061]/2.\nG0 X80.\nZ20.\n",
)


def test_the_mean_of_two_touches_scatters_less_and_its_ball_does_not_count(tmp_path):
    world = finished_part(
        set_up(
            files(
                tmp_path,
                program=BOTH,
                scenario=SCENARIO.replace(
                    'setup = "setup.toml"',
                    'setup = "setup.toml"\n[cut.tools]\n9 = { u_touch = "0.5 um", u_radius = "1 um" }\n',
                ),
            )
        )
    )[1]
    normal = world.measuring.task.touches.run.normal
    found = [float(np.einsum("nik,ni->nk", f.response, normal)[0, 0]) for f in world.influences()]
    names = [f.input.effect for f in world.influences()]
    touches = sorted(abs(v) for v, n in zip(found, names) if n == "probe_touch")
    assert touches == pytest.approx([0.5, 0.5], abs=1e-9)  # u = 0.35 um together
    assert [v for v, n in zip(found, names) if n == "tool_radius"] == pytest.approx([0.0], abs=1e-9)


def test_a_scatter_of_a_tool_that_does_not_probe_is_refused(tmp_path):
    said = SCENARIO.replace(
        'setup = "setup.toml"', 'setup = "setup.toml"\n[cut.tools]\n1 = { u_touch = "1 um" }\n'
    )
    with pytest.raises(UsageError, match=r"tools\.1\.u_touch: .* does not probe with tool 1"):
        set_up(files(tmp_path, scenario=said))


def test_a_surface_that_no_set_up_states_stays_where_it_is(tmp_path):
    # P9811 twice on a face that nothing states: the second touch finds what the first set; only the second counts, the zero by hand not
    bare = SETUP[: SETUP.index("[stock]")]
    twice = PROBED.replace(
        "G31 X-40. F100.\n#5221=#5221+#5061+53.\n", "G65 P9811 X-50. S1.\nG65 P9811 X-50. S1.\n"
    )
    job = set_up(files(tmp_path, LONG, program=twice, setup=bare))
    assert moved(job.scenario)[0] == pytest.approx(-0.5, abs=0.002)
    last = job.touched_zero.weight[-3, 1]  # G1 Y60: X follows the second touch alone
    assert last[0] == pytest.approx([0.0, 1.0], abs=1e-6)
    assert not job.touched_zero.is_held[-3, 0]


def test_an_arc_whose_radius_follows_a_touch_grows_with_it(tmp_path):
    # the half circle about X0 Y0 from (-R, 0) to (R, 0) with R = -#5061: 1 mm less per mm that the touch reads further
    round_ = PROBED.replace("#5221=#5221+#5061+53.\n", "#101=-#5061\n").replace(
        "G1 X-58. F600.\nY60.\nX-80.\n", "G1 X-#101 Y0. F600.\nG2 X#101 Y0. I#101 J0.\nG1 X80.\n"
    )
    touched = set_up(files(tmp_path, program=round_)).touched_zero
    number = next(iter(touched.arcs))
    weight = touched.at(np.full(3, number), np.array([0.0, 0.5, 1.0]))[:, :, 0]
    # from the left over the top to the right: inward by 1 at each
    assert weight == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]), abs=1e-6)


def test_the_scatter_of_touches_stands_in_the_budget(tmp_path):
    said = SCENARIO.replace(
        'setup = "setup.toml"', 'setup = "setup.toml"\n[cut.tools]\n9 = { u_touch = "0.5 um" }\n'
    )
    found = cut(files(tmp_path, program=BOTH, scenario=said))
    names = {line.input for line in found.uncertainty.characteristics[0].budget}
    assert {"probe_touch[1].shift", "probe_touch[2].shift"} <= names


ALIGNED = """G17 G71 G90 G94 G54
T9 D1
M6
G0 X-80 Y-20
Z-6
CYCLE998(105,9000,0,1,-50,0,,40,5,201,0,40)
G0 Z20
T1 D1
M6
S3000 M3
G0 X-80 Y-60
Z-10
G1 X-58 F600
Y60
X-80
G0 Z50
M30
"""


def test_a_zero_turned_by_an_edge_takes_the_squareness_into_the_part(tmp_path):
    # C0Y = 50 urad leans the path of Y by 2 um over 40 mm of wall; the edge was measured along the same path: nothing is left of it
    setup = SETUP.replace('"fanuc"', '"sinumerik"')
    skew = '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "50 urad"\n'
    slopes = []
    for program in (ALIGNED, ALIGNED.replace("CYCLE998(105", "CYCLE998(5")):
        world = finished_part(set_up(files(tmp_path, skew, program=program, setup=setup)))[1]
        rows = world.contacts.row[:, 0]
        y, x = world.measuring.task.touches.points[:, 1], world.tool.errors()[rows, 0] * 1e3
        slopes.append(abs(np.polyfit(y, x, 1)[0]) * 40.0)
    assert slopes == pytest.approx([0.0, 2.0], abs=1e-3)
