"""Exact kinematic chains of the exam: 4x4 matrices multiplied row by row, written against docs/conventions.md only.

A link of axis j is  T = L · T_nominal(q) · E,  E a turn by one rotation vector about `measured_at` and a shift; an axis
that carries the workpiece moves nominally by -q. The tip is T_work^-1 · T_tool · [offset, 1].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UNITS = {letter: np.eye(3)["XYZABC".index(letter) % 3] for letter in "XYZABC"}


def skew(v: Array) -> Array:
    """(n, 3) -> (n, 3, 3) with skew(v) w = v x w."""
    zero = np.zeros(len(v))
    x, y, z = v.T
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)


def turn(vector: Array) -> Array:
    """Rotation matrices of rotation vectors, by the exponential series (30 terms after halving: exact to rounding)."""
    half = skew(vector) / 16.0
    out = np.broadcast_to(np.eye(3), half.shape).copy()
    term = out.copy()
    for k in range(1, 14):
        term = term @ half / k
        out += term
    for _ in range(4):
        out = out @ out
    return out


def matrix(rotation: Array, shift: Array) -> Array:
    out = np.zeros((len(shift), 4, 4))
    out[:, :3, :3], out[:, :3, 3], out[:, 3, 3] = rotation, shift, 1.0
    return out


def about(point: Array, vector: Array, shift: Array) -> Array:
    """p -> m + R (p - m) + shift."""
    r = turn(vector)
    return matrix(r, point + shift - r @ point)


@dataclass(frozen=True)
class Chain:
    """Structure in the contract's words, centres and reference points of the axes."""

    structure: str
    centre: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    measured_at: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    def sides(self) -> tuple[list[str], list[str]]:
        """Axes of the tool side and of the work side, both from the bed outwards."""
        words = self.structure.split()
        bed = words.index("b")
        return words[bed + 1 : -1], [w[0] for w in reversed(words[1:bed])]

    @property
    def letters(self) -> list[str]:
        tool, work = self.sides()
        return tool + work


@dataclass(frozen=True, eq=False)
class Errors:
    """six: own error motion of each axis (n, 6) mm rad. square: A0Z B0Z C0Y rad. place: location (n, 6) of rotary axes.
    actual: what is added to the commanded position (n,), in the sense of the command."""

    six: Mapping[str, Array] = field(default_factory=dict)
    square: Mapping[str, float | Array] = field(default_factory=dict)
    place: Mapping[str, Array] = field(default_factory=dict)
    actual: Mapping[str, Array] = field(default_factory=dict)


def travel_direction(letter: str, square: Mapping[str, float | Array], n: int) -> Array:
    """e_j turned by the small rotation vector of its squareness errors."""
    vector = np.zeros((n, 3))
    for word, angle in square.items():
        if word[2] == letter:
            vector[:, "ABC".index(word[0])] = angle
    return np.einsum("nij,j->ni", turn(vector), UNITS[letter])


def link(chain: Chain, letter: str, q: Array, carries: bool, errors: Errors) -> Array:
    n = len(q)
    moved = q + errors.actual.get(letter, 0.0)
    moved = -moved if carries else moved
    centre = np.array(chain.centre.get(letter, (0.0, 0.0, 0.0)))
    rotary = letter in "ABC"
    if rotary:
        place = errors.place.get(letter, np.zeros((n, 6)))
        nominal = about(centre, moved[:, None] * UNITS[letter], np.zeros((n, 3)))
        nominal = about(centre, place[:, 3:], place[:, :3]) @ nominal
    else:
        way = moved[:, None] * travel_direction(letter, errors.square, n)
        nominal = matrix(np.broadcast_to(np.eye(3), (n, 3, 3)), way)
    six = errors.six.get(letter)
    if six is None:
        return nominal
    pivot = np.array(chain.measured_at.get(letter, tuple(centre) if rotary else (0.0, 0.0, 0.0)))
    return nominal @ about(pivot, six[:, 3:], six[:, :3])


def tip(chain: Chain, q: Mapping[str, Array], offset: Array, errors: Errors) -> Array:
    """Tip positions (n, 3) mm in workpiece axes."""
    n = len(offset)
    ends = []
    tool, work = chain.sides()
    for side, carries in ((tool, False), (work, True)):
        here = np.broadcast_to(np.eye(4), (n, 4, 4))
        for letter in side:
            here = here @ link(chain, letter, q[letter], carries, errors)
        ends.append(here)
    point = np.concatenate([offset, np.ones((n, 1))], axis=1)[:, :, None]
    return np.linalg.solve(ends[1], ends[0] @ point)[:, :3, 0]


def tip_error(chain: Chain, q: Mapping[str, Array], offset: Array, errors: Errors) -> Array:
    """actual - nominal (n, 3) mm."""
    return tip(chain, q, offset, errors) - tip(chain, q, offset, Errors())
