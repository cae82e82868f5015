"""Readings on the machine that cut the part count from its zeros, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.part.part import Feature, Part
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.shop.machining.probing import ProbedHere
from vcmm.task.measuring.plan import Plan, Step, Stylus, touches
from vcmm.task.measuring.task import Task

FACE = Feature("face", "plane", np.zeros(3), np.array([1.0, 0.0, 0.0]), np.zeros(0), extent=(40.0, 20.0))
KNOWN = Input("scale_factor", "X", "k", Normal(1e-6))


def world(zero: float) -> ProbedHere:
    """Three points at X 400 of a machine with +10 um/m, the zero at X `zero`."""
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    machine = Machine(
        "mill",
        "machine-tool",
        parse_structure("w X' Y' b Z t"),
        axes,
        (ScaleFactor(axis="X", k=10e-6),),
        (KNOWN,),
    )
    points = np.array([[0.0, 0, 0], [0, 10, 0], [0, 0, 10]])
    plan = Plan(
        (Step("face", "s", points, np.tile(FACE.axis, (3, 1)), None),), {"s": Stylus("s", np.zeros(3), 2.0)}
    )
    placed = touches(plan, Pose(np.eye(3), np.array([400.0, 0.0, 0.0])), machine)
    labels = {**placed.run.labels, "work_offset": np.array(["G54"] * 3)}
    placed = type(placed)(
        **{**vars(placed), "run": type(placed.run)(**{**vars(placed.run), "labels": labels})}
    )
    task = Task(machine, Part({"face": FACE}, ()), plan, placed, machine.inputs, np.zeros(3))
    return ProbedHere(task, {"G54": np.array([zero, 0.0, 0.0])})


def test_a_scale_is_read_from_the_zero():
    """A long scale says too little, 10 um/m: the tip centre at X 402 less that at 300 gives -1.02 um; at the zero nothing is left."""
    assert world(300.0).errors()[:, 0] == pytest.approx(np.full(3, -10e-6 * 102.0), abs=1e-9)
    assert world(402.0).errors()[:, 0] == pytest.approx(np.zeros(3), abs=1e-9)


def test_influences_likewise():
    """d reading / dk = -(402 - 300) mm."""
    (one,) = world(300.0).influences()
    assert one.response[:, 0, 0] == pytest.approx(np.full(3, -102.0), abs=1e-6)
    assert len(one.codes) == 3
