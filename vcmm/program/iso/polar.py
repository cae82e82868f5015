"""Polar words: G16 of Fanuc and its kin, @ and ^ of LinuxCNC."""

from __future__ import annotations

import math

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl
from vcmm.program.iso.lengths import length
from vcmm.program.moves import PLANES


def polar_ends(c: IsoControl, w: IsoWords, p: list[float]) -> tuple[int, int]:
    """Read polar ends, G16: the first axis of the plane is a radius, the second an angle; with G91 the angle counts on, and a radius is one about
    the position of the tool (FANUC B-64304EN, "polar coordinate command"). Return the axes that this sets."""
    first, second, _ = PLANES[c.plane]
    polar = c.polar
    assert polar is not None
    radius, angle = w.take(AXES[first]), w.take(AXES[second])
    if radius is None and angle is None:
        return first, second
    if radius is not None:
        polar.radius = length(c, w, AXES[first], radius)
        polar.pole = (0.0, 0.0) if c.absolute else (c.p[first], c.p[second])
    if angle is not None:
        polar.angle = math.radians(angle) if c.absolute else polar.angle + math.radians(angle)
    p[first] = polar.pole[0] + polar.radius * math.cos(polar.angle)
    p[second] = polar.pole[1] + polar.radius * math.sin(polar.angle)
    return first, second


def radial_ends(c: IsoControl, w: IsoWords, p: list[float]) -> tuple[int, ...]:
    """Read polar ends: @ is the distance from the work zero, ^ the angle from X; the one that is missing is that of the point where the tool
    stands, and with G91 both count on (LinuxCNC, G code overview, "polar coordinates"). Return the axes that this sets."""
    if not (w.has("@") or w.has("^")):
        return ()
    column = w.column("@" if w.has("@") else "^")
    if c.plane != "XY":
        raise BlockFault(column, "@ and ^ are words of the plane XY; choose it with G17")
    if w.has("X") or w.has("Y"):
        raise BlockFault(column, "@ and ^ stand beside X or Y; keep one of the two forms")
    radius, angle = math.hypot(c.p[0], c.p[1]), math.atan2(c.p[1], c.p[0])
    if not radius and not (c.absolute and w.has("@") and w.has("^")):
        raise BlockFault(
            column, "the tool is at the work zero, which has no angle; give both @ and ^, with G90"
        )
    if w.has("@"):
        radius = length(c, w, "@", w.take("@") or 0.0) + (0.0 if c.absolute else radius)
    if w.has("^"):
        angle = math.radians(w.take("^") or 0.0) + (0.0 if c.absolute else angle)
    p[0], p[1] = radius * math.cos(angle), radius * math.sin(angle)
    return 0, 1
