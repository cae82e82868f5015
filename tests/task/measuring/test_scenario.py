"""A scenario becomes a task: effects, Inputs and form of the part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import SCATTER, scenario
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.pose import Pose
from vcmm.part.form import Lobes
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.task.measuring.qualification import Qualification

K = Input("scale_factor", "X", "k", Normal(1e-6))


def test_all_that_is_known_meets_in_the_task():
    one = replace(scenario(ScaleFactor("X")), inputs=(K,), qualifications={"down": Qualification()})
    task = one.task()
    assert [i.id for i in task.inputs] == [
        "scatter.value",
        "scale_factor[X].k",
        "stylus_qualification[down].d by repeatability",
    ]
    assert [e.id for e in task.machine.effects] == [
        "scatter",
        "scale_factor[X]",
        "stylus_qualification[down]",
    ]
    assert one.informed_machine().inputs[1] is K


def test_what_is_said_twice_is_refused():
    with pytest.raises(UsageError, match=r"scatter.value has an input already"):
        replace(scenario(), inputs=(SCATTER,)).task()


def test_the_form_of_the_part_stands_at_its_touches():
    # two lobes of 3 um: + 3 um at 0 deg, - 3 um at 90 deg; the faces are plane
    one = replace(scenario(), forms={"bore": Lobes(2, 3e-3)})
    task = one.task()
    bore = task.touches.rows["bore"]
    angle = np.arctan2(task.touches.points[bore, 1], task.touches.points[bore, 0])
    assert np.abs(task.form[bore]) == pytest.approx(np.abs(3e-3 * np.cos(2 * angle)), abs=1e-12)
    assert task.form[task.touches.rows["left"]].tolist() == [0.0] * 4


def test_a_part_elsewhere_moves_the_axes():
    first, second = scenario().task(), scenario().at(Pose(np.eye(3), np.array([7.0, 0.0, 0.0]))).task()
    assert second.touches.run.q("X") - first.touches.run.q("X") == pytest.approx(np.full(24, 7.0))
    with pytest.raises(ModelLimit, match=r"some point is out of travel \(a point on bore\): row 1: axis X"):
        scenario(shift=(2000.0, 0.0, 0.0)).task()


def test_a_scenario_is_placed_once_and_a_changed_one_anew():
    one = scenario(ScaleFactor("X"))
    moved = one.at(Pose(np.eye(3), one.pose.shift + [1.0, 0.0, 0.0]))
    assert one.task() is one.task()
    q, other = one.task().touches.run.q("X"), moved.task().touches.run.q("X")
    np.testing.assert_allclose(other - q, 1.0, atol=1e-9)
