"""Room for the tool at every touch and on the way between touches, for one direction of the tool in the drawing frame.

At a touch the shaft keeps `shaft` mm (no more than half of what the tip is thicker), head and quill keep `safe` mm, while the
tool approaches and retracts. Between touches the tool goes straight from the retract to the next start; where that
is blocked it draws back along the shaft beyond everything, crosses there, and comes down the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.pose import Array
from vcmm.measuring.obstacles import Surroundings
from vcmm.placing.collision import Bodies, joined, rods, slack
from vcmm.placing.solid import Solid
from vcmm.placing.tool import NAMES, at_touches, shaft_radius, tool_bodies
from vcmm.placing.touches import Rows

Ints = npt.NDArray[np.intp]
GRAZE = 0.1  # mm: what the tip may seem to be inside the surface on its way to the touch (chords of a mesh)
FINE, COARSE = 0.02, 0.5  # mm: how well the gaps of the shaft, and of head and quill, are known


@dataclass(frozen=True, eq=False)
class Room:
    """What the tool lacks, mm, 0 where it is clear: one number per touch (n,) or per pair (k,).

    bodies: NAMES -> (n,); tip (n,): the ball before and during its approach. direct (k,): straight moves between the
    touches of `pairs`. What drawing back lacks is asked touch by touch (`vcmm.placing.retreat`).
    """

    bodies: dict[str, Array]
    tip: Array
    direct: Array
    pairs: Ints


class Tooling:
    """The tool of every stylus of a plan, and the gaps it must keep."""

    def __init__(self, rows: Rows, around: Surroundings) -> None:
        self.rows, self.around = rows, around
        styli = [rows.plan.styli[name] for name in rows.styli]
        self.tools = [_round_quill(tool_bodies(around.head, s)) for s in styli]
        shaft = np.array([shaft_radius(around.head, s) for s in styli])[rows.stylus]
        self.shaft_need = np.minimum(around.shaft, 0.5 * (rows.radius - shaft))

    def key(self, rotation: Array) -> tuple[float, ...]:
        """Poses with one key (machine_from_part rotations) see the part from the same side: all bodies are round."""
        up = np.array(self.around.head.up, dtype=float)
        seen = np.vstack([up / np.linalg.norm(up), *(t.centre[0] for t in self.tools)]) @ rotation
        return tuple((np.round(seen, 9) + 0.0).ravel().tolist())

    def need(self, body: int) -> Array:
        return self.shaft_need if body == 0 else np.full(self.rows.n, self.around.safe)

    def placed(self, body: int, which: Ints, tips: Array, rotation: Array) -> Bodies:
        """One body at the touches `which` (k,), whose tips are at (k, 3); rotation: frame_from_machine."""
        stylus = self.rows.stylus[which]
        groups = [np.flatnonzero(stylus == s) for s in range(len(self.tools))]
        parts = [at_touches(self.tools[s], body, tips[g], rotation) for s, g in enumerate(groups) if len(g)]
        order = np.argsort(np.concatenate([g for g in groups if len(g)]), kind="stable")
        return joined(parts).take(order)

    def body(
        self, body: int, which: Ints, begin: Array, end: Array, rotation: Array
    ) -> tuple[Bodies, Array, Array]:
        """One body while the tip goes straight from begin (k, 3) to end (k, 3); what it must keep; how well it is known."""
        bodies = self.placed(body, which, begin, rotation).swept(np.zeros_like(begin), end - begin)
        return bodies, self.need(body)[which], np.full(len(which), FINE if body == 0 else COARSE)

    def ball(self, which: Ints, begin: Array, end: Array, need: Array) -> tuple[Bodies, Array, Array]:
        """The tip itself."""
        return rods(begin, end, self.rows.radius[which]), need, np.full(len(which), FINE)

    def moving(self, solid: Solid, which: Ints, begin: Array, end: Array, rotation: Array) -> Array:
        """(k,) mm that the whole tool lacks on a straight positioning move; the tip keeps `safe`, or what it has."""
        if not len(which):
            return np.zeros(0)
        keep = np.full(len(which), min(self.around.safe, 0.5 * self.rows.plan.touch.approach))
        asked = [self.body(b, which, begin, end, rotation) for b in range(len(NAMES))]
        return np.asarray(lacking(solid, [self.ball(which, begin, end, keep), *asked]).max(axis=0))


def lacking(solid: Solid, asked: list[tuple[Bodies, Array, Array]]) -> Array:
    """(len(asked), k) mm that bodies lack, all looked at in one go; inf where a gap cannot be told, never 0."""
    bodies, need, known = (list(column) for column in zip(*asked))
    room = slack(solid, joined(bodies), np.concatenate(need), np.concatenate(known))
    return np.maximum(0.0, -room).reshape(len(asked), -1)


def room(tooling: Tooling, solid: Solid, rows: Rows, rotation: Array) -> Room:
    """The room of all touches and straight moves against a solid.

    rows: tips in the frame of the solid; rotation: frame_from_machine.
    """
    every = np.arange(rows.n)
    slope = np.abs(np.einsum("ni,ni->n", rows.start - rows.tip, rows.normal))
    ways = [(rows.tip, rows.start)] + (
        [(rows.tip, rows.left)] if not np.allclose(rows.start, rows.left) else []
    )
    asked = [tooling.body(b, every, *way, rotation) for way in ways for b in range(len(NAMES))]
    asked.append(tooling.ball(every, rows.tip, rows.start, np.full(rows.n, -GRAZE)))
    asked.append(tooling.ball(every, rows.start, rows.start, np.minimum(tooling.around.safe, 0.5 * slope)))
    found = lacking(solid, asked)
    bodies = {name: found[b : -2 : len(NAMES)].max(axis=0) for b, name in enumerate(NAMES)}
    tip = found[-2:].max(axis=0)
    pairs = rows.pairs()
    direct = np.zeros(0)
    if len(pairs):
        direct = tooling.moving(solid, pairs[:, 0], rows.left[pairs[:, 0]], rows.start[pairs[:, 1]], rotation)
    return Room(bodies, tip, direct, pairs)


def drawn_back(rows: Rows, blocked: Ints) -> Ints:
    """Touches from which the tool must be able to draw back: both ends of blocked moves, and where a stylus changes."""
    return np.unique(np.concatenate([rows.ends(), blocked.ravel()])).astype(np.intp)


def back_lacking(
    tooling: Tooling, solid: Solid, reach: Array, rows: Rows, which: Ints, rotation: Array
) -> Array:
    """(k,) mm that the tool lacks while it draws back from the start and from the retract of touches."""
    begin = np.concatenate([rows.start[which], rows.left[which]])
    both = np.concatenate([which, which])
    end = beyond(tooling, reach, rows, both, begin, rotation)
    return tooling.moving(solid, both, begin, end, rotation).reshape(2, -1).max(axis=0)


def beyond(tooling: Tooling, reach: Array, rows: Rows, which: Ints, begin: Array, rotation: Array) -> Array:
    """(k, 3): where the tip is when the whole tool, drawn back along its shaft, is `clearance` beyond the points (p, 3)."""
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


def _round_quill(tool: Bodies) -> Bodies:
    """The square quill in its round, so that a turn about the axis changes nothing."""
    edges, quill = tool.edges.copy(), NAMES.index("quill")
    sides = np.linalg.norm(edges[quill, :2], axis=1)
    radius = float(np.hypot(*sides))
    edges[quill, :2] *= (radius / sides)[:, None]
    round_ = tool.round.copy()
    round_[quill] = radius
    return Bodies(tool.centre, edges, tool.radius, round_)
