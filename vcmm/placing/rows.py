"""Rows of many poses at once: the Run of a plan at m poses, pose after pose, without walking through the plan again.

A plan does not change with the pose but for a rigid motion, so that time, stylus, labels and temperatures are those of
one reference placing; positions, normals, approach directions and the senses of the axes are made here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.fixture import pose_of
from vcmm.kinematics import nominal_tip
from vcmm.machine import Machine
from vcmm.plan import Touches, probe_angles
from vcmm.pose import Pose
from vcmm.qualification import qualified_machine
from vcmm.run import Array, Run
from vcmm.scenario import Scenario
from vcmm.task import Task

FAR = 1e7  # mm: travels of the reference placing, which may lie out of reach


@dataclass(frozen=True, eq=False)
class Rows:
    """A plan ready to be placed: everything of a scenario that does not depend on the pose."""

    scenario: Scenario
    machine: Machine
    task: Task  # on a machine without errors and limits, at the present pose

    @classmethod
    def of(cls, scenario: Scenario) -> Rows:
        """Raises UsageError where the plan itself is wrong."""
        machine, found = qualified_machine(scenario.machine, scenario.plan, scenario.qualifications)
        axes = {
            a: replace(axis, travel=(-FAR, FAR)) if not axis.rotary else axis for a, axis in machine.axes.items()
        }
        bare = Machine(machine.name, machine.kind, machine.chain, axes)
        still = replace(scenario, machine=bare, inputs=(), qualifications={})
        inputs = (*machine.inputs, *scenario.inputs, *found)
        return cls(scenario, replace(machine, inputs=inputs), still.task())

    @property
    def placed(self) -> Touches:
        return self.task.touches

    @property
    def n(self) -> int:
        return self.placed.run.n

    @cached_property
    def zero(self) -> Array:
        """(n, 3): the tip with all axes at zero."""
        run = self.placed.run
        still = Run({a: np.zeros(run.n) for a in self.machine.chain.letters}, run.offset)
        return nominal_tip(self.machine.chain, self.machine.axes, still)

    @cached_property
    def balls(self) -> Array:
        """(n, 3): centres of the tip in the drawing frame."""
        t = self.placed
        return t.points + t.tip_radius[:, None] * t.normals

    @cached_property
    def needed(self) -> frozenset[str]:
        """Columns that some effect of the machine asks for."""
        return frozenset(c for e in self.machine.effects for c in e.required())

    def wanted(self, six: Array) -> Array:
        """(m, n, 3): axis positions along x y z that the touches need at poses (m, 6), reachable or not."""
        pose = pose_of(six)
        return np.asarray(pose.apply(np.broadcast_to(self.balls, (len(six), self.n, 3))) - self.zero)

    def run(self, six: Array) -> Run:
        """The prepared Run of m n rows for poses (m, 6)."""
        m, t = len(six), self.placed
        pose = pose_of(six)
        tip = pose.apply(np.broadcast_to(self.balls, (m, self.n, 3)))
        position, flat = tip - self.zero, (m * self.n,)
        axes = {a: position[..., "XYZ".index(a)].reshape(flat) for a in self.machine.chain.letters if a in "XYZ"}
        axes |= {a: np.zeros(flat) for a in self.machine.chain.letters if a in "ABC"}
        normal = pose.turn(np.broadcast_to(t.normals, tip.shape)).reshape(-1, 3)
        part = pose.turn(np.broadcast_to(t.points, tip.shape)).reshape(-1, 3)
        columns = {f"n{c}": normal[:, i] for i, c in enumerate("xyz")}
        columns |= {f"part_{c}_mm": part[:, i] for i, c in enumerate("xyz")}
        columns |= {f"tip_{c}_mm": tip[..., i].reshape(flat) for i, c in enumerate("xyz")}
        columns |= self._history(pose, tip, position)
        columns |= self._probe(normal, m)
        for name, values in t.run.columns.items():
            if name not in columns:
                columns[name] = np.tile(values, m)
        labels = {k: np.tile(v, m) for k, v in t.run.labels.items()}
        return Run(axes, np.tile(t.run.offset, (m, 1)), columns, labels, t.run.series)

    def _probe(self, normal: Array, m: int) -> Mapping[str, Array]:
        if not {"probe_angle_rad", "probe_lateral", "stylus_length_mm"} & self.needed:
            return {}
        styli = [self.scenario.plan.styli[str(s)] for s in self.placed.run.labels["stylus"]]
        direction, length = np.array([s.direction for s in styli]), np.array([s.length for s in styli])
        return probe_angles(np.tile(direction, (m, 1)), np.tile(length, m), normal)

    def _history(self, pose: Pose, tip: Array, position: Array) -> dict[str, Array]:
        """Speeds and senses of the axes, as `plan.touches` makes them; only those that an effect asks for."""
        wanted = [c for c in self.needed if c.startswith(("speed_", "sense_"))]
        if not wanted:
            return {}
        t, touch = self.placed, self.scenario.plan.touch
        direction = pose.turn(np.broadcast_to(t.approach, tip.shape))
        normal = pose.turn(np.broadcast_to(t.normals, tip.shape))
        out: dict[str, Array] = {}
        for i, letter in enumerate("XYZ"):
            out[f"speed_{letter}_mm_s"] = (touch.speed * direction[..., i]).ravel()
            if letter in self.machine.chain.letters:
                lift = touch.clearance if i == 2 else 0.0
                path = direction[..., i], normal[..., i], touch.approach, lift
                out[f"sense_{letter}"] = _sense(position[..., i], *path).ravel()
        return out


def _sense(q: Array, direction: Array, normal: Array, approach: float, lift: float) -> Array:
    """(m, n): the sense in which an axis comes to each touch; an axis that did not move keeps its last sense."""
    begin = q - approach * direction
    before = np.concatenate([begin[:, :1] + lift, (q + approach * normal)[:, :-1]], axis=1)
    final = np.where(np.abs(direction) > 1e-9, direction, begin - before)
    sense = np.where(np.abs(final) > 1e-9, np.sign(final), 0.0)
    for row in range(1, sense.shape[1]):
        sense[:, row] = np.where(sense[:, row] == 0.0, sense[:, row - 1], sense[:, row])
    return np.asarray(sense)
