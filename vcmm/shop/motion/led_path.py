"""The path of a move whose tip is led over the workpiece: a line, an arc, a helix or a spiral, at shares of it."""

from __future__ import annotations

import math

import numpy as np

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
