"""Paths that clear a pocket or a face, in the plane of the tool centre. The milling cycles of all languages use them.

Manuals say in which order a cycle clears (from the middle outwards, row by row) and leave the rest to the control. These paths
keep to that; a reader adds a remark that they are assumed. Lengths mm, points (n, 2), counterclockwise unless turned round.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from vcmm.program.drilling import whole_count

Vec = tuple[float, float]


class PathPiece(NamedTuple):
    """Path from the tool position to `end`: straight, or an arc about `centre`."""

    end: Vec
    centre: Vec | None = None
    clockwise: bool = False


def rings(half: float, step: float) -> list[float]:
    """Return the distances from the middle line of the rings that clear a half width: equal, at most `step` apart, the last one `half`."""
    count = max(1, whole_count(math.ceil(half / step - 1e-9))) if step > 0 else 1
    return [half * (k + 1) / count for k in range(count)] if half > 0 else [0.0]


def rectangle(
    size: Vec, step: float, corner: float = 0.0, clockwise: bool = False, angle: float = 0.0
) -> list[PathPiece]:
    """Return the path that clears a rectangle about the origin from its middle line outwards.

    size: how far the centre of the tool goes to each side, mm; corner: radius of its path in the corners of the last ring;
    angle: rad by which all is turned.
    """
    a, b = size
    out: list[PathPiece] = []
    widths = rings(min(a, b), step)
    for k, offset in enumerate(min(a, b) - w for w in widths):
        last = k == len(widths) - 1
        out += list(_ring((a - offset, b - offset), corner if last else 0.0))
    if clockwise:
        out = [
            PathPiece((p.end[0], -p.end[1]), p.centre and (p.centre[0], -p.centre[1]), not p.clockwise)
            for p in out
        ]
    return [turn_piece(p, angle) for p in out]


def _ring(half: Vec, corner: float) -> Iterator[PathPiece]:
    """Return one ring: once round, from the middle of the right side, counterclockwise."""
    a, b = half
    r = min(corner, a, b)
    yield PathPiece((a, 0.0))
    for sa, sb in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        centre = (sa * (a - r), sb * (b - r))
        begin, end = ((sa * a, centre[1]), (centre[0], sb * b))
        if sa != sb:
            begin, end = end, begin
        yield PathPiece(begin)
        if r > 0:
            yield PathPiece(end, centre)
    yield PathPiece((a, 0.0))


def circle(radius: float, step: float, clockwise: bool = False) -> list[PathPiece]:
    """Return the path that clears a circle about the origin: full circles from the middle outwards."""
    out: list[PathPiece] = []
    for r in rings(radius, step):
        out += [PathPiece((r, 0.0)), PathPiece((r, 0.0), (0.0, 0.0), clockwise)] if r else []
    return out


def rows(first: Vec, size: Vec, count: int) -> list[Vec]:
    """Return the ends of rows to and fro: along the first axis over size[0], `count` rows over size[1]."""
    out: list[Vec] = []
    for k in range(max(count, 1)):
        across = first[1] + size[1] * k / max(count - 1, 1)
        ends = [(first[0], across), (first[0] + size[0], across)]
        out += ends if k % 2 == 0 else ends[::-1]
    return out


def turn_piece(piece: PathPiece, angle: float) -> PathPiece:
    """Return the piece turned about the origin, rad."""
    if not angle:
        return piece
    c, s = math.cos(angle), math.sin(angle)
    end, centre = piece.end, piece.centre
    return piece._replace(
        end=(end[0] * c - end[1] * s, end[0] * s + end[1] * c),
        centre=centre and (centre[0] * c - centre[1] * s, centre[0] * s + centre[1] * c),
    )


def shift_pieces(pieces: Sequence[PathPiece], by: Vec) -> list[PathPiece]:
    """Return the pieces shifted in the plane."""
    return [
        p._replace(
            end=(p.end[0] + by[0], p.end[1] + by[1]),
            centre=p.centre and (p.centre[0] + by[0], p.centre[1] + by[1]),
        )
        for p in pieces
    ]
