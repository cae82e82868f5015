"""What the fixture allows of a pose: free ranges, lists of turns, slots, faces on the table; by how much a pose departs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from vcmm.core.pose import Array, Pose, unit

DOFS = ("x", "y", "z", "turn_x", "turn_y", "turn_z")
TILT = 1e-6  # rad: how well a face must lie on the table, a list of turns be met
NEAR = 1e-6  # mm


class FreedomLike(Protocol):
    """One number of the pose: free between low and high, or one of `values`."""

    @property
    def name(self) -> str: ...
    @property
    def low(self) -> float: ...
    @property
    def high(self) -> float: ...
    @property
    def values(self) -> tuple[float, ...]: ...


class FixtureLike(Protocol):
    """freedoms by name; slots: allowed shifts; faces: directions of the drawing of which one points down."""

    @property
    def freedoms(self) -> Sequence[FreedomLike]: ...
    @property
    def slots(self) -> Sequence[tuple[float, float, float]]: ...
    @property
    def faces(self) -> Mapping[str, tuple[float, float, float]]: ...


def off_fixture(fixture: FixtureLike, poses: Array) -> tuple[Array, Array]:
    """Largest departure of poses (m, 6) from what the fixture allows: mm (m,) and rad (m,), 0 where it is met."""
    shift, turn = np.zeros(len(poses)), np.zeros(len(poses))
    for freedom in fixture.freedoms:
        at = DOFS.index(freedom.name)
        off = _off(freedom, poses[:, at], at >= 3)
        if at < 3:
            shift = np.maximum(shift, off)
        else:
            turn = np.maximum(turn, off)
    if fixture.slots:
        apart = np.linalg.norm(poses[:, None, :3] - np.array(fixture.slots, dtype=float), axis=2).min(axis=1)
        shift = np.maximum(shift, np.where(apart > NEAR, apart, 0.0))
    if fixture.faces:
        down = unit(np.array(list(fixture.faces.values()), dtype=float))
        turned = Pose.from_turns(poses[:, :3], poses[:, 3:]).turn(down)
        tilt = np.arctan2(np.hypot(turned[..., 0], turned[..., 1]), -turned[..., 2]).min(axis=1)
        turn = np.maximum(turn, np.where(tilt > TILT, tilt, 0.0))
    return shift, turn


def _off(freedom: FreedomLike, value: Array, turns: bool) -> Array:
    if freedom.values:
        apart = value[:, None] - np.array(freedom.values)
        if turns:
            apart = (apart + np.pi) % (2.0 * np.pi) - np.pi
        off = np.abs(apart).min(axis=1)
        return np.where(off > (TILT if turns else NEAR), off, 0.0)
    off = np.maximum(freedom.low - value, value - freedom.high)
    return np.where(off > (TILT if turns else NEAR), off, 0.0)


def pose_from(six: npt.ArrayLike) -> Pose:
    """The pose of six numbers (6,): shift mm, turns rad."""
    numbers = np.asarray(six, dtype=np.float64)
    return Pose.from_turns(numbers[:3], numbers[3:])
