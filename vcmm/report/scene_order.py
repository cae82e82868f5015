"""Which piece hides which, for every view at once: a tree of planes between the items, sorted pieces in its leaves.

The painter's algorithm sorts by the depth of a piece's centre. That is right for small pieces and wrong for a large
table under a small part. So space is first divided by planes along the faces of the items' boxes (Fuchs, Kedem and
Naylor, binary space partition, 1980, with axis-parallel planes): what lies beyond a plane is drawn first. Only in
the leaves is the centre's depth used; a leaf with several interpenetrating solids gets its pieces cut small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.report.scene_pieces import Piece, cut, shortened


@dataclass(frozen=True)
class Leaf:
    """Pieces drawn by depth; `mixed`: several solids interpenetrate here."""

    pieces: tuple[Piece, ...]
    mixed: bool


@dataclass(frozen=True)
class Node:
    """A plane across `axis`: what lies on its low and on its high side."""

    axis: int
    low: Node | Leaf
    high: Node | Leaf


@dataclass(frozen=True)
class _Extent:
    """Boxes of the solids in a cell: unit numbers (m,), corners (m, 3); how many items they belong to."""

    units: tuple[int, ...]
    items: int
    lo: npt.NDArray[np.float64]
    hi: npt.NDArray[np.float64]


def order(pieces: Sequence[Piece], size: float) -> Node | Leaf:
    """The tree for pieces of a scene of extent `size` (mm)."""
    return _divide(list(pieces), size, 0)


def _divide(pieces: list[Piece], size: float, depth: int) -> Node | Leaf:
    extent = _solids(pieces)
    plane = _best_plane(extent, 1e-6 * size) if extent.items > 1 and depth < 200 else None
    if plane is None:
        return _leaf(pieces, size, extent.items)
    axis, at = plane
    low, high = _sides(pieces, extent, axis, at, 1e-6 * size)
    return Node(axis, _divide(low, size, depth + 1), _divide(high, size, depth + 1))


def _solids(pieces: list[Piece]) -> _Extent:
    boxes: dict[int, list[npt.NDArray[np.float64]]] = {}
    for piece in pieces:
        if piece.is_face:
            boxes.setdefault(piece.unit, []).append(piece.points)
    joined = [np.concatenate(points) for points in boxes.values()]
    lo = np.array([p.min(axis=0) for p in joined]).reshape(-1, 3)
    items = len({piece.item for piece in pieces if piece.is_face})
    return _Extent(tuple(boxes), items, lo, np.array([p.max(axis=0) for p in joined]).reshape(-1, 3))


def _best_plane(extent: _Extent, eps: float) -> tuple[int, float] | None:
    """The plane that cuts the fewest solids and, among these, divides them most evenly; None if none divides them."""
    count = len(extent.units)
    best, found = (-count - 1, 0), None
    for axis in range(3):
        lo, hi = extent.lo[:, axis], extent.hi[:, axis]
        for at in np.unique(np.concatenate([lo, hi])):
            on_top = _rests_on_top(lo, hi, at, eps)
            sides = [_side(a, b, at, eps, on_top) for a, b in zip(lo, hi)]
            below, above = sides.count("low"), sides.count("high")
            score = (below + above - count, min(below, above))
            if max(below, above) < count and score > best:
                best, found = score, (axis, float(at))
    return found


def _rests_on_top(
    lo: npt.NDArray[np.float64], hi: npt.NDArray[np.float64], at: float, eps: float
) -> bool:
    """A solid ends at this plane: what lies in the plane belongs above it."""
    return bool(((hi - lo > eps) & (np.abs(hi - at) <= eps)).any())


def _sides(
    pieces: list[Piece], extent: _Extent, axis: int, at: float, eps: float
) -> tuple[list[Piece], list[Piece]]:
    """Units beside the plane go whole; others, and edges, piece by piece, cut where needed."""
    lo, hi = extent.lo[:, axis], extent.hi[:, axis]
    on_top = _rests_on_top(lo, hi, at, eps)
    whole = {unit: _side(a, b, at, eps, on_top) for unit, a, b in zip(extent.units, lo, hi)}
    low: list[Piece] = []
    high: list[Piece] = []
    for piece in pieces:
        ends = piece.points[:, axis]
        side = whole.get(piece.unit) or _side(float(ends.min()), float(ends.max()), at, eps, on_top)
        first, second = cut(piece, axis, at) if side is None else (piece, piece)
        if side != "high" and first is not None:
            low.append(first)
        if side != "low" and second is not None:
            high.append(second)
    return low, high


def _side(lo: float, hi: float, at: float, eps: float, on_top: bool) -> str | None:
    below, above = hi <= at + eps, lo >= at - eps
    if below and above:
        return "high" if on_top else "low"
    return "low" if below else "high" if above else None


def _leaf(pieces: list[Piece], size: float, solids: int) -> Leaf:
    mixed = solids > 1
    if solids == 0:
        return Leaf(tuple(pieces), False)
    out: list[Piece] = []
    for piece in pieces:
        free = not piece.is_face and not piece.faces
        out += shortened(piece, size / 12) if mixed or free else [piece]
    return Leaf(tuple(out), mixed)
