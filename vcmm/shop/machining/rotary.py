"""Rotary axes while cutting: tools of a program in workpiece axes, from the nominal chain of the machine.

A move gives positions of X Y Z A B C, all linear in the share of the move (along an arc: in its angle). The tip is

    tip(share) = T_work(q)^-1 T_tool(q) (-tool offset)        tool axis(share) = R_work(q)^T R_tool(q) z

for any chain, with the tool offset along Z of the machine as G43 counts it: no tool centre point control, no turned work
offset. While the rotary axes stand still this map is affine in X Y Z, so lines stay lines, and arcs stay arcs. While they
turn, the way is cut into short lines with the tool held as in their middle, good enough to find what touches a point
(SEARCH); vcmm.shop.machining.rotary_milling then puts the tool exactly where it stands.

Source of the chain: ISO 230-1 structure codes, multiplied out in vcmm.core.kinematics.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.core.axes import ROTARY
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import commanded_directions, link_frames
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.program.moves import Move, Program
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.sweeps import Sweep, frames_of, lengths, position
from vcmm.shop.motion.tool_pose import by_letter, ends_of, tip_and_axis

Bools = np.typing.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class RotaryMotion:
    """The moves of a program that turns rotary axes, and how the rows of its sweep in workpiece axes lie on them.

    base: moves as tip positions of the machine with its rotary axes at zero, and the way from tip to holder, one row each; angles (m, 2, 3): A, B, C in rad
    at start and end; offset (m, 3): tool offset in force. row (n,): move of each row of the sweep; first, last (n,): shares
    of that move at its ends; inexact (n,): rows that stand for a turning tool. sweep: these rows; rapid (m,): of the moves.
    """

    machine: Machine
    base: Sweep
    angles: Array
    offset: Array
    row: Ints
    first: Array
    last: Array
    inexact: Bools
    sweep: Sweep
    rapid: Bools

    def share(self, row: Ints, t: Array) -> Array:
        """Return the share of the move (k,) at fractions t (k,) of rows of the sweep."""
        return self.first[row] + t * (self.last - self.first)[row]

    def command(self, move: Ints, share: Array) -> dict[str, Array]:
        """Return the positions of all axes (k,) at shares of rows of `base`; mm and rad."""
        tip, angle = machine_position(self.base, self.angles, move, share)
        return by_letter(self.machine, tip + self.offset[move], angle)

    def pose(self, move: Ints, share: Array) -> tuple[Array, Array]:
        """Return the tip and tool axis (k, 3) in workpiece axes at shares of rows of `base`."""
        position = machine_position(self.base, self.angles, move, share)
        return tip_and_axis(self.machine, *position, self.offset[move], self.base.axis[move])

    @cached_property
    def feed_lengths(self) -> tuple[Array, Array]:
        """Feed length of the tip of the tool of each row of the sweep, (n,), (n,) mm: in the part before it, and in it.

        Where the tool turns, its tip runs on chords of 2 um sagitta at most: for an arc of radius 15 mm they are shorter by 4e-5.
        """
        length = np.asarray(lengths(self.sweep), dtype=float).copy()
        free = np.flatnonzero(self.inexact)
        ends = [self.pose(self.row[free], share[free])[0] for share in (self.first, self.last)]
        length[free] = np.linalg.norm(ends[1] - ends[0], axis=1)
        length[self.rapid[self.row]] = 0.0
        before = np.zeros(len(length))
        for tool in np.unique(self.sweep.tool):
            mine = self.sweep.tool == tool
            before[mine] = np.cumsum(length[mine]) - length[mine]
        return before, length

    def standing(self, row: Ints, t: Array) -> tuple[Array, Array]:
        """Return tip (k, 3) and frame of the tool (k, 3, 3), its axes as rows, at fractions t of rows of the sweep."""
        tip, axis = self.pose(self.row[row], self.share(row, t))
        return tip, frames_of(axis)


def machine_position(base: Sweep, turned: Array, move: Ints, share: Array) -> tuple[Array, Array]:
    """Return the tip as with rotary axes at zero (k, 3), mm, and A, B, C (k, 3), rad."""
    tip = position(base.take(move), share)
    return tip, turned[move, 0] + share[:, None] * (turned[move, 1] - turned[move, 0])


def tool_offset_to(machine: Machine, axes: dict[str, Array], at: Array) -> Array:
    """Return the offset (k, 3) in the frame of the last tool-side axis that leads to points (k, 3) in workpiece axes."""
    _, tool, work = ends_of(machine, axes)
    return tool.undo(work.apply(at))


def commands_to_work(machine: Machine, run: Run) -> Array:
    """Return the effect of a shift of the commanded X, Y, Z on the tip in workpiece axes (n, 3, 3)."""
    return commanded_directions(link_frames(machine.chain, machine.axes, run), run.n)


def point_of_part(machine: Machine, zero: Array, angle: Array) -> Array:
    """Return the point of the workpiece (3,) that lies at a work zero (3,) while the rotary axes that carry it are at angle (3,), rad."""
    table_angle = np.array([v if a in machine.chain.work else 0.0 for a, v in zip(ROTARY, angle)])
    return tip_and_axis(machine, zero[None], table_angle[None], np.zeros((1, 3)))[0][0]


def angle_of(program: Program, motion: RotaryMotion, offset: str) -> Array:
    """Return A, B, C (3,) rad at which all cuts of a work offset are made. Raises UsageError where they differ."""
    mine = [i for i, m in enumerate(motion.base.move.tolist()) if _cuts(program.moves[m], offset)]
    angles = motion.angles[mine].reshape(-1, 3)
    if not len(angles):
        return np.zeros(3)
    off = np.flatnonzero(np.abs(angles - angles[0]).max(axis=1) > 1e-9)
    if len(off):
        line = program.moves[int(motion.base.move[mine[int(off[0]) // 2]])].source.line
        raise UsageError(
            f'work_offset.rotary = "as cut": {offset} cuts with the rotary axes in several places (line {line}), but it was set in '
            'one of them; write rotary = "zero", or give each place a work offset of its own'
        )
    return np.asarray(angles[0])


def _cuts(move: Move, offset: str) -> bool:
    return move.kind != "rapid" and move.offset == offset


def turn_to_workpiece(frame: Array | None, vectors: Array) -> Array:
    """Return the vectors (..., 3) of workpiece axes in frames (..., 3, 3) of tools; None: the tool points along Z."""
    return vectors if frame is None else np.einsum("...ij,...j->...i", frame, vectors)


def turned_back(frame: Array | None, vectors: Array) -> Array:
    """Return the vectors (..., 3) in frames of tools back in workpiece axes."""
    return vectors if frame is None else np.einsum("...ji,...j->...i", frame, vectors)
