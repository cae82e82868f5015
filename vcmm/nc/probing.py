"""One surface read by a probe: towards it, until ball and surface meet, and back. What the cycles of all controls are made of."""

from __future__ import annotations

from vcmm.nc.moves import Point
from vcmm.nc.recorder import Recorder
from vcmm.nc.setup import Tool

OVERTRAVEL = 10.0  # mm beyond the expected surface, as in Renishaw's Inspection Plus (Q) and usual as set-up of a probe elsewhere


def ball_radius(tool: Tool) -> float:
    """mm; 0 where the set-up does not state it."""
    return (tool.diameter or 0.0) / 2.0


def read_surface(
    r: Recorder, axis: int, expected: float, sense: float, tool: Tool, *, overtravel: float = OVERTRAVEL
) -> float:
    """Coordinate of a surface along an axis (0, 1, 2), mm as programmed: the probe goes there from where it stands, and back.

    expected: where the program takes the surface to be; sense: +1 or -1, the way to it. Where the set-up states no surface on that
    way it is taken to lie where expected. From the side the ball touches its radius before; from above with its lowest point.
    """
    radius = 0.0 if axis == 2 else ball_radius(tool)
    start = r.p
    met = r.touch(
        _at(start, axis, expected + sense * overtravel), tool, expected=_at(start, axis, expected - sense * radius)
    )
    if not met:
        r.fault("the probe stands behind the surface that it is to touch; check where it starts and the expected position")
    measured = r.p[axis] + sense * radius
    r.straight(start, False)
    return measured


def _at(point: Point, axis: int, value: float) -> Point:
    out = list(point)
    out[axis] = value
    return out[0], out[1], out[2]
