"""Polar interpolation as motions of X and C: the tip runs over the end face, X follows its distance from the axis of C.

    x = centre + |p - centre|        C = C0 + atan2(p - centre)        Y at the centre, Z as programmed

between points so close that straight motions of X and C leave the programmed path by no more than CHORD: the error of half a piece
shrinks with the square of its length. A path through the axis itself would turn C by half a turn at once; it is
refused. Source: FANUC B-64304EN-1, "polar coordinate interpolation"; Siemens, "TRANSMIT".

`led_path` is the path of a move whose tip is led over the workpiece: a line, an arc, a helix or a spiral, at shares of it.
"""

from __future__ import annotations

import math

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.program.moves import PLANES, Move


def swept_angle(m: Move) -> float:
    """Return the signed angle of an arc in its plane, rad; 0 of a line."""
    if m.centre is None:
        return 0.0
    a, b, _ = PLANES[m.plane]
    begin = math.atan2(m.start[b] - m.centre[b], m.start[a] - m.centre[a])
    stop = math.atan2(m.end[b] - m.centre[b], m.end[a] - m.centre[a])
    turn = (begin - stop if m.clockwise else stop - begin) % (2.0 * math.pi)
    turn = (turn if turn > 1e-6 else turn + 2.0 * math.pi) + 2.0 * math.pi * (m.turns - 1)
    return -turn if m.clockwise else turn


def led_path(m: Move, begin: Array, share: Array) -> Array:
    """Return the tips (k, 3) in the workpiece from `begin` (3,), where the tool really is, to the end of the move."""
    end = np.array(m.end)
    if m.centre is None:
        return np.asarray(begin + share[:, None] * (end - begin))
    a, b, n = PLANES[m.plane]
    sweep, centre = swept_angle(m), m.centre
    r0, r1 = (math.hypot(p[a] - centre[a], p[b] - centre[b]) for p in (m.start, m.end))
    angle = math.atan2(m.start[b] - centre[b], m.start[a] - centre[a]) + share * sweep
    radius = r0 + share * (r1 - r0)
    out = np.empty((len(share), 3))
    out[:, a], out[:, b] = centre[a] + radius * np.cos(angle), centre[b] + radius * np.sin(angle)
    out[:, n] = m.start[n] + share * (m.end[n] - m.start[n])
    return np.asarray(out + (1.0 - share)[:, None] * (begin - np.array(m.start)))


CHORD = 1e-5  # mm by which the axes may leave the path between two points
LOOKS = 64  # pieces at which it is first looked
MOST_TURN = 1.0  # rad of C in one piece at most
NEAREST = 0.01  # mm from the axis of C


def polar_samples(m: Move, centre: Array, tip: Array, c: float) -> tuple[Array, Array, Array]:
    """Return (points of the face (k, 3), tips of the machine (k, 3), angles of C (k,) rad) along a move over the face.

    tip (3,): position of the machine before it, C at c. Raises ModelLimit for a way through the axis of C.
    """
    offset = m.rotary_start[2] - math.atan2(m.start[1] - centre[1], m.start[0] - centre[0])
    fine = led_path(m, np.array(m.start), np.linspace(0.0, 1.0, 2 * LOOKS + 1))
    radius, angle = _polar(fine, centre)
    if m.kind != "rapid" and radius.min() < NEAREST:
        raise ModelLimit(
            f"line {m.source.line}: polar interpolation leads the tool through the axis of C, where C would turn at once; keep away from it by "
            f"{NEAREST:g} mm"
        )
    middle = 0.5 * (radius[:-2:2] + radius[2::2]), 0.5 * (angle[:-2:2] + angle[2::2])
    off = np.hypot(
        centre[0] + middle[0] * np.cos(middle[1]) - fine[1::2, 0],
        centre[1] + middle[0] * np.sin(middle[1]) - fine[1::2, 1],
    )
    followed = (
        float(np.abs(np.diff(angle)).sum()) / MOST_TURN
    )  # so that no turn of C is lost from piece to piece
    count = max(1, math.ceil(followed), math.ceil(LOOKS * math.sqrt(float(off.max()) / CHORD)))
    at = led_path(m, np.array(m.start), np.linspace(0.0, 1.0, count + 1))
    radius, angle = _polar(at, centre)
    angle = np.unwrap(np.concatenate([[c], angle + offset]))[1:]
    moved = np.column_stack([centre[0] + radius, np.full(len(at), centre[1]), at[:, 2]])
    moved[0], angle[0] = tip, c
    return at, moved, angle


def _polar(points: Array, centre: Array) -> tuple[Array, Array]:
    """Return the distance from the axis of C, mm, and angle about it, rad, without jumps."""
    x, y = points[:, 0] - centre[0], points[:, 1] - centre[1]
    return np.hypot(x, y), np.unwrap(np.arctan2(y, x))
