"""Rigid transforms row by row, rotations by vectors, and the shortest turn of one direction into another."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vcmm.core.axes import unit_vector
from vcmm.core.run import Array


@dataclass(frozen=True)
class Frame:
    """A rigid transform per row: rotation (n, 3, 3) or None for the identity, shift (n, 3)."""

    rotation: Array | None
    shift: Array

    def apply(self, points: Array) -> Array:
        return self.turn(points) + self.shift

    def turn(self, vectors: Array) -> Array:
        return vectors if self.rotation is None else np.einsum("nij,nj->ni", self.rotation, vectors)

    def turn_back(self, vectors: Array) -> Array:
        return vectors if self.rotation is None else np.einsum("nji,nj->ni", self.rotation, vectors)

    def undo(self, points: Array) -> Array:
        return self.turn_back(points - self.shift)

    def then(self, inner: Frame) -> Frame:
        """Return self · inner: first inner, then self."""
        if inner.rotation is None or self.rotation is None:
            rotation = self.rotation if inner.rotation is None else inner.rotation
        else:
            rotation = self.rotation @ inner.rotation
        return Frame(rotation, self.apply(np.broadcast_to(inner.shift, self.shift.shape)))

    def inverse(self) -> Frame:
        """Return the inverse transform."""
        if self.rotation is None:
            return Frame(None, -self.shift)
        return Frame(self.rotation.transpose(0, 2, 1), -self.turn_back(self.shift))


def rotation_from_vector(vector: Array) -> Array:
    """Return exp([v]x) for rotation vectors (n, 3) rad: Rodrigues' formula, (n, 3, 3)."""
    angle = np.linalg.norm(vector, axis=1)
    small = angle < 1e-8  # series to second order is exact to 1e-24 there
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle**2 / 6, np.sin(safe) / safe)
    b = np.where(small, 0.5, 2 * np.sin(safe / 2) ** 2 / safe**2)
    x, y, z = vector.T
    ax, ay, az = a * x, a * y, a * z
    bxy, bxz, byz = b * x * y, b * x * z, b * y * z
    out = np.empty((len(vector), 3, 3))
    out[:, 0, 0], out[:, 0, 1], out[:, 0, 2] = 1.0 - b * (y * y + z * z), bxy - az, bxz + ay
    out[:, 1, 0], out[:, 1, 1], out[:, 1, 2] = bxy + az, 1.0 - b * (x * x + z * z), byz - ax
    out[:, 2, 0], out[:, 2, 1], out[:, 2, 2] = bxz - ay, byz + ax, 1.0 - b * (x * x + y * y)
    return out


@lru_cache(maxsize=64)
def _turn_of(letter: str, direction: tuple[float, float, float]) -> Array:
    e, d = unit_vector(letter), np.array(direction)
    cosine = float(e @ d)
    if cosine < -1.0 + 1e-12:
        about = np.roll(e, 1)
        return np.asarray(2.0 * np.outer(about, about) - np.eye(3))
    x, y, z = np.cross(e, d)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + cosine))


def shortest_turn(letter: str, direction: Array) -> Array:
    """Return the shortest turn (3, 3) that takes the axis of a letter into a unit vector (3,): 1 + [v]x + [v]x^2 / (1 + e.d), v = e x d.

    Where the two are opposite, half a turn about the letter that follows: of A about Y, of B about Z, of C about X. Source: Rodrigues' formula.
    """
    return _turn_of(letter[0], (float(direction[0]), float(direction[1]), float(direction[2])))
