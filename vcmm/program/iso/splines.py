"""G5 and G5.1 of LinuxCNC: cubic and quadratic splines in the plane XY, as chords.

    G5 X Y I J P Q      cubic: I, J from its start to the first control point, P, Q from its end to the second; behind another G5 I and J may
                        be left out: the spline goes on in the direction in which that one ended
    G5.1 X Y I J        quadratic: I, J from its start to the control point

Source: LinuxCNC, G code reference, "G5 Cubic Spline", "G5.1 Quadratic Spline".
"""

from __future__ import annotations

import math

from vcmm.program.chords import SAG
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.lengths import length
from vcmm.program.iso.motion import target

Flat = tuple[float, float]


def spline(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Execute one block of a spline. Raises BlockFault where the control stops."""
    if c.plane != "XY":
        raise BlockFault(column, f"{code} lies in the plane XY; write G17 before it")
    if c.compensation is not None:
        raise BlockFault(column, f"{code} with cutter radius compensation: end it by G40 before")
    for axis in "ZABC":
        if w.has(axis):
            raise BlockFault(
                w.column(axis), f"{code} moves X and Y alone; write {axis} in a block of its own"
            )
    start, before = c.p, c.leaving
    first = _offset(c, w, "IJ", code)
    if code == "G5":
        last = _offset(c, w, "PQ", code)
        if last is None:
            raise BlockFault(column, "G5 needs P and Q, from its end to the second control point")
        if first is None:
            if before is None or before[0] != start:
                raise BlockFault(
                    column, "G5 without I and J goes on from another G5, which does not stand before it"
                )
            first = (-before[1][0], -before[1][1])
    elif first is None or first == (0.0, 0.0):
        raise BlockFault(column, "G5.1 needs I or J, from its start to the control point")
    end, _ = target(c, w)
    a = (start[0] + first[0], start[1] + first[1])
    if code == "G5":
        assert last is not None
        points = [start[:2], a, (end[0] + last[0], end[1] + last[1]), end[:2]]
    else:
        points = [start[:2], a, end[:2]]
    c.assume("splines (G5, G5.1)", f"straight lines within {SAG * 1e3:g} um", column=column, matters=False)
    for x, y in bezier_chords(points):
        c.straight((x, y, start[2]), False)
    c.leaving = (c.p, last) if code == "G5" and last is not None else None


def _offset(c: IsoControl, w: IsoWords, letters: str, code: str) -> Flat | None:
    """Return two words that belong together, mm; None where neither is there. Of I and J of G5.1 a missing one is 0."""
    values = [w.take(k) for k in letters]
    if values[0] is None and values[1] is None:
        return None
    if None in values and code == "G5":
        raise BlockFault(
            c.column, f"G5 takes {letters[0]} and {letters[1]} together; write both, the one that is 0 too"
        )
    x, y = (0.0 if v is None else length(c, w, k, v) for k, v in zip(letters, values))
    return x, y


def bezier_chords(points: list[Flat] | list[tuple[float, ...]]) -> list[Flat]:
    """Return the ends of even chords of a Bezier curve, no more than SAG off it.

    Its second derivative lies between those at the ends of its control polygon, m (m - 1) |p[i] - 2 p[i+1] + p[i+2]| for degree m, and a
    chord over 1/n of the parameter is off by |B''| / 8 n^2 at most.
    """
    m = len(points) - 1
    bend = max(
        math.hypot(*(p[k] - 2.0 * q[k] + r[k] for k in (0, 1)))
        for p, q, r in zip(points, points[1:], points[2:])
    )
    count = max(1, math.ceil(math.sqrt(m * (m - 1) * bend / (8.0 * SAG))))
    out: list[Flat] = []
    for i in range(1, count):
        t = i / count
        weights = [math.comb(m, k) * t**k * (1.0 - t) ** (m - k) for k in range(m + 1)]
        x, y = (sum(v * p[axis] for v, p in zip(weights, points)) for axis in (0, 1))
        out.append((x, y))
    return [*out, (points[-1][0], points[-1][1])]
