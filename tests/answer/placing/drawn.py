"""Drawn placement problems: two balls on a drawn machine with a drawn field of errors, one to five freedoms.

Used by the tests and by tools/place_statistics.py; small, so that the reference may use ten times the evaluations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.placing.fixture_boxes import PoseBox, boxes
from vcmm.answer.placing.objective import Uncertain
from vcmm.answer.placing.travels import Travels
from vcmm.core.effect import Effect
from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.physics.structure.component import ComponentSpline
from vcmm.physics.structure.residual import CorrelatedField
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.measuring.fixture import Fixture, Freedom, Goal, six_of
from vcmm.task.measuring.plan import Plan, Step, Stylus
from vcmm.task.measuring.scenario import Scenario

TRAVEL = {"X": (0.0, 700.0), "Y": (0.0, 600.0), "Z": (-450.0, 0.0)}


@dataclass(frozen=True, eq=False)
class Problem:
    """An objective over boxes, ready to be searched."""

    objective: Uncertain
    boxes: list[PoseBox]


def problem(seed: int) -> Problem:
    """Problem number `seed`."""
    rng = np.random.default_rng([seed, 20140425])
    machine, part = _machine(rng), _part(rng)
    scenario = Scenario(
        f"drawn {seed}", machine, part, _plan(part), Pose.from_turns((350, 300, -300), (0, 0, 0))
    )
    weights = rng.dirichlet(np.ones(3))
    names = [c.name for c in scenario.part.characteristics]
    objective = Uncertain.of(scenario, Goal({"U": 1.0}, dict(zip(names, map(float, weights)))))
    found = boxes(_fixture(rng), six_of(scenario.pose), Travels(objective.closed.rows))
    return Problem(objective, found)


def _machine(rng: np.random.Generator) -> Machine:
    axes = {a: Axis(a, t) for a, t in TRAVEL.items()}
    grid = [np.linspace(-1, 701, 3), np.linspace(-1, 601, 3), np.linspace(-600, 0, 2)]
    at = np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, 3)
    field = CorrelatedField(
        nodes=at, deviation=rng.uniform(0.2e-3, 2e-3, at.shape), length=float(rng.uniform(150, 350))
    )
    effects: list[Effect] = [Scatter(), field, Squareness("C0Y")]
    inputs = [
        Input("scatter", "", "value", Normal(float(rng.uniform(0.1e-3, 0.5e-3))), "touch"),
        Input("correlated_field", "", "values", MultivariateNormal(field.covariance()), "run"),
        Input("squareness", "C0Y", "angle", Normal(float(rng.uniform(0.2e-6, 3e-6)))),
    ]
    for component in rng.choice(["EXX", "EYX", "EZX", "EXY", "EYY", "EBX", "ECY", "EAZ"], 3, replace=False):
        nodes = np.linspace(*TRAVEL[component[2]], 5)
        effects.append(ComponentSpline(str(component), nodes=nodes, values=np.zeros(5)))
        size = 1e-6 if component[1] in "ABC" else 1e-3
        inputs.append(
            Input(
                "component_spline",
                str(component),
                "values",
                Normal(1.0),
                scale=size * rng.uniform(0.2, 2.0, 5),
            )
        )
    return Machine(
        "drawn",
        "cmm",
        parse_structure(str(rng.choice(["w b Y X Z t", "w Y' b X Z t"]))),
        axes,
        tuple(effects),
        tuple(inputs),
    )


def _part(rng: np.random.Generator) -> Part:
    far = rng.uniform(60, 220) * np.array([1.0, 0.0, 0.0]) + np.array(
        [0.0, rng.uniform(-60, 60), rng.uniform(-40, 40)]
    )
    balls = {
        n: Feature(n, "sphere", p, np.zeros(3), np.array([r]))
        for n, p, r in (("a", np.zeros(3), rng.uniform(8, 20)), ("b", far, rng.uniform(8, 20)))
    }
    wanted = (
        Characteristic("size a", "size", of=("a",)),
        Characteristic("size b", "size", of=("b",)),
        Characteristic("distance", "distance", between=("a", "b")),
    )
    return Part(balls, wanted)


def _plan(part: Part) -> Plan:
    """Five touches on each ball: its top and four at its equator."""
    directions = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], dtype=float)
    steps = tuple(
        Step(n, "down", f.point + f.sizes[0] * directions, directions) for n, f in part.features.items()
    )
    return Plan(steps, {"down": Stylus("down", np.array([0.0, 0.0, -120.0]), 2.0)})


def _fixture(rng: np.random.Generator) -> Fixture:
    """x and y, often the turn, sometimes z and small tilts; discrete turns in some."""
    free = [Freedom("x", -np.inf, np.inf), Freedom("y", -np.inf, np.inf)]
    turn = rng.integers(4)
    if turn == 0:
        free.append(Freedom("turn_z", values=tuple(np.radians([0.0, 90.0, 180.0, 270.0]))))
    elif turn < 3:
        free.append(Freedom("turn_z", -np.pi, np.pi))
    if rng.random() < 0.4:
        free.append(Freedom("z", -400.0, -200.0))
    if rng.random() < 0.25:
        free.append(Freedom("turn_x", -0.2, 0.2))
    return Fixture(tuple(free))
