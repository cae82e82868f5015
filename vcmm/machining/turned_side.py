"""The lathe when it cuts each point: states of the machine at the passes, and how errors there move the surface.

Everything stands in the meridian frame of the pass: x from the spindle axis to the tool, y square to both, z along the axis.
It turns with the angle C of the spindle, so that errors which the machine states in axes of the workpiece are turned back by
C. An error e of the tool moves the surface along n by (N . e) / (N . n); a radial one counts twice in a diameter. An error
e_y square to the section (height of the tool) makes a point at the radius rho come out at sqrt((rho + e_x)^2 + e_y^2): of
second order, e_y^2 / 2 rho, but for the middle of a face. What it does to the angle of the contact is left out.

Tools and offsets were set by a trial cut: what the machine errs by at the place of setting, as the mean over a turn of the
spindle, is taken off draw by draw.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.inputs import Input
from vcmm.core.run import OFFSET_LABEL, Array, Run
from vcmm.cutting import nose
from vcmm.cutting.contactmap import Contacts, Ints, upright
from vcmm.cutting.sweeps import Sweep, position
from vcmm.machining.batch import by_tool, later_in_batch
from vcmm.machining.preparation import Shop, zeros
from vcmm.machining.rows import Words, joined, setting_rows, settings_of
from vcmm.machining.tool_errors import ToolSide
from vcmm.machining.turned import TurnedSurface, Turning
from vcmm.machining.turning_states import chip_length, states_when
from vcmm.machining.zero_setting import without_setting
from vcmm.response.influence import Influence, Product
from vcmm.response.trials import Draws

STEP = 1e-3  # of a move, to either side, for its direction
ANGLES = 12  # of the spindle, over which the errors at the place of setting are averaged


@dataclass(frozen=True, eq=False)
class NoseCircles:
    """The noses of the candidates: arm (P, K, 2) from their centre to the point, r (P, K); rho (P,) radius of the point."""

    arm: Array
    r: Array
    rho: Array

    def entry(self, shift: Array, normal: Array) -> Array:
        """Where the rays from the points along normal (P, 3) meet noses moved by shift (..., P, K, 3), (..., P, K)."""
        rho = self.rho[:, None]
        out = np.hypot(rho + shift[..., 0], shift[..., 1]) - rho
        moved = np.stack([self.arm[..., 0] - out, self.arm[..., 1] - shift[..., 2]], axis=-1)
        rays = np.broadcast_to(normal[:, None, [0, 2]], moved.shape)
        return nose.entry(moved, rays, self.r)


@dataclass(frozen=True, eq=False, kw_only=True)
class TurnedSide(ToolSide):
    """setting (n,): first of the `angles` rows in which the zero of each row was set, -1 = none; phi (n,): C of the frame."""

    phi: Array
    angles: int

    def errors(self, exact: bool = False) -> Array:
        return self._less(self._back(self._plain.errors(exact))) + self.known

    def influences(self) -> tuple[Influence, ...]:
        found = super().influences()
        turned = [np.moveaxis(self._back(np.moveaxis(f.response, -1, 0)), 0, -1) for f in found]
        return tuple(replace(f, response=r) for f, r in zip(found, turned))

    def relative(self, one: Influence) -> Influence:
        return replace(one, response=self._less_response(one.response, one.codes))

    def products(self, found: Sequence[Influence]) -> tuple[Product, ...]:
        return tuple(
            replace(
                p,
                response=self._less_response(
                    self._back(p.response), found[p.first].codes, found[p.second].codes
                ),
            )
            for p in self._plain.products(found)
        )

    def exact(self, drawn: Sequence[Draws]) -> Array:
        at = np.flatnonzero(self.setting < 0) if (self.setting >= 0).any() else np.zeros(0, dtype=np.intp)
        quiet = [without_setting(d, at) for d in drawn]
        return self._less(self._back(self._plain.exact(quiet))) + self.known

    @property
    def _plain(self) -> ToolSide:
        """The same rows, nothing taken off and nothing known."""
        none, nothing = np.full(self.run.n, -1, dtype=np.intp), np.zeros_like(self.known)
        return ToolSide(self.machine, self.run, none, nothing, self.inputs)

    def _back(self, vectors: Array) -> Array:
        """Vectors (..., n, 3) of workpiece axes, in the meridian frame of their row."""
        c, s = np.cos(self.phi), np.sin(self.phi)
        x, y, z = (vectors[..., i] for i in range(3))
        return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)

    def _rows(self) -> Ints:
        """Rows of setting of every row (n, angles)."""
        return np.maximum(self.setting, 0)[:, None] + np.arange(self.angles)

    def _less(self, found: Array) -> Array:
        """Errors (..., n, 3) less the mean of those in the rows of setting."""
        if not (self.setting >= 0).any():
            return found
        mean = found[..., self._rows(), :].mean(axis=-2)
        return np.asarray(found - np.where((self.setting >= 0)[:, None], mean, 0.0))

    def _less_response(self, response: Array, *codes: Ints) -> Array:
        """Responses (n, 3, ...) less their mean in the rows of setting, where the draws are the same there."""
        if not (self.setting >= 0).any():
            return response
        same = self.setting >= 0
        for one in codes:
            same = same & (one == one[np.maximum(self.setting, 0)])
        mean = response[self._rows()].mean(axis=1)
        return np.asarray(response - np.where(same.reshape(-1, *[1] * (response.ndim - 1)), mean, 0.0))


def turned_side(
    shop: Shop, surface: TurnedSurface, touch: Words, feature: Words, inputs: tuple[Input, ...] = ()
) -> tuple[TurnedSide, Contacts]:
    """States of the lathe at every pass that may cut a point, and how its errors there move the surface."""
    turning = shop.turning
    assert turning is not None
    contacts, point, candidate = _contacts(turning, surface)
    run, known, phi = _cut_run(shop, turning, surface, point, candidate)
    run = replace(run, labels={**run.labels, "touch": touch[point], "feature": feature[point]})
    full, setting, turn, angles = _with_setting(shop, turning, run, phi)
    known = np.concatenate([known, np.zeros((full.n - run.n, 3))])
    turn = turn if turning.rotary else np.zeros(full.n)
    return TurnedSide(
        shop.machine, shop.machine.prepare(full), setting, known, inputs, phi=turn, angles=angles
    ), contacts


def _contacts(turning: Turning, surface: TurnedSurface) -> tuple[Contacts, Ints, Ints]:
    known = surface.row >= 0
    point, candidate = np.nonzero(known)
    row = np.full(surface.row.shape, -1, dtype=np.intp)
    row[point, candidate] = np.arange(len(point))
    which, share = surface.row[point, candidate], surface.t[point, candidate]
    arm, r = np.zeros((*known.shape, 2)), np.ones(known.shape)
    centre = nose.noses(turning.sweep, which, share)
    arm[point, candidate] = surface.flat[point][:, [0, 2]] - centre
    r[point, candidate] = nose.nose_radius(turning.sweep)[which]
    height = np.where(known, surface.contact_s, np.inf)
    cutter = upright(surface.normal, surface.flat_normals, known)
    circles = NoseCircles(arm, r, surface.flat[:, 0])
    return Contacts(height, cutter, surface.flat_normals, row, circles), point, candidate  # type: ignore[arg-type]


def _cut_run(
    shop: Shop, turning: Turning, surface: TurnedSurface, point: Ints, candidate: Ints
) -> tuple[Run, Array, Array]:
    """(run of all passes, what is known there (rows, 3) in the meridian frame, angle of the spindle (rows,))."""
    row, share = surface.row[point, candidate], surface.t[point, candidate]
    phi, n = surface.phi[point], surface.flat_normals[point]
    r = nose.nose_radius(turning.sweep)[row]
    centre = nose.noses(turning.sweep, row, share)
    tip = np.zeros((len(row), 3))
    tip[:, [0, 2]] = centre + r[:, None] * turning.to_tip[row]
    tip[:, :2] += turning.centre
    contact = surface.flat[point] + surface.contact_s[point, candidate][:, None] * n
    contact = contact + np.array([*turning.centre, 0.0])
    states, known = states_when(turning, surface.time[point, candidate], turning.sweep.move[row], tip, phi)
    columns = _columns(shop, turning, n, contact, turning.to_tip[row], phi)
    chips = by_tool(turning.path, chip_length(turning.path, turning.centre))  # wear of a lathe goes by these
    states = later_in_batch(states, turning.path, shop.scenario.batch_part, chips)
    force = turning_forces(shop, row, share, phi if turning.rotary else np.zeros(len(phi)))
    offset = states.offset + contact - tip
    full = Run(states.position, offset, {**states.columns, **columns, **force}, states.labels, states.series)
    return full, known, phi


def turned_by(vectors: Array, phi: Array) -> Array:
    """Vectors (n, 3) turned by phi (n,) about z."""
    c, s = np.cos(phi), np.sin(phi)
    x, y, z = vectors.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


def _columns(
    shop: Shop, turning: Turning, n: Array, contact: Array, to_tip: Array, phi: Array
) -> dict[str, Array]:
    """Columns of the surface, in axes of the workpiece: normal, place in the part, way from the tip to the nose centre."""
    turn = phi if turning.rotary else np.zeros(len(phi))
    centre = np.array([*turning.centre, 0.0])
    out = {f"n{c}": v for c, v in zip("xyz", turned_by(n, turn).T)}
    place = turned_by(contact - centre, turn) + centre - shop.pose.shift
    out |= {f"part_{c}_mm": v for c, v in zip("xyz", place.T)}
    inward = np.stack([-to_tip[:, 0], np.zeros(len(phi)), -to_tip[:, 1]], axis=1)
    out |= {f"nose_{c}": v for c, v in zip("xyz", turned_by(inward, turn).T)}
    return out | {name: np.full(len(phi), value) for name, value in shop.scenario.constants.items()}


def turning_forces(shop: Shop, row: Ints, share: Array, turn: Array) -> dict[str, Array]:
    """force_x_N ... at shares (k,) of rows (k,), workpiece axes; nothing where the set-up states no material.

    The force of a move is stated for the direction of feed in its middle; along an arc it turns with the feed.
    """
    if shop.blank is None or shop.blank.forces is None:
        return {}
    assert shop.turning is not None
    part = shop.turning.sweep.take(row)
    lean = _slope(part, np.clip(share, STEP, 1.0 - STEP)) - _slope(part, np.full(len(row), 0.5))
    x, y, z = shop.blank.forces[row].T
    c, s = np.cos(lean), np.sin(lean)
    force = turned_by(np.stack([c * x - s * z, y, s * x + c * z], axis=1), turn)
    return {f"force_{c}_N": force[:, i] for i, c in enumerate("xyz")}


def _slope(sweep: Sweep, share: Array) -> Array:
    """Angle (k,) of the direction of feed in the meridian, from x to z, rad."""
    way = position(sweep, share + STEP) - position(sweep, share - STEP)
    return np.arctan2(way[:, 2], way[:, 0])


def _with_setting(shop: Shop, turning: Turning, run: Run, phi: Array) -> tuple[Run, Ints, Array, int]:
    """The rows of the cut, then for each tool and work offset one per angle of the spindle in which it was set."""
    run = run.with_columns({"setting": np.zeros(run.n)})
    if not shop.scenario.set_here:
        return run, np.full(run.n, -1, dtype=np.intp), phi, 1
    angles = ANGLES if turning.rotary else 1
    first, number = settings_of(run)
    chosen = np.repeat(first, angles)
    tools = [shop.scenario.setup.tools[int(name)] for name in run.labels["tool"][chosen]]
    offset = -np.array([tool.offset for tool in tools])
    rows = setting_rows(run, chosen, offset, zeros(shop, run.labels[OFFSET_LABEL][chosen]), shop.pose)
    turn = np.tile(2 * np.pi * np.arange(angles) / angles, len(first))
    if turning.rotary:
        rows = replace(rows, position={**rows.position, "C": turning.position_c(turn)})
    setting = np.concatenate([run.n + angles * number, np.full(rows.n, -1, dtype=np.intp)])
    return joined(run, rows), setting, np.concatenate([phi, turn]), angles
