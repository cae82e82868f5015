"""Frame of a block: machine point of the tip <-> numbers of the program."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.program.trace import Trace

AXES, CENTRES = "XYZ", "IJK"


@dataclass(frozen=True, eq=False)
class BlockFrame:
    """Machine point of the tip <-> numbers of the program (its unit; diameters where X is one)."""

    matrix: Array
    inverse: Array
    shift: Array
    scale: Array
    offset: Array
    absolute: bool
    inch: bool
    arc_absolute: bool

    def numbers(self, tip: Array) -> Array:
        return np.asarray((tip - self.shift) @ self.inverse.T * self.scale)

    def ways(self, way: Array) -> Array:
        """Convert a vector instead of a point; never a diameter."""
        return np.asarray(way @ self.inverse.T * abs(self.scale[1]))

    def radii(self) -> Array:
        """Return the length of one unit of the numbers of each axis (3,), as ways count: 0.5 where they are diameters."""
        return np.asarray(np.abs(self.scale[1] / self.scale))

    def tip(self, numbers: Array) -> Array:
        return np.asarray(self.matrix @ (numbers / self.scale) + self.shift)

    def length(self, value: float, axis: int) -> float:
        """Return a length (mm) along an axis of the plane, as the program writes it."""
        way = np.zeros(3)
        way[axis] = value
        return float(np.linalg.norm(self.ways(way)))


def frame_of(trace: Trace) -> BlockFrame:
    t, m = trace.transformation, trace.after
    scale = np.full(3, 1.0 / m.unit)
    if m.diameter:
        scale[0] *= 2.0
    matrix = np.array(t.matrix)
    turned = np.abs(matrix @ matrix.T - np.eye(3)).max() < 1e-9  # no scaling
    return BlockFrame(
        matrix=matrix,
        inverse=matrix.T if turned else np.linalg.inv(matrix),
        shift=np.array(t.shift),
        scale=scale,
        offset=np.array(trace.contour.tool_offset),
        absolute=m.absolute,
        inch=m.unit > 1.0,
        arc_absolute=m.arc_absolute,
    )
