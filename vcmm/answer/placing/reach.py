"""Feasibility: decide whether a plan can be carried out at a pose, and report obstacles with the missing clearance.

    check = Feasibility.of(scenario)
    for problem in check.problems(pose):
        print(problem.constraint, problem.text)

Everything that depends only on the side from which the tool sees the part is kept, so that shifts cost microseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.answer.placing.access import (
    ROUNDING,
    Room,
    TableRoom,
    Way,
    back_lacking,
    drawn_back,
    moves_lacking,
    room,
)
from vcmm.answer.placing.collision import Bodies, slack
from vcmm.answer.placing.hindrances import Hindrance, problems
from vcmm.answer.placing.material import part_points, part_solid
from vcmm.answer.placing.solid import Solid, Union, cuboid, half_space
from vcmm.answer.placing.tool import NAMES, Tooling, TouchSequence, touch_sequence
from vcmm.core.kinematics import nominal_tip
from vcmm.core.pose import Array, Pose
from vcmm.core.run import Run
from vcmm.task.measuring.fixture import Fixture, off_fixture
from vcmm.task.measuring.plan import Ints
from vcmm.task.measuring.scenario import Scenario

Bools = npt.NDArray[np.bool_]
CONSTRAINTS = (
    "load",
    "size",
    "fixture",
    "travel",
    "table",
    "direction",
    "approach",
    *NAMES,
    "clamps",
    "moves",
)
MAX_KEPT = 4096


@dataclass(eq=False)
class Feasibility:
    """Constraints of one scenario. poses (m, 6): shift mm, then turns rad about fixed x, y, z."""

    scenario: Scenario
    rows: TouchSequence
    tooling: Tooling
    solid: Solid
    reach: Array  # (p, 3): points whose hull holds part and clamps on the part, drawing frame
    corners: Array  # (q, 3): of the part alone
    fixture: Fixture | None = None
    _rooms: dict[tuple[float, ...], Room] = field(default_factory=dict)
    _backs: dict[tuple[float, ...], Array] = field(default_factory=dict)

    @classmethod
    def of(cls, scenario: Scenario, fixture: Fixture | None = None) -> Feasibility:
        """Return the constraints. fixture: poses that the clamping allows (slots, faces down, turns); None = any pose."""
        around, rows = scenario.surroundings, touch_sequence(scenario.plan)
        corners = part_points(scenario.part)
        carried = [c for c in around.clamps if c.on == "part"]
        solid = part_solid(scenario.part, around.wall)
        boxes = [cuboid(c.pose, c.size) for c in carried]
        reach = np.concatenate([corners, *(c.corners() for c in carried)])
        whole = Union((solid, *boxes)) if boxes else solid
        tooling = Tooling(rows, around)
        return cls(scenario, rows, tooling, whole, reach=reach, corners=corners, fixture=fixture)

    def feasible(self, poses: npt.ArrayLike) -> Bools:
        """Return which poses have nothing in the way (m,)."""
        six = np.atleast_2d(np.asarray(poses, dtype=np.float64))
        together = Pose.from_turns(six[:, :3], six[:, 3:])
        static = self._static(six, together).max(axis=1)
        left = np.flatnonzero(static == 0.0)  # the tool is looked at where nothing simpler is in the way
        static[left] = self._of_tool(together.some(left)).max(axis=1)
        return np.asarray(static == 0.0)

    def violation(self, poses: npt.ArrayLike) -> Array:
        """Return the sum of the amounts missed by all constraints, each at its worst place, (m,) mm; 0 = feasible."""
        return np.asarray(self.amounts(poses).sum(axis=1))

    def amounts(self, poses: npt.ArrayLike) -> Array:
        """Return the amounts missed (m, len(CONSTRAINTS)) mm, 0 where met. Angles count as the arc at the part's rim, kg as mm."""
        six = np.atleast_2d(np.asarray(poses, dtype=np.float64))
        together = Pose.from_turns(six[:, :3], six[:, 3:])
        return np.asarray(self._static(six, together) + self._of_tool(together))

    def _static(self, six: Array, pose: Pose) -> Array:
        """Return the columns that need no tool (m, len(CONSTRAINTS)), others 0; pose: the batch of the six numbers (m, 6)."""
        out = np.zeros((len(six), len(CONSTRAINTS)))
        column = CONSTRAINTS.index
        out[:, column("load")] = self.overload()
        size, over = self._travel(pose)
        out[:, column("size")], out[:, column("travel")] = size.max(axis=1), over.max(axis=(1, 2))
        if self.fixture is not None:
            shift, turn = off_fixture(self.fixture, six)
            out[:, column("fixture")] = np.maximum(shift, turn * self._arm())
        if self.scenario.surroundings.table is not None:
            out[:, column("table")] = self._depth_in_table(pose)
        return out

    def problems(self, pose: Pose) -> list[Hindrance]:
        """Return everything that is in the way at one pose, worst first within each constraint; empty = feasible."""
        return problems(self, pose)

    # ---------------------------------------------------------------- parts of it

    def overload(self) -> float:
        """Return the load above the limit of the machine, kg."""
        limit = self.scenario.machine.load_limit
        return 0.0 if limit is None else max(0.0, self.scenario.part.mass - limit)

    def positions(self, pose: Pose) -> Array:
        """Return axis positions wanted at touches, starts, retracts and above the first start (m, 3n + 1, 3); m poses."""
        tips = np.concatenate([self.rows.tip, self.rows.start, self.rows.end, self.rows.start[:1]])
        wanted = pose.apply(np.broadcast_to(tips, (len(pose.shift), *tips.shape))) - np.concatenate(
            [self.zero, self.zero, self.zero, self.zero[:1]]
        )
        wanted[:, -1, 2] += self.scenario.plan.touch.clearance
        return np.asarray(wanted)

    @cached_property
    def zero(self) -> Array:
        """Tip with all axes at zero (n, 3)."""
        machine = self.scenario.machine
        still = Run({a: np.zeros(self.rows.n) for a in machine.chain.letters}, self.rows.offset)
        return nominal_tip(machine.chain, machine.axes, still)

    def limits(self) -> Array:
        """Return the travels along x, y, z (2, 3); an axis that the machine lacks counts as fixed at zero."""
        axes = self.scenario.machine.axes
        return np.array([axes[a].travel if a in axes else (0.0, 0.0) for a in "XYZ"]).T

    def _travel(self, pose: Pose) -> tuple[Array, Array]:
        """Return the amounts by which the travels are missed: (m, 3) in length, for any shift, and (m, 3n + 1, 3) in place."""
        wanted, (low, high) = self.positions(pose), self.limits()
        span = wanted.max(axis=1) - wanted.min(axis=1) - (high - low)
        over = np.maximum(low - wanted, wanted - high)
        return np.where(span > ROUNDING, span, 0.0), np.where(over > ROUNDING, over, 0.0)

    def _arm(self) -> float:
        return float(np.linalg.norm(self.corners - self.corners.mean(axis=0), axis=1).max())

    def _depth_in_table(self, pose: Pose) -> Array:
        table = self.scenario.surroundings.table
        lowest = pose.apply(np.broadcast_to(self.corners, (len(pose.shift), *self.corners.shape)))[
            ..., 2
        ].min(axis=1)
        off = (0.0 if table is None else table) - lowest
        return np.where(off > 1e-3, off, 0.0)

    @cached_property
    def shafts(self) -> Array:
        """Unit directions (s, 3), machine: from the tip of each stylus to its head."""
        return np.array([-self.rows.plan.styli[name].direction for name in self.rows.styli])

    def steep(self, rotation: Array) -> Array:
        """Return the angles (..., n) rad by which the shaft leans over the surface too far, by rotations (..., 3, 3)."""
        shafts = self.shafts @ rotation
        cosine = np.einsum("...ni,ni->...n", shafts[..., self.rows.stylus, :], self.rows.normal)
        off = np.arccos(np.clip(cosine, -1.0, 1.0)) - self.scenario.surroundings.steepest
        return np.where(off > 1e-9, off, 0.0)

    def room(self, rotation: Array) -> Room:
        """Return the room against the part, for a rotation machine_from_part; cached by side."""
        key = self.tooling.key(rotation)
        if key not in self._rooms:
            if len(self._rooms) >= MAX_KEPT:
                self._rooms.clear()
                self._backs.clear()
            self._rooms[key] = room(self.tooling, self.solid, self.rows, rotation.T)
        return self._rooms[key]

    def rooms_by_obstacle(self, rotation: Array) -> dict[str, Room]:
        """Return the room against the part alone and against each clamp that it carries, for messages about the obstacle."""
        around = self.scenario.surroundings
        solids: dict[str, Solid] = {"the part": part_solid(self.scenario.part, around.wall)}
        for c in around.clamps:
            if c.on == "part":
                solids[f'the clamp "{c.name}"'] = cuboid(c.pose, c.size)
        return {name: room(self.tooling, solid, self.rows, rotation.T) for name, solid in solids.items()}

    def part_back(self, rotation: Array, which: Ints) -> Array:
        """Return the missing clearance (n,) mm from the part while the tool draws back from `which`; inf at touches that are not in `which`."""
        back = self._backs.setdefault(self.tooling.key(rotation), np.full(self.rows.n, np.inf))
        new = which[np.isinf(back[which])]
        if len(new):
            back[new] = back_lacking(self.tooling, self.solid, self.reach, self.rows, new, rotation.T)
        return back

    def table_room(self, pose: Pose) -> TableRoom | None:
        """Return the room against clamps on the table and the table itself, in workpiece axes; None without any."""
        around = self.scenario.surroundings
        clamps = [c for c in around.clamps if c.on == "table"]
        if not clamps and around.table is None:
            return None
        parts: list[Solid] = [cuboid(c.pose, c.size) for c in clamps]
        if around.table is not None:
            parts.append(half_space(around.table, np.array([0.0, 0.0, 1.0])))
        solid, back = Union(tuple(parts)), pose.inverse()
        overlap = [
            slack(self.solid, _block(c.pose, c.size).to_frame(back.rotation, back.shift), np.array([-0.01]))
            for c in clamps
        ]
        corners = np.concatenate([np.zeros((0, 3)), *(c.corners() for c in clamps)])
        beside = room(self.tooling, solid, self.machine_rows(pose), np.eye(3))
        return TableRoom(solid, corners, beside, np.maximum(0.0, -np.array(overlap).reshape(-1)))

    def machine_rows(self, pose: Pose) -> TouchSequence:
        """Return the touches in workpiece axes."""
        r = self.rows
        return replace(
            r,
            tip=pose.apply(r.tip),
            start=pose.apply(r.start),
            end=pose.apply(r.end),
            normal=pose.turn(r.normal),
        )

    def blocked_moves(self, poses: Pose, of_part: Room, table: TableRoom | None) -> tuple[Array, Array]:
        """Return the moves that cannot be made at m poses of one side (one, where there is a table): (m, k) mm per pair (straight and by
        drawing back), (n,) mm where a stylus changes.
        """
        direct = of_part.direct if table is None else np.maximum(of_part.direct, table.room.direct)
        pairs = of_part.pairs
        drawn_moves = drawn_back(self.rows, pairs[direct > 0.0])
        way = Way(
            self.tooling,
            self.rows,
            poses,
            drawn_moves,
            pairs[direct > 0.0],
            zero=self.zero,
            limits=self.limits(),
        )
        over, ends = moves_lacking(way, self.reach, self.part_back(poses.rotation[0], drawn_moves), table)
        moves = np.zeros((len(over), len(pairs)))
        moves[:, direct > 0.0] = np.minimum(over, direct[direct > 0.0])
        return moves, ends

    def _of_tool(self, poses: Pose) -> Array:
        """Return the columns that need the tool (m, len(CONSTRAINTS)), others 0; poses that see the part from one side together."""
        out, sides = np.zeros((len(poses.shift), len(CONSTRAINTS))), dict[tuple[float, ...], list[int]]()
        around = self.scenario.surroundings
        shared = around.table is None and all(c.on != "table" for c in around.clamps)
        for i, key in enumerate(self.tooling.keys(poses.rotation)):
            sides.setdefault(key if shared else (float(i),), []).append(i)
        for rows in sides.values():
            out[rows] = self._of_side(poses.some(np.array(rows)))
        return out

    def _of_side(self, poses: Pose) -> Array:
        """Return the same for poses of one side; one pose where there is an obstacle on the table."""
        out, column, first = (
            np.zeros((len(poses.shift), len(CONSTRAINTS))),
            CONSTRAINTS.index,
            poses.each()[0],
        )
        out[:, column("direction")] = self.steep(poses.rotation).max(axis=1) * self._arm()
        of_part, table = self.room(first.rotation), self.table_room(first)
        for name in NAMES:
            out[:, column(name)] = of_part.bodies[name].max()
        out[:, column("approach")] = of_part.tip.max()
        if table is not None:
            worst = max(float(b.max()) for b in table.room.bodies.values())
            tip, overlap = float(table.room.tip.max()), float(table.overlap.max(initial=0.0))
            out[:, column("clamps")] = max(worst, tip, overlap)
        moves, ends = self.blocked_moves(poses, of_part, table)
        out[:, column("moves")] = np.maximum(moves.max(axis=1, initial=0.0), float(ends.max(initial=0.0)))
        return out


def _block(pose: Pose, size: Sequence[float]) -> Bodies:
    edges = np.zeros((1, 4, 3))
    edges[0, :3] = (pose.rotation * (0.5 * np.array(size))).T
    return Bodies(pose.shift[None], edges, np.zeros(1), np.zeros(1))
