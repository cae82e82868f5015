"""The shift of the tool along a program that leaves the surface where it is to be, linear between knots, by least squares.

    at each point     over_k - gain_k . e  = 0   of the cut that makes it
                      over_k - gain_k . e >= 0   of every other cut that comes as near: it must not go deeper, and need not go as deep

Moves that follow one another share the knot between them. The inequalities are kept by squares of what violates them, so the problem is
convex; the set of those that count is found by turns (active set: Nocedal & Wright, Numerical Optimization, 2nd ed. (2006), ch. 16.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.compensation.contours import length_of, sweep_of
from vcmm.core.run import Array
from vcmm.program.moves import Move
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.machining.process import Words

Bools = np.typing.NDArray[np.bool_]
KNOT, MOST_KNOTS = 12.0, 24  # mm between knots of a line; of one move
TURN = np.pi / 8  # between knots of an arc
SMOOTH, SMALL = (
    0.03,
    1e-3,
)  # weights of what changes along a move and of its size against a point that is measured: chosen
STIFF = (
    3.0  # the same of moves that make no point of the surface: they go along as a whole, and stay one block
)
UNSEEN = 1e-6  # mm: below it there is nothing to correct
TURNS = 30  # of the search for the cuts that count


@dataclass(frozen=True, eq=False)
class Cuts:
    """k cuts of points on features: point, move and share of it, gain (k, 3), over (k,) mm above where the surface is to be, and whether
    each makes its point; feature (points,)."""

    point: Ints
    move: Ints
    share: Array
    gain: Array
    over: Array
    makes: Bools
    feature: Words


def shifts_of(moves: Sequence[Move], cuts: Cuts) -> tuple[Ints, Array, Array]:
    """(first knot of each move (n + 1,), e at the knots (k, 3) mm, what is left of every point (points,) mm)."""
    first, same = _knots(moves)
    counts, released = cuts.makes.copy(), np.zeros(len(cuts.over), dtype=bool)
    for _ in range(TURNS):
        stiff = _stiffness(moves, cuts.move[counts])
        value, shown = _solve(first, same, stiff, cuts, counts)
        over = cuts.over - shown
        deeper = ~counts & (over < -UNSEEN)
        free = counts & ~cuts.makes & ~released & (over > UNSEEN)  # it would be drawn down, which it need not
        if not deeper.any() and not free.any():
            break
        counts = (counts & ~free) | deeper
        released |= free  # once: what goes too deep again counts to the end
    left = np.full(len(cuts.feature), np.inf)
    np.minimum.at(left, cuts.point, cuts.over - shown)
    return first, value, left[np.isfinite(left)]


def _knots(moves: Sequence[Move]) -> tuple[Ints, Ints]:
    """(first knot of each move (n + 1,), number of the unknown of each knot): a move begins with the shift with which the one before ends."""
    count = [
        2 + min(int(abs(sweep_of(m)) / TURN if m.kind == "arc" else length_of(m) / KNOT), MOST_KNOTS)
        if m.kind not in ("rapid", "dwell") else 2
        for m in moves
    ]  # fmt: skip
    first = np.concatenate([[0], np.cumsum(count)]).astype(np.intp)
    same = np.zeros(first[-1], dtype=np.intp)
    last = free = 0
    for m, k, low in zip(moves, count, first.tolist()):
        same[low : low + k] = [last, *range(free + 1, free + k)]
        free += k - 1
        if m.kind == "arc" and m.start == m.end:  # a full circle comes back to the shift with which it began
            same[low + k - 1] = last
        last = int(same[low + k - 1])
    return first, same


def _stiffness(moves: Sequence[Move], touched: Ints) -> Array:
    """Weight of a change along each move (n,): what cuts a point may bend, a rapid across may lead anywhere, the rest stays straight."""
    out = np.full(len(moves), STIFF)
    out[np.unique(touched)] = SMOOTH
    across = [m.kind == "rapid" and m.start[:2] != m.end[:2] for m in moves]
    out[np.array(across, dtype=bool)] = SMOOTH * SMALL
    return out


def _solve(first: Ints, same: Ints, stiff: Array, cuts: Cuts, counts: Bools) -> tuple[Array, Array]:
    """e at the knots (k, 3) by the cuts that count, and what it does at every cut (k,)."""
    from scipy.sparse import coo_matrix, csr_matrix, vstack
    from scipy.sparse.linalg import spsolve

    unknown, n, move = int(same.max()) + 1, len(cuts.over), cuts.move
    place = cuts.share * (first[move + 1] - first[move] - 1)
    low = np.minimum(place.astype(np.intp), first[move + 1] - first[move] - 2)
    weight = np.stack([1.0 - (place - low), place - low], axis=1)
    at = np.stack([same[first[move] + low], same[first[move] + low + 1]], axis=1)
    column = (3 * at[:, :, None] + np.arange(3)).reshape(n, 6)
    values = (weight[:, :, None] * cuts.gain[:, None, :]).reshape(n, 6)
    shows = csr_matrix((values.ravel(), (np.repeat(np.arange(n), 6), column.ravel())), (n, 3 * unknown))
    steps = np.delete(
        np.arange(len(same) - 1), first[1:-1] - 1
    )  # within a move; its end is the start of the next
    a, b = (3 * same[steps + k][:, None] + np.arange(3) for k in (0, 1))
    pull = np.repeat(np.repeat(stiff, np.diff(first))[steps], 3)
    rows = np.tile(np.arange(a.size), 2)
    change = coo_matrix(
        (np.concatenate([-pull, pull]), (rows, np.concatenate([a.ravel(), b.ravel()]))), (a.size, 3 * unknown)
    )
    small = coo_matrix((np.full(3 * unknown, SMALL), (np.arange(3 * unknown),) * 2))
    whole = vstack([shows[counts], change, small], format="csc")
    right = np.concatenate([cuts.over[counts], np.zeros(whole.shape[0] - int(counts.sum()))])
    found = spsolve((whole.T @ whole).tocsc(), whole.T @ right)
    return found.reshape(-1, 3)[same], np.asarray(shows @ found)
