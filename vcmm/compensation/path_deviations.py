"""A program point by point with the error of the machine there, for pictures of the path before and after compensation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.compensation.contours import points
from vcmm.core.run import Array
from vcmm.program.moves import Move
from vcmm.shop.cutting.contactmap import Ints


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """n pieces between points (n + 1, 3) mm; of each its move (n,) and its error (n,) mm, nan of rapids.

    line (n,): of the file that was given, also of a rewritten program.
    """

    moves: tuple[Move, ...]
    points: Array
    move: Ints
    error: Array
    line: Ints


def follow_path(
    moves: Sequence[Move], knot: Ints, tip: Array, error: Array, lines: Sequence[int] = ()
) -> FollowedPath:
    """Return moves in pieces between the knots of a walk (k,), which belong to moves `knot` and lie at tip (k, 3) mm, one piece where there are
    none; each with the larger error (k,) mm of its ends.

    lines: source line of each line of the program, where it was rewritten.
    """
    first = np.searchsorted(knot, np.arange(len(moves) + 1))
    at, which, value = [np.array([moves[0].start])], [], []
    for i, (a, b) in enumerate(zip(first[:-1].tolist(), first[1:].tolist())):
        tips = tip[a + 1 : b] if b - a > 1 else points(moves[i], np.ones(1))
        at.append(tips)
        which.append(np.full(len(tips), i))
        value.append(np.maximum(error[a : b - 1], error[a + 1 : b]) if b - a > 1 else np.full(1, np.nan))
    move = np.concatenate(which).astype(np.intp)
    line = np.array([m.source.line for m in moves], dtype=np.intp)
    line = np.array(lines, dtype=np.intp)[line - 1] if lines else line
    return FollowedPath(tuple(moves), np.concatenate(at), move, np.concatenate(value), line[move])
