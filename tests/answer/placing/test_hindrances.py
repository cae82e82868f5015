"""What is in the way, in words: the amount, its unit, the place and what to do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.answer.placing.placing_independent import job
from vcmm.answer.placing.hindrances import problems
from vcmm.answer.placing.reach import Feasibility
from vcmm.core.pose import Pose
from vcmm.task.measuring.fixture import Fixture, Freedom
from vcmm.task.measuring.plan import Stylus


def test_weight_fixture_and_table_by_hand():
    base = job(both=False)
    heavy = replace(base, machine=replace(base.machine, load_limit=2.25))
    fixture = Fixture((Freedom("x", 10.0, 20.0), Freedom("turn_z", values=(0.5,))))
    found = problems(Feasibility.of(heavy, fixture), Pose(np.eye(3), np.array([6.0, 0.0, -1.5])))
    by_text = {p.text: p for p in found}
    load = by_text["the part weighs 3 kg, the machine carries 2.25 kg"]
    assert (load.name, load.constraint, load.point, load.amount, load.unit) == (
        "load",
        "load",
        "part",
        0.75,
        "kg",
    )
    assert by_text["the fixture does not allow this place: 4 mm off"].amount == pytest.approx(4.0)
    turn = by_text["the fixture does not allow this turn: 28.65 deg off"]  # 0.5 rad
    assert (turn.amount, turn.unit) == (pytest.approx(0.5), "rad")
    assert by_text["the part reaches 1.5 mm below the table; raise it"].amount == pytest.approx(1.5)


def test_the_worst_touch_of_a_travel_comes_first():
    # the shift of 170 takes x = 35 on top to 205, and the bore (12 - 3 of approach and retract) stays within 200
    found = problems(Feasibility.of(job(both=False)), Pose(np.eye(3), np.array([170.0, 0.0, 5.0])))
    travels = [p for p in found if p.name == "travel"]
    assert [p.point for p in travels] == ["point 2 on top", "point 3 on top"]
    assert "is 5 mm beyond the travel of X" in travels[0].text


def test_a_body_that_is_too_near_is_named_with_what_it_meets():
    base = job(both=False)
    side = Stylus("down", np.array([-80.0, 0.0, -3.0]), 2.0, 80.0)  # lies nearly flat on the top
    plan = replace(base.plan, styli={**base.plan.styli, "down": side})
    found = problems(Feasibility.of(replace(base, plan=plan)), base.pose)
    shafts = [p for p in found if p.name == "shaft"]
    assert shafts
    assert all(p.amount > 0 for p in found)
    assert "the shaft meets the part" in shafts[0].text
    assert "use a thinner or longer stylus" in shafts[0].text
