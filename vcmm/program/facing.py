"""Polar interpolation: the plane over the end face, X and C leading the tip, in every language that has it.

The moves hold the points of the tip over the face (`Move.over_face`); the angle of C at both ends follows, C = C0 + atan2(y, x), and goes
on from move to move. Source: FANUC B-64304EN-1, "polar coordinate interpolation"; Siemens, Job Planning, "TRANSMIT".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vcmm.program.moves import Move, Point
from vcmm.program.recorder import Recorder

PIECES = 16  # of a move over the end face, along which its angle is followed


@dataclass(frozen=True, slots=True)
class EndFace:
    """zero: the turning axis in machine coordinates, mm; angle: of C where polar interpolation began, rad."""

    zero: Point
    angle: float


def face_begins(c: Recorder) -> EndFace:
    """Begin polar interpolation and return its end face: X and the angle lead the tip from here on."""
    c.is_tcp_on = c.over_face = True
    return EndFace(c.world.apply((0.0, 0.0, 0.0)), c.rotary[2])


def face_ends(c: Recorder, on: EndFace) -> None:
    """Return to the axes themselves: C keeps its angle, X its distance."""
    c.is_tcp_on = c.over_face = False
    x, y, z = c.p
    c.rotary = (c.rotary[0], c.rotary[1], on.angle + math.atan2(y, x))
    tip, o = c.world.apply((math.hypot(x, y), 0.0, z)), c.tool_offset
    c.q = (tip[0] + o[0], tip[1] + o[1], tip[2] + o[2])
    c.locate()


def with_angles(moves: tuple[Move, ...], on: EndFace) -> tuple[Move, ...]:
    """Return the moves over the end face with the angle of C at both ends; it goes on from move to move."""
    out, angle = [], on.angle
    for m in moves:
        if not m.over_face or m.rotary_end[2] != on.angle:
            out.append(m)
            continue
        way = np.unwrap([angle - on.angle, *(_angle(m, on, k / PIECES) for k in range(PIECES + 1))])
        begin, angle = on.angle + float(way[1]), on.angle + float(way[-1])
        a, b, _ = m.rotary_end
        out.append(m._replace(rotary_start=(a, b, begin), rotary_end=(a, b, angle)))
    return tuple(out)


def _angle(m: Move, on: EndFace, share: float) -> float:
    x = m.start[0] + share * (m.end[0] - m.start[0]) - on.zero[0]
    y = m.start[1] + share * (m.end[1] - m.start[1]) - on.zero[1]
    if m.centre is not None:
        r0, r1 = (math.hypot(q[0] - m.centre[0], q[1] - m.centre[1]) for q in (m.start, m.end))
        begin, last = (math.atan2(q[1] - m.centre[1], q[0] - m.centre[0]) for q in (m.start, m.end))
        sweep = (begin - last if m.clockwise else last - begin) % (2.0 * math.pi) or 2.0 * math.pi
        at, radius = begin + share * sweep * (-1.0 if m.clockwise else 1.0), r0 + share * (r1 - r0)
        x, y = (
            m.centre[0] + radius * math.cos(at) - on.zero[0],
            m.centre[1] + radius * math.sin(at) - on.zero[1],
        )
    return math.atan2(y, x)
