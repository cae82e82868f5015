"""A small measuring job built in Python: a ring of touches in a bore, two faces, one stylus, one machine."""

from __future__ import annotations

import numpy as np

from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.physics.structure.scatter import Scatter
from vcmm.task.measuring.plan import Plan, Step, Stylus
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.strategies import Grid, Levels, plan_points

BORE = Feature(
    "bore", "cylinder", np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([15.0]), inside=True, extent=(20.0,)
)
LEFT = Feature(
    "left",
    "plane",
    np.array([-50.0, 0.0, 10.0]),
    np.array([-1.0, 0.0, 0.0]),
    np.zeros(0),
    extent=(40.0, 20.0),
)
RIGHT = Feature(
    "right", "plane", np.array([50.0, 0.0, 10.0]), np.array([1.0, 0.0, 0.0]), np.zeros(0), extent=(40.0, 20.0)
)
DIAMETER = Characteristic("diameter", "size", of=("bore",), limits=(-0.01, 0.01))
LENGTH = Characteristic("length", "distance", between=("left", "right"))
FORM = Characteristic("form", "cylindricity", of=("bore",), zone=0.01)
SCATTER = Input("scatter", "", "value", Normal(1e-3), "touch")


def machine(*effects, inputs=()) -> Machine:
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    return Machine("m", "cmm", parse_structure("w b Y X Z t"), axes, tuple(effects), tuple(inputs))


def scenario(
    *effects, inputs=(), characteristics=(DIAMETER, LENGTH, FORM), constants=None, shift=(0.0, 0.0, 0.0)
) -> Scenario:
    """Scatter of 1 um per touch unless other inputs are given; 16 touches in the bore, 4 on each face."""
    part = Part({f.name: f for f in (BORE, LEFT, RIGHT)}, tuple(characteristics))
    plans = {"bore": Levels((5.0, 15.0), 8), "left": Grid((2, 2), 5.0), "right": Grid((2, 2), 5.0)}
    steps = tuple(Step(f.name, "down", *plan_points(f, plans[f.name])) for f in (BORE, LEFT, RIGHT))
    plan = Plan(steps, {"down": Stylus("down", np.array([0.0, 0.0, -100.0]), 2.0, 100.0)})
    known = tuple(inputs) or (SCATTER,)
    all_effects = (Scatter(), *effects)
    return Scenario(
        "job",
        machine(*all_effects, inputs=known),
        part,
        plan,
        Pose(np.eye(3), np.array(shift)),
        constants or {},
    )
