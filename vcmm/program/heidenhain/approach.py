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
from typing import NamedTuple

from vcmm.program.faults import refuse
from vcmm.program.moves import PLANES, Move, Point, Source
from vcmm.program.offsetting import Vec, in_space, left_normal, minus, moved_along, piece_of, planar, tangent
from vcmm.program.radius import RadiusCompensation
from vcmm.program.recorder import Sides

APPROACH_WORDS = ("LT", "LN", "CT", "LCT")


class Approach(NamedTuple):
    """Data of an APPR or DEP block; mm, rad. length: LEN, radius: R, angle: CCA."""

    kind: str
    length: float = 0.0
    radius: float = 0.0
    angle: float = 0.0


class ApproachBlock(NamedTuple):
    """An APPR block; how PS to PH is travelled: at rapid, or at a feed, mm/min (None: that of the block)."""

    approach: Approach
    rapid: bool
    feed: float | None


def resolve(
    moves: Sequence[Move],
    sides: Sequence[RadiusCompensation | None],
    blocks: Sequence[ApproachBlock],
    file: str,
) -> tuple[list[Move], Sides]:
    """Replace the placeholders of kind "approach" (from PS to PA) by their moves. `seconds` of a placeholder is its
    number in `said`."""
    out: list[Move] = []
    sides_out: Sides = []
    for k, move in enumerate(moves):
        if move.kind != "approach":
            out.append(move)
            sides_out.append(sides[k])
            continue
        first = next((m for m in moves[k + 1 :] if planar(m)), None)
        if first is None or first.plane != move.plane:
            refuse(
                file,
                move.source,
                "APPR is not followed by a contour element in its plane",
                "program the first element (L, C, CR ...) after it",
            )
        words = blocks[round(move.seconds)]
        side = sides[k]
        assert side is not None
        for made, beside in _approach(move._replace(seconds=0.0), first, side, words, file):
            out.append(made)
            sides_out.append(beside)
    return out, sides_out


def _approach(
    move: Move, first: Move, side: RadiusCompensation, block: ApproachBlock, file: str
) -> list[tuple[Move, RadiusCompensation | None]]:
    """Return PS to PH in the plane, down at PH, PH to PA; with what is in force on each."""
    approach, piece = block.approach, piece_of(first)
    t = tangent(piece, piece.start)
    n = left_normal(t) if side.side == "left" else (t[1], -t[0])
    if approach.kind == "LT":
        line = _to_help_point(move, moved_along(piece.start, t, -approach.length), block)
        return [*((m, side) for m in line), (_last(move, line, piece.start), side)]
    if approach.kind == "LN":
        line = _to_help_point(move, moved_along(piece.start, n, approach.length + side.radius), block)
        return [*((m, None) for m in line), (_last(move, line, piece.start), side)]
    target = moved_along(piece.start, n, side.radius)
    centre = moved_along(target, n, approach.radius)
    ccw = (side.side == "left") == (approach.radius > 0)
    if approach.kind == "CT":
        help_point = _turn(target, centre, -approach.angle if ccw else approach.angle)
    else:
        first_axis, second, _ = PLANES[move.plane]
        start = (move.start[first_axis], move.start[second])
        help_point = _touching(start, centre, abs(approach.radius), ccw, (file, move.source))
    line = _to_help_point(move, help_point, block)
    height = move.end[PLANES[move.plane][2]]
    arc = _last(move, line, target)._replace(
        kind="arc", centre=in_space(move.plane, centre, height), clockwise=not ccw
    )
    return [*((m, None) for m in line), (arc, None)]


def _to_help_point(move: Move, help_point: Vec, block: ApproachBlock) -> list[Move]:
    """Return PS to PH in the plane, and down at PH."""
    plane, normal = move.plane, PLANES[move.plane][2]
    feed = block.feed if block.feed is not None else move.feed
    line = move._replace(kind="rapid", feed=None) if block.rapid else move._replace(kind="line", feed=feed)
    ph, low = (in_space(plane, help_point, p[normal]) for p in (move.start, move.end))
    return [line._replace(end=ph), *([line._replace(start=ph, end=low)] if low != ph else [])]


def _last(move: Move, before: Sequence[Move], target: Vec) -> Move:
    """Return a line from PH to PA."""
    end = in_space(move.plane, target, move.end[PLANES[move.plane][2]])
    return move._replace(kind="line", start=before[-1].end, end=end)


def depart(
    last: Move, side: RadiusCompensation, departure: Approach, to: Vec, where: tuple[str, Source]
) -> list[tuple[Point, Point, Point | None, bool | None]]:
    """Return the moves (start, end, centre and sense of an arc) of the tool centre from the end of the contour, in its plane.

    to: PN of LCT. where: file and block, for messages.
    """
    height = last.end[PLANES[last.plane][2]]
    piece = piece_of(last)
    t = tangent(piece, piece.end)
    n = left_normal(t) if side.side == "left" else (t[1], -t[0])
    leave = moved_along(piece.end, n, side.radius)

    def space(v: Vec) -> Point:
        return in_space(last.plane, v, height)

    if departure.kind in ("LT", "LN"):
        end = moved_along(leave, t if departure.kind == "LT" else n, departure.length)
        return [(space(leave), space(end), None, None)]
    centre = moved_along(leave, n, departure.radius)
    ccw = (side.side == "left") == (departure.radius > 0)
    if departure.kind == "CT":
        end = _turn(leave, centre, departure.angle if ccw else -departure.angle)
        return [(space(leave), space(end), space(centre), not ccw)]
    end = _touching(to, centre, abs(departure.radius), not ccw, where)
    return [(space(leave), space(end), space(centre), not ccw), (space(end), space(to), None, None)]


def _turn(point: Vec, centre: Vec, angle: float) -> Vec:
    a, b = minus(point, centre)
    c, s = math.cos(angle), math.sin(angle)
    return centre[0] + a * c - b * s, centre[1] + a * s + b * c


def _touching(start: Vec, centre: Vec, radius: float, ccw: bool, where: tuple[str, Source]) -> Vec:
    """Return where a line from `start` touches a circle so that it runs on in the given direction."""
    distance = math.dist(start, centre)
    if distance <= radius:
        refuse(
            *where,
            f"the start or end point lies within the arc of radius {radius:g} mm of LCT",
            "move it away or make R smaller",
        )
    angle = math.atan2(start[1] - centre[1], start[0] - centre[0])
    half = math.acos(radius / distance)
    turned = angle + half if ccw else angle - half
    return centre[0] + radius * math.cos(turned), centre[1] + radius * math.sin(turned)
