"""A second opinion on feasibility, written without vcmm.answer.placing: the tool as dense points, the part as inequalities.

A block of 80 x 80 x 20 mm with a through bore of 30 mm, a side stylus and one that points down, a clamp on the table.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.build import machine  # tests/build.py
from vcmm.answer.placing.reach import Feasibility
from vcmm.core.kinematics import Axis
from vcmm.core.pose import Pose
from vcmm.part.part import Feature, Part
from vcmm.task.measuring.obstacles import Clamp, Head, Surroundings
from vcmm.task.measuring.plan import Plan, Step, Stylus, Touch
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.strategies import Grid, Levels, plan_points

Z = np.array([0.0, 0.0, 1.0])
TOP = Feature("top", "plane", np.array([0, 0, 20.0]), Z, np.zeros(0), extent=(80.0, 80.0))
BOTTOM = Feature("bottom", "plane", np.zeros(3), -Z, np.zeros(0), extent=(80.0, 80.0))
BORE = Feature("bore", "cylinder", np.zeros(3), Z, np.array([15.0]), inside=True, extent=(20.0,))
FRONT = Feature(
    "front", "plane", np.array([0, -40.0, 10.0]), np.array([0, -1.0, 0]), np.zeros(0), extent=(80.0, 20.0)
)
CLAMP = Clamp("clamp", (20.0, 20.0, 60.0), Pose.from_turns((90.0, 0.0, 30.0), (0.0, 0.0, 0.3)))
HEAD = Head(diameter=40.0, length=60.0, quill=(50.0, 50.0, 200.0), shafts={"down": 2.0})
DOWN = Stylus("down", np.array([0.0, 0.0, -90.0]), 2.0, 60.0)
SIDE = Stylus("side", np.array([0.0, 80.0, -20.0]), 2.5, 70.0)


def job(both: bool = True) -> Scenario:
    steps = [Step("top", "down", *plan_points(TOP, Grid((2, 2), 5.0)))]
    steps.append(Step("bore", "down", *plan_points(BORE, Levels((4.0, 16.0), 3))))
    if both:
        steps.append(Step("front", "side", *plan_points(FRONT, Grid((2, 2), 4.0))))
    plan = Plan(tuple(steps), {"down": DOWN, "side": SIDE}, Touch(clearance=10.0))
    part = Part({f.name: f for f in (TOP, BOTTOM, BORE, FRONT)}, mass=3.0)
    around = Surroundings(head=HEAD, clamps=(CLAMP,), table=0.0)
    axes = {"X": (-200.0, 200.0), "Y": (-250.0, 200.0), "Z": (0.0, 260.0)}
    m = replace(machine(), axes={a: Axis(a, t) for a, t in axes.items()})
    return Scenario("job", m, part, plan, Pose.from_turns((0, 0, 5.0), (0, 0, 0)), surroundings=around)


def poses(n: int, seed: int):
    """Shifts over the table, turns about the vertical, small and large tilts: (n, 6)."""
    rng = np.random.default_rng(seed)
    six = np.zeros((n, 6))
    six[:, :3] = rng.uniform([-160, -160, -5], [160, 160, 60], (n, 3))
    six[:, 3:5] = rng.normal(size=(n, 2)) * 0.15 * rng.integers(0, 2, (n, 1))
    six[:, 5] = rng.uniform(-np.pi, np.pi, n)
    return six


def tool_points(stylus: Stylus, rng, count: int = 150):
    """Points in and on the tool, the tip at the origin: shaft, extension, head, quill."""
    offset = np.asarray(stylus.offset)
    way = -offset / np.linalg.norm(offset)
    shaft = 0.5 * HEAD.shafts.get(stylus.name, 0.7 * 2 * stylus.tip_radius)
    sides = np.linalg.svd(way[None])[2][1:]

    def cylinder(begin, axis, across, low, high, radius):
        turn, out = rng.uniform(0, 2 * np.pi, count), radius * np.sqrt(rng.uniform(0.8, 1, count))
        ring = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
        return begin + rng.uniform(low, high, count)[:, None] * axis + out[:, None] * ring

    root, mount = stylus.length, np.linalg.norm(offset)
    out = [cylinder(np.zeros(3), way, sides, 0.0, root, shaft)]
    out.append(cylinder(np.zeros(3), way, sides, root + 0.5 * HEAD.extension, mount, 0.5 * HEAD.extension))
    out.append(cylinder(-offset, Z, np.eye(3)[:2], 0.0, HEAD.length, 0.5 * HEAD.diameter))
    box = rng.uniform([-25, -25, HEAD.length], [25, 25, HEAD.length + 200.0], (count, 3))
    out.append(-offset + box)
    return np.concatenate(out)


def in_block(p):
    inside = (np.abs(p[..., 0]) <= 40) & (np.abs(p[..., 1]) <= 40) & (p[..., 2] >= 0) & (p[..., 2] <= 20)
    return inside & (np.hypot(p[..., 0], p[..., 1]) >= 15)


def in_clamp(p):
    q = CLAMP.pose.inverse().apply(p.reshape(-1, 3)).reshape(p.shape)
    return (np.abs(q) <= 0.5 * np.array(CLAMP.size)).all(axis=-1)


def second_opinion(scenario: Scenario, six, rng) -> bool:
    """Whether the touches, starts and retracts keep clear and within the travels, by sampling."""
    pose = Pose.from_turns(six[:3], six[3:])
    travels = np.array([scenario.machine.axes[a].travel for a in "XYZ"])
    for step in scenario.plan.steps:
        stylus = scenario.plan.styli[step.stylus]
        tip = step.points + stylus.tip_radius * step.normals
        away = tip + scenario.plan.touch.approach * step.normals
        places = pose.apply(np.concatenate([tip, 0.5 * (tip + away), away]))
        axes = places - stylus.offset
        if (axes < travels[:, 0] - 1e-6).any() or (axes > travels[:, 1] + 1e-6).any():
            return False
        tool = places[:, None] + tool_points(stylus, rng)
        if (tool[..., 2] < 0).any() or in_clamp(tool).any():
            return False
        if in_block(pose.inverse().apply(tool.reshape(-1, 3))).any():
            return False
    corners = np.array([[x, y, z] for x in (-40, 40) for y in (-40, 40) for z in (0, 20)], dtype=float)
    placed = pose.apply(corners)
    block = pose.apply(rng.uniform([-40, -40, 0], [40, 40, 20], (500, 3)))
    block = block[in_block(pose.inverse().apply(block))]
    return not ((placed[:, 2] < -2e-3).any() or in_clamp(block).any())


def compare(n: int, seed: int, both: bool = True) -> tuple[int, int, int]:
    """(called feasible, called infeasible, called feasible against the second opinion)."""
    scenario, six = job(both), poses(n, seed)
    rng = np.random.default_rng(seed + 1)
    called = Feasibility.of(scenario).feasible(six)
    wrong = sum(not second_opinion(scenario, one, rng) for one in six[called])
    return int(called.sum()), int((~called).sum()), wrong
