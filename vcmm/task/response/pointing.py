"""Pointing: the observed direction of a tool against the direction computed from its axes, as small rotations.

A turn about the tool itself is not seen, so every direction gives two observations, about two axes across it:

    value = s u . w,   w = the rotation from the nominal direction to the observed one, the shortest way
    u1 = the last rotary axis of the tool, made perpendicular to the tool;   u2 = nominal direction x u1

s = -1 for indicated - true, +1 for actual - commanded, as everywhere. No first order: w is the exact angle.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.axes import is_rotary, unit_vector
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Motion, link_frames, nominal_tip, tip_motion
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run

POINTING_COLUMNS = ("pointed_x", "pointed_y", "pointed_z")  # observed direction of the tool, workpiece axes
ALONG = 1e-3  # share of an axis across the tool below which it says nothing


def nominal_direction(run: Run, machine: Machine) -> Array:
    """Return the unit direction (n, 3), workpiece axes, in which the tool (its offset) points at the nominal axis positions."""
    if not (np.linalg.norm(run.offset, axis=1) > 0).all():
        raise UsageError(
            "a pointed direction needs the tool's own direction: give offset_x_mm, offset_y_mm, offset_z_mm, the vector along "
            "the tool in the frame of the last tool-side axis"
        )
    still = Run(run.position, np.zeros_like(run.offset))
    way = nominal_tip(machine.chain, machine.axes, Run(run.position, run.offset))
    way = way - nominal_tip(machine.chain, machine.axes, still)
    return np.asarray(way / np.linalg.norm(way, axis=1)[:, None])


def pointing_observations(run: Run, machine: Machine, sign: float) -> tuple[Array, Array]:
    """Return value (2 n,) rad and direction (2 n, 3) of the pointed directions of a run. Raises ModelLimit beyond 90 deg."""
    nominal, observed = nominal_direction(run, machine), run.vector(*POINTING_COLUMNS)
    observed = observed / np.linalg.norm(observed, axis=1)[:, None]
    cross, cosine = np.cross(nominal, observed), (nominal * observed).sum(axis=1)
    sine = np.linalg.norm(cross, axis=1)
    far = np.flatnonzero(cosine <= 0)
    if len(far):
        raise ModelLimit(
            f"row {int(far[0]) + 1}: the tool points {np.degrees(np.arctan2(sine, cosine))[far[0]]:.0f} deg off ({len(far)} of "
            f"{run.n} rows beyond 90 deg); check the structure, the senses of the axes and the frame of pointed_x ...",
            row=int(far[0]),
        )
    turn = cross * (np.arctan2(sine, cosine) / np.where(sine > 0, sine, 1.0))[:, None]
    about = _across(run, machine, nominal)
    value = sign * np.einsum("nki,ni->nk", about, turn)
    return value.ravel(), about.reshape(-1, 3)


def _across(run: Run, machine: Machine, nominal: Array) -> Array:
    """Return two unit axes across the nominal direction (n, 2, 3)."""
    rotary = [a for a in machine.chain.tool if is_rotary(a)] or [
        a for a in machine.chain.work if is_rotary(a)
    ]
    if not rotary:
        raise UsageError("pointed directions need a machine with a rotary axis")
    six = np.tile(np.concatenate([np.zeros(3), unit_vector(rotary[-1])]), (run.n, 1))
    line = tip_motion(machine.chain, machine.axes, run, [Motion(rotary[-1], "motion", six)])[:, 3:]
    first = line - (line * nominal).sum(axis=1)[:, None] * nominal
    size = np.linalg.norm(first, axis=1)
    other = np.eye(3)[np.abs(nominal).argmin(axis=1)]  # the tool lies along the axis: any axis across
    other = other - (other * nominal).sum(axis=1)[:, None] * nominal
    first = np.where((size > ALONG)[:, None], first, other)
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(nominal, first)], axis=1)


def with_down(run: Run, machine: Machine, down: Array) -> Run:
    """Return the run with down_x, down_y, down_z: gravity in the frame of the last tool-side axis. down (3,): its direction in the machine frame."""
    size = float(np.linalg.norm(down))
    if not size > 0:
        raise UsageError("down is no direction; write for example down = [0, 0, -1]")
    _, tool, _ = link_frames(machine.chain, machine.axes, run)
    down_in_tool = tool.turn_back(np.tile(np.asarray(down, dtype=float) / size, (run.n, 1)))
    return run.with_columns({f"down_{c}": down_in_tool[:, i] for i, c in enumerate("xyz")})
