"""Where a machine holds its tool: tip and tool axis in the workpiece for positions of all axes, and the way back.

    tip = T_work(q)^-1 T_tool(q) (-tool offset)        tool axis = R_work(q)^T R_tool(q) z

for any chain of linear and rotary axes. With the rotary axes held, the tip is affine in X, Y, Z, so that the axes that lead it
to a point follow from one linear system. Angles that turn the tool into a direction are found by Newton's method with
the pseudo-inverse, which leaves an axis that does not matter (a singular position) where it stands.

Source of the chain: ISO 230-1 structure codes, multiplied out in vcmm.core.kinematics.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vcmm.core.axes import LINEAR, ROTARY
from vcmm.core.kinematics import Frame, Pose6, link_frames
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run

Z = np.array([0.0, 0.0, 1.0])
AIMED = 1e-12  # of the tool axis, rad
STEPS, SMALL = 60, 1e-6
STARTS = (0.0, 0.5 * np.pi, -0.5 * np.pi, np.pi)
TURN = 2.0 * np.pi
SLACK = 1e-9  # rad beyond a travel


def by_letter(machine: Machine, linear: Array, angle: Array) -> dict[str, Array]:
    """Axis letter -> position (k,), for the axes the machine has."""
    both = {a: linear[:, i] for i, a in enumerate(LINEAR)} | {a: angle[:, i] for i, a in enumerate(ROTARY)}
    return {a: both[a] for a in machine.chain.letters}


def ends_of(machine: Machine, axes: dict[str, Array]) -> tuple[dict[str, Pose6], Frame, Frame]:
    """Frames of all links and of both ends of the chain at positions (k,)."""
    count = len(next(iter(axes.values())))
    return link_frames(machine.chain, machine.axes, Run(axes, np.zeros((count, 3))))


def tip_and_axis(
    machine: Machine, tip: Array, angle: Array, offset: Array, direction: Array = Z
) -> tuple[Array, Array]:
    """Tip and tool axis (k, 3) in workpiece axes; tip as with rotary axes at zero, offset: that of the tool, mm.

    direction (3,) or (k, 3): from tip to holder, in the frame of the last tool-side axis.
    """
    _, tool, work = ends_of(machine, by_letter(machine, tip + offset, angle))
    at = work.undo(tool.apply(-offset))
    axis = work.turn_back(tool.turn(np.broadcast_to(direction, tip.shape)))
    axis = axis.round(15)  # cos 90 deg is no 6e-17
    return at, axis / np.linalg.norm(axis, axis=1)[:, None]


def tip_as_at_zero(machine: Machine, at: Array, angle: Array, offset: Array) -> Array:
    """The way back: tips (k, 3) as with rotary axes at zero that lead to points (k, 3) of the workpiece at angles (k, 3)."""
    count = len(at)
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    found, _ = tip_and_axis(
        machine, np.tile(corners, (count, 1)), np.repeat(angle, 4, axis=0), np.repeat(offset, 4, axis=0)
    )
    found = found.reshape(count, 4, 3)
    ways = np.moveaxis(found[:, 1:] - found[:, :1], 1, 2)
    return np.asarray(np.linalg.solve(ways, (at - found[:, 0])[:, :, None])[:, :, 0])


def rotary_of(machine: Machine) -> list[int]:
    """Numbers (0 = A) of the rotary axes of a machine, those on the side of the tool first."""
    return [ROTARY.index(a) for a in machine.chain.letters if a in ROTARY]


def pointed(machine: Machine, axis: Array, near: Array) -> Array | None:
    """Angles A, B, C (3,) rad that turn the tool into a direction (3,) of the workpiece, the nearest to `near` (3,).

    None where no position of the rotary axes within their travels does.
    """
    letters = rotary_of(machine)
    best: Array | None = None
    for start in _starts(near, letters):
        found = _newton(machine, axis, start, letters)
        if found is None:
            continue
        found = _within(machine, found, near, letters)
        if found is not None and (
            best is None or np.abs(found - near).max() < np.abs(best - near).max() - SLACK
        ):
            best = found
            if np.array_equal(start, near) and np.abs(found - near).max() < 0.1:
                break  # a small step from where the axes stand
    return best


def _starts(near: Array, letters: list[int]) -> Iterator[Array]:
    yield near
    for first in STARTS:
        for second in STARTS if len(letters) > 1 else (0.0,):
            out = near.copy()
            for letter, value in zip(letters, (first, second)):
                out[letter] = value
            yield out


def _direction(machine: Machine, angle: Array) -> Array:
    """Tool axes (k, 3) at angles (k, 3)."""
    none = np.zeros_like(angle)
    return tip_and_axis(machine, none, angle, none)[1]


def _newton(machine: Machine, axis: Array, start: Array, letters: list[int]) -> Array | None:
    """Angles from a start at which the tool axis is `axis`; None where it does not get there."""
    angle = start.copy()
    for _ in range(STEPS):
        moved = np.tile(angle, (len(letters) + 1, 1))
        for row, letter in enumerate(letters, 1):
            moved[row, letter] += SMALL
        found = _direction(machine, moved)
        miss = axis - found[0]
        if np.linalg.norm(miss) < AIMED * 10:
            return angle
        slope = (found[1:] - found[0]).T / SMALL
        step = np.linalg.pinv(slope, rcond=1e-5) @ miss
        size = float(np.abs(step).max(initial=0.0))
        if size < 1e-14:
            return angle if np.linalg.norm(miss) < 1e-9 else None
        angle[letters] += step * min(1.0, 0.5 / size)
    return angle if np.linalg.norm(axis - _direction(machine, angle[None])[0]) < 1e-9 else None


def _within(machine: Machine, angle: Array, near: Array, letters: list[int]) -> Array | None:
    """The same orientation with every axis turned by whole turns: within its travel and as near as can be."""
    out = angle.copy()
    for letter in letters:
        low, high = machine.axes[ROTARY[letter]].travel
        first = near[letter] + np.remainder(angle[letter] - near[letter] + np.pi, TURN) - np.pi
        allowed = [v for v in (first, first - TURN, first + TURN) if low - SLACK <= v <= high + SLACK]
        if not allowed:
            return None
        out[letter] = min(allowed, key=lambda v, letter=letter: abs(v - near[letter]))  # type: ignore[misc]
    return out
