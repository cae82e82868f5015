"""Rows of many poses at once: the Run of a plan at m poses, pose after pose, without walking through the plan again.

A plan does not change with the pose but for a rigid motion, so that time, stylus, labels and temperatures are those of
one reference placing; positions, normals, approach directions and the senses of the axes are made here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import required
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.task.measuring.fixture import pose_of
from vcmm.task.measuring.plan import Ints, Touches, probe_angles
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.task import Task

REFERENCE_TRAVEL_MM = 1e7  # mm: travels of the reference placing, which may lie out of reach


@dataclass(frozen=True, eq=False)
class Rows:
    """A plan ready to be placed: everything of a scenario that does not depend on the pose."""

    scenario: Scenario
    machine: Machine
    task: Task  # on a machine without errors and limits, at the present pose
    subset: Ints | None = None  # touches that are looked at; None = all

    @classmethod
    def of(cls, scenario: Scenario) -> Rows:
        """Raises UsageError where the plan itself is wrong."""
        machine = scenario.informed_machine()
        axes = {
            a: replace(axis, travel=(-REFERENCE_TRAVEL_MM, REFERENCE_TRAVEL_MM)) if not axis.rotary else axis
            for a, axis in machine.axes.items()
        }
        bare = Machine(machine.name, machine.kind, machine.chain, axes)
        still = replace(scenario, machine=bare, inputs=(), qualifications={})
        return cls(scenario, machine, still.task())

    @property
    def touches(self) -> Touches:
        return self.task.touches

    @cached_property
    def still(self) -> Run:
        """Touches in use, at the present pose: labels and columns that do not move."""
        return self.touches.run if self.subset is None else self.touches.run.take(self.subset)

    @property
    def n(self) -> int:
        """Number of touches in use."""
        return self.still.n

    def only(self, subset: Ints) -> Rows:
        """Return the same plan, of which `run` makes some touches only."""
        return replace(self, subset=subset)

    @cached_property
    def zero(self) -> Array:
        """Tip with all axes at zero (n, 3)."""
        run = self.touches.run
        still = Run({a: np.zeros(run.n) for a in self.machine.chain.letters}, run.offset)
        return nominal_tip(self.machine.chain, self.machine.axes, still)

    @cached_property
    def balls(self) -> Array:
        """Centres of the tip in the drawing frame (n, 3)."""
        t = self.touches
        return t.points + t.tip_radius[:, None] * t.normals

    @cached_property
    def needed_columns(self) -> frozenset[str]:
        """Columns that some effect of the machine needs."""
        return frozenset(c for e in self.machine.effects for c in required(e))

    def axis_positions(self, six: Array) -> Array:
        """Return axis positions along x y z (m, n, 3) that the touches need at poses (m, 6), reachable or not."""
        return np.asarray(_move_points(pose_of(six), self.balls) - self.zero)

    def run(self, six: Array) -> Run:
        """Return the prepared Run of m n rows for poses (m, 6)."""
        m, rows = len(six), slice(None) if self.subset is None else self.subset
        t, pose, still = self.touches, pose_of(six), self.still
        tip = _move_points(pose, self.balls[rows])
        position, flat = tip - self.zero[rows], (m * self.n,)
        axes = {
            a: position[..., "XYZ".index(a)].reshape(flat) for a in self.machine.chain.letters if a in "XYZ"
        }
        axes |= {a: np.zeros(flat) for a in self.machine.chain.letters if is_rotary(a)}
        normal = _turn_vectors(pose, t.normals[rows]).reshape(-1, 3)
        part = _turn_vectors(pose, t.points[rows]).reshape(-1, 3)
        columns = {f"n{c}": normal[:, i] for i, c in enumerate("xyz")}
        columns |= {f"part_{c}_mm": part[:, i] for i, c in enumerate("xyz")}
        columns |= {f"tip_{c}_mm": tip[..., i].reshape(flat) for i, c in enumerate("xyz")}
        columns |= {k: v[:, rows].ravel() for k, v in self._history(six).items()}
        columns |= self._probe(normal, m)
        columns |= {k: np.tile(still.columns[k], m) for k in self.constant if k not in columns}
        labels = {k: np.tile(v, m) for k, v in still.labels.items()}
        return Run(axes, np.tile(still.offset, (m, 1)), columns, labels, still.series)

    @cached_property
    def constant(self) -> tuple[str, ...]:
        """Columns that do not move with the pose: time, temperatures and others that an effect or input may need."""
        moving = ("tip_", "part_", "sense_", "speed_", "probe_")
        names = [c for c in self.still.columns if not c.startswith(moving) and c not in ("nx", "ny", "nz")]
        return tuple(names)

    def _probe(self, normal: Array, m: int) -> Mapping[str, Array]:
        if not {"probe_angle_rad", "probe_lateral", "stylus_length_mm"} & self.needed_columns:
            return {}
        direction, length = self._styli
        return probe_angles(np.tile(direction, (m, 1)), np.tile(length, m), normal)

    @cached_property
    def _styli(self) -> tuple[Array, Array]:
        """Direction (n, 3) and length (n,) of the stylus of every touch in use."""
        styli = [self.scenario.plan.styli[str(s)] for s in self.still.labels["stylus"]]
        return np.array([s.direction for s in styli]), np.array([s.length for s in styli])

    def _history(self, six: Array) -> dict[str, Array]:
        """Return speeds and senses (m, all touches), as `plan.touches` makes them; only where an effect needs them."""
        if not any(c.startswith(("speed_", "sense_")) for c in self.needed_columns):
            return {}
        t, touch, pose = self.touches, self.scenario.plan.touch, pose_of(six)
        position, direction, normal = (
            self.axis_positions(six),
            _turn_vectors(pose, t.approach),
            _turn_vectors(pose, t.normals),
        )
        out: dict[str, Array] = {}
        for i, letter in enumerate("XYZ"):
            out[f"speed_{letter}_mm_s"] = touch.speed * direction[..., i]
            if letter in self.machine.chain.letters:
                lift = touch.clearance if i == 2 else 0.0
                path = direction[..., i], normal[..., i], touch.approach, lift
                out[f"sense_{letter}"] = _sense(position[..., i], *path)
        return out


def _move_points(pose: Pose, points: Array) -> Array:
    """Return points (n, 3) at every pose of a batch, (m, n, 3)."""
    return _turn_vectors(pose, points) + pose.shift[:, None, :]


def _turn_vectors(pose: Pose, vectors: Array) -> Array:
    return np.asarray(vectors @ pose.rotation.swapaxes(1, 2))


def _sense(q: Array, direction: Array, normal: Array, approach: float, lift: float) -> Array:
    """Return the sense (m, n) in which an axis comes to each touch; an axis that did not move keeps its last sense."""
    begin = q - approach * direction
    before = np.concatenate([begin[:, :1] + lift, (q + approach * normal)[:, :-1]], axis=1)
    final = np.where(np.abs(direction) > 1e-9, direction, begin - before)
    sense = np.where(np.abs(final) > 1e-9, np.sign(final), 0.0)
    for row in range(1, sense.shape[1]):
        sense[:, row] = np.where(sense[:, row] == 0.0, sense[:, row - 1], sense[:, row])
    return np.asarray(sense)
