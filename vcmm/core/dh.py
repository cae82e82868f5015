"""Convert the Denavit-Hartenberg parameters of an arm into joints with centre and direction, as a machine holds them.

    distal (usual)      T = turn_z(theta) shift_z(d) shift_x(a) turn_x(alpha)      Denavit & Hartenberg, J. Appl. Mech. 22 (1955) 215
    proximal (modified) T = turn_x(alpha) shift_x(a) turn_z(theta) shift_z(d)      Craig, Introduction to Robotics (1986)

theta: the angle of the link at joint angle zero. Machine axes are those of the base; the tool hangs where the last frame is at joint
angles zero, so that an offset of zero is the origin of the base and not of the flange: `flange` says where that is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees

import numpy as np

from vcmm.core.axes import ROTARY
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis
from vcmm.core.run import Array

EXACT = 1e-9  # of a direction: then it is that of its letter


@dataclass(frozen=True)
class LinkOfArm:
    """One row: a and d in mm, alpha and theta in rad; travel of the joint in rad."""

    a: float
    alpha: float
    d: float
    theta: float = 0.0
    travel: tuple[float, float] = (-np.pi, np.pi)


@dataclass(frozen=True, eq=False)
class ArmChain:
    """structure, joints, and the frame of the flange (4, 4) with all joints at zero."""

    structure: str
    axes: dict[str, Axis]
    flange: Array

    @property
    def text(self) -> str:
        """The part of a machine file that describes the arm: structure and [axes]."""
        lines = [f'structure = "{self.structure}"']
        for name, axis in self.axes.items():
            low, high = (f'"{degrees(q):.10g} deg"' for q in axis.travel)
            lines += [f"[axes.{name}]", f"travel = [{low}, {high}]"]
            lines.append(f'centre = "{" ".join(f"{c:.10g}" for c in axis.centre)} mm"')
            if axis.direction is not None:
                lines.append(f"direction = [{', '.join(f'{c:.17g}' for c in axis.direction)}]")
        return "\n".join(lines) + "\n"


def arm_of_links(links: Sequence[LinkOfArm], proximal: bool = False) -> ArmChain:
    """Return the joints of an arm from its links. Raises UsageError for fewer than two or more than nine."""
    if not 2 <= len(links) <= 9:
        raise UsageError(f"{len(links)} links; an arm has two to nine joints here")
    frame, names, axes = np.eye(4), [], {}
    for number, link in enumerate(links, 1):
        if proximal:
            frame = frame @ _x(link.a, link.alpha)
        centre, way = frame[:3, 3], frame[:3, 2]
        k = int(np.abs(way).argmax())
        name = f"{ROTARY[k]}{number}"
        x, y, z = (float(v) for v in np.where(np.abs(way) < EXACT, 0.0, way) / np.linalg.norm(way))
        along, across, up = (float(c) for c in np.round(centre, 9) + 0.0)
        direction = None if way[k] > 1.0 - EXACT else (x, y, z)
        axes[name] = Axis(name, link.travel, (along, across, up), direction=direction)
        names.append(name)
        frame = frame @ _z(link.d, link.theta)
        if not proximal:
            frame = frame @ _x(link.a, link.alpha)
    return ArmChain(f"w b {' '.join(names)} t", axes, frame)


def _x(shift: float, turn: float) -> Array:
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[1, 0, 0, shift], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


def _z(shift: float, turn: float) -> Array:
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, shift], [0, 0, 0, 1.0]])
