"""A program that probes its own zero: what the machine errs by at the touch goes into all that follows, by hand."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.machining import shop
from vcmm.core.errors import DataError, ModelLimit
from vcmm.machining.job import cut, finished_part
from vcmm.machining.placement import place_cut
from vcmm.machining.preparation import set_up

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
