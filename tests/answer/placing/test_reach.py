"""Feasibility of a pose: numbers by hand for every constraint, and an independent test by sampling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.answer.placing.placing_independent import BORE, DOWN, TOP, Z, compare, job
from vcmm.answer.placing.reach import CONSTRAINTS, Feasibility
from vcmm.core.errors import DataError
from vcmm.core.pose import Pose
from vcmm.part.part import Feature, Part
from vcmm.task.measuring.fixture import Fixture, Freedom
from vcmm.task.measuring.obstacles import Clamp, Surroundings
from vcmm.task.measuring.plan import Plan, Step, Stylus, Touch
from vcmm.task.measuring.strategies import Levels, plan_points

HERE = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])


def named(check, six):
    return {p.constraint for p in check.problems(Pose.from_turns(six[:3], six[3:]))}


def amount(check, six, constraint):
    return float(check.amounts(six)[0, CONSTRAINTS.index(constraint)])


def test_the_present_pose_is_feasible():
    check = Feasibility.of(job())
    assert check.feasible(HERE)[0]
    assert check.violation(HERE)[0] == 0.0
    assert check.problems(job().pose) == []


def test_travel_by_hand():
    # the rightmost touch on top: x = 35; travel of X ends at 200, so that a shift of 170 is 5 mm too far
    check = Feasibility.of(job(both=False))
    six = HERE + [170.0, 0, 0, 0, 0, 0]
    assert amount(check, six, "travel") == pytest.approx(5.0)
    found = [p for p in check.problems(Pose(np.eye(3), six[:3])) if p.constraint == "travel"]
    assert found[0].point == "point 2 on top"
    assert "beyond the travel of X" in found[0].text


def test_the_start_above_the_first_touch_counts():
    # first touch on top: tip centre 22, start 25, lift 10, stylus 90, shift z: Z = z + 125 <= 260
    check = Feasibility.of(job(both=False))
    assert amount(check, HERE + [0, 0, 130.0, 0, 0, 0], "travel") == 0.0
    assert amount(check, HERE + [0, 0, 132.0, 0, 0, 0], "travel") == pytest.approx(2.0)


def test_a_part_larger_than_the_machine_is_named():
    small = job(both=False)
    axes = dict(small.machine.axes)
    axes["X"] = replace(axes["X"], travel=(0.0, 60.0))
    check = Feasibility.of(replace(small, machine=replace(small.machine, axes=axes)))
    # touches on top span 70 mm
    assert amount(check, HERE, "size") == pytest.approx(10.0)
    assert any("larger than the machine" in p.text for p in check.problems(small.pose))


def test_load_limit():
    heavy = job(both=False)
    check = Feasibility.of(replace(heavy, machine=replace(heavy.machine, load_limit=2.5)))
    assert amount(check, HERE, "load") == pytest.approx(0.5)  # 3 kg on 2.5 kg
    assert named(check, HERE) == {"load"}


def test_table_by_hand():
    # the lowest corner lies at z = shift: 4 mm below the table at -4
    check = Feasibility.of(job(both=False))
    assert amount(check, HERE - [0, 0, 9.0, 0, 0, 0], "table") == pytest.approx(4.0)


def test_a_short_stylus_brings_the_head_into_the_part():
    # stylus of 15 mm in a bore of 30 mm with a head of 40 mm diameter: at 4 mm depth the head is 16 + 2 - 15 = inside
    short = Stylus("short", np.array([0.0, 0.0, -15.0]), 2.0, 15.0)
    base = job(both=False)
    plan = Plan(
        (Step("bore", "short", *plan_points(BORE, Levels((4.0,), 5))),),
        {"short": short},
        Touch(clearance=10.0),
    )
    check = Feasibility.of(replace(base, plan=plan))
    # tip at z = 4: underside of the head at 19, the top at 20: 1 mm too low, 2 mm safe distance: 3 mm
    assert amount(check, HERE, "head") == pytest.approx(3.0, abs=0.6)
    assert "head" in named(check, HERE)


def test_the_approach_must_fit_into_the_bore():
    # bore of 30 mm, approach of 25 mm: the start is 12 - 25 = 13 mm beyond the axis, 1 mm beyond where the tip fits (13)
    base = job(both=False)
    plan = replace(base.plan, touch=Touch(approach=25.0, clearance=10.0))
    check = Feasibility.of(replace(base, plan=plan))
    assert "approach" in named(check, HERE)


def test_direction_limit():
    base = job(both=False)
    check = Feasibility.of(replace(base, surroundings=replace(base.surroundings, steepest=np.radians(80.0))))
    found = [p for p in check.problems(base.pose) if p.constraint == "direction"]
    assert {p.point.split(" on ")[1] for p in found} == {"bore"}  # a wall: 90 deg
    assert found[0].amount == pytest.approx(np.radians(10.0))
    assert found[0].unit == "rad"


def test_a_clamp_over_the_top_blocks_and_is_named():
    base = job(both=False)
    over = Clamp("bridge", (20.0, 120.0, 10.0), Pose.from_turns((35.0, 0.0, 35.0), (0, 0, 0)))
    check = Feasibility.of(replace(base, surroundings=replace(base.surroundings, clamps=(over,))))
    assert "clamps" in named(check, HERE)
    inside = Clamp("inside", (20.0, 20.0, 10.0), Pose.from_turns((30.0, 0.0, 20.0), (0, 0, 0)))
    check = Feasibility.of(replace(base, surroundings=replace(base.surroundings, clamps=(inside,))))
    assert any('overlaps the clamp "inside"' in p.text for p in check.problems(base.pose))


def test_a_clamp_may_move_with_the_part():
    base = job(both=False)
    over = Clamp("bridge", (20.0, 120.0, 10.0), Pose.from_turns((35.0, 0.0, 30.0), (0, 0, 0)), on="part")
    check = Feasibility.of(replace(base, surroundings=replace(base.surroundings, clamps=(over,))))
    for six in (HERE, HERE + [30.0, 20, 0, 0, 0, 1.0]):
        assert not check.feasible(six)[0]
    texts = [p.text for p in check.problems(base.pose) if "meets" in p.text]
    assert texts
    assert all('meets the clamp "bridge"' in text for text in texts)  # the part itself is in nobody's way


def test_moves_draw_back_where_straight_is_blocked():
    # from the top to the bore the straight way crosses the rim; drawing back is free, so that nothing is wrong
    check = Feasibility.of(job(both=False))
    room = check.room(np.eye(3))
    assert (room.direct > 0).sum() >= 1
    assert check.feasible(HERE)[0]
    # a lid on the part 30 mm above blocks drawing back too, and the pair is named
    base = job(both=False)
    lid = Clamp("lid", (20.0, 20.0, 5.0), Pose.from_turns((12.0, 0.0, 200.0), (0, 0, 0)), on="part")
    check = Feasibility.of(replace(base, surroundings=replace(base.surroundings, clamps=(lid,))))
    assert "moves" in named(check, HERE) or "head" in named(check, HERE) or "quill" in named(check, HERE)


def test_slots_turns_and_faces():
    scenario = job(both=False)
    turns = Fixture(freedoms=(Freedom("turn_z", values=(0.0, np.pi / 2)),))
    check = Feasibility.of(scenario, turns)
    assert amount(check, HERE, "fixture") == 0.0
    assert amount(check, HERE + [0, 0, 0, 0, 0, np.pi / 2], "fixture") == 0.0
    # 5 deg off a quarter turn: an arc of 0.08727 at the farthest corner of the part
    arm = np.linalg.norm(check.corners - check.corners.mean(axis=0), axis=1).max()
    off = amount(check, HERE + [0, 0, 0, 0, 0, np.radians(95.0)], "fixture")
    assert off == pytest.approx(np.radians(5.0) * arm)
    slots = Feasibility.of(scenario, Fixture(slots=((0.0, 0.0, 5.0), (100.0, 0.0, 5.0))))
    assert amount(slots, HERE + [40.0, 0, 0, 0, 0, 0], "fixture") == pytest.approx(40.0)
    down = Feasibility.of(scenario, Fixture(faces={"bottom": (0.0, 0.0, -1.0)}))
    assert amount(down, HERE, "fixture") == 0.0
    assert amount(down, HERE + [0, 0, 0, 0.2, 0, 0], "fixture") == pytest.approx(0.2 * arm)


def test_contradictory_clamps_are_refused():
    low = Clamp("low", (10.0, 10.0, 10.0), Pose.from_turns((0, 0, -20.0), (0, 0, 0)))
    with pytest.raises(DataError, match="below the table"):
        Surroundings(clamps=(low,), table=0.0)
    with pytest.raises(DataError, match="Two clamps"):
        Surroundings(clamps=(low, low))


def test_shifts_and_turns_about_a_vertical_stylus_use_what_is_kept():
    check = Feasibility.of(job(both=False))
    check.amounts(np.array([HERE, HERE + [5, 5, 0, 0, 0, 1.0], HERE + [1, 2, 3, 0, 0, 2.0]]))
    assert len(check._rooms) == 1


def test_pocket_floor_is_reached_and_its_wall_is_not_crossed():
    """A floor 15 mm below the top: a stylus from above reaches it; one that comes from the side crosses the wall."""
    floor = Feature("floor", "plane", np.array([0, 0, 5.0]), Z, np.zeros(0), extent=(30.0, 30.0))
    part = Part({"top": TOP, "floor": floor})
    points = np.array([[0.0, 0.0, 5.0], [5.0, 0, 5], [0, 5.0, 5]])
    down = Step("floor", "down", points, np.tile(Z, (3, 1)))
    base = job(both=False)
    plan = Plan((down,), {"down": DOWN}, Touch(clearance=10.0))
    assert Feasibility.of(replace(base, part=part, plan=plan)).feasible(HERE)[0]
    side = Stylus("side", np.array([-80.0, 0.0, -25.0]), 2.0, 80.0)
    plan = Plan((replace(down, stylus="side"),), {"side": side}, Touch(clearance=10.0))
    check = Feasibility.of(replace(base, part=part, plan=plan))
    assert "shaft" in named(check, HERE)


@pytest.mark.parametrize("both", [False, True])
@pytest.mark.thorough
def test_no_violation_against_an_independent_test(both):
    feasible, infeasible, wrong = compare(110, seed=11, both=both)
    assert wrong == 0
    assert feasible > 10
    assert infeasible > 30


def test_poses_together_are_judged_as_each_by_itself():
    # tilted and turned: several sides of the part, several poses of each; with a clamp on the table every pose by itself
    rng = np.random.default_rng(5)
    six = HERE + np.hstack([rng.uniform(-60.0, 60.0, (12, 2)), np.zeros((12, 4))])
    six[4:8, 5], six[8:, 3] = rng.uniform(-3.0, 3.0, 4), 0.2
    clamp = Clamp("stop", (20.0, 20.0, 40.0), Pose(np.eye(3), np.array([130.0, 0.0, 10.0])))
    for around in (Surroundings(), Surroundings(clamps=(clamp,))):
        check = Feasibility.of(replace(job(), surroundings=around))
        together = check.amounts(six)
        assert (together == np.concatenate([check.amounts(one) for one in six])).all()
        assert (check.feasible(six) == (together.sum(axis=1) == 0.0)).all()
        assert 0 < check.feasible(six).sum() < len(six)


def test_poses_none_of_which_the_travels_allow_leave_the_tool_nothing_to_look_at():
    # shifts of 1000 and 2000 mm in X, where the travel allows 165: no pose is left for the tool, and none is feasible
    check = Feasibility.of(job())
    far = HERE + np.array([[1000.0, 0, 0, 0, 0, 0], [2000.0, 0, 0, 0, 0, 0]])
    assert check.feasible(far).tolist() == [False, False]
    assert check.feasible(np.vstack([far, HERE])).tolist() == [False, False, True]
    assert check.tooling.keys(np.zeros((0, 3, 3))) == []
