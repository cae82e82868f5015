"""Rigid transforms between named frames, and the vector helpers that all geometry uses.

A pose reads b_from_a: it takes coordinates in frame a to coordinates in frame b.

    machine_from_part = Pose.from_turns(shift=(300, 250, -200), turns=(0, 0, math.pi / 2))
    part_from_machine = machine_from_part.inverse()
    machine_from_stylus = machine_from_part @ part_from_stylus

A pose may hold one rotation (3, 3) or a batch (m, 3, 3), one per trial. Arrays inside are read-only.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError

Array = npt.NDArray[np.float64]

ORTHONORMAL_TOLERANCE = 1e-9


def read_only_copy(values: npt.ArrayLike) -> Array:
    """Return a read-only float64 copy."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def dot(a: Array, b: Array) -> Array:
    """Return the scalar product over the last axis; leading axes broadcast."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def length(vectors: Array) -> Array:
    """Return the euclidean length over the last axis."""
    return np.sqrt(dot(vectors, vectors))


def unit(vectors: Array) -> Array:
    """Return the vectors (..., 3) divided by their length. UsageError for a zero or non-finite vector."""
    size = length(vectors)
    if not np.all(np.isfinite(size) & (size > 0.0)):
        raise UsageError(
            "A direction is zero or not finite; give a vector with a length, for example [0, 0, 1]."
        )
    return np.asarray(vectors / size[..., None])


def triad(axis: npt.ArrayLike, towards: npt.ArrayLike | None = None) -> Array:
    """Return the orthonormal right-handed rows u, v, w (3, 3) with w along `axis`.

    u is `towards` projected square to w. By default x of the frame is projected; when w lies within
    2.6 deg of x, y is projected instead. So a face whose normal is -y has u = x and v = z.
    """
    w = unit(np.asarray(axis, dtype=np.float64))
    if towards is None:
        towards = (0.0, 1.0, 0.0) if abs(w[0]) > 0.999 else (1.0, 0.0, 0.0)
    along = np.asarray(towards, dtype=np.float64)
    u = unit(along - dot(along, w) * w)
    return np.stack([u, np.cross(w, u), w])


@dataclass(frozen=True, eq=False)
class Pose:
    """Rotation (..., 3, 3) and shift (..., 3) in mm: b = rotation @ a + shift.

    UsageError when shapes do not fit, a number is not finite or the rotation is not a right-handed one.
    """

    rotation: Array
    shift: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", read_only_copy(self.rotation))
        object.__setattr__(self, "shift", read_only_copy(self.shift))
        _check(self.rotation, self.shift)

    @staticmethod
    @cache
    def identity() -> Pose:
        """Return the pose that changes nothing; one object, whose arrays cannot be written."""
        return Pose(np.eye(3), np.zeros(3))

    @classmethod
    def from_turns(cls, shift: npt.ArrayLike, turns: npt.ArrayLike) -> Pose:
        """Shift (..., 3) mm after turns (..., 3) rad about the fixed axes x, then y, then z: R = Rz Ry Rx."""
        angles = np.asarray(turns, dtype=np.float64)
        (cx, cy, cz), (sx, sy, sz) = np.moveaxis(np.cos(angles), -1, 0), np.moveaxis(np.sin(angles), -1, 0)
        rows = [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ]
        return cls(
            np.stack([np.stack(row, axis=-1) for row in rows], axis=-2), np.asarray(shift, dtype=np.float64)
        )

    def turns(self) -> Array:
        """Turns (..., 3) rad about fixed x, then y, then z that `from_turns` turns back into this rotation.

        At a turn of +-90 deg about y only x -+ z is determined; z is then 0.
        """
        r = self.rotation
        locked = np.hypot(r[..., 0, 0], r[..., 1, 0]) < 1e-12
        x = np.where(locked, np.arctan2(-r[..., 1, 2], r[..., 1, 1]), np.arctan2(r[..., 2, 1], r[..., 2, 2]))
        y = np.arctan2(-r[..., 2, 0], np.hypot(r[..., 0, 0], r[..., 1, 0]))
        z = np.where(locked, 0.0, np.arctan2(r[..., 1, 0], r[..., 0, 0]))
        return np.stack([x, y, z], axis=-1)

    def apply(self, points: npt.ArrayLike) -> Array:
        """Apply the pose to point sets (..., 3); the result has the same shape. A batch (m,) of poses takes (3,), (n, 3) or (m, n, 3)."""
        p = np.asarray(points, dtype=np.float64)
        shift = self.shift if p.ndim == 1 or self.shift.ndim == 1 else self.shift[..., None, :]
        return np.asarray(self.turn(p) + shift)

    def turn(self, vectors: npt.ArrayLike) -> Array:
        """Turn directions: as `apply`, without the shift."""
        return np.asarray(np.asarray(vectors, dtype=np.float64) @ np.swapaxes(self.rotation, -1, -2))

    def apply_each(self, points: Array) -> Array:
        """Apply each pose to its own point: (m, 3) -> (m, 3); leading axes broadcast."""
        return np.asarray(self.turn_each(points) + self.shift)

    def turn_each(self, vectors: Array) -> Array:
        """Turn one direction by each pose: (m, 3) -> (m, 3); leading axes broadcast."""
        return np.asarray(np.einsum("...ij,...j->...i", self.rotation, vectors))

    def inverse(self) -> Pose:
        """Return a_from_b."""
        back = np.swapaxes(self.rotation, -1, -2)
        return _sound(back, -np.einsum("...ij,...j->...i", back, self.shift))

    def __matmul__(self, other: Pose) -> Pose:
        """Return c_from_a = c_from_b @ b_from_a: the right-hand pose acts first."""
        return _sound(self.rotation @ other.rotation, self.apply_each(other.shift))

    def shifted_to(self, shift: Array) -> Pose:
        """Return the same rotation with another shift (..., 3) mm, finite."""
        if shift.shape != self.shift.shape or not np.all(np.isfinite(shift)):
            raise UsageError("A pose holds a number that is not finite; give finite mm and rad.")
        return _sound(self.rotation, shift)

    def some(self, rows: npt.NDArray[np.intp]) -> Pose:
        """Return some poses of a batch (m,), by their numbers."""
        return _sound(self.rotation[rows], self.shift[rows])

    def alone(self) -> Pose:
        """Return the one pose as a batch (1,)."""
        return _sound(self.rotation[None], self.shift[None])

    def each(self) -> list[Pose]:
        """Return the single poses of a batch (m,)."""
        return [_sound(rotation, shift) for rotation, shift in zip(self.rotation, self.shift)]

    def then(self, after: Pose) -> Pose:
        """Return c_from_a of b_from_a.then(c_from_b): this pose acts first."""
        return after @ self


def _sound(rotation: Array, shift: Array) -> Pose:
    """Return a pose whose rotation follows from rotations that were checked, so that it needs no check of its own."""
    pose = object.__new__(Pose)
    object.__setattr__(pose, "rotation", read_only_copy(rotation))
    object.__setattr__(pose, "shift", read_only_copy(shift))
    return pose


def _check(rotation: Array, shift: Array) -> None:
    if rotation.shape[-2:] != (3, 3) or shift.shape != rotation.shape[:-1]:
        shapes = f"rotation {rotation.shape} and shift {shift.shape}"
        raise UsageError(f"A pose needs a rotation (..., 3, 3) and a shift (..., 3), not {shapes}.")
    if not (np.all(np.isfinite(rotation)) and np.all(np.isfinite(shift))):
        raise UsageError("A pose holds a number that is not finite; give finite mm and rad.")
    gram = rotation @ np.swapaxes(rotation, -1, -2)
    worst = float(np.max(np.abs(gram - np.eye(3)), initial=0.0))
    if worst > ORTHONORMAL_TOLERANCE or np.any(_handedness(rotation) < 0.0):
        reason = "is a mirror image" if worst <= ORTHONORMAL_TOLERANCE else f"is off by {worst:.1e}"
        raise UsageError(f"The rotation of a pose must be orthonormal and right-handed; this one {reason}.")


def _handedness(rotation: Array) -> Array:
    """Return u . (v x w) of the rows (...,): the determinant, without a general elimination for each matrix."""
    u, v, w = rotation[..., 0, :], rotation[..., 1, :], rotation[..., 2, :]
    return dot(u, np.cross(v, w))
