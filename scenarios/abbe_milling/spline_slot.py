"""A spline-shaped slot: drawing, NC program cut into short lines, and the nets over its walls and floor.

The spline is our own. One finishing contour inside the slot, counter-clockwise so that both walls are down milled, of
lines no longer than the chord tolerance allows; its two passes cover the floor as well. A bore of the slot's width goes
deeper at both ends, cut in short lines too: features that can be fitted and toleranced.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm import Array, UsageError, machining

STRAIGHT = 4e-3  # 1/mm: where the spline is straighter than that, lines get no longer (2 mm)


@dataclass(frozen=True)
class Slot:
    """Lengths in mm, work coordinates: z = 0 is the top of the workpiece."""

    knots: tuple[tuple[float, float], ...] = ((-110, -25), (-55, 18), (0, -8), (55, 18), (110, -25))
    width: float = 20.0
    depth: float = 10.0
    bore: float = 6.0  # below the floor
    cutter: float = 12.0  # diameter, flat
    chord: float = 2e-3
    feed: float = 900.0  # mm/min
    speed: float = 4000.0  # 1/min

    @cached_property
    def _spline(self) -> tuple[object, float]:
        from scipy.interpolate import CubicSpline

        points = np.array(self.knots, dtype=float)
        at = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        return CubicSpline(at, points, bc_type="natural"), float(at[-1])

    @property
    def length(self) -> float:
        """Of the parameter (the chord length of the knots), mm."""
        return self._spline[1]

    def point(self, s: Array) -> Array:
        """(n, 2)"""
        return np.asarray(self._spline[0](s))  # type: ignore[operator]

    def left(self, s: Array) -> Array:
        """Unit normal (n, 2) to the left of the direction of the spline."""
        d = np.asarray(self._spline[0](s, 1))  # type: ignore[operator]
        return np.stack([-d[:, 1], d[:, 0]], axis=1) / np.linalg.norm(d, axis=1)[:, None]

    def curvature(self, s: Array) -> Array:
        """(n,) 1/mm, plus = turns left."""
        d, dd = (np.asarray(self._spline[0](s, k)) for k in (1, 2))  # type: ignore[operator]
        return np.asarray((d[:, 0] * dd[:, 1] - d[:, 1] * dd[:, 0]) / np.linalg.norm(d, axis=1) ** 3)


def contour(slot: Slot) -> Array:
    """Closed path of the cutter's centre (n, 2), counter-clockwise: right wall out, end, left wall back, end."""
    s = _stations(slot)
    offset = (slot.width - slot.cutter) / 2
    middle, left = slot.point(s), slot.left(s)
    far = _cap(middle[-1], -left[-1] * offset, slot.chord)
    near = _cap(middle[0], left[0] * offset, slot.chord)
    path = np.concatenate([middle - offset * left, far, (middle + offset * left)[::-1], near])
    return np.vstack([path, path[:1]])


def _stations(slot: Slot) -> Array:
    """Parameters (n,) whose chords stay within the tolerance on the outer of the two passes."""
    dense = np.linspace(0.0, slot.length, 2001)
    curvature = np.abs(slot.curvature(dense))
    if curvature.max() * slot.width / 2 >= 0.9:
        raise UsageError(
            f"the spline turns on {1 / curvature.max():.1f} mm, too tight for a slot {slot.width:g} mm wide"
        )
    offset = (slot.width - slot.cutter) / 2
    tightest = curvature / (1 - curvature * offset)  # of the inner pass
    speed = np.linalg.norm(
        np.gradient(slot.point(dense), dense, axis=0), axis=1
    )  # mm per unit of the parameter
    step = np.sqrt(8 * slot.chord / np.maximum(tightest, STRAIGHT)) / speed
    grown = np.append(0.0, np.cumsum(np.diff(dense) / (0.5 * (step[1:] + step[:-1]))))
    return np.interp(np.linspace(0.0, grown[-1], int(np.ceil(grown[-1])) + 1), grown, dense)


def _cap(centre: Array, start: Array, chord: float) -> Array:
    """Points between the ends of a half circle, counter-clockwise."""
    count = int(np.ceil(np.pi / np.sqrt(8 * chord / np.linalg.norm(start))))
    angle = np.linspace(0.0, np.pi, count + 1)[1:-1]
    turned = np.array([-start[1], start[0]])
    return np.asarray(centre + np.cos(angle)[:, None] * start + np.sin(angle)[:, None] * turned)


def circles(slot: Slot) -> tuple[Array, Array]:
    """Closed paths of the cutter's centre (n, 2) in the bores at both ends, counter-clockwise."""
    radius = (slot.width - slot.cutter) / 2
    count = int(np.ceil(2 * np.pi / np.sqrt(8 * slot.chord / radius)))
    angle = np.linspace(0.0, 2 * np.pi, count + 1)
    round_about = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    start, end = slot.point(np.array([0.0, slot.length]))
    return start + round_about, end + round_about


def program(slot: Slot | None = None) -> str:
    """The NC program (Fanuc dialect): the contour at full depth and both bores, in short lines."""
    s = slot or Slot()
    lines = [
        "%",
        "O2424 (SPLINE SLOT, FINISHING, SHORT LINES)",
        "G21 G17 G40 G49 G80 G90 G94",
        "T1 M6",
        f"G54 G0 S{s.speed:.0f} M3",
        "G43 H1 Z20.",
    ]
    lines += _passed("SLOT", contour(s), s.depth, s)
    for name, path in zip(("BORE AT THE START", "BORE AT THE END"), circles(s)):
        lines += _passed(name, path, s.depth + s.bore, s)
    return "\n".join([*lines, "M5", "G91 G28 Z0", "M30", "%"]) + "\n"


def _passed(name: str, path: Array, depth: float, slot: Slot) -> list[str]:
    """Down at the first point, along the path in lines, up."""
    x, y = path[0]
    lines = [f"({name})", f"G0 X{x:.4f} Y{y:.4f}", "Z1.", f"G1 Z-{depth:.1f} F300"]
    lines += [f"G1 X{path[1, 0]:.4f} Y{path[1, 1]:.4f} F{slot.feed:.0f}"]
    return [*lines, *(f"X{x:.4f} Y{y:.4f}" for x, y in path[2:]), "G0 Z20."]


def nets(slot: Slot, along: int = 121) -> tuple[machining.Net, ...]:
    """Left wall, right wall and floor; normals out of the material, that is into the slot."""
    s = np.linspace(0.0, slot.length, along)
    middle, left = slot.point(s), slot.left(s)
    heights = -slot.depth * np.array([0.1, 0.5, 0.9])
    out = []
    for name, side in (("left wall", left), ("right wall", -left)):
        foot = middle + side * slot.width / 2
        points = np.concatenate([np.column_stack([foot, np.full(along, z)]) for z in heights])
        normals = np.tile(np.column_stack([-side, np.zeros(along)]), (len(heights), 1))
        out.append(machining.Net(name, points, normals, s, heights, ("along the slot / mm", "z / mm")))
    across = slot.width * np.array([-0.4, 0.0, 0.4])
    s = np.linspace(0.6 * slot.width, slot.length - 0.6 * slot.width, along)  # the bores have no floor here
    middle, left = slot.point(s), slot.left(s)
    spread = [np.column_stack([middle + a * left, np.full(along, -slot.depth)]) for a in across]
    up = np.tile([0.0, 0.0, 1.0], (along * len(across), 1))
    out.append(
        machining.Net("floor", np.concatenate(spread), up, s, across, ("along the slot / mm", "across / mm"))
    )
    return tuple(out)
