"""Turning: the steps of vcmm.shop.machining.contact_path on a lathe.

Everything is in the meridian frame of the pass: x from the spindle axis to the tool, y square to both, z along the axis.
It turns with the angle C of the spindle, so that errors which the machine states in axes of the workpiece are turned back by
C. An error e of the tool moves the surface along n by (N . e) / (N . n); a radial one counts twice in a diameter. An error
e_y square to the section (height of the tool) makes a point at the radius rho come out at sqrt((rho + e_x)^2 + e_y^2): of
second order, e_y^2 / 2 rho, but for the middle of a face. Its effect on the angle of the contact is left out.

Tools and offsets were set by a trial cut: the machine's errors at the place of setting, as the mean over a turn of the
spindle, are subtracted draw by draw.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.inputs import Input
from vcmm.core.run import Array, Run
from vcmm.part.part import Feature
from vcmm.shop.cutting import nose
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.envelope import CutSurface
from vcmm.shop.cutting.sweeps import Sweep, position
from vcmm.shop.machining.maps import Net
from vcmm.shop.machining.process import (
    DEEPEST,
    DEPTH,
    HEIGHT,
    ContactRows,
    CutCandidates,
    PreparedCut,
    Process,
    Words,
    by_axis,
)
from vcmm.shop.machining.states import by_tool, states_when
from vcmm.shop.machining.tool_errors import ToolSide
from vcmm.shop.machining.turned_blank import TurnedBlank, turned_blank
from vcmm.shop.machining.turned_faces import turned_net
from vcmm.shop.machining.turned_passes import crest_lift
from vcmm.shop.machining.turned_surface import TurnedSurface, Turning, backs, turned_surface
from vcmm.shop.motion.toolpath import CUTS, Toolpath
from vcmm.task.measuring.settings import Settings

STEP = 1e-3  # of a move, to either side, for its direction
ANGLES = 12  # of the spindle, over which the errors at the place of setting are averaged
EXACT_TRIALS = 2000  # where no engine is requested: interval ends to about 3 % of U


@dataclass(frozen=True, eq=False)
class NoseCircles:
    """The noses of the candidates: arm (P, K, 2) from their centre to the point, r (P, K); rho (P,) radius of the point."""

    arm: Array
    r: Array
    rho: Array

    def entry(self, shift: Array, normal: Array) -> Array:
        """Return where the rays from the points along normal (P, 3) meet noses moved by shift (..., P, K, 3), (..., P, K)."""
        rho = self.rho[:, None]
        out = np.hypot(rho + shift[..., 0], shift[..., 1]) - rho
        moved = np.stack([self.arm[..., 0] - out, self.arm[..., 1] - shift[..., 2]], axis=-1)
        rays = np.broadcast_to(normal[:, None, [0, 2]], moved.shape)
        return nose.entry(moved, rays, self.r)


@dataclass(frozen=True, eq=False)
class TurningProcess(Process):
    """Process of turning. turning: the program in the meridian half plane."""

    turning: Turning
    each_tool_set = True

    @property
    def sweep(self) -> Sweep:  # type: ignore[override]
        return self.turning.sweep

    def surface(self, job: PreparedCut, points: Array, normals: Array, exact: bool) -> TurnedSurface:
        return turned_surface(self.turning, points, normals, DEPTH, DEEPEST, HEIGHT)

    def contacts_seen(self, surface: CutSurface) -> tuple[Array, Array]:
        surface = _as_turned(surface)
        return surface.flat + np.array([*self.turning.centre, 0.0]), surface.flat_normals

    def candidates(self, job: PreparedCut, surface: CutSurface) -> CutCandidates:
        """Return the passes of the nose that the surface holds; tip: the imaginary one of the insert, machine axes."""
        is_cut, tip = surface.row >= 0, np.zeros((*surface.row.shape, 3))
        row, share = surface.row[is_cut], surface.t[is_cut]
        centre = nose.noses(self.sweep, row, share)
        at = np.zeros((len(row), 3))
        at[:, [0, 2]] = centre + nose.nose_radius(self.sweep)[row][:, None] * self.turning.to_tip[row]
        at[:, :2] += self.turning.centre
        tip[is_cut] = at
        height = np.where(is_cut, surface.contact_s, np.inf)
        return CutCandidates(height, surface.normal, tip, surface.row, surface.t)

    def cutters(self, surface: CutSurface, candidates: CutCandidates) -> NoseCircles:
        flat, is_cut = _as_turned(surface).flat, candidates.row >= 0
        row, point = candidates.row[is_cut], np.nonzero(is_cut)[0]
        arm, r = np.zeros((*is_cut.shape, 2)), np.ones(is_cut.shape)
        arm[is_cut] = flat[point][:, [0, 2]] - nose.noses(self.sweep, row, candidates.share[is_cut])
        r[is_cut] = nose.nose_radius(self.sweep)[row]
        return NoseCircles(arm, r, flat[:, 0])

    def cusp_lift(self, job: PreparedCut, surface: CutSurface, some: Ints, radius: float) -> Array:
        return crest_lift(self.turning, _as_turned(surface), some, radius)

    def net(self, job: PreparedCut, feature: Feature, across: int) -> Net | None:
        return turned_net(feature, across, job.pose, self.turning)

    def states(self, job: PreparedCut, rows: ContactRows) -> tuple[Run, Array]:
        """Return the states with axis C at the angle at which the tool passes the section of the point."""
        time = _as_turned(rows.surface).time[rows.point, rows.candidate]
        states, known_error = states_when(job.path, self.sweep.move[rows.row], time, rows.tip)
        cut = np.interp(time, job.path.time, chip_length(job.path, self.turning.centre))
        turned = {"C": self.turning.position_c(self._phi(rows))} if self.turning.rotary else {}
        states = replace(
            states, position={**states.position, **turned}, offset=states.offset + rows.at - rows.tip
        )
        return states.with_columns({"cut_length_mm": cut}), known_error

    def _phi(self, rows: ContactRows) -> Array:
        """Return the angle (rows,) by which workpiece axes are turned from the section: zero where the spindle is no axis."""
        return _as_turned(rows.surface).phi[rows.point] if self.turning.rotary else np.zeros(len(rows.point))

    def columns(self, job: PreparedCut, rows: ContactRows) -> dict[str, Array]:
        """Return the columns in axes of the workpiece: normal, place in the part, way from the tip to the centre of the nose."""
        phi, to_tip = self._phi(rows), self.turning.to_tip[rows.row]
        centre = np.array([*self.turning.centre, 0.0])
        place = turned_by(rows.at - centre, phi) + centre - job.pose.shift
        inward = np.stack([-to_tip[:, 0], np.zeros(len(phi)), -to_tip[:, 1]], axis=1)
        normal = turned_by(_as_turned(rows.surface).flat_normals[rows.point], phi)
        return (
            by_axis("n{}", normal) | by_axis("part_{}_mm", place) | by_axis("nose_{}", turned_by(inward, phi))
        )

    def fed_in_part(self, job: PreparedCut) -> Mapping[str, float]:
        """Return the feed length: wear of a lathe goes by the length of the chips."""
        return by_tool(job.path, chip_length(job.path, self.turning.centre))

    def force(self, job: PreparedCut, rows: ContactRows, forces: Array) -> Array:
        return turned_by(turning_force_along(forces, self.sweep, rows.row, rows.share), self._phi(rows))

    @property
    def rows_per_zero(self) -> int:  # type: ignore[override]
        return ANGLES if self.turning.rotary else 1

    def set_at(self, job: PreparedCut, rows: Run) -> Run:
        if not self.turning.rotary:
            return rows
        turn = np.tile(2 * np.pi * np.arange(ANGLES) / ANGLES, rows.n // ANGLES)
        return replace(rows, position={**rows.position, "C": self.turning.position_c(turn)})

    def tool_side(
        self, job: PreparedCut, run: Run, setting: Ints, known_error: Array, inputs: tuple[Input, ...]
    ) -> ToolSide:
        phi = run.position["C"] if self.turning.rotary else np.zeros(run.n)
        return ToolSide(
            job.machine, run, setting, known_error, inputs, phi=phi, rows_per_zero=self.rows_per_zero
        )

    def blank(self, job: PreparedCut, zero: Array) -> TurnedBlank | None:
        return turned_blank(job.scenario.setup, job.program, self.turning, float(zero[2]))

    def why_fixed(self, job: PreparedCut) -> str:
        return (
            "vcmm place cannot move a turned part: it lies on the axis of the spindle. How far it protrudes from the chuck is the work "
            "offset in Z; change it in the set-up and run vcmm cut again"
        )

    def engine(self, settings: Settings) -> tuple[Settings, tuple[str, ...]]:
        """Return settings of exact trials: feed marks move along with the errors, which the linear model does not follow."""
        if settings.engine != "auto":
            return settings, ()
        trials = min(settings.trials, EXACT_TRIALS)
        text = f"computed by {trials} exact trials, as feed marks move along with the errors"
        if trials < settings.trials:
            text += f"; all {settings.trials} with --engine exact, or a linear model with --engine montecarlo"
        return replace(settings, engine="exact", trials=trials), (text,)

    def remarks(self) -> Sequence[str]:
        return self.turning.notes

    def remarks_on(self, surface: CutSurface, features: Words) -> Sequence[str]:
        return backs(self.turning, _as_turned(surface), features)


def _as_turned(surface: CutSurface) -> TurnedSurface:
    assert isinstance(surface, TurnedSurface)
    return surface


def turned_by(vectors: Array, phi: Array) -> Array:
    """Return the vectors (n, 3) turned by phi (n,) about z."""
    c, s = np.cos(phi), np.sin(phi)
    x, y, z = vectors.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


def chip_length(path: Toolpath, centre: Array) -> Array:
    """Return the length (n,) mm that the edge of the tool of each row has cut by then: 2 pi x dn over its feed moves (ISO 3685)."""
    radius = np.abs(path.tip[:, 0] - centre[0])
    rate = 2 * np.pi / 60.0 * np.abs(path.columns["spindle_rpm"])
    middle = 0.5 * (radius + np.concatenate([radius[:1], radius[:-1]]))
    feeding = np.array([m.kind in CUTS for m in path.timing.moves], dtype=bool)[path.move]
    step = np.where(feeding, rate * middle * np.diff(path.time, prepend=path.time[:1]), 0.0)
    tools, out = path.columns["tool_number"], np.zeros(path.n)
    for tool in np.unique(tools):
        mine = tools == tool
        out[mine] = np.cumsum(np.where(mine, step, 0.0))[mine]
    return out


def turning_force_along(forces: Array, sweep: Sweep, row: Ints, share: Array) -> Array:
    """Return the force (k, 3) N at shares (k,) of rows (k,), meridian frame; forces (rows, 3): for the middle of each.

    The force of a move is stated for the direction of feed in its middle; along an arc it turns with the feed.
    """
    part = sweep.take(row)
    lean = _slope(part, np.clip(share, STEP, 1.0 - STEP)) - _slope(part, np.full(len(row), 0.5))
    x, y, z = forces[row].T
    c, s = np.cos(lean), np.sin(lean)
    return np.stack([c * x - s * z, y, s * x + c * z], axis=1)


def _slope(sweep: Sweep, share: Array) -> Array:
    """Return the angle (k,) of the direction of feed in the meridian, from x to z, rad."""
    way = position(sweep, share + STEP) - position(sweep, share - STEP)
    return np.arctan2(way[:, 2], way[:, 0])
