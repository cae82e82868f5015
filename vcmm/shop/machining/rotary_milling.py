"""Milling with rotary axes off zero: what differs from three axes on the way of vcmm.shop.machining.contact_path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit, VcmmError
from vcmm.core.inputs import Input
from vcmm.core.kinematics import nominal_tip
from vcmm.core.run import OFFSET_LABEL, TOOL_AXIS_COLUMNS, Array, Run
from vcmm.physics.structure.residual import OVER_VOLUME
from vcmm.program.limits import AXES
from vcmm.shop.cutting.contactmap import Ints, Solids
from vcmm.shop.cutting.envelope import CutSurface
from vcmm.shop.machining.milling import CONTACTS, MillingProcess
from vcmm.shop.machining.process import ContactRows, CutCandidates, PreparedCut, zeros
from vcmm.shop.machining.rotary import RotaryMotion, angle_of, commands_to_work, point_of_part, tool_offset_to
from vcmm.shop.machining.rotary_contacts import TiltedSolids, polish_contacts
from vcmm.shop.machining.states import moment, seconds_at
from vcmm.shop.machining.tool_errors import ToolSide

OF_TURNING = 16  # contacts of one point while rotary axes turn: rows beside each other find one contact


@dataclass(frozen=True, eq=False)
class RotaryMillingProcess(MillingProcess):
    """motion: how the rows of the sweep lie on the moves."""

    motion: RotaryMotion

    def surface(self, job: PreparedCut, points: Array, normals: Array, exact: bool) -> CutSurface:
        if not exact or not self.motion.inexact.any():
            return self.search_contacts(job, points, normals, CONTACTS)
        return polish_contacts(self.search_contacts(job, points, normals, OF_TURNING), self.motion, CONTACTS)

    def standing(self, row: Ints, share: Array) -> tuple[Array, Array | None]:
        return self.motion.standing(row, share)

    def on_path(self, job: PreparedCut, row: Ints, share: Array, at: Array) -> tuple[Run, Array]:
        """As while milling. The offset of the run leads to the points `at` (k, 3), which count as fixed to the tool."""
        motion, path = self.motion, job.path
        move, along = motion.row[row], motion.share(row, share)
        time = seconds_at(path.timing, motion.base.move[move], along)
        columns, labels = moment(path, motion.base.move[move], time)
        before, length = motion.feed_lengths  # the toolpath counts X, Y and Z only
        columns["cut_length_mm"] = before[row] + share * length[row]
        position = motion.command(move, along)
        offset = tool_offset_to(motion.machine, position, at)
        columns |= self._led(job, motion.base.move[move], Run(position, offset))
        state = path.timing.state(time).position
        really = {letter: state[:, AXES.index(letter)] for letter in position}
        for letter, c in zip("XYZ", "xyz"):
            if letter in really:
                really[letter] = really[letter] + columns[f"follow_{c}_mm"]
        moved = nominal_tip(motion.machine.chain, motion.machine.axes, Run(really, offset))
        return Run(position, offset, columns, labels), moved - at

    def _led(self, job: PreparedCut, move: Ints, run: Run) -> dict[str, Array]:
        """Where the control leads the tip over the workpiece: what X, Y, Z are told for 1 mm along each axis of the part, else
        the axis itself; led: 1 there. Nothing where no move is led."""
        led = np.array([job.program.moves[i].tool_axis_end is not None for i in move.tolist()], dtype=bool)
        if not any(m.tool_axis_end is not None for m in job.program.moves):
            return {}
        told = np.where(led[:, None, None], np.linalg.inv(commands_to_work(job.machine, run)), np.eye(3))
        names = {f"led_{d}{c}": told[:, i, j] for j, d in enumerate("xyz") for i, c in enumerate("xyz")}
        return {"led": led.astype(float), **names}

    def cutters(self, surface: CutSurface, candidates: CutCandidates) -> Solids:
        plain, known = super().cutters(surface, candidates), candidates.row >= 0
        frame = np.broadcast_to(np.eye(3), (*known.shape, 3, 3)).copy()
        frame[known] = self.motion.standing(candidates.row[known], candidates.share[known])[1]
        return TiltedSolids(plain.tools, plain.which, plain.arm, frame)

    def cusp_lift(self, job: PreparedCut, surface: CutSurface, some: Ints, radius: float) -> Array:
        """The ball rolls on the surface that the search sees."""
        seen = self.surface(job, surface.points[some], surface.normals[some], exact=False)
        return super().cusp_lift(job, seen, np.arange(len(some)), radius)

    def states(self, job: PreparedCut, rows: ContactRows) -> tuple[Run, Array]:
        return self.on_path(job, rows.row, rows.share, rows.at)

    def tool_axis(self, rows: ContactRows) -> Array:
        return self.motion.standing(rows.row, rows.share)[1][:, 2]

    def columns(self, job: PreparedCut, rows: ContactRows) -> dict[str, Array]:
        axis = self.tool_axis(rows)
        return super().columns(job, rows) | {name: axis[:, i] for i, name in enumerate(TOOL_AXIS_COLUMNS)}

    def fed_in_part(self, job: PreparedCut) -> Mapping[str, float]:
        """Along the tip in the part."""
        before, length = self.motion.feed_lengths
        tools = np.array([job.program.moves[i].tool for i in self.sweep.move.tolist()])
        return {str(t): float((before + length)[tools == t].max()) for t in np.unique(tools)}

    def set_at(self, job: PreparedCut, rows: Run) -> Run:
        """Where the scenario says so, with A, B, C as the offset is used, and what of the part then lies at the zero."""
        if not job.scenario.set_as_cut:
            return rows
        names = rows.labels[OFFSET_LABEL]
        angle = np.array([self.angle_set(job, str(name)) for name in names]).reshape(-1, 3)
        position = {a: angle[:, "ABC".index(a)] if a in "ABC" else q for a, q in rows.position.items()}
        zero = zeros(job, names)
        at = np.array([point_of_part(job.machine, z, a) for z, a in zip(zero, angle)]).reshape(-1, 3)
        part = {f"part_{c}_mm": (at - job.pose.shift)[:, i] for i, c in enumerate("xyz")}
        return replace(rows, position=position, columns={**rows.columns, **part})

    def angle_set(self, job: PreparedCut, offset: str) -> Array:
        return angle_of(job.program, self.motion, offset) if job.scenario.set_as_cut else np.zeros(3)

    def tool_side(
        self, job: PreparedCut, run: Run, setting: Ints, known: Array, inputs: tuple[Input, ...]
    ) -> ToolSide:
        ways = commands_to_work(job.machine, run)
        turn = ways @ np.linalg.inv(ways[np.maximum(setting[:, 0], 0)])
        if "led" in run.columns:  # the control turns its zero with the part
            turn[run.columns["led"] > 0.5] = np.eye(3)
        return ToolSide(job.machine, run, setting, known, inputs, turn)

    def refusal(self, job: PreparedCut) -> VcmmError | None:
        """Fields over workpiece axes are known with rotary axes at zero only."""
        fixed = [e.id for e in job.machine.effects if isinstance(e, OVER_VOLUME)]
        if fixed:
            return ModelLimit(
                f"{', '.join(fixed)}: a field over workpiece axes says nothing of a machine whose rotary axes stand off zero, as this "
                f"program's do (line {self._first_turned_line(job)}); leave it out, or state the errors of the axes instead"
            )
        return super().refusal(job)

    def why_fixed(self, job: PreparedCut) -> str:
        return (
            f"line {self._first_turned_line(job)} of the program turns a rotary axis: a part that is shifted on a table "
            "that turns needs another program for every position, so it is not placed; cut it where it stands (vcmm cut)"
        )

    def _first_turned_line(self, job: PreparedCut) -> int:
        """Line of the first move with a rotary axis off zero."""
        row = int(np.argmax(np.abs(self.motion.turned).max(axis=(1, 2)) > 0))
        return job.program.moves[int(self.motion.base.move[row])].source.line

    def depth_hint(self, job: PreparedCut, depth: float, error: Exception) -> str | None:
        if not self.motion.inexact.any():
            return None
        lines = sorted(
            {job.program.moves[i].source.line for i in self.sweep.move[self.motion.inexact].tolist()}
        )
        return (
            f"a rotary axis turns while the tool is in the part, up to {depth:g} mm below the features; the moves that turn are "
            f"those of line {', '.join(map(str, lines[:10]))}{' ...' if len(lines) > 10 else ''}. Check from where it turns, the "
            f"work offset and the pose of the part ({error})"
        )
