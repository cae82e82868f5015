"""Every sign and frame of docs/conventions.md by a number made by hand. One error at a time, mm and rad inside."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.effect import Effect
from vcmm.core.kinematics import Axis, nominal_tip, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.core.units import quantity
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.probe import TriggerDelay
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.expansion import PartExpansion, ScaleExpansion
from vcmm.physics.structure.squareness import RotaryLocation, Squareness
from vcmm.physics.structure.tip import TipRadius

UM, URAD = 1e-3, 1e-6
CMM = "w b Y X Z t"


def machine(structure: str, *effects: Effect, **axes: dict) -> Machine:
    chain = parse_structure(structure)
    travel = {a: (-np.pi, np.pi) if a in "ABC" else (-1000.0, 1000.0) for a in chain.letters}
    return Machine(
        "m", "cmm", chain, {a: Axis(a, travel[a], **axes.get(a, {})) for a in chain.letters}, effects
    )


def one_row(offset=(0.0, 0.0, 0.0), columns=None, **position: float) -> Run:
    columns = {name: np.array([value]) for name, value in (columns or {}).items()}
    return Run({a: np.array([q]) for a, q in position.items()}, np.array([offset]), columns)


def constant(component: str, value: float) -> ComponentTable:
    return ComponentTable(
        component, (component[2],), (np.array([-1000.0, 1000.0]),), np.array([value, value])
    )


def test_units_are_converted_at_the_border():
    assert quantity("0.8 um", "length") == pytest.approx(0.0008)
    assert quantity("3 arcsec", "angle") == pytest.approx(3 * np.pi / 180 / 3600)
    assert quantity("8.0 um/(m K)", "expansion") == pytest.approx(8e-6)  # 8e-3 mm per 1e3 mm and K
    assert quantity("2 um/m^2", "curvature") == pytest.approx(2e-9)  # 2e-3 mm / 1e6 mm^2
    assert quantity("21.2 degC", "temperature") == pytest.approx(21.2)


def test_a_primed_axis_is_commanded_in_tool_relative_sense():
    run = one_row(X=10.0, Y=20.0, Z=30.0)
    for structure in ("w b X Y Z t", "w X' Y' b Z t", "w Z' Y' X' b t"):
        m = machine(structure)
        assert nominal_tip(m.chain, m.axes, run)[0] == pytest.approx([10.0, 20.0, 30.0])


def test_errors_of_a_table_are_those_of_its_own_motion():
    # the table stands 1 um too far in +x, so seen from the workpiece the tip stands at -1 um
    run = one_row(X=10.0, Y=20.0, Z=30.0)
    assert machine("w X' b Y Z t", constant("EXX", 1 * UM)).tip_error(run)[0] == pytest.approx(
        [-1 * UM, 0, 0]
    )
    assert machine("w b X Y Z t", constant("EXX", 1 * UM)).tip_error(run)[0] == pytest.approx([1 * UM, 0, 0])


@pytest.mark.parametrize("structure", ["w b X Y Z t", "w Z' Y' X' b t", "w Y' b X Z t"])
@pytest.mark.parametrize(
    ("pair", "tip"),
    [  # 10 urad; y = 200 mm, z = -100 mm
        ("C0Y", (-10 * URAD * 200, 0, 0)),
        ("B0Z", (10 * URAD * -100, 0, 0)),
        ("A0Z", (0, -10 * URAD * -100, 0)),
    ],
)
def test_squareness_turns_the_direction_of_travel_only(structure, pair, tip):
    run = one_row(offset=(5.0, 6.0, -150.0), X=300.0, Y=200.0, Z=-100.0)
    assert machine(structure, Squareness(pair, 10 * URAD)).tip_error(run)[0] == pytest.approx(tip, abs=1e-15)


def test_rotations_act_through_the_lever_arm():
    # EAX = 10 urad (roll of X about X), tip 150 mm below and 40 mm in front of the X slide: r x p
    # = (10e-6, 0, 0) x (0, -40, -150) = (0, +150 x 10e-6, -40 x 10e-6) = (0, +1.5 um, -0.4 um)
    run = one_row(offset=(0.0, -40.0, -150.0), X=100.0, Y=0.0, Z=0.0)
    tip = machine("w b Y X Z t", constant("EAX", 10 * URAD)).tip_error(run)[0]
    assert tip == pytest.approx([0.0, 1.5 * UM, -0.4 * UM], abs=1e-15)


def test_the_arm_counts_from_the_point_where_translations_were_measured():
    # EBX = 10 urad, tip at z = -150 mm, reflector at z = -120 mm: arm -30 mm, 10e-6 x (-30) = -0.3 um, not -1.5 um
    run = one_row(offset=(0.0, 0.0, -150.0), X=100.0, Y=0.0, Z=0.0)
    reflector = machine(CMM, constant("EBX", 10 * URAD), X={"measured_at": (0.0, 0.0, -120.0)})
    assert reflector.tip_error(run)[0] == pytest.approx([-0.3 * UM, 0, 0], abs=1e-15)
    assert machine(CMM, constant("EBX", 10 * URAD)).tip_error(run)[0] == pytest.approx(
        [-1.5 * UM, 0, 0], abs=1e-15
    )


def test_rotary_location_moves_the_centre_line():
    head, table = (
        machine("w b X Z B t", RotaryLocation("X0B", 2 * UM)),
        machine("w C' b X Z t", RotaryLocation("X0C", 2 * UM)),
    )
    assert head.tip_error(one_row(X=0.0, Z=0.0, B=0.0))[0] == pytest.approx([2 * UM, 0, 0])
    assert table.tip_error(one_row(X=0.0, Z=0.0, C=0.0))[0] == pytest.approx([-2 * UM, 0, 0])


def test_moving_and_fixed_error_frames():
    # a table turned by 90 deg; its radial error +1 um along x. Moving frame: x of the table, so x of the workpiece.
    # Fixed frame: x of the room; the table is turned by -90 deg, so the room's x is y of the workpiece.
    error = constant("EXC", 1 * UM)
    run = one_row(X=0.0, Z=0.0, C=np.pi / 2)
    moving, fixed = machine("w C' b X Z t", error), machine("w C' b X Z t", error, C={"error_frame": "fixed"})
    assert moving.tip_error(run)[0] == pytest.approx([-1 * UM, 0, 0], abs=1e-15)
    assert fixed.tip_error(run)[0] == pytest.approx([0, -1 * UM, 0], abs=1e-15)


def test_measuring_is_the_negative_of_the_tip_error():
    run = one_row(X=10.0, Y=20.0, Z=30.0)
    m = machine(CMM, constant("EXX", 1 * UM))
    assert m.tip_error(run)[0] == pytest.approx([1 * UM, 0, 0])  # machining: actual - commanded
    assert m.indication_error(run)[0] == pytest.approx([-1 * UM, 0, 0])  # measuring: indicated - true


def test_readings_are_indicated_minus_true_along_the_outward_normal():
    touch = {"nx": 0.0, "ny": 0.0, "nz": 1.0}
    run = one_row(columns=touch, X=10.0, Y=20.0, Z=30.0)
    large = machine(CMM, TipRadius(dr=1 * UM))  # a ball larger than believed: the surface seems to stand out
    assert large.indication_error(run)[0] == pytest.approx([0, 0, 1 * UM])
    assert large.tip_error(run)[0] == pytest.approx([0, 0, 0])
    # approaching with 5 mm/s against the normal, latched 0.2 ms late: 5 x 0.0002 = 1 um too little material
    speed = {"speed_X_mm_s": 0.0, "speed_Y_mm_s": 0.0, "speed_Z_mm_s": -5.0}
    late = machine(CMM, TriggerDelay(delay=2e-4))
    moving = one_row(columns=touch | speed, X=10.0, Y=20.0, Z=30.0)
    assert late.indication_error(moving)[0] == pytest.approx([0, 0, -1 * UM])


def test_backlash_stops_the_axis_short_of_its_target():
    # gap 1 um, arriving in + direction: half the gap short, -0.5 um; in - direction +0.5 um
    for sense, tip in ((1.0, -0.5 * UM), (-1.0, 0.5 * UM)):
        run = one_row(columns={"sense_X": sense}, X=10.0, Y=0.0, Z=0.0)
        assert machine(CMM, Backlash("X", 1 * UM)).tip_error(run)[0] == pytest.approx([tip, 0, 0])


def test_a_warm_scale_travels_too_far_and_a_warm_part_is_indicated_larger():
    # scale: 8e-6 /K x 1 K x 500 mm = +4 um of tip error, so -4 um indicated; part: 11.5e-6 x 2 K x 100 mm = +2.3 um
    run = one_row(columns={"temp_scale_x_C": 21.0}, X=500.0, Y=0.0, Z=0.0)
    scale = machine(CMM, ScaleExpansion("X", 8e-6))
    assert scale.tip_error(run)[0] == pytest.approx([4 * UM, 0, 0])
    assert scale.indication_error(run)[0] == pytest.approx([-4 * UM, 0, 0])
    warm = {"temp_part_C": 22.0, "part_x_mm": 100.0, "part_y_mm": 0.0, "part_z_mm": 0.0}
    part = machine(CMM, PartExpansion(11.5e-6))
    assert part.indication_error(one_row(columns=warm, X=500.0, Y=0.0, Z=0.0))[0] == pytest.approx(
        [2.3 * UM, 0, 0]
    )
