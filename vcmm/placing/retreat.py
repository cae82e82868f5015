"""Moves that are not free straight on: the tool draws back along its shaft, crosses there, and comes down the same way.

The way back ends beyond the part and its clamps, so that only what stands on the table can block the crossing. Where
something there is in that way, the tool draws back beyond the clamps on the table as well; one of the two must be free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.pose import Array, Pose
from vcmm.placing.access import Ints, Room, Tooling, beyond
from vcmm.placing.solid import Solid
from vcmm.placing.touches import Rows

ROUNDING = 1e-6  # mm, as check_travel allows


@dataclass(frozen=True, eq=False)
class TableRoom:
    """What stands on the table, workpiece axes: solid, corners of the clamps (p, 3), the room that touches and straight
    moves have beside it, and what the part overlaps with each clamp (c,) mm.
    """

    solid: Solid
    corners: Array
    room: Room
    overlap: Array


@dataclass(frozen=True, eq=False)
class Way:
    """Drawing back at one pose. asked (k,): touches it starts from; pairs (j, 2): the blocked moves, ends among `asked`.

    zero (n, 3): the tip with all axes at zero. limits (2, 3): travels along x, y, z.
    """

    tooling: Tooling
    rows: Rows
    pose: Pose
    asked: Ints
    pairs: Ints
    zero: Array
    limits: Array


def moves_lacking(way: Way, reach: Array, of_part: Array, table: TableRoom | None) -> tuple[Array, Array]:
    """What drawing back lacks, mm: (j,) per blocked move, (n,) where a stylus comes into play or goes out of it.

    reach (p, 3): points whose hull holds part and clamps on it, drawing frame. of_part (n,): what drawing back lacks of
    the part; beyond `reach` there is none of it, so it holds for every way that ends farther out.
    """
    over, ends = _at_level(way, reach, of_part, table)
    if table is not None and len(table.corners) and max(over.max(initial=0.0), ends.max()) > 0.0:
        farther = np.concatenate([reach, way.pose.inverse().apply(table.corners)])
        other = _at_level(way, farther, of_part, table)
        over, ends = np.minimum(over, other[0]), np.minimum(ends, other[1])
    return over, ends


def _at_level(way: Way, reach: Array, of_part: Array, table: TableRoom | None) -> tuple[Array, Array]:
    """The same for drawing back beyond `reach` only. At a change of stylus the operator chooses the way: no travels there."""
    rows, both = way.rows, np.concatenate([way.asked, way.asked])
    begin = np.concatenate([rows.start[way.asked], rows.left[way.asked]])
    end = beyond(way.tooling, reach, rows, both, begin, way.pose.rotation.T)
    begin, end = way.pose.apply(begin), way.pose.apply(end)
    back, crossing = of_part.copy(), np.zeros(len(way.pairs))
    if table is not None:
        lacks = way.tooling.moving(table.solid, both, begin, end, np.eye(3))
        back[way.asked] = np.maximum(back[way.asked], _worse(lacks))
        crossing = _crossing(way, end, table.solid)
    travel = np.zeros(rows.n)
    travel[way.asked] = _worse(_beyond_travels(way, both, end))
    a, b = way.pairs.T
    over = np.max([back[a], back[b], travel[a], travel[b], crossing], axis=0)
    ends = np.zeros(rows.n)
    ends[rows.ends()] = back[rows.ends()]
    return over, ends


def _worse(lacks: Array) -> Array:
    """Of drawing back from the start and from the retract of each touch."""
    return np.asarray(lacks.reshape(2, -1).max(axis=0))


def _crossing(way: Way, end: Array, solid: Solid) -> Array:
    """(j,) mm that the whole tool lacks from above the retract of the first touch to above the start of the second."""
    first, second = np.searchsorted(way.asked, way.pairs.T)
    k = len(way.asked)
    return way.tooling.moving(solid, way.pairs[:, 0], end[k + first], end[second], np.eye(3))


def _beyond_travels(way: Way, which: Ints, end: Array) -> Array:
    """(2k,) mm by which the drawn-back places leave the travels; between two that do not the crossing keeps them too."""
    low, high = way.limits
    wanted = end - way.zero[which]
    over = np.maximum(low - wanted, wanted - high).max(axis=1)
    return np.where(over > ROUNDING, over, 0.0)
