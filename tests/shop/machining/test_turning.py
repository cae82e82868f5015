"""Errors of a lathe on a turned part, each with its number by hand. Signs: actual - commanded; material left is plus.

A point of a cylinder is cut by the side of the nose: its imaginary tip, which the slide carries, stands the nose radius, 0.8 mm,
further along, to half a feed of 0.05 mm: BESIDE. At a face the same holds of X.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import vcmm
from tests.shop.machining import lathe
from tests.shop.machining.lathe import effect
from vcmm.shop.machining.job import cut, finished_part
from vcmm.shop.machining.preparation import set_up

UM = 1e-3
NOSE, BESIDE = 0.8, 0.026


def angle(points: np.ndarray) -> np.ndarray:
    return np.arctan2(points[:, 1], points[:, 0])


def test_z_slide_out_of_parallel_with_the_spindle_tapers_a_cylinder(tmp_path):
    machine = effect("squareness", pair="B0Z", angle="50 urad")
    found, points = lathe.moved(lathe.shop(lathe.write(tmp_path, machine)), "seat")
    # B0Z = +b shifts the tip by (b z, 0, 0); the tool was set at the front, z = 0 of the part:
    # at z = -80 the radius is 50e-6 x -80.8 = -4.04 um, at z = -70 -3.54 um: 1 um of diameter per 10 mm
    assert found == pytest.approx(50e-6 * (points[:, 2] - NOSE), abs=50e-6 * BESIDE)


def test_x_slide_out_of_square_with_the_spindle_makes_a_cone_of_a_face(tmp_path):
    machine = effect("squareness", pair="B0X", angle="50 urad")
    found, points = lathe.moved(lathe.shop(lathe.write(tmp_path, machine)), "step")
    r = np.hypot(points[:, 0], points[:, 1])
    # X turned about Y by b: e_z = -b x; at r = 12 mm -50e-6 x 11.2 = -0.56 um, at 14.9 mm -0.705 um: a flatness of 0.145 um
    assert found == pytest.approx(-50e-6 * (r - NOSE), abs=50e-6 * BESIDE)


def test_straightness_of_z_appears_once_in_the_radius(tmp_path):
    machine = effect("component_polynomial", component="EXZ", coefficients='["0 um", "0 um", "100 um"]')
    found, points = lathe.moved(lathe.shop(lathe.write(tmp_path, machine)), "journal")
    # axis Z stands at 200 + 60 (tool length) + z: EXZ(z) = 100 um ((260 + z) / 1000)^2, set at z = 0: 6.76 um taken off
    # at z = -20: 100 x 0.2392^2 = 5.722 um, so -1.038 um
    at = (260 + points[:, 2] - NOSE) / 1000
    assert found == pytest.approx(0.1 * (at**2 - 0.26**2), abs=0.1 * 2 * 0.26 * BESIDE / 1000)


def test_a_scale_of_x_counts_from_where_the_tool_was_set(tmp_path):
    machine = effect("scale_factor", axis="X", k="50 um/m")
    scenario = lathe.SCENARIO.replace(
        'setup = "setup.toml"', 'setup = "setup.toml"\nwork_offset = { at = "20 0 150 mm" }'
    )
    ready = lathe.shop(lathe.write(tmp_path, machine, scenario=scenario))
    # trial cut of radius 20: nothing there, at radius 10 50e-6 x (10 - 20) = -0.5 um
    assert lathe.moved(ready, "seat")[0] == pytest.approx(0.0, abs=1e-9)
    assert lathe.moved(ready, "journal")[0] == pytest.approx(-0.5 * UM, abs=1e-8)


def test_a_radial_error_counts_twice_in_the_diameter(tmp_path):
    scenario = lathe.SCENARIO.replace(
        "[part.features]", '[cut.tools.1]\nu_offset_x = "5 um"\n[part.features]'
    )
    found = cut(vcmm.load_cut(lathe.write(tmp_path, scenario=scenario)), engine="montecarlo")
    size = found.characteristics[0]
    # u of the radius 5 um -> u of the diameter 10 um; feed marks add twice f^2 / 24 r = 0.26 um to the mean
    assert size.u == pytest.approx(10 * UM, rel=1e-4)
    assert size.value - 40.0 == pytest.approx(0.26 * UM, abs=0.03 * UM)
    assert found.shares["diameter"]["tool"] == pytest.approx(1.0, abs=1e-4)


def shifted(ready, **shifts):
    """The shop with effects of setting moved: tool_offset x and y, tool_length, tool_radius of tool 1, mm."""
    from dataclasses import replace

    from vcmm.physics.structure.setting import ToolLength, ToolOffset, ToolRadius

    made = {
        "x": lambda v: ToolOffset("1", "x", v), "y": lambda v: ToolOffset("1", "y", v),
        "length": lambda v: ToolLength("1", v), "radius": lambda v: ToolRadius("1", v),
    }  # fmt: skip
    machine = replace(ready.machine, effects=tuple(made[k](v) for k, v in shifts.items()))
    return lathe.on_machine(ready, machine)


def test_a_tool_that_stands_out_cuts_deeper(tmp_path):
    ready = shifted(lathe.shop(lathe.write(tmp_path)), x=5 * UM)
    # 5 um nearer to the axis: radius -5 um (diameter -10 um); a face does not see it
    assert lathe.moved(ready, "seat")[0] == pytest.approx(-5 * UM, abs=1e-8)
    assert np.abs(lathe.moved(ready, "step")[0]).max() < 0.4 * UM  # feed marks pass by, nothing else
    assert lathe.moved(ready, "step")[0].mean() == pytest.approx(0.0, abs=0.02 * UM)


def test_tool_length_moves_faces_and_tapers(tmp_path):
    ready = shifted(lathe.shop(lathe.write(tmp_path)), length=5 * UM)
    # 5 um longer: the face lies 5 um deeper; a taper of 5.71 deg by 5 um x tan = 0.5 um in radius, 0.4975 um along its normal
    assert lathe.moved(ready, "step")[0] == pytest.approx(-5 * UM, abs=1e-8)
    taper = lathe.moved(ready, "taper")[0].mean()
    assert taper == pytest.approx(-5 * UM * math.sin(math.radians(5.71059)), abs=0.02 * UM)


def test_a_larger_nose_leaves_cylinders_and_faces_alone(tmp_path):
    ready = shifted(lathe.shop(lathe.write(tmp_path)), radius=10 * UM)
    assert lathe.moved(ready, "seat")[0].mean() == pytest.approx(0.0, abs=0.05 * UM)
    assert lathe.moved(ready, "step")[0].mean() == pytest.approx(0.0, abs=0.05 * UM)
    # set at its imaginary tip the centre goes back by dr in x and z: on the taper (n = cos a, sin a), a = 5.7106 deg, material is
    # left by dr (cos a + sin a - 1) = 10 (0.995037 + 0.099504 - 1) = 0.945 um; on the ball at 45 deg by 4.142 um
    assert lathe.moved(ready, "taper")[0].mean() == pytest.approx(0.945 * UM, abs=0.05 * UM)
    found, points = lathe.moved(ready, "ball")
    slope = np.arctan2(points[:, 2] + 10, np.hypot(points[:, 0], points[:, 1]))
    assert found == pytest.approx(10 * UM * (np.cos(slope) + np.sin(slope) - 1), abs=0.4 * UM)


def test_height_of_the_tool_is_of_second_order(tmp_path):
    ready = shifted(lathe.shop(lathe.write(tmp_path)), y=0.1)
    # sqrt(20^2 + 0.1^2) - 20 = 0.25 um on the seat, sqrt(10^2 + 0.1^2) - 10 = 0.50 um on the journal
    assert lathe.moved(ready, "seat")[0] == pytest.approx(0.25 * UM, abs=1e-7)
    assert lathe.moved(ready, "journal")[0] == pytest.approx(0.50 * UM, abs=1e-7)


def test_error_motion_of_the_spindle_copies_to_the_form(tmp_path):
    """Two waves per turn in the direction of the tool: the work comes towards it by a cos 2C, so the radius lacks a cos 2C."""
    machine = effect("rotary_cyclic", component="EXC", coefficients='["0 um", "0 um", "1 um", "0 um"]')
    found, points = lathe.moved(lathe.shop(lathe.write(tmp_path, machine)), "seat")
    assert found == pytest.approx(-1 * UM * np.cos(2 * angle(points)), abs=1e-7)


def test_error_motion_once_per_turn_makes_no_form_but_a_shift(tmp_path):
    """r = R - a cos C is a circle about (-a, 0) to a^2 / 4 R = 0.1 nm: the feature has no roundness, only another axis."""
    machine = effect("rotary_cyclic", component="EXC", coefficients='["3 um", "0 um"]')
    found, points = lathe.moved(lathe.shop(lathe.write(tmp_path, machine)), "seat")
    phi = angle(points)
    assert found == pytest.approx(-3 * UM * np.cos(phi), abs=1e-7)
    x, y = (20 + found) * np.cos(phi), (20 + found) * np.sin(phi)
    r = np.hypot(x + 3 * UM, y)
    assert np.ptp(r) < 0.3e-6 * 1.5  # a^2 / 2 R = 0.225 nm and rounding
    assert r.mean() == pytest.approx(20.0, abs=1e-6)


def test_error_motion_across_the_tool_is_not_seen(tmp_path):
    machine = effect("rotary_cyclic", component="EYC", coefficients='["0 um", "0 um", "10 um", "0 um"]')
    found, _ = lathe.moved(lathe.shop(lathe.write(tmp_path, machine)), "seat")
    # not in the sensitive direction: 0.01^2 / 40 = 2.5 nm at most
    assert found.min() >= 0
    assert found.max() == pytest.approx(0.01**2 / 40, rel=1e-3)


def test_axial_motion_of_the_spindle_tilts_a_face_and_leaves_cylinders(tmp_path):
    machine = effect("rotary_cyclic", component="EZC", coefficients='["2 um", "0 um"]')
    ready = lathe.shop(lathe.write(tmp_path, machine))
    found, points = lathe.moved(ready, "step")
    # the work goes 2 um cos C towards +Z while that side is cut, so as much more is taken off it, whatever the radius
    assert found == pytest.approx(-2 * UM * np.cos(angle(points)), abs=1e-7)
    assert np.abs(lathe.moved(ready, "seat")[0]).max() < 0.13 * UM  # feed marks move by 2 um of 50


def test_errors_of_the_moving_frame_turn_with_the_work(tmp_path):
    """A constant EXC in the moving frame is a work that is clamped beside the axis: nothing shows, it is cut about the spindle."""
    machine = effect("rotary_location", component="X0C", offset="10 um")
    found, _ = lathe.moved(lathe.shop(lathe.write(tmp_path, machine)), "seat")
    # the centre line of the spindle lies 10 um nearer to the tool: the trial cut has taken that into the offset of the tool
    assert np.abs(found).max() < 1e-7


def test_a_lathe_whose_spindle_is_no_axis(tmp_path):
    base = lathe.MACHINE.replace("w C' b Z X t", "w b Z X t").split("[axes.C]")[0]
    machine = effect("squareness", pair="B0Z", angle="50 urad")
    found, points = lathe.moved(lathe.shop(lathe.write(tmp_path, machine, base=base)), "seat")
    assert found == pytest.approx(50e-6 * (points[:, 2] - NOSE), abs=50e-6 * BESIDE)


def test_linear_model_and_exact_trials_agree(tmp_path):
    inputs = '[[inputs]]\neffect = "squareness"\npair = "B0Z"\nparameter = "angle"\nu = "20 urad"\n'
    machine = effect("squareness", pair="B0Z", angle="50 urad") + inputs
    scenario = lathe.SCENARIO.replace(
        "[part.features]", '[cut.tools.1]\nu_offset_x = "3 um"\n[part.features]'
    )
    ready = set_up(vcmm.load_cut(lathe.write(tmp_path, machine, scenario=scenario)))
    task, world, _ = finished_part(ready)
    first = {f.input.id: f for f in world.influences()}
    z = task.touches.points[:, 2]
    n = task.touches.run.normal
    slope = np.einsum("pik,pi->p", first["squareness[B0Z].angle"].response, n)
    assert slope == pytest.approx(z - NOSE, abs=BESIDE)  # d radius / d angle = z of the tip
    shift = np.einsum("pik,pi->p", first["tool_offset[1,x].shift"].response, n)
    assert shift == pytest.approx(-1.0, abs=1e-9)
    found = cut(ready.scenario, trials=1000, engine="exact").characteristics[0]
    # u: 2 x 3 um of the tool, and 2 x 20e-6 x 80 = 3.2 um of the angle at the middle of the seat: 6.8 um
    assert found.u == pytest.approx(6.8 * UM, rel=0.12)
