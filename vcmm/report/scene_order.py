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

from vcmm.report.scene_pieces import ScenePiece, cut, shortened

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Leaf:
    """Pieces drawn by depth; `mixed`: several solids interpenetrate here."""

    pieces: tuple[ScenePiece, ...]
    mixed: bool


@dataclass(frozen=True)
class Node:
    """A plane across `axis`: what lies on its low and on its high side."""

    axis: int
    low: Node | Leaf
    high: Node | Leaf


@dataclass(frozen=True)
class _Solids:
    """Boxes of the units in a cell: numbers (m,), corners (m, 3), outward normals of box sides (m, 3), else zero."""

    units: tuple[int, ...]
    items: int
    lo: Array
    hi: Array
    facing: Array


@dataclass(frozen=True)
class _Plane:
    """Coordinate `axis` = `at`. What lies in the plane goes above it if it rests on a solid; with `own`, the sides
    of boxes stay with their box instead."""

    axis: int
    at: float
    own: bool


def order(pieces: Sequence[ScenePiece], size: float) -> Node | Leaf:
    """The tree for pieces of a scene of extent `size` (mm)."""
    return _divide(list(pieces), size, 0)


def _divide(pieces: list[ScenePiece], size: float, depth: int) -> Node | Leaf:
    solids, eps = _solids(pieces), 1e-6 * size
    plane = _best_plane(solids, eps) if solids.items > 1 and depth < 200 else None
    if plane is None:
        return _leaf(pieces, size, solids.items)
    whole = dict(zip(solids.units, _sides(solids, plane, eps)))
    low, high = _parted(pieces, whole, plane, eps, _rests(solids, plane, eps))
    return Node(plane.axis, _divide(low, size, depth + 1), _divide(high, size, depth + 1))


def _solids(pieces: list[ScenePiece]) -> _Solids:
    groups: dict[int, list[ScenePiece]] = {}
    for piece in pieces:
        if piece.is_face:
            groups.setdefault(piece.unit, []).append(piece)
    points = [np.concatenate([p.points for p in group]) for group in groups.values()]
    lo = np.array([p.min(axis=0) for p in points]).reshape(-1, 3)
    hi = np.array([p.max(axis=0) for p in points]).reshape(-1, 3)
    facing = np.array([group[0].facing for group in groups.values()]).reshape(-1, 3)
    return _Solids(tuple(groups), len({p.item for p in pieces if p.is_face}), lo, hi, facing)


def _best_plane(solids: _Solids, eps: float) -> _Plane | None:
    """The plane that cuts the fewest solids and, among these, divides them most evenly; None if none divides them."""
    count = len(solids.units)
    best, found = (-count - 1, 0), None
    for axis in range(3):
        for at in np.unique(np.concatenate([solids.lo[:, axis], solids.hi[:, axis]])):
            for own in (True, False):
                plane = _Plane(axis, float(at), own)
                sides = _sides(solids, plane, eps)
                below, above = sides.count("low"), sides.count("high")
                score = (below + above - count, min(below, above))
                if max(below, above) < count and score > best:
                    best, found = score, plane
    return found


def _rests(solids: _Solids, plane: _Plane, eps: float) -> bool:
    """A solid ends at this plane: what lies in the plane lies on it."""
    lo, hi = solids.lo[:, plane.axis], solids.hi[:, plane.axis]
    return bool(((hi - lo > eps) & (np.abs(hi - plane.at) <= eps)).any())


def _sides(solids: _Solids, plane: _Plane, eps: float) -> list[str]:
    """ "low", "high" or "" (to be cut) for each unit."""
    lo, hi = solids.lo[:, plane.axis], solids.hi[:, plane.axis]
    below, above = hi <= plane.at + eps, lo >= plane.at - eps
    on_top = np.full(len(lo), _rests(solids, plane, eps))
    if plane.own:
        facing = solids.facing[:, plane.axis]
        on_top = np.where(facing == 0, on_top, facing < 0)
    return np.where(below & ~(above & on_top), "low", np.where(above, "high", "")).tolist()


def _parted(
    pieces: list[ScenePiece], whole: dict[int, str], plane: _Plane, eps: float, on_top: bool
) -> tuple[list[ScenePiece], list[ScenePiece]]:
    """Units beside the plane go whole; the rest is divided piece by piece.

    An edge follows its faces. One that lies in the plane goes to both sides: it is drawn where a face of it shows.
    """
    low: list[ScenePiece] = []
    high: list[ScenePiece] = []
    for piece in pieces:
        units = (piece.unit,) if piece.unit >= 0 else piece.faces
        near = {whole[u] for u in units if u in whole}
        if units and not near:
            continue  # an edge that came without its faces
        side = near.pop() if len(near) == 1 else ""
        side = side or _side_of(piece.points[:, plane.axis], plane.at, eps)
        if side == "in" and (piece.is_face or not units):
            side = "high" if on_top else "low"
        first, second = (piece, piece) if side else cut(piece, plane.axis, plane.at)
        if side != "high" and first is not None:
            low.append(first)
        if side != "low" and second is not None:
            high.append(second)
    return low, high


def _side_of(ends: Array, at: float, eps: float) -> str:
    """ "low", "high", "in" the plane, or "" for a piece to be cut."""
    below, above = ends.max() <= at + eps, ends.min() >= at - eps
    return ("in" if above else "low") if below else "high" if above else ""


def _leaf(pieces: list[ScenePiece], size: float, items: int) -> Leaf:
    mixed = items > 1
    if items == 0:
        return Leaf(tuple(pieces), False)
    out: list[ScenePiece] = []
    for piece in pieces:
        free = not piece.is_face and not piece.faces
        out += shortened(piece, size / 12) if mixed or free else [piece]
    return Leaf(tuple(out), mixed)
