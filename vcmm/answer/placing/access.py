"""Room for the tool at every touch and on the way between touches, for one direction of the tool in the drawing frame.

At a touch the shaft keeps `shaft` mm (no more than half of what the tip is thicker), head and quill keep `safe` mm, while the
tool approaches and retracts. Between touches the tool goes straight from the retract to the next start; where that
is blocked it draws back along the shaft, crosses there, and comes down the same way. The way back ends beyond the part and
its clamps, so that only obstacles on the table can block the crossing. Where one of them is in that way, the tool
draws back beyond the clamps on the table as well; one of the two must be free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.placing.collision import missing_clearance
from vcmm.answer.placing.solid import Cuboid, Solid, Union
from vcmm.answer.placing.tool import NAMES, Tooling, TouchSequence
from vcmm.core.pose import Array, Pose
from vcmm.task.measuring.plan import Ints

GRAZE = 0.1  # mm: what the tip may seem to be inside the surface on its way to the touch (chords of a mesh)
ROUNDING = 1e-6  # mm, as check_travel allows


@dataclass(frozen=True, eq=False)
class Room:
    """Missing clearance of the tool, mm, 0 where it is clear: one number per touch (n,) or per pair (k,).

    bodies: NAMES -> (n,); tip (n,): the ball before and during its approach. direct (k,): straight moves between the
    touches of `pairs`. `moves_lacking` computes the missing clearance of drawing back, touch by touch.
    """

    bodies: dict[str, Array]
    tip: Array
    direct: Array
    pairs: Ints


def room(tooling: Tooling, solid: Solid, rows: TouchSequence, rotation: Array) -> Room:
    """Compute the room of all touches and straight moves against a solid.

    rows: tips in the frame of the solid; rotation: frame_from_machine.
    """
    every = np.arange(rows.n)
    slope = np.abs(np.einsum("ni,ni->n", rows.start - rows.tip, rows.normal))
    ways = [(rows.tip, rows.start)] + (
        [(rows.tip, rows.end)] if not np.allclose(rows.start, rows.end) else []
    )
    queries = [tooling.body(b, every, *way, rotation) for way in ways for b in range(len(NAMES))]
    graze, clamps = np.full(rows.n, -GRAZE), clamps_of(solid)
    queries.append(tooling.ball(every, rows.tip, rows.start, graze))
    queries.append(tooling.ball(every, rows.start, rows.start, np.minimum(tooling.around.safe, 0.5 * slope)))
    lacks = missing_clearance(solid, queries)
    bodies = {name: lacks[b : -2 : len(NAMES)].max(axis=0) for b, name in enumerate(NAMES)}
    tip = lacks[-2:].max(axis=0)
    if clamps.parts:  # a clamp is no mesh with chords: the tip may not be inside it at all
        at_clamps = [tooling.ball(every, rows.tip, rows.start, np.zeros(rows.n))]
        tip = np.maximum(tip, missing_clearance(clamps, at_clamps)[0])
    pairs = rows.pairs()
    direct = np.zeros(0)
    if len(pairs):
        direct = tooling.moving(solid, pairs[:, 0], rows.end[pairs[:, 0]], rows.start[pairs[:, 1]], rotation)
    return Room(bodies, tip, direct, pairs)


def clamps_of(solid: Solid) -> Union:
    """Return the clamps and other boxes beside the part."""
    parts = solid.parts if isinstance(solid, Union) else ()
    return Union(tuple(p for p in parts if isinstance(p, Cuboid)))


def drawn_back(rows: TouchSequence, blocked: Ints) -> Ints:
    """Return the touches from which the tool must be able to draw back: both ends of blocked moves, and changes of stylus."""
    return np.unique(np.concatenate([rows.ends, blocked.ravel()])).astype(np.intp)


def back_lacking(
    tooling: Tooling, solid: Solid, reach: Array, rows: TouchSequence, which: Ints, rotation: Array
) -> Array:
    """Return the missing clearance (k,) mm while the tool draws back from the start and from the retract of touches."""
    begin = np.concatenate([rows.start[which], rows.end[which]])
    both = np.concatenate([which, which])
    end = withdrawn_tip(tooling, reach, rows, both, begin, rotation)
    return tooling.moving(solid, both, begin, end, rotation).reshape(2, -1).max(axis=0)


def withdrawn_tip(
    tooling: Tooling, reach: Array, rows: TouchSequence, which: Ints, begin: Array, rotation: Array
) -> Array:
    """Return the place (k, 3) of the tip when the whole tool, drawn back along its shaft, is `clearance` beyond the points (p, 3)."""
    out = begin.copy()
    for s, name in enumerate(rows.styli):
        mine = rows.stylus[which] == s
        if not mine.any():
            continue
        stylus, tool = rows.plan.styli[name], tooling.tools[s]
        machine_way = -stylus.direction
        spread = np.abs(tool.edges @ machine_way).sum(axis=1) + tool.radius
        foremost = float(np.min(tool.centre @ machine_way - spread, initial=-stylus.tip_radius))
        way = rotation @ machine_way
        level = float(np.max(reach @ way)) + rows.plan.touch.clearance - foremost
        far = np.maximum(0.0, level - begin[mine] @ way)
        out[mine] = begin[mine] + far[:, None] * way
    return out


@dataclass(frozen=True, eq=False)
class TableRoom:
    """Obstacles on the table, workpiece axes: solid, corners of the clamps (p, 3), the room that touches and straight
    moves have beside it, and the overlap of the part with each clamp (c,) mm.
    """

    solid: Solid
    corners: Array
    room: Room
    overlap: Array


@dataclass(frozen=True, eq=False)
class Way:
    """Drawing back at m poses that see the part from one side; at one where there is an obstacle on the table. starts (k,): touches it
    starts from; pairs (j, 2): the blocked moves, ends among `starts`.

    poses: a batch (m,). zero (n, 3): the tip with all axes at zero. limits (2, 3): travels along x, y, z.
    """

    tooling: Tooling
    rows: TouchSequence
    poses: Pose
    starts: Ints
    pairs: Ints
    zero: Array
    limits: Array


def moves_lacking(way: Way, reach: Array, of_part: Array, table: TableRoom | None) -> tuple[Array, Array]:
    """Return the missing clearance of drawing back, mm: (m, j) per pose and blocked move, (n,) where a stylus comes into play or goes out of it.

    reach (p, 3): points whose hull holds part and clamps on it, drawing frame. of_part (n,): missing clearance of drawing back from
    the part; beyond `reach` there is none of it, so it holds for every way that ends farther out.
    """
    over, ends = _at_level(way, reach, of_part, table)
    if table is not None and len(table.corners) and max(over.max(initial=0.0), ends.max()) > 0.0:
        farther = np.concatenate([reach, way.poses.each()[0].inverse().apply(table.corners)])
        other = _at_level(way, farther, of_part, table)
        over, ends = np.minimum(over, other[0]), np.minimum(ends, other[1])
    return over, ends


def _at_level(way: Way, reach: Array, of_part: Array, table: TableRoom | None) -> tuple[Array, Array]:
    """Return the same for drawing back beyond `reach` only. At a change of stylus the operator chooses the way: no travels there."""
    rows, both = way.rows, np.concatenate([way.starts, way.starts])
    begin = np.concatenate([rows.start[way.starts], rows.end[way.starts]])
    end = withdrawn_tip(way.tooling, reach, rows, both, begin, way.poses.rotation[0].T)
    m = len(way.poses.shift)
    ends_at = way.poses.apply(np.broadcast_to(end, (m, *end.shape)))
    back, crossing = of_part.copy(), np.zeros(len(way.pairs))
    if table is not None:
        begins_at = way.poses.each()[0].apply(begin)
        lacks = way.tooling.moving(table.solid, both, begins_at, ends_at[0], np.eye(3))
        back[way.starts] = np.maximum(back[way.starts], _worse(lacks))
        crossing = _crossing(way, ends_at[0], table.solid)
    travel = np.zeros((m, rows.n))
    travel[:, way.starts] = _worse(_beyond_travels(way, both, ends_at))
    a, b = way.pairs.T
    least = np.max([back[a], back[b], crossing], axis=0)
    over = np.maximum(least, np.maximum(travel[:, a], travel[:, b]))
    ends = np.zeros(rows.n)
    ends[rows.ends] = back[rows.ends]
    return over, ends


def _worse(lacks: Array) -> Array:
    """Return the worse of drawing back from the start and from the retract of each touch."""
    return np.asarray(lacks.reshape(*lacks.shape[:-1], 2, -1).max(axis=-2))


def _crossing(way: Way, end: Array, solid: Solid) -> Array:
    """Return the missing clearance (j,) mm of the whole tool from above the retract of the first touch to above the start of the second."""
    first, second = np.searchsorted(way.starts, way.pairs.T)
    k = len(way.starts)
    return way.tooling.moving(solid, way.pairs[:, 0], end[k + first], end[second], np.eye(3))


def _beyond_travels(way: Way, which: Ints, end: Array) -> Array:
    """Return how far the drawn-back places (m, 2k, 3) leave the travels, (m, 2k) mm; between two that do not the crossing keeps them too."""
    low, high = way.limits
    wanted = end - way.zero[which]
    over = np.maximum(low - wanted, wanted - high).max(axis=-1)
    return np.where(over > ROUNDING, over, 0.0)
