"""Pose of the tool in the workpiece: tip and tool axis for positions of all axes, and the inverse.

    tip = T_work(q)^-1 T_tool(q) (-tool offset)        tool axis = R_work(q)^T R_tool(q) z

for any chain of linear and rotary axes. With the rotary axes held, the tip is affine in X, Y, Z, so that the axes that lead it
to a point follow from one linear system. The angles that turn the tool into a direction: vcmm.shop.motion.posture.

Source of the chain: ISO 230-1 structure codes, multiplied out in vcmm.core.kinematics.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.axes import LINEAR, ROTARY
from vcmm.core.kinematics import Axis, Pose6, link_frames
from vcmm.core.machine import Machine
from vcmm.core.rigid import Frame
from vcmm.core.run import Array, Run

Z = np.array([0.0, 0.0, 1.0])


def by_letter(machine: Machine, linear: Array, angle: Array) -> dict[str, Array]:
    """Return axis letter -> position (k,), for the axes the machine has."""
    both = {a: linear[:, i] for i, a in enumerate(LINEAR)} | {a: angle[:, i] for i, a in enumerate(ROTARY)}
    return {a: both[a] for a in machine.chain.letters}


def ends_of(machine: Machine, axes: dict[str, Array]) -> tuple[dict[str, Pose6], Frame, Frame]:
    """Return the frames of all links and of both ends of the chain at positions (k,)."""
    count = len(next(iter(axes.values())))
    return link_frames(machine.chain, machine.axes, Run(axes, np.zeros((count, 3))))


def tip_and_axis(
    machine: Machine, tip: Array, angle: Array, offset: Array, direction: Array = Z
) -> tuple[Array, Array]:
    """Return the tip and tool axis (k, 3) in workpiece axes; tip as with rotary axes at zero, offset: that of the tool, mm.

    direction (3,) or (k, 3): from tip to holder, in the frame of the last tool-side axis.
    """
    positions = by_letter(machine, tip + offset, angle)
    at = _along_chain(machine, positions, -offset, True)
    axis = _along_chain(machine, positions, np.broadcast_to(direction, tip.shape), False)
    axis = axis.round(15)  # cos 90 deg is no 6e-17
    return at, axis / np.linalg.norm(axis, axis=1)[:, None]


def _along_chain(machine: Machine, positions: dict[str, Array], vector: Array, is_point: bool) -> Array:
    """Return the points or directions (k, 3) of the last tool-side axis in the workpiece: T_work^-1 T_tool v, axis by axis.

    Towards the bed every axis moves v by its position; from the bed to the workpiece an axis moves by -q, and back by q, too.
    """
    c = [vector[:, 0], vector[:, 1], vector[:, 2]]
    for letter in (*reversed(machine.chain.tool), *machine.chain.work):
        q = positions[letter]
        if letter in LINEAR:
            if is_point:
                i = LINEAR.index(letter)
                c[i] = c[i] + q
            continue
        if machine.axes[letter].direction is not None:
            c = _turned_about(machine.axes[letter], q, c, is_point)
            continue
        axis = ROTARY.index(letter)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        centre = machine.axes[letter].centre if is_point else (0.0, 0.0, 0.0)
        cosine, sine = np.cos(q), np.sin(q)
        u, v = c[i] - centre[i], c[j] - centre[j]
        c[i], c[j] = centre[i] + cosine * u - sine * v, centre[j] + sine * u + cosine * v
    return np.stack(c, axis=1)


def _turned_about(axis: Axis, q: Array, c: list[Array], is_point: bool) -> list[Array]:
    """Return points or directions turned by q (k,) about an axis with a direction d of its own: Rodrigues, p cos + d x p sin + d (d.p) (1 - cos)."""
    d, centre = np.array(axis.direction), np.array(axis.centre) if is_point else np.zeros(3)
    p = np.stack(c, axis=1) - centre
    cosine, sine = np.cos(q)[:, None], np.sin(q)[:, None]
    turned = centre + p * cosine + np.cross(d, p) * sine + (p @ d)[:, None] * (1.0 - cosine) * d
    return [turned[:, 0], turned[:, 1], turned[:, 2]]


def tip_as_at_zero(machine: Machine, at: Array, angle: Array, offset: Array) -> Array:
    """Return the inverse: tips (k, 3) as with rotary axes at zero that lead to points (k, 3) of the workpiece at angles (k, 3)."""
    count = len(at)
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    tips, _ = tip_and_axis(
        machine, np.tile(corners, (count, 1)), np.repeat(angle, 4, axis=0), np.repeat(offset, 4, axis=0)
    )
    tips = tips.reshape(count, 4, 3)
    ways = np.moveaxis(tips[:, 1:] - tips[:, :1], 1, 2)
    return np.asarray(np.linalg.solve(ways, (at - tips[:, 0])[:, :, None])[:, :, 0])


def rotary_of(machine: Machine) -> list[int]:
    """Return the numbers (0 = A) of the rotary axes of a machine, those on the side of the tool first."""
    return [ROTARY.index(a) for a in machine.chain.letters if a in ROTARY]
