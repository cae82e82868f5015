"""Rounded and chamfered corners of a programmed contour: RND, CHF, CHR (Sinumerik), RND, CHF (Klartext).

A rounding of radius r touches both neighbours: its centre is where their parallel curves at r meet, on the side to which
the corner turns. It acts on the programmed contour, before radius compensation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeVar

from vcmm.program.faults import refuse
from vcmm.program.moves import PLANES, Move, Source
from vcmm.program.offsetting import (
    ContourPiece,
    NoMeeting,
    Vec,
    corner,
    in_space,
    minus,
    moved_along,
    parallel_radius,
    piece_of,
    planar,
    tangent,
    trimmed_sweep,
    turn_between,
    unit,
)

State = TypeVar("State")


class RoundedCorner(NamedTuple):
    """Rounding or chamfer at the end of the move with number `after`. kind: "round" (size: radius, mm), "chamfer" (mm cut
    off each side), "width" (mm across the chamfer). feed: its own, None = that of the move that follows."""

    after: int
    kind: str
    size: float
    source: Source
    feed: float | None = None
    ahead: tuple[float, float, float] | None = None  # which way the next move must go, machine axes
    modal: bool = False  # of a rounding in force: the last move of a contour has none


def round_corners(
    moves: Sequence[Move], states: Sequence[State], corners: Sequence[RoundedCorner], file: str = ""
) -> tuple[list[Move], list[State]]:
    """Return the moves with all corners worked in; states[i] belongs to move i and is carried along.

    Raises ProgramLimit with the place where a corner does not fit between its neighbours.
    """
    out, out_states = list(moves), list(states)
    for rounded in reversed(corners):
        following = next((k for k in range(rounded.after + 1, len(out)) if planar(out[k])), None)
        if following is None and rounded.modal:
            continue
        if following is None or not planar(out[rounded.after]):
            refuse(
                file,
                rounded.source,
                "a rounding or chamfer needs a move in the plane before and after it",
                "place it between two such moves",
            )
        if out[following].plane != out[rounded.after].plane:
            refuse(
                file,
                rounded.source,
                "a rounding or chamfer lies between two planes",
                "keep the plane across it",
            )
        _check_way(out[following], rounded, file)
        a, b, extra = _work_corner(out[rounded.after], out[following], rounded, file)
        out[rounded.after], out[following] = a, b
        if extra is not None:
            out.insert(following, extra)
            out_states.insert(following, out_states[following])
    return out, out_states


def _check_way(second: Move, rounded: RoundedCorner, file: str) -> None:
    """Check the sign of a chamfer (C, I, K of a lathe): it is that of the next move."""
    if rounded.ahead is None:
        return
    way = [b - a for a, b in zip(second.start, second.end)]
    along = sum(a * b for a, b in zip(way, rounded.ahead))
    if along < (1.0 - 1e-6) * math.hypot(*way):
        refuse(
            file,
            rounded.source,
            "the next block does not go the way that the sign of the chamfer says",
            "correct the sign, or the next block, which runs along the other axis alone",
        )


def _work_corner(
    first: Move, second: Move, rounded: RoundedCorner, file: str
) -> tuple[Move, Move, Move | None]:
    a, b = piece_of(first), piece_of(second)
    turn = turn_between(a, b)
    if abs(turn) < 1e-9 or rounded.size == 0.0:
        return first, second, None  # smooth already
    ends = (
        _round(a, b, turn, rounded.size) if rounded.kind == "round" else _chamfer(a, b, turn, rounded, file)
    )
    if ends is None or not _fits(a, a.start, ends[0]) or not _fits(b, ends[1], b.end):
        refuse(
            file,
            rounded.source,
            f"a {'rounding of radius' if rounded.kind == 'round' else 'chamfer of'} {rounded.size:g} mm does not fit between its neighbours",
            "make it smaller or the neighbours longer",
        )
    plane, height = first.plane, first.end[PLANES[first.plane][2]]
    start, end = in_space(plane, ends[0], height), in_space(plane, ends[1], height)
    feed = (
        rounded.feed if rounded.feed is not None else second.feed if second.feed is not None else first.feed
    )
    made = second._replace(
        kind="line", source=rounded.source, start=start, end=end, centre=None, turns=1, clockwise=None, feed=feed,
        rotary_end=second.rotary_start, exact_stop=False,
    )  # fmt: skip
    if rounded.kind == "round":
        made = made._replace(kind="arc", centre=in_space(plane, ends[2], height), clockwise=turn < 0)
    return first._replace(end=start), second._replace(start=end), made


def _round(a: ContourPiece, b: ContourPiece, turn: float, radius: float) -> tuple[Vec, Vec, Vec] | None:
    h = math.copysign(radius, turn)
    if math.pi - abs(turn) < 1e-9:
        return None
    if any(p.centre is not None and parallel_radius(p, h) < 1e-9 for p in (a, b)):
        return None
    try:
        centre = corner(a, b, h, "arc").end
    except NoMeeting:
        return None
    return _foot(a, centre), _foot(b, centre), centre


def _foot(piece: ContourPiece, centre: Vec) -> Vec:
    """Return the point of a piece that is nearest to a point beside it."""
    if piece.centre is None:
        direction = tangent(piece, piece.start)
        reach = (centre[0] - piece.start[0]) * direction[0] + (centre[1] - piece.start[1]) * direction[1]
        return moved_along(piece.start, direction, reach)
    return moved_along(piece.centre, unit(minus(centre, piece.centre)), math.dist(piece.start, piece.centre))


def _chamfer(
    a: ContourPiece, b: ContourPiece, turn: float, rounded: RoundedCorner, file: str
) -> tuple[Vec, Vec, Vec]:
    if a.centre is not None or b.centre is not None:
        refuse(
            file,
            rounded.source,
            "a chamfer beside an arc",
            "chamfers stand between two straight lines; program the line itself",
        )
    size = (
        rounded.size if rounded.kind == "chamfer" else rounded.size / (2 * math.cos(turn / 2))
    )  # across = 2 side cos(turn / 2)
    return (
        moved_along(a.end, tangent(a, a.end), -size),
        moved_along(b.start, tangent(b, b.start), size),
        a.end,
    )


def _fits(piece: ContourPiece, start: Vec, end: Vec) -> bool:
    """Return True where the trimmed piece still runs forwards and lies within the programmed rounded."""
    if piece.centre is not None:
        return trimmed_sweep(piece, start, end) * piece.sweep > 0
    direction, length = tangent(piece, piece.start), math.dist(piece.start, piece.end)
    reach = [
        (p[0] - piece.start[0]) * direction[0] + (p[1] - piece.start[1]) * direction[1] for p in (start, end)
    ]
    return -1e-9 <= reach[0] <= reach[1] + 1e-9 <= length + 2e-9
