"""Describe the links of an arm by the numbers of its trade: lengths, offsets, twists and joint offsets.

Denavit-Hartenberg (J. Appl. Mech. 22 (1955) 215) from joint to joint, distal: turn about z by theta, along z by d, along x by a, turn about
x by alpha; z along the axis of a joint, x along the common normal of it and the next. Where two axes are nearly parallel d runs away with
their angle; there d is zero and a second twist beta about y takes its place (Hayati, Proc. IEEE CDC (1983) 1477). Axes are taken with all
joints at zero, so that theta is the angle of the link that joint angle zero means.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import unit_vector
from vcmm.core.machine import Machine
from vcmm.core.rigid import rotation_from_vector
from vcmm.core.run import Array
from vcmm.physics.structure.squareness import RotaryLocation

PARALLEL = np.radians(5.0)  # nominal angle below which axes are taken as parallel
QUANTITIES = ("joint offset", "link offset d", "link length a", "twist alpha", "twist beta")


@dataclass(frozen=True)
class LinkNumber:
    """One number of a link: its joint and the next, which of QUANTITIES; mm or rad."""

    joint: str
    following: str
    quantity: str
    value: float

    @property
    def is_angle(self) -> bool:
        return self.quantity in ("joint offset", "twist alpha", "twist beta")


Line = tuple[Array, Array]  # a point and the unit vector of an axis


def axis_lines(machine: Machine) -> list[Line]:
    """Return the line of every axis in machine axes, all joints at zero, its location errors included."""
    turn, shift = np.eye(3), np.zeros(3)
    lines = []
    for name in machine.chain.tool:
        axis = machine.axes[name]
        centre = np.array(axis.centre)
        alignment = axis.alignment if axis.alignment is not None else np.eye(3)
        six = np.zeros(6)
        for effect in machine.effects:
            if isinstance(effect, RotaryLocation) and effect.link == name:
                letter = effect.component[0]
                six["XYZABC".index(letter)] += effect.offset if letter in "XYZ" else effect.tilt
        located = alignment @ rotation_from_vector(six[None, 3:])[0] @ alignment.T
        moved = centre + alignment @ six[:3]
        shift = shift + turn @ (moved - located @ centre)
        turn = turn @ located
        lines.append((turn @ centre + shift, turn @ alignment @ unit_vector(name)))
    return lines


def link_numbers(machine: Machine, nominal: Machine) -> list[LinkNumber]:
    """Return all numbers of the links that poses can determine: of the first joint its length and twists, of the last none (its own are
    in the placing
    of tracker and tool). nominal: determines which axes are parallel and which way x points, so that both machines use the same convention.
    """
    lines, ideal = axis_lines(machine), axis_lines(nominal)
    names = machine.chain.tool
    out: list[LinkNumber] = []
    origin, x = None, None
    for i, (name, second) in enumerate(itertools.pairwise(names)):
        ends = _link(lines[i], lines[i + 1], origin, ideal[i], ideal[i + 1], _sense(ideal, i))
        values = [ends.theta(x, lines[i][1]), ends.d, ends.a, ends.alpha, ends.beta]
        for word, value in zip(QUANTITIES, values):
            first = i == 0 and word in ("joint offset", "link offset d")
            if value is not None and not first:
                out.append(LinkNumber(name, second, word, float(value)))
        origin, x = ends.foot, ends.x
    return out


def _sense(ideal: Sequence[Line], i: int) -> float:
    """Return which way along the common normal x points: the length is positive; where the axes meet the twist is."""
    (p, z), (q, w) = ideal[i], ideal[i + 1]
    normal = np.cross(z, w)
    along = float((q - p) @ normal)
    return -1.0 if along < -1e-9 else 1.0


@dataclass(frozen=True)
class _NextLink:
    """Transform from a joint to the next: d None where the axes are parallel, beta None where not. foot: where x meets the next axis."""

    x: Array
    foot: Array
    d: float | None
    a: float
    alpha: float
    beta: float | None

    def theta(self, before: Array | None, z: Array) -> float | None:
        """Return the angle about z from the x before; None for the first joint."""
        if before is None:
            return None
        across = before - z * (z @ before)
        return float(np.arctan2(np.cross(across, self.x) @ z, across @ self.x))


def _link(
    first: Line, second: Line, origin: Array | None, ideal_one: Line, ideal_two: Line, sense: float
) -> _NextLink:
    (p, z), (q, w) = first, second
    start = p if origin is None else origin
    if np.linalg.norm(np.cross(ideal_one[1], ideal_two[1])) < np.sin(PARALLEL):
        foot = q + w * ((start - q) @ z) / (w @ z)
        way = foot - start
        a = float(np.linalg.norm(way))
        x = way / a if a > 1e-9 else _across(z)
        y = np.cross(z, x)
        sign = np.sign(w @ z)
        return _NextLink(
            x,
            foot,
            None,
            a,
            float(np.arctan2(-w @ y * sign, w @ z * sign)),
            float(np.arcsin(np.clip(w @ x * sign, -1, 1))),
        )
    normal = np.cross(z, w) * sense
    x = normal / np.linalg.norm(normal)
    # feet of the common normal: p + s z and q + t w with (q + t w - p - s z) along x
    s, t, _ = np.linalg.solve(np.column_stack([z, -w, x]), q - p)
    near, foot = p + s * z, q + t * w
    return _NextLink(
        x,
        foot,
        float((near - start) @ z),
        float((foot - near) @ x),
        float(np.arctan2(np.cross(z, w) @ x, z @ w)),
        None,
    )


def _across(z: Array) -> Array:
    """Return some direction across z."""
    e = np.eye(3)[int(np.abs(z).argmin())]
    out = np.cross(z, e)
    return np.asarray(out / np.linalg.norm(out))
