"""The whole placement: gain, order of the poses, discrete choices, what is said when nothing can be reached."""

from __future__ import annotations

from types import SimpleNamespace as Made

import numpy as np
import pytest

import vcmm
from tests.answer.placing.cases import plate, with_field
from tests.answer.placing.placing_independent import job
from vcmm.answer.placing.confirmation import fresh_seed
from vcmm.answer.placing.placement import _known_bias, no_reachable_pose, place, relaxation
from vcmm.answer.placing.reach import CONSTRAINTS, Feasibility
from vcmm.core.errors import ModelLimit
from vcmm.task.measuring.fixture import Fixture, Freedom, Goal


def test_gain_is_confirmed_out_of_sample(placed):
    """The gain by paired trials agrees with the closed form within its standard error and what k is good for."""
    sure = placed.confirmation
    assert sure is not None
    assert placed.present is not None
    assert sure.is_confirmed
    assert sure.seed == fresh_seed(placed.seed) != placed.seed
    closed = placed.present.value - placed.best.value
    assert sure.gain == pytest.approx(closed, abs=4 * sure.u_gain + 0.02 * closed)
    assert (
        0 < sure.u_gain < 0.1 * sure.gain
    )  # common random numbers: the difference is known better than either


def test_order_of_the_poses_and_the_full_evaluation(placed):
    assert placed.best.value <= placed.median.value <= placed.worst.value
    assert placed.best.value < placed.present.value
    for at, result in ((placed.best, placed.after), (placed.present, placed.before)):
        for i in placed.objective.smooth:
            assert result.characteristics[i].u == pytest.approx(at.u[i], rel=1e-3)
            found = result.characteristics[i]  # the search weighs U without the known bias
            assert found.expanded - found.bias_in_U == pytest.approx(at.expanded[i], rel=0.02)


@pytest.mark.thorough
def test_the_same_seed_gives_the_same_answer(tmp_path, monkeypatch):
    monkeypatch.setattr("vcmm.answer.placing.confirmation.TRIALS", 100)
    scenario = with_field(plate(tmp_path), 5)
    options = {
        "evaluations": 60,
        "scanned": 16,
        "trials": 1000,
        "constraints": (),
        "goal": Goal({"U": 1.0}, {"bore diameter": 1.0}),
    }
    first, again = vcmm.place(scenario, **options), vcmm.place(scenario, **options)
    assert np.array_equal(first.best.pose, again.best.pose)
    assert first.confirmation == again.confirmation


@pytest.mark.parametrize(
    ("u_new", "left_in", "told"),
    [(9.4e-3, 8.0e-3, "length from 4.9 um to 9.4 um"), (5.0e-3, 8.0e-3, ""), (9.4e-3, 0.0, "")],
)
def test_a_known_bias_that_takes_away_the_gain_is_said(u_new: float, left_in: float, told: str):
    """U with its bias grows from 4.9 to 9.4 um while the gain is of U without it; 2 % more is not told, nor U without a bias in it."""
    old = Made(name="length", unit="mm", expanded=4.9e-3, bias_in_U=2.7e-3)
    new = Made(name="length", unit="mm", expanded=u_new, bias_in_U=left_in)
    made = Made(best=object(), present=object(), objective=Made(weights={"length": 1.0}))
    said = _known_bias(made, Made(characteristics=(old,)), Made(characteristics=(new,)))  # type: ignore[arg-type]
    assert (told in said[0]) if told else not said


def test_present_pose_out_of_reach_is_said(tmp_path):
    scenario = plate(tmp_path, "", ('shift = "300 250 -300 mm"', 'shift = "20 250 -300 mm"'))
    found = vcmm.place(
        scenario, evaluations=100, scanned=32, trials=1000, goal=Goal({"U": 1.0}, {"bore diameter": 1.0})
    )
    assert found.present is None
    assert found.before is None
    assert found.gain is None
    assert found.problems[0].constraint == "travel of axis X"
    assert any("cannot be used" in w for w in found.warnings)


def test_discrete_choices_are_enumerated(tmp_path):
    scenario = with_field(plate(tmp_path), 4)
    slots = ((150.0, 150.0, -300.0), (300.0, 250.0, -300.0), (430.0, 330.0, -300.0))
    turns = Freedom("turn_z", values=tuple(np.radians([0.0, 90.0, 180.0])))
    goal = Goal({"U": 1.0}, {"bore to front": 1.0})
    found = vcmm.place(
        scenario, fixture=Fixture((turns,), slots), goal=goal, evaluations=100, scanned=32, trials=1000
    )
    every = np.array([[*s, 0, 0, t] for s in slots for t in turns.values])
    values = found.objective.values(every)
    assert np.allclose(found.best.pose, every[values.argmin()])
    assert found.label.startswith("slot ")


def test_a_part_larger_than_the_machine(tmp_path):
    small = plate(tmp_path, "", ('travel = ["0 mm", "600 mm"]', 'travel = ["0 mm", "60 mm"]'))
    fixture = Fixture((Freedom("x", -np.inf, np.inf), Freedom("turn_z", -0.01, 0.01)))
    with pytest.raises(ModelLimit, match="the part is larger than the machine: the touches need"):
        place(small, fixture=fixture)


@pytest.mark.thorough
def test_among_equal_poses_the_present_one_stays(tmp_path):
    # nothing but scatter is uncertain: u is the same at every pose, so nothing is gained by going anywhere
    from dataclasses import replace

    job = plate(tmp_path)
    scatter = tuple(i for i in job.machine.inputs if i.id == "scatter.value")
    quiet = replace(job, machine=replace(job.machine, inputs=scatter), inputs=(), qualifications={})
    fixture = Fixture((Freedom("x", 200.0, 400.0), Freedom("y", 200.0, 300.0)))
    found = place(quiet, fixture=fixture, evaluations=200, scanned=50, trials=1000)
    assert found.best is found.present
    assert found.gain == 0.0


HERE = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])


@pytest.mark.thorough
def test_relaxation_by_hand():
    """x may only lie between 170 and 190: the nearest, 170, lacks 5 mm of travel, and nothing else."""
    check = Feasibility.of(job(both=False))
    low, high = HERE.copy(), HERE.copy()
    low[0], high[0] = 170.0, 190.0
    points = np.linspace(low, high, 5)
    found = relaxation(check, points, low, high, polish=40)
    assert found[0].constraint == "travel"
    assert found[0].amount == pytest.approx(5.0, abs=1e-6)
    error = no_reachable_pose(found, check, found[0].pose)
    assert "travel by 5 mm" in str(error)
    assert "point 2 on top" in str(error)


def test_relaxation_of_an_open_space_is_zero():
    check = Feasibility.of(job(both=False))
    assert relaxation(check, HERE)[0].amount == 0.0


class _Table:
    """Violations (2 poses, all constraints) that are given."""

    def __init__(self, **lacks: list[float]) -> None:
        self.lacks = np.stack([lacks.get(name, [0.0, 0.0]) for name in CONSTRAINTS], axis=1)

    def amounts(self, poses):
        return self.lacks


def test_no_constraint_gives_way_for_another():
    """The first pose lacks 5 mm of travel alone; the second 1 mm of table and 2 mm of travel: it opens for no single constraint."""
    violations = relaxation(_Table(travel=[5.0, 2.0], table=[0.0, 1.0]), [HERE, HERE + 1.0])
    assert [(r.constraint, r.amount, r.pose[0]) for r in violations] == [("travel", 5.0, 0.0)]
