"""Plain 4x4 transforms of a machine "w b Y X Z t", after the contract on frames and signs.

Sources: ISO 230-1:2012 (names of component errors, squareness), ISO 841 (axes), Rodrigues' formula.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
AXES = "XYZ"
ORDER = "YXZ"  # from the bed to the tip


def turn(vector: Array) -> Array:
    """Turn matrices of rotation vectors.

    Parameters
    ----------
    vector : array, shape (..., 3)
        Axis times angle, rad, right hand.

    Returns
    -------
    array, shape (..., 3, 3)
    """
    vector = np.asarray(vector, float)
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*vector.shape[:-1], 3, 3)
    small = angle < 1e-12
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 1.0, np.sin(safe) / safe)
    # (1 - cos a)/a^2 written without cancellation
    second = np.where(small, 0.5, 0.5 * (np.sin(safe / 2) / (safe / 2)) ** 2)
    return np.eye(3) + first * cross + second * (cross @ cross)


def transform(rotation: Array, shift: Array) -> Array:
    """Build 4x4 matrices from turns (..., 3, 3) and shifts (..., 3)."""
    result = np.zeros((*np.broadcast_shapes(rotation.shape[:-2], shift.shape[:-1]), 4, 4))
    result[..., :3, :3] = rotation
    result[..., :3, 3] = shift
    result[..., 3, 3] = 1.0
    return result


@dataclass
class Geometry:
    """The 21 errors of a machine with three axes.

    Attributes
    ----------
    errors : dict
        By axis letter a function of the positions (n,) that gives (n, 6): EX, EY, EZ in mm, EA, EB, EC in rad.
    squareness : array, shape (3,)
        A0Z, B0Z, C0Y in rad.
    gap : array, shape (3,)
        Reversal play of X, Y, Z in mm: an axis stops half of it short of its target.
    """

    errors: dict
    squareness: Array
    gap: Array

    def scaled(self, factor: float) -> "Geometry":
        """The same machine with all errors times a factor."""
        old = self.errors
        errors = {axis: (lambda q, f=old[axis]: factor * f(q)) for axis in AXES}
        return Geometry(errors, factor * self.squareness, factor * self.gap)


def perfect() -> Geometry:
    """A machine without errors."""
    return Geometry({a: (lambda q: np.zeros((len(q), 6))) for a in AXES}, np.zeros(3), np.zeros(3))


def tip_error(machine: Geometry, positions: Array, offset: Array, sense: Array | None = None) -> Array:
    """Actual minus nominal tip in workpiece axes, by the product of all transforms.

    Parameters
    ----------
    machine : Geometry
    positions : array, shape (n, 3)
        X, Y, Z of the axes, mm.
    offset : array, shape (3,) or (n, 3)
        Tip in the frame of the last axis, mm.
    sense : array, shape (n, 3), optional
        Direction in which each axis last moved, -1, 0 or 1.

    Returns
    -------
    array, shape (n, 3), mm
    """
    positions = np.atleast_2d(np.asarray(positions, float))
    count = len(positions)
    a0z, b0z, c0y = machine.squareness
    travel = {
        "X": np.array([1.0, 0.0, 0.0]),
        "Y": turn(np.array([0.0, 0.0, c0y])) @ np.array([0.0, 1.0, 0.0]),
        "Z": turn(np.array([a0z, b0z, 0.0])) @ np.array([0.0, 0.0, 1.0]),
    }
    chain = np.broadcast_to(np.eye(4), (count, 4, 4))
    eye = np.broadcast_to(np.eye(3), (count, 3, 3))
    for axis in ORDER:
        column = AXES.index(axis)
        q = positions[:, column]
        error = machine.errors[axis](q)
        chain = (
            chain @ transform(eye, q[:, None] * travel[axis]) @ transform(turn(error[:, 3:]), error[:, :3])
        )
    tip = np.concatenate([np.broadcast_to(offset, (count, 3)), np.ones((count, 1))], axis=1)
    actual = np.einsum("nij,nj->ni", chain, tip)[:, :3]
    result = actual - (positions + np.broadcast_to(offset, (count, 3)))
    if sense is not None:
        result = result - 0.5 * machine.gap * sense
    return result


def pose(shift: Array, degrees: Array) -> tuple[Array, Array]:
    """Turn matrix and shift of a pose: turns about the fixed x, then y, then z."""
    rx, ry, rz = np.deg2rad(np.asarray(degrees, float))
    matrix = turn(np.array([0, 0, rz])) @ turn(np.array([0, ry, 0.0])) @ turn(np.array([rx, 0.0, 0]))
    return matrix, np.asarray(shift, float)
