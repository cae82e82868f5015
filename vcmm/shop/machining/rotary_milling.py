"""Milling with rotary axes off zero: the steps of vcmm.shop.machining.contact_path that differ from three axes.

Contacts while rotary axes turn, put exactly where the tool stands, and solids of tools that do not point along Z.

The search knows a turning tool as short rows of constant direction (vcmm.shop.machining.rotary_sweep). For each contact found
there, the tool is put at shares of its move about it, exactly, and met by the ray in closed form: the lowest entry over
the share is the surface. The window shrinks about the best share so far. What is lowest over a window of PIECES rows to
either side is taken; a program that touches a point more often has further contacts there.
"""

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
from vcmm.shop.cutting.standing_tool import entry
from vcmm.shop.cutting.sweeps import Sweep
from vcmm.shop.machining.milling import CONTACTS, MillingProcess
from vcmm.shop.machining.process import ContactRows, CutCandidates, PreparedCut, zeros
from vcmm.shop.machining.rotary import (
    RotaryMotion,
    angle_of,
    commands_to_work,
    point_of_part,
    tool_offset_to,
    turn_to_workpiece,
)
from vcmm.shop.machining.rotary_sweep import in_workpiece, turns
from vcmm.shop.machining.states import moment, seconds_at
from vcmm.shop.machining.tool_errors import ToolSide

PIECES = 3.0  # rows to either side
# 4^10: the share is found to 1e-6 of the window, the height, which is flat there, to rounding
LOOKS = 9
ROUNDS = 10
ASTRAY = 0.02  # mm: an exact entry further off belongs to another side of the tool


@dataclass(frozen=True, eq=False)
class TiltedSolids(Solids):
    """Solids of tools with other directions: frame (P, K, 3, 3), axes of each tool as rows, in workpiece axes."""

    frame: Array | None = None

    def entry(self, shift: Array, normal: Array) -> Array:
        """Return where the rays from the points along normal (P, 3) enter the tools moved by shift (..., P, K, 3), (..., P, K)."""
        out = np.full(shift.shape[:-1], np.inf)
        frame = np.broadcast_to(self.frame, (*out.shape, 3, 3))  # type: ignore[arg-type]
        rays = np.broadcast_to(normal[:, None, :], shift.shape)
        for number, tool in enumerate(self.tools):
            mine = np.broadcast_to(self.which == number, out.shape)
            if mine.any():
                f = frame[mine]
                out[mine] = entry(
                    tool, turn_to_workpiece(f, (self.arm - shift)[mine]), turn_to_workpiece(f, rays[mine])
                )
        return out


def polish_contacts(surface: CutSurface, motion: RotaryMotion, keep: int) -> CutSurface:
    """Return the surface with exact contacts of turning tools, each once, the `keep` lowest of every point."""
    surface = _each_once(surface, motion)
    is_cut = surface.row >= 0
    point, k = np.nonzero(is_cut & motion.inexact[np.maximum(surface.row, 0)])
    if not len(point):
        return _lowest(surface, keep)
    row = surface.row[point, k].astype(np.intp)
    height, t = _least(motion, row, surface.t[point, k], surface.points[point], surface.normals[point])
    near = np.abs(height - surface.contact_s[point, k]) < ASTRAY
    s, at = surface.contact_s.copy(), surface.t.copy()
    s[point[near], k[near]], at[point[near], k[near]] = height[near], t[near]
    return _lowest(_sort_by_height(replace(surface, contact_s=np.where(is_cut, s, np.inf), t=at)), keep)


def _least(motion: RotaryMotion, row: Ints, t: Array, points: Array, normals: Array) -> tuple[Array, Array]:
    """Return (least height, fraction of the row) (k,) about fractions t of rows; the fraction may lie beside the row, on its move."""
    width = (motion.last - motion.first)[row]
    best = motion.share(row, t)
    low, high = np.clip(best - PIECES * width, 0.0, 1.0), np.clip(best + PIECES * width, 0.0, 1.0)
    least = np.full(len(row), np.inf)
    every = np.arange(len(row))
    for _ in range(ROUNDS):
        share = low + np.linspace(0.0, 1.0, LOOKS)[:, None] * (high - low)
        heights = np.array([_entries_of_rays(motion, row, at, points, normals) for at in share])
        i = heights.argmin(axis=0)
        lower = heights[i, every] < least
        best = np.where(lower, share[i, every], best)
        least = np.where(lower, heights[i, every], least)
        step = (high - low) / (LOOKS - 1)
        low, high = np.maximum(best - step, low), np.minimum(best + step, high)
    return least, (best - motion.first[row]) / width


def _entries_of_rays(motion: RotaryMotion, row: Ints, share: Array, points: Array, normals: Array) -> Array:
    """Return where rays (k,) enter the tool of rows at shares (k,) of their moves; inf where they miss."""
    t = (share - motion.first[row]) / (motion.last - motion.first)[row]
    tip, frame = motion.standing(row, t)
    arm, ray = turn_to_workpiece(frame, points - tip), turn_to_workpiece(frame, normals)
    out = np.full(len(row), np.inf)
    which = motion.base.tool[motion.row[row]]
    for number, tool in enumerate(motion.base.tools):
        mine = which == number
        out[mine] = entry(tool, arm[mine], ray[mine])
    return out


def _sort_by_height(surface: CutSurface) -> CutSurface:
    """Sort contacts by height."""
    order = np.argsort(surface.contact_s, axis=1, kind="stable")
    at = np.arange(len(order))[:, None]
    return replace(
        surface, contact_s=surface.contact_s[at, order], row=surface.row[at, order], t=surface.t[at, order], normal=surface.normal[at, order]
    )  # fmt: skip


def _each_once(surface: CutSurface, motion: RotaryMotion) -> CutSurface:
    """Drop contacts of rows that lie in the window about a lower contact of the same turning move: they are the same contact."""
    row = np.maximum(surface.row, 0)
    move = np.where(surface.row >= 0, motion.row[row], -1)
    share = np.where(
        surface.row >= 0, motion.first[row] + surface.t * (motion.last - motion.first)[row], np.nan
    )
    window = np.where(motion.inexact[row], (PIECES - 0.5) * (motion.last - motion.first)[row], 0.0)
    again = np.zeros(row.shape, dtype=bool)
    for k in range(1, row.shape[1]):
        same = (move[:, :k] == move[:, k : k + 1]) & ~again[:, :k]
        again[:, k] = (same & (np.abs(share[:, :k] - share[:, k : k + 1]) < window[:, :k])).any(axis=1)
    gone = again & (surface.row >= 0)
    return _sort_by_height(
        replace(
            surface, contact_s=np.where(gone, np.inf, surface.contact_s), row=np.where(gone, -1, surface.row)
        )
    )


def _lowest(surface: CutSurface, keep: int) -> CutSurface:
    """Return the `keep` lowest contacts; missing ones have nan, as from the search."""
    is_cut = surface.row[:, :keep] >= 0
    return replace(
        surface, contact_s=np.where(is_cut, surface.contact_s[:, :keep], np.nan), row=surface.row[:, :keep],
        t=np.where(is_cut, surface.t[:, :keep], np.nan), normal=np.where(is_cut[:, :, None], surface.normal[:, :keep], np.nan),
    )  # fmt: skip


OF_TURNING = 16  # contacts of one point while rotary axes turn: rows beside each other find one contact


@dataclass(frozen=True, eq=False)
class RotaryMillingProcess(MillingProcess):
    """Process of milling with rotary axes. motion: how the rows of the sweep lie on the moves."""

    motion: RotaryMotion

    def surface(self, job: PreparedCut, points: Array, normals: Array, exact: bool) -> CutSurface:
        if not exact or not self.motion.inexact.any():
            return self.search_contacts(job, points, normals, CONTACTS)
        return polish_contacts(self.search_contacts(job, points, normals, OF_TURNING), self.motion, CONTACTS)

    def standing(self, row: Ints, share: Array) -> tuple[Array, Array | None]:
        return self.motion.standing(row, share)

    def on_path(self, job: PreparedCut, row: Ints, share: Array, at: Array) -> tuple[Run, Array]:
        """Return the states as while milling. The offset of the run leads to the points `at` (k, 3), which count as fixed to the tool."""
        motion, path = self.motion, job.path
        move, along = motion.row[row], motion.share(row, share)
        time = seconds_at(path.timing, motion.base.move[move], along)
        columns, labels = moment(path, motion.base.move[move], time)
        before, length = motion.feed_lengths  # the toolpath counts X, Y and Z only
        columns["cut_length_mm"] = before[row] + share * length[row]
        position = motion.command(move, along)
        offset = tool_offset_to(motion.machine, position, at)
        columns |= self._leading(job, motion.base.move[move], Run(position, offset))
        state = path.timing.state(time).position
        really = {letter: state[:, AXES.index(letter)] for letter in position}
        for letter, c in zip("XYZ", "xyz"):
            if letter in really:
                really[letter] = really[letter] + columns[f"follow_{c}_mm"]
        moved = nominal_tip(motion.machine.chain, motion.machine.axes, Run(really, offset))
        return Run(position, offset, columns, labels), moved - at

    def _leading(self, job: PreparedCut, move: Ints, run: Run) -> dict[str, Array]:
        """Return, where the control leads the tip over the workpiece, the commanded X, Y, Z for 1 mm along each axis of the part, else
        the axis itself; led: 1 there. Nothing where no move is led."""
        led = np.array([job.program.moves[i].tool_axis_end is not None for i in move.tolist()], dtype=bool)
        if not any(m.tool_axis_end is not None for m in job.program.moves):
            return {}
        commands = np.where(led[:, None, None], np.linalg.inv(commands_to_work(job.machine, run)), np.eye(3))
        names = {f"led_{d}{c}": commands[:, i, j] for j, d in enumerate("xyz") for i, c in enumerate("xyz")}
        return {"led": led.astype(float), **names}

    def cutters(self, surface: CutSurface, candidates: CutCandidates) -> Solids:
        plain, is_cut = super().cutters(surface, candidates), candidates.row >= 0
        frame = np.broadcast_to(np.eye(3), (*is_cut.shape, 3, 3)).copy()
        frame[is_cut] = self.motion.standing(candidates.row[is_cut], candidates.share[is_cut])[1]
        return TiltedSolids(plain.tools, plain.which, plain.arm, frame)

    def cusp_lift(self, job: PreparedCut, surface: CutSurface, some: Ints, radius: float) -> Array:
        """Return the lift of a ball that rolls on the surface of the search."""
        rough = self.surface(job, surface.points[some], surface.normals[some], exact=False)
        return super().cusp_lift(job, rough, np.arange(len(some)), radius)

    def states(self, job: PreparedCut, rows: ContactRows) -> tuple[Run, Array]:
        return self.on_path(job, rows.row, rows.share, rows.at)

    def tool_axis(self, rows: ContactRows) -> Array:
        return self.motion.standing(rows.row, rows.share)[1][:, 2]

    def columns(self, job: PreparedCut, rows: ContactRows) -> dict[str, Array]:
        axis = self.tool_axis(rows)
        return super().columns(job, rows) | {name: axis[:, i] for i, name in enumerate(TOOL_AXIS_COLUMNS)}

    def rough(self, within: float) -> Sweep:
        """Return the sweep in as few rows as miss the tool by no more than that, while rotary axes turn."""
        m = self.motion
        return in_workpiece(m.machine, m.base, m.angles, m.offset, m.rapid, within)[0]

    def feed(self, job: PreparedCut) -> Array:
        """Return the feed: where a rotary axis turns, F may be degrees per minute, so the way of the tip over the part in its time counts."""
        motion = self.motion
        move = motion.base.move[motion.row]
        programmed = np.array([job.program.moves[i].feed or 0.0 for i in move.tolist()])
        begins, ends = (seconds_at(job.path.timing, move, share) for share in (motion.first, motion.last))
        time = np.maximum(ends - begins, 1e-9)
        return np.where(turns(motion.angles)[motion.row], motion.feed_lengths[1] / time * 60.0, programmed)

    def fed_in_part(self, job: PreparedCut) -> Mapping[str, float]:
        """Return the feed length along the tip in the part."""
        before, length = self.motion.feed_lengths
        tools = np.array([job.program.moves[i].tool for i in self.sweep.move.tolist()])
        return {str(t): float((before + length)[tools == t].max()) for t in np.unique(tools)}

    def set_at(self, job: PreparedCut, rows: Run) -> Run:
        """Return the rows of setting where the scenario says so, with A, B, C as the offset is used, and the point of the part at the zero."""
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
        self, job: PreparedCut, run: Run, setting: Ints, known_error: Array, inputs: tuple[Input, ...]
    ) -> ToolSide:
        ways = commands_to_work(job.machine, run)
        turn = ways @ np.linalg.inv(ways[np.maximum(setting[:, 0], 0)])
        if "led" in run.columns:  # the control turns its zero with the part
            turn[run.columns["led"] > 0.5] = np.eye(3)
        return ToolSide(job.machine, run, setting, known_error, inputs, turn)

    def refusal(self, job: PreparedCut) -> VcmmError | None:
        """Refuse fields over workpiece axes, which are known with rotary axes at zero only."""
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
            "that turns needs another program for every position, so it is not placed; cut it in its present place (vcmm cut)"
        )

    def _first_turned_line(self, job: PreparedCut) -> int:
        """Return the line of the first move with a rotary axis off zero."""
        row = int(np.argmax(np.abs(self.motion.angles).max(axis=(1, 2)) > 0))
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
