"""Compute the clearance of moving tools from a solid, by branch and bound over the volume that each tool body sweeps.

A body is a rounded zonotope: centre + sum of c_k e_k with |c_k| <= 1, and everything within `radius` of it. A shaft is one
edge with a radius, a quill three edges, and a straight move of either adds one more edge. The distance d of a solid
is Lipschitz, so over a cell with half-edges h_k its minimum is at least d(centre) - |half diagonal|. Cells that are
clear are dropped, others halved, until all are clear or a point is found that is not. A body that is called clear is
clear, up to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.answer.placing.solid import Solid
from vcmm.core.pose import Array
from vcmm.task.measuring.plan import Ints

TOLERANCE = 0.02  # mm: how well a gap near its limit is known
EDGES = 4
CELLS, BEAM = 3000, 50  # cells of one body at a time: while it may be clear, and once it is known not to be


@dataclass(frozen=True, eq=False)
class Bodies:
    """n bodies: centre (n, 3), half-edges (n, 4, 3), radius (n,), round (n,): see below; all mm.

    round > 0: the first two edges are the half-sides of a square about a cylinder of that radius; the corners of the
    square do not belong to the body.
    """

    centre: Array
    edges: Array
    radius: Array
    round: Array

    @property
    def n(self) -> int:
        return len(self.centre)

    def take(self, rows: npt.NDArray[np.bool_] | Ints) -> Bodies:
        return Bodies(self.centre[rows], self.edges[rows], self.radius[rows], self.round[rows])

    def to_frame(self, rotation: Array, shift: Array) -> Bodies:
        """Return the bodies in another frame: x -> rotation x + shift."""
        return Bodies(self.centre @ rotation.T + shift, self.edges @ rotation.T, self.radius, self.round)

    def swept_volume(self, start: Array, end: Array) -> Bodies:
        """Return the volume passed by each body on the straight way from its place + start (n, 3) to its place + end."""
        edges = self.edges.copy()
        edges[:, 3] = 0.5 * (end - start)
        return Bodies(self.centre + 0.5 * (start + end), edges, self.radius, self.round)


def join_bodies(parts: Sequence[Bodies]) -> Bodies:
    """Join bodies one after the other."""
    return Bodies(
        *(np.concatenate([getattr(p, k) for p in parts]) for k in ("centre", "edges", "radius", "round"))
    )


def rods(start: Array, end: Array, radius: Array) -> Bodies:
    """Return the capsules between two points (n, 3) each."""
    edges = np.zeros((len(start), EDGES, 3))
    edges[:, 0] = 0.5 * (end - start)
    return Bodies(
        0.5 * (start + end), edges, np.broadcast_to(radius, (len(start),)).astype(float), np.zeros(len(start))
    )


def slack(solid: Solid, bodies: Bodies, need: Array, tolerance: float | Array = TOLERANCE) -> Array:
    """Return the gap between each body and the solid less the gap that it needs (n,), mm; where it is positive the body is clear.

    Positive values are proved, and say only that there is room, not how much. A body whose room is known to be smaller
    than `tolerance` (one, or one per body), or takes more than CELLS cells to decide, counts as not clear. A negative
    value is what the worst point found lacks, known to about a quarter.
    """
    owner = np.arange(bodies.n)
    due, allowed = bodies.radius + need, np.broadcast_to(tolerance, (bodies.n,))
    middle, half = np.zeros((bodies.n, EDGES)), np.ones((bodies.n, EDGES))
    half[np.einsum("nki,nki->nk", bodies.edges, bodies.edges) == 0.0] = 0.0
    sure, best = np.full(bodies.n, np.inf), np.full(bodies.n, np.inf)
    while len(owner):
        edges = half[:, :, None] * bodies.edges[owner]
        centre = bodies.centre[owner] + np.einsum("mk,mki->mi", middle, bodies.edges[owner])
        value, reach = _sure(solid.distance(centre) - due[owner], _half_diagonal(edges))
        inside, outside = _round(bodies, owner, middle, half)
        np.minimum.at(best, owner[inside], value[inside])
        fine = np.maximum(allowed[owner], -0.25 * best[owner])
        low = value - reach
        crowded = np.bincount(owner, minlength=bodies.n)[owner] > CELLS
        done = outside | (low > 0.0) | (reach <= fine) | (low >= best[owner] - fine) | crowded
        settled = done & ~outside
        np.minimum.at(sure, owner[settled], low[settled])
        keep = np.flatnonzero(~done)
        keep = keep[_most_promising(owner[keep], low[keep], best)]
        owner, middle, half = _halve_cells(owner[keep], middle[keep], half[keep], edges[keep])
    return np.where(best < 0.0, best, sure)


def missing_clearance(solid: Solid, queries: list[tuple[Bodies, Array, Array]]) -> Array:
    """Return the missing clearance of bodies (len(queries), k) mm, all evaluated together; inf where a gap is undetermined, never 0."""
    bodies, need, allowed = (list(column) for column in zip(*queries))
    room = slack(solid, join_bodies(bodies), np.concatenate(need), np.concatenate(allowed))
    return np.maximum(0.0, -room).reshape(len(queries), -1)


def _sure(value: Array, reach: Array) -> tuple[Array, Array]:
    """Return values in which a gap that is not a number counts as -inf, so that it never passes for room."""
    unknown = np.isnan(value) | np.isnan(reach)
    return np.where(unknown, -np.inf, value), np.where(unknown, 0.0, reach)


def _most_promising(owner: Ints, low: Array, best: Array) -> npt.NDArray[np.bool_]:
    """Return all cells of bodies that may be clear; of bodies that are known not to be, the BEAM lowest ones."""
    order = np.lexsort((low, owner))
    first = (
        np.concatenate([[True], owner[order][1:] != owner[order][:-1]]) if len(owner) else np.zeros(0, bool)
    )
    place = np.arange(len(order)) - np.maximum.accumulate(np.where(first, np.arange(len(order)), 0))
    rank = np.empty(len(owner), dtype=np.intp)
    rank[order] = place
    return (best[owner] >= 0.0) | (rank < BEAM)


def _half_diagonal(edges: Array) -> Array:
    """Return the largest |sum +- e_k| of half-edges (m, 4, 3): (m,). Eight sign patterns, the first edge positive."""
    out = np.zeros(len(edges))
    for pattern in range(8):
        signs = np.array([1.0, *(1.0 if pattern >> k & 1 else -1.0 for k in range(3))])
        corner = np.einsum("k,mki->mi", signs, edges)
        out = np.maximum(out, np.einsum("mi,mi->m", corner, corner))
    return np.sqrt(out)


def _round(
    bodies: Bodies, owner: Ints, middle: Array, half: Array
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return which cells have their middle inside the body, and which lie outside of it altogether (corners of a round body)."""
    round_ = bodies.round[owner] > 0.0
    near = np.hypot(*np.maximum(np.abs(middle[:, :2]) - half[:, :2], 0.0).T)
    return ~round_ | (np.hypot(middle[:, 0], middle[:, 1]) <= 1.0), round_ & (near > 1.0)


def _halve_cells(owner: Ints, middle: Array, half: Array, edges: Array) -> tuple[Ints, Array, Array]:
    """Cut every cell in two across its longest edge."""
    longest, rows = np.argmax(np.einsum("mki,mki->mk", edges, edges), axis=1), np.arange(len(owner))
    half = half.copy()
    half[rows, longest] *= 0.5
    step = np.zeros_like(middle)
    step[rows, longest] = half[rows, longest]
    return (
        np.concatenate([owner, owner]),
        np.concatenate([middle - step, middle + step]),
        np.concatenate([half, half]),
    )
