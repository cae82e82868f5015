"""Possible errors of an arm: numbers of effects, each with its effect on poses.

Geometry: every joint may have another zero position, and its axis may be shifted and tilted across itself (location errors of ISO 230-1).
Poses cannot determine all of them: `vcmm.learn.calibration.arm` decides in this order which ones are kept.
Further terms, each with two numbers: elastic joints under gravity (`elastic_joint`) and once-per-turn errors (`rotary_cyclic`) of an eccentric gear or
encoder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.axes import LINEAR, ROTARY, unit_vector
from vcmm.core.effect import Effect
from vcmm.core.kinematics import Motion, tip_motion
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.physics.structure.elastic_joint import ElasticJoint
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.squareness import RotaryLocation

SHIFT, TURN = 2.0, 20e-3  # mm, rad: the most that links of an arm and zero positions are off (RotaryLocation)
LEVEL = np.cos(np.radians(80.0))  # share along gravity below which an axis is taken as level
ALIKE = np.cos(np.radians(5.0))  # of directions of two axes that turn a link together
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class Term:
    """One effect whose numbers (one, or two) are estimated. most: largest believable size of each, mm or rad."""

    effect: Effect
    parameter: str
    size: int
    most: float

    @property
    def name(self) -> str:
        return self.effect.where if isinstance(self.effect, RotaryLocation) else self.effect.id

    def with_values(self, values: Array) -> Effect:
        """Return the effect with these numbers."""
        numbers = float(values[0]) if self.size == 1 else np.array(values, dtype=float)
        return replace(self.effect, **{self.parameter: numbers})

    def motion(self, run: Run, k: int, machine: Machine) -> Array:
        """Shift and turn of the tip (n, 6) per unit of number k, first order, at the nominal machine."""
        unit = self.with_values(np.eye(self.size)[k])
        moved = Motion(unit.link, unit.place, machine.sign(unit) * unit.error_motion(run))
        return tip_motion(machine.chain, machine.axes, run, [moved])


def geometry_terms(machine: Machine) -> list[Term]:
    """Return joint offsets first, then shifts, then tilts, from the base outwards: as a tilt about the joint before is that joint's offset, it is
    the tilt that is left out.
    """
    joints = machine.chain.tool
    offsets = [_location(f"{a[0]}0{a}") for a in joints]
    tilts = [_location(f"{c}0{a}") for a in joints for c in ROTARY if c != a[0]]
    shifts = [_location(f"{c}0{a}") for a in joints for c in LINEAR if c != "XYZ"["ABC".index(a[0])]]
    return offsets + shifts + tilts


def _location(component: str) -> Term:
    shift = component[0] in LINEAR
    return Term(RotaryLocation(component), "offset" if shift else "tilt", 1, SHIFT if shift else TURN)


def further_terms(machine: Machine) -> list[Term]:
    """Return elastic joints where an axis lies level, then once-per-turn errors of every joint."""
    elastic = [
        Term(ElasticJoint(axis, words), "coefficients", 2, TURN) for axis, words in load_patterns(machine)
    ]
    cyclic = [
        Term(RotaryCyclic(f"E{a[0]}{a}", np.zeros(2)), "coefficients", 2, TURN) for a in machine.chain.tool
    ]
    return elastic + cyclic


def load_patterns(machine: Machine) -> list[tuple[str, str]]:
    """Return (joint, summed angles) of every joint that lies level and every link that it carries with joints parallel to it in between."""
    joints = machine.chain.tool
    ways = {a: _direction(machine, a) for a in joints}
    out = []
    for i, axis in enumerate(joints):
        if abs(float(ways[axis] @ DOWN)) > LEVEL:
            continue
        first = i
        while first and abs(float(ways[joints[first - 1]] @ ways[axis])) > ALIKE:
            first -= 1
        if any(abs(float(ways[a] @ DOWN)) < ALIKE for a in joints[:first]):
            continue  # a joint before them that does not stand upright tilts them
        last = i
        while last + 1 < len(joints) and abs(float(ways[joints[last + 1]] @ ways[axis])) > ALIKE:
            last += 1
        for end in range(i, last + 1):
            out.append((axis, _sum_of(joints[first : end + 1], ways, axis)))
    return out


def _sum_of(names: Sequence[str], ways: dict[str, Array], axis: str) -> str:
    return " ".join(a if float(ways[a] @ ways[axis]) > 0 else f"-{a}" for a in names)


def _direction(machine: Machine, name: str) -> Array:
    turn = machine.axes[name].alignment
    return unit_vector(name) if turn is None else np.asarray(turn @ unit_vector(name))
