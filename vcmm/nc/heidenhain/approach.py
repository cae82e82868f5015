"""APPR and DEP of Klartext: approach to and departure from a contour.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Approaching and departing a contour". PS start, PH
auxiliary point, PA first point of the contour, PE its last, PN end point.

    LT   along the tangent over LEN          LN   along the normal over LEN + tool radius
    CT   arc of radius R over the angle CCA  LCT  straight line and arc of radius R, tangential to one another

n points from the contour to the tool. R is the radius of the path of the centre, which is tangential to the offset
contour. A Z coordinate of APPR is approached at PH, after the motion in the plane (iTNC 530, TNC 640 up to 34059x-05).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, NoReturn

from vcmm.core.errors import ModelLimit
from vcmm.nc.moves import PLANES, Move, Point
from vcmm.nc.offsetting import Vec, along, left, minus, tangent
from vcmm.nc.recorder import NO_SIDE, Side
from vcmm.nc.rounding import in_space, piece_of, planar

KINDS = ("LT", "LN", "CT", "LCT")


class Approach(NamedTuple):
    """What an APPR or DEP block says; mm, rad. length: LEN, radius: R, angle: CCA."""

    kind: str
    length: float = 0.0
    radius: float = 0.0
    angle: float = 0.0


class Said(NamedTuple):
    """An APPR block; how PS to PH is travelled: at rapid, or at a feed, mm/min (None: that of the block)."""

    approach: Approach
    rapid: bool
    feed: float | None


def resolve(
    moves: Sequence[Move], sides: Sequence[Side], said: Sequence[Said], file: str
) -> tuple[list[Move], list[Side]]:
    """Replaces the placeholders of kind "approach" (from PS to PA) by their moves. `seconds` of a placeholder is its
    number in `said`."""
    out: list[Move] = []
    kept: list[Side] = []
    for k, move in enumerate(moves):
        if move.kind != "approach":
            out.append(move)
            kept.append(sides[k])
            continue
        first = next((m for m in moves[k + 1 :] if planar(m)), None)
        if first is None or first.plane != move.plane:
            _refuse(
                file,
                move,
                "APPR is not followed by a contour element in its plane",
                "program the first element (L, C, CR ...) after it",
            )
        words = said[round(move.seconds)]
        for made, side in _approach(move._replace(seconds=0.0), first, sides[k], words, file):
            out.append(made)
            kept.append(side)
    return out, kept


def _approach(move: Move, first: Move, side: Side, said: Said, file: str) -> list[tuple[Move, Side]]:
    one, two, normal = PLANES[move.plane]
    approach = said.approach
    piece = piece_of(first)
    contour = piece.start
    t = tangent(piece, contour)
    n = left(t) if side.side == "left" else (t[1], -t[0])
    start = (move.start[one], move.start[two])
    arc: tuple[Vec, bool] | None = None
    outside = NO_SIDE
    target = contour
    if approach.kind == "LT":
        help_point, outside = along(contour, t, -approach.length), side
    elif approach.kind == "LN":
        help_point = along(contour, n, approach.length + side.radius)
    else:
        target = along(contour, n, side.radius)
        centre = along(target, n, approach.radius)
        ccw = (side.side == "left") == (approach.radius > 0)
        arc = centre, not ccw
        if approach.kind == "CT":
            help_point = _turned(target, centre, -approach.angle if ccw else approach.angle)
        else:
            help_point = _touching(start, centre, abs(approach.radius), ccw, move, file)
    return _moves(move, help_point, target, arc, said, outside, side, normal)


def _moves(
    move: Move,
    help_point: Vec,
    target: Vec,
    arc: tuple[Vec, bool] | None,
    said: Said,
    outside: Side,
    side: Side,
    normal: int,
) -> list[tuple[Move, Side]]:
    """PS to PH in the plane, down at PH, PH to PA."""
    plane = move.plane
    feed = said.feed if said.feed is not None else move.feed
    line = move._replace(kind="rapid", feed=None) if said.rapid else move._replace(kind="line", feed=feed)
    ph = in_space(plane, help_point, move.start[normal])
    low = in_space(plane, help_point, move.end[normal])
    end = in_space(plane, target, move.end[normal])
    made = [(line._replace(end=ph), outside)]
    if low != ph:
        made.append((line._replace(start=ph, end=low), outside))
    if arc is None:
        made.append((move._replace(kind="line", start=low, end=end), side))
    else:
        centre = in_space(plane, arc[0], move.end[normal])
        made.append((move._replace(kind="arc", start=low, end=end, centre=centre, clockwise=arc[1]), outside))
    return made


def depart(
    last: Move, side: Side, departure: Approach, to: Vec | None, file: str, where: Move
) -> list[tuple[str, Point, Point, Point | None, bool]]:
    """Moves (kind, start, end, centre, clockwise) of the centre from the end of the contour, in its plane. to: PN of LCT."""
    normal = PLANES[last.plane][2]
    height = last.end[normal]
    piece = piece_of(last)
    t = tangent(piece, piece.end)
    n = left(t) if side.side == "left" else (t[1], -t[0])
    leave = along(piece.end, n, side.radius)

    def space(v: Vec) -> Point:
        return in_space(last.plane, v, height)

    if departure.kind in ("LT", "LN"):
        end = along(leave, t if departure.kind == "LT" else n, departure.length)
        return [("line", space(leave), space(end), None, False)]
    centre = along(leave, n, departure.radius)
    ccw = (side.side == "left") == (departure.radius > 0)
    if departure.kind == "CT":
        end = _turned(leave, centre, departure.angle if ccw else -departure.angle)
        return [("arc", space(leave), space(end), space(centre), not ccw)]
    assert to is not None
    end = _touching(to, centre, abs(departure.radius), not ccw, where, file)
    return [
        ("arc", space(leave), space(end), space(centre), not ccw),
        ("line", space(end), space(to), None, False),
    ]


def _turned(point: Vec, centre: Vec, angle: float) -> Vec:
    a, b = minus(point, centre)
    c, s = math.cos(angle), math.sin(angle)
    return centre[0] + a * c - b * s, centre[1] + a * s + b * c


def _touching(start: Vec, centre: Vec, radius: float, ccw: bool, move: Move, file: str) -> Vec:
    """Where a line from `start` touches a circle so that it runs on in the given direction."""
    distance = math.dist(start, centre)
    if distance <= radius:
        _refuse(
            file,
            move,
            f"the start or end point lies within the arc of radius {radius:g} mm of LCT",
            "move it away or make R smaller",
        )
    angle = math.atan2(start[1] - centre[1], start[0] - centre[0])
    half = math.acos(radius / distance)
    turned = angle + half if ccw else angle - half
    return centre[0] + radius * math.cos(turned), centre[1] + radius * math.sin(turned)


def _refuse(file: str, move: Move, what: str, fix: str) -> NoReturn:
    raise ModelLimit(f"{file}:{move.source.line}:{move.source.first}: {what}; {fix}.")
