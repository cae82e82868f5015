"""Milling with all rotary axes at zero: the steps of vcmm.shop.machining.contact_path for it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import required
from vcmm.core.errors import ModelLimit, UsageError, VcmmError
from vcmm.core.inputs import Input
from vcmm.core.run import Array, Run
from vcmm.shop.cutting.contactmap import Ints, Solids
from vcmm.shop.cutting.envelope import BEYOND, CutSurface, surface_left
from vcmm.shop.cutting.force import to_workpiece
from vcmm.shop.cutting.index import Index
from vcmm.shop.cutting.stylus import roll_ball
from vcmm.shop.cutting.sweeps import LINE, UP, Sweep, position
from vcmm.shop.cutting.tooth_force import ToothCuts
from vcmm.shop.machining.blank import Blank, BlankRequest, machined_blank
from vcmm.shop.machining.neighbours import candidates
from vcmm.shop.machining.process import (
    DEEPEST,
    DEPTH,
    HEIGHT,
    ContactRows,
    CutCandidates,
    PreparedCut,
    Process,
)
from vcmm.shop.machining.states import states_at
from vcmm.shop.machining.tool_errors import ToolSide

CONTACTS = 6  # of one point: repeated passes tie
SPINDLE_ANGLE = "spindle_angle_rad"  # column of effects that follow the turning spindle
UPRIGHT = 0.01  # share of the normal of a wall along the tool, below which the cylinder of the tool makes it
STEP = 1e-3  # of a move, to either side, for its direction


@dataclass(frozen=True, eq=False)
class MillingProcess(Process):
    """Process of milling. sweep: motions of the tools, workpiece axes; index: the same for the search."""

    sweep: Sweep
    index: Index

    def surface(self, job: PreparedCut, points: Array, normals: Array, exact: bool) -> CutSurface:
        return self.search_contacts(job, points, normals, CONTACTS)

    def search_contacts(self, job: PreparedCut, points: Array, normals: Array, contacts: int) -> CutSurface:
        """Search the surface with so many contacts of each point; deeper where it is gouged deep."""
        surface = self._surface_of_rays(job, points, normals, DEPTH, contacts)
        deep = np.flatnonzero(surface.status == BEYOND)
        if not len(deep):
            return surface
        again = self._surface_of_rays(job, points[deep], normals[deep], DEEPEST, contacts)
        names = ("status", "contact_s", "row", "t", "normal", "tests")
        merged = {name: getattr(surface, name).copy() for name in names}
        for name in names:
            merged[name][deep] = getattr(again, name)
        return replace(surface, **merged)

    def _surface_of_rays(
        self, job: PreparedCut, points: Array, normals: Array, depth: float, contacts: int
    ) -> CutSurface:
        try:
            return surface_left(points, normals, self.index, depth, HEIGHT, candidates=contacts)
        except ModelLimit as error:
            hint = self.depth_hint(job, depth, error)
            if hint is None:
                raise
            raise ModelLimit(hint) from None

    def depth_hint(self, job: PreparedCut, depth: float, error: Exception) -> str | None:
        """Return a better message for a search that found too many moves below the surface."""
        return None

    def standing(self, row: Ints, share: Array) -> tuple[Array, Array | None]:
        """Return the tips (k, 3) at shares of rows of the sweep, and frames of the tools there; None: all point along Z."""
        return position(self.sweep.take(row), share), None

    def on_path(self, job: PreparedCut, row: Ints, share: Array, at: Array) -> tuple[Run, Array]:
        """Return states with the tool at shares of rows, and how far it has left the programmed path at points (k, 3) of it."""
        return states_at(job.path, self.sweep.move[row], share, at)

    def candidates(self, job: PreparedCut, surface: CutSurface) -> CutCandidates:
        def off(row: Ints, share: Array, at: Array) -> Array:
            return self.on_path(job, row, share, at)[1]

        tips, is_cut = np.full((*surface.row.shape, 3), np.nan), surface.row >= 0
        tips[is_cut] = self.standing(surface.row[is_cut].astype(np.intp), surface.t[is_cut])[0]
        return candidates(surface, self.sweep, tips, self.standing, off)

    def cutters(self, surface: CutSurface, candidates: CutCandidates) -> Solids:
        is_cut = candidates.row >= 0
        which = np.where(is_cut, self.sweep.tool[np.maximum(candidates.row, 0)], -1).astype(np.intp)
        return Solids(self.sweep.tools, which, surface.points[:, None, :] - candidates.tip)

    def cusp_lift(self, job: PreparedCut, surface: CutSurface, some: Ints, radius: float) -> Array:
        lift = roll_ball(surface.points[some], surface.normals[some], radius, self.index)
        return np.where(np.isfinite(lift.s), np.maximum(lift.s - surface.contact_s[some, 0], 0.0), 0.0)

    def states(self, job: PreparedCut, rows: ContactRows) -> tuple[Run, Array]:
        states, known_error = self.on_path(job, rows.row, rows.share, rows.tip)
        return replace(states, offset=states.offset + (rows.at - rows.tip)), known_error

    def tool_axis(self, rows: ContactRows) -> Array:
        """Return the unit vectors (rows, 3) along the tools, workpiece axes."""
        return np.broadcast_to(UP, rows.at.shape)

    def columns(self, job: PreparedCut, rows: ContactRows) -> dict[str, Array]:
        """Return the columns, with the share of the normal that lies across the axis of the tool: 1 on walls, 0 on floors."""
        across = np.cross(rows.surface.normals[rows.point], self.tool_axis(rows))
        return super().columns(job, rows) | {"across_tool": np.linalg.norm(across, axis=1)}

    def force(self, job: PreparedCut, rows: ContactRows, forces: Array) -> Array:
        assert isinstance(job.blank, Blank)
        assert job.blank.pieces is not None
        stretch, share = job.blank.pieces.at(rows.row, rows.share)
        out = force_along(forces, job.blank.pieces.sweep, stretch, share)
        if job.blank.teeth is not None:
            _made_by_edges(out, job.blank.teeth, job.blank.pieces.sweep.take(stretch), stretch, share, rows)
        return out

    def tool_side(
        self, job: PreparedCut, run: Run, setting: Ints, known_error: Array, inputs: tuple[Input, ...]
    ) -> ToolSide:
        return ToolSide(job.machine, run, setting, known_error, inputs)

    def blank(self, job: PreparedCut, zero: Array) -> Blank | None:
        asks = BlankRequest(runout_by_tool(job), self.feed(job), self.rough)
        return machined_blank(job.scenario.setup, job.program, self.sweep, zero, asks)

    def rough(self, within: float) -> Sweep:
        """Return a sweep that is accurate enough for a picture of the stock, mm."""
        return self.sweep

    def feed(self, job: PreparedCut) -> Array | None:
        """Return the speed of the tip over the part in each row of the sweep, mm/min; None: F as programmed."""
        return None

    def refusal(self, job: PreparedCut) -> VcmmError | None:
        """Return an error for a wave with a tool that runs out: the most protruding tooth passes everywhere once per turn, and a wave
        would be undersampled."""
        waves = [e for e in job.machine.effects if SPINDLE_ANGLE in required(e)]
        if waves:
            return UsageError(
                f"{waves[0].id}: while milling the most protruding tooth makes the surface at any angle; write harmonic = 0 with the "
                "amplitude (feed marks, f^2 / 8R per turn, come on top). Waves per turn are for lathes and for diagnose"
            )
        return None


def runout_by_tool(job: PreparedCut) -> dict[int, float]:
    """Return the run-out of the most protruding tooth of each tool in mm, as the machine file states it."""
    stated = [
        e for e in job.machine.effects if e.about.belongs_to == "tool" and getattr(e, "harmonic", None) == 0
    ]
    numbers = {m.tool for m in job.program.moves}
    by_tool = {
        n: sum(float(getattr(e, "cosine", 0.0)) for e in stated if getattr(e, "tool", "") in ("", str(n)))
        for n in numbers
    }
    return {n: amount for n, amount in by_tool.items() if amount > 0.0}


def force_along(forces: Array, sweep: Sweep, row: Ints, share: Array) -> Array:
    """Return the force (k, 3) N at fractions share (k,) of the rows (k,); forces (rows, 3): for the middle of each, workpiece axes.

    The force of a move is a mean over the move, stated for the direction in its middle. On an arc the direction of feed
    turns while the tool runs along it, and the force with it: round a full circle a boss is cut larger all round, not shifted.
    """
    out = np.array(forces[row])
    arcs = np.flatnonzero(sweep.kind[row] != LINE)
    if len(arcs):
        mine = sweep.take(row[arcs])
        middle = _feed(mine, np.full(len(arcs), 0.5))
        here = _feed(mine, np.clip(share[arcs], STEP, 1.0 - STEP))
        x, y = (to_workpiece(np.tile(e, (len(arcs), 1)), middle, mine.axis) for e in np.eye(3)[:2])
        along = [np.einsum("ki,ki->k", out[arcs], v) for v in (x, y, mine.axis)]
        out[arcs] = to_workpiece(np.stack(along, axis=1), here, mine.axis)
    return out


def _made_by_edges(
    out: Array, teeth: ToothCuts, sweep: Sweep, stretch: Ints, share: Array, rows: ContactRows
) -> None:
    """Replace the mean force of a turn on walls that a cylinder of known helix makes, by the force at the moment at which an edge makes them.

    An edge makes the point at the angle, from feed and left of it, of the way from the axis to the point, against the outward normal.
    """
    normal, axis = rows.surface.normals[rows.point], sweep.axis
    steep = np.einsum("ki,ki->k", normal, axis)
    walls = np.flatnonzero(
        ~np.isnan(teeth.lag[stretch]) & (np.abs(steep) < UPRIGHT) & (teeth.axial[stretch] > 0.0)
    )
    if not len(walls):
        return
    inner = np.where(sweep.kind == LINE, 0.5, np.clip(share, STEP, 1.0 - STEP))
    feed = _feed(sweep, inner)[walls]
    normal, axis = normal[walls], axis[walls]
    across = feed - np.einsum("ki,ki->k", feed, axis)[:, None] * axis
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-12)[:, None]
    left = np.cross(axis, across)
    angle = np.arctan2(-np.einsum("ki,ki->k", normal, across), -np.einsum("ki,ki->k", normal, left))
    height = np.einsum("ki,ki->k", (rows.at - rows.tip)[walls], axis)
    out[walls] = to_workpiece(teeth.take(stretch[walls]).generating(angle, height), feed, axis)


def _feed(sweep: Sweep, share: Array) -> Array:
    """Return the direction of feed (k, 3) at fractions (k,) of the rows."""
    way = position(sweep, share + STEP) - position(sweep, share - STEP)
    length = np.linalg.norm(way, axis=1)
    return np.asarray(way / np.where(length > 0.0, length, 1.0)[:, None])
