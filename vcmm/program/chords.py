"""Arcs that do not lie in a plane of the machine, as chords."""

from __future__ import annotations

import math

from vcmm.program.frames import in_plane
from vcmm.program.moves import PLANES, Point
from vcmm.program.offsetting import sweep_of
from vcmm.program.recorder import Recorder

SAG = 1e-3  # mm from the arc to its chords, at most


def arc_or_chords(r: Recorder, end: Point, centre: Point, clockwise: bool, turns: int = 1) -> None:
    """Make an arc of the plane in force; chords at most `SAG` off where a frame tilts that plane out of the planes of the machine.

    Strict reading keeps arcs arcs, and refuses those.
    """
    if r.setup.strict or in_plane(r.world, r.plane) is not None:
        r.arc(end, centre, clockwise, turns)
        return
    r.remark(f"arcs of a tilted plane are read as chords, {SAG * 1e3:g} um off them at most")
    r.check_radii(r.plane, end, centre)
    for point in chords(r.p, end, centre, (clockwise, turns), r.plane):
        r.straight(point, False)


def chords(start: Point, end: Point, centre: Point, sense: tuple[bool, int], plane: str) -> list[Point]:
    """Return the ends of the chords of an arc or helix, mm. sense: clockwise, turns. Half the angle of a chord is acos(1 - sag / radius)."""
    first_axis, second, normal = PLANES[plane]
    from_, to, about = ((p[first_axis], p[second]) for p in (start, end, centre))
    sweep = sweep_of(from_, to, about, *sense)
    first, last = math.dist(from_, about), math.dist(to, about)
    step = 2.0 * math.acos(1.0 - min(SAG / first, 0.5))
    count = max(1, math.ceil(abs(sweep) / step))
    angle = math.atan2(from_[1] - about[1], from_[0] - about[0])
    out = []
    for k in range(1, count):
        share = k / count
        radius, turned = first + (last - first) * share, angle + sweep * share
        point = list(start)
        point[first_axis], point[second] = (
            about[0] + radius * math.cos(turned),
            about[1] + radius * math.sin(turned),
        )
        point[normal] += (end[normal] - start[normal]) * share
        out.append((point[0], point[1], point[2]))
    return [*out, end]
