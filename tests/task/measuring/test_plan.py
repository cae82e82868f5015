"""Touches: where the axes go, how they got there, what the probe sees; by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.task.measuring.plan import Plan, Step, Stylus, Touch, axis_positions, probe_columns, touches

DOWN = Stylus("down", np.array([0.0, 0.0, -100.0]), 2.0, 100.0)
UP = np.array([[0.0, 0.0, 1.0]])


def _machine(structure: str = "w b Y X Z t", low: float = -1000.0, high: float = 1000.0) -> Machine:
    chain = parse_structure(structure)
    return Machine("m", "cmm", chain, {a: Axis(a, (low, high)) for a in chain.letters})


def _touched(points, normals, stylus: Stylus = DOWN, shift=(0.0, 0.0, 0.0), **more):
    normals = np.array(normals, dtype=float)
    step = Step("face", stylus.name, np.array(points, dtype=float), normals, more.pop("approach", None))
    plan = Plan((step,), {stylus.name: stylus}, more.pop("touch", Touch()))
    pose = Pose(np.eye(3), np.array(shift))
    return touches(plan, pose, more.pop("machine", _machine()), more.pop("constants", None))


@pytest.mark.parametrize("structure", ["w b Y X Z t", "w Y' b X Z t", "w X' Y' b Z t", "w X' Y' Z' b t"])
def test_the_axes_bring_the_tip_to_the_surface(structure):
    # point (10 20 30) of the part shifted by (100 0 0), ball of 2 mm above it: tip at (110 20 32);
    # the tip hangs 100 mm below Z: Z = 132. Commanded numbers are tool-relative: the same for a table axis
    run = _touched([[10, 20, 30]], UP, shift=(100.0, 0.0, 0.0), machine=_machine(structure)).run
    assert [run.q(a)[0] for a in "XYZ"] == pytest.approx([110.0, 20.0, 132.0])
    assert run.tip[0] == pytest.approx([110.0, 20.0, 32.0])
    assert run.part_point[0] == pytest.approx([10.0, 20.0, 30.0])


def test_a_turned_part_turns_points_and_normals():
    # 90 deg about z: (10 0 0) with n = x goes to (0 10 0) with n = y; the tip stands at (0 12 0)
    pose = Pose(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3))
    step = Step("face", "down", np.array([[10.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]]))
    run = touches(Plan((step,), {"down": DOWN}), pose, _machine()).run
    assert run.normal[0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)
    assert run.tip[0] == pytest.approx([0.0, 12.0, 0.0], abs=1e-12)


def test_speed_is_that_of_the_approach():
    # touching from above at 5 mm/s: v = (0 0 -5), v . n = -5 mm/s: negative while approaching
    run = _touched([[0, 0, 0]], UP, touch=Touch(speed=5.0)).run
    assert run.vector("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s")[0] == pytest.approx([0.0, 0.0, -5.0])


def test_sense_of_the_axes():
    # row 1 comes straight down: X and Y have not moved. Row 2: 10 mm in +X, Y still not. Row 3: 10 mm back in X and -5 in Y
    points = [[0, 0, 0], [10, 0, 0], [0, -5, 0], [0, -5, 0]]
    run = _touched(points, np.tile(UP, (4, 1))).run
    assert run.column("sense_Z").tolist() == [-1.0] * 4  # always touched from above
    assert run.column("sense_X").tolist() == [0.0, 1.0, -1.0, -1.0]  # row 4: as it last moved
    assert run.column("sense_Y").tolist() == [0.0, 0.0, -1.0, -1.0]


def test_time_of_the_touches():
    # approach 3 mm at 5 mm/s there and back: 1.2 s; row 1 comes down 20 mm at 100 mm/s: 0.2 s; row 2 is 50 mm away: 0.5 s
    run = _touched([[0, 0, 0], [50, 0, 0]], np.tile(UP, (2, 1)), touch=Touch(5.0, 3.0, 20.0, 100.0)).run
    assert run.column("time_s") == pytest.approx([1.4, 1.4 + 0.5 + 1.2])


def test_labels_and_constants():
    steps = (
        Step("a", "down", np.zeros((2, 3)), np.tile(UP, (2, 1))),
        Step("b", "side", np.zeros((1, 3)), np.array([[0.0, -1.0, 0.0]])),
    )
    side = Stylus("side", np.array([0.0, 50.0, -80.0]), 1.0, 30.0, event="A90")
    placed = touches(
        Plan(steps, {"down": DOWN, "side": side}), Pose.identity(), _machine(), {"temp_part_C": 21.0}
    )
    run = placed.run
    assert run.labels["feature"].tolist() == ["a", "a", "b"]
    assert run.labels["touch"].tolist() == ["a#1", "a#2", "b#1"]
    assert run.labels["event"].tolist() == ["down", "down", "A90"]
    assert run.column("temp_part_C").tolist() == [21.0] * 3
    assert run.column("stylus_length_mm").tolist() == [100.0, 100.0, 30.0]
    assert {k: v.tolist() for k, v in placed.rows.items()} == {"a": [0, 1], "b": [2]}
    assert placed.tip_radius.tolist() == [2.0, 2.0, 1.0]


def test_probe_angle_and_lateral_share():
    # stylus down: n = x 0 deg, n = y 90 deg, n = -x 180 deg, all fully lateral; n = z along the stylus;
    # n = (0.6 0 0.8): lateral sqrt(1 - 0.8^2) = 0.6
    normal = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1], [0.6, 0, 0.8]], dtype=float)
    plan = Plan((Step("a", "down", normal, normal),), {"down": DOWN})
    found = probe_columns(plan, np.array(["down"] * 5), normal)
    assert np.degrees(found["probe_angle_rad"][:3]) == pytest.approx([0.0, 90.0, 180.0])
    assert found["probe_lateral"] == pytest.approx([1.0, 1.0, 1.0, 0.0, 0.6])


def test_a_slanted_approach():
    # 45 deg from the normal is allowed, 85 deg is not: the tip would slide
    slanted = np.array([[np.sin(np.pi / 4), 0.0, -np.cos(np.pi / 4)]])
    run = _touched([[0, 0, 0]], UP, approach=slanted).run
    assert run.column("speed_X_mm_s")[0] == pytest.approx(5.0 * np.sqrt(0.5))
    steep = np.radians(85.0)
    with pytest.raises(
        UsageError, match=r"point 1 \(face\) is 85 deg from the inward normal; keep it under 80 deg"
    ):
        _touched([[0, 0, 0]], UP, approach=np.array([[np.sin(steep), 0.0, -np.cos(steep)]]))


def test_out_of_reach_names_point_feature_axis_and_travel():
    machine = _machine(low=0.0, high=150.0)
    with pytest.raises(ModelLimit) as caught:
        _touched([[10, 20, 30], [200, 20, 30]], np.tile(UP, (2, 1)), machine=machine)
    message = str(caught.value)
    assert "a point on face" in message
    assert "row 2: axis X = 200 mm is outside its travel 0 to 150 mm (1 of 2 rows are)" in message


def test_a_machine_without_an_axis():
    machine = _machine("w b X Z t")
    tip = np.array([[1.0, 0.0, 5.0]])
    offset = np.zeros((1, 3))
    assert axis_positions(machine.chain, machine.axes, tip, offset)["X"] == pytest.approx([1.0])
    with pytest.raises(ModelLimit, match="has no axis Y, but the plan needs Y = 3 mm"):
        axis_positions(machine.chain, machine.axes, tip + [[0.0, 3.0, 0.0]], offset)


def test_rotary_axes_stay_at_zero():
    run = _touched([[10, 20, 30]], UP, machine=_machine("w C' b X Y Z t")).run
    assert run.q("C").tolist() == [0.0]


def test_plans_that_are_none():
    with pytest.raises(UsageError, match="the plan is empty"):
        Plan((), {})
    step = Step("a", "dwon", np.zeros((1, 3)), UP)
    with pytest.raises(UsageError, match=r'stylus "dwon". Did you mean "down"'):
        Plan((step,), {"down": DOWN})


def test_a_stylus_without_offset_points_down():
    assert Stylus("s", np.zeros(3), 1.0).direction.tolist() == [0.0, 0.0, -1.0]
