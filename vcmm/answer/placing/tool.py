"""The tool at the touches of a plan: its bodies in the frame of the tip, and the touches, one row each, in the drawing frame.

The tip is the origin; a touch gives its place. All directions are those of the machine: rotary axes stay at zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.answer.placing.collision import EDGES, Bodies, join_bodies, missing_clearance, rods
from vcmm.answer.placing.solid import Solid
from vcmm.core.pose import Array, triad, unit
from vcmm.task.measuring.obstacles import SHAFT_SHARE, Head, Surroundings
from vcmm.task.measuring.plan import Ints, Plan, Stylus

NAMES = ("shaft", "extension", "head", "quill")
FINE, COARSE = 0.02, 0.5  # mm: how well the gaps of the shaft, and of head and quill, are known


def shaft_radius(head: Head, stylus: Stylus) -> float:
    """Return the radius in mm; a shaft is never thicker than its tip."""
    diameter = head.shafts.get(stylus.name, 2.0 * SHAFT_SHARE * stylus.tip_radius)
    return min(0.5 * diameter, stylus.tip_radius)


def tool_bodies(head: Head, stylus: Stylus) -> Bodies:
    """Return the four bodies of NAMES about the tip's centre."""
    up = unit(np.array(head.up, dtype=float))
    mount = -np.asarray(stylus.offset, dtype=float)
    root = -stylus.direction * min(
        stylus.length or float(np.linalg.norm(mount)), float(np.linalg.norm(mount))
    )
    radius = 0.5 * head.extension
    way = mount - root
    far = float(np.linalg.norm(way))
    # the extension is a cylinder with flat ends: its capsule must not stick out towards the tip
    begin = root + way * min(1.0, radius / far) if far > 0 else mount
    shaft = rods(np.zeros((1, 3)), root[None], np.array([shaft_radius(head, stylus)]))
    extension = rods(begin[None], mount[None], np.array([radius if far > 0 else shaft.radius[0]]))
    u, v, w = triad(up)
    cylinder = _bar(mount + 0.5 * head.length * up, (u, v, w), (head.diameter, head.diameter, head.length))
    cylinder = Bodies(cylinder.centre, cylinder.edges, cylinder.radius, np.array([0.5 * head.diameter]))
    bar = _bar(mount + (head.length + 0.5 * head.quill[2]) * up, (u, v, w), head.quill)
    return join_bodies([shaft, extension, cylinder, bar])


def _bar(centre: Array, axes: Sequence[Array], sizes: Sequence[float]) -> Bodies:
    edges = np.zeros((1, EDGES, 3))
    for k in range(3):
        edges[0, k] = 0.5 * sizes[k] * axes[k]
    return Bodies(centre[None], edges, np.zeros(1), np.zeros(1))


def at_touches(tool: Bodies, body: int, tips: Array, rotation: Array) -> Bodies:
    """Return one body of the tool at n tips (n, 3), turned from machine to another frame by `rotation`."""
    body_tool = tool.take(np.array([body]))
    n = len(tips)
    return Bodies(
        tips + body_tool.centre @ rotation.T,
        np.broadcast_to(body_tool.edges @ rotation.T, (n, EDGES, 3)),
        np.broadcast_to(body_tool.radius, (n,)),
        np.broadcast_to(body_tool.round, (n,)),
    )


@dataclass(frozen=True, eq=False)
class TouchSequence:
    """n touches in measuring order. tip (n, 3): centre of the tip at the touch; start: before the approach;
    end: after the retract. stylus (n,): number among `styli`. names: "point 3 on bore".
    """

    plan: Plan
    styli: tuple[str, ...]
    tip: Array
    normal: Array
    start: Array
    end: Array
    radius: Array
    offset: Array
    stylus: Ints
    names: tuple[str, ...]

    @property
    def n(self) -> int:
        return len(self.tip)

    def pairs(self) -> Ints:
        """Return the numbers of touches that follow one another with one stylus, (k, 2)."""
        first = np.flatnonzero(self.stylus[1:] == self.stylus[:-1])
        return np.stack([first, first + 1], axis=1)

    @cached_property
    def ends(self) -> Ints:
        """Touches at which a stylus comes into play or goes out of it."""
        change = np.flatnonzero(self.stylus[1:] != self.stylus[:-1])
        return np.unique(np.concatenate([[0], change, change + 1, [self.n - 1]]))


def touch_sequence(plan: Plan) -> TouchSequence:
    """Return the touches of a plan; approach, start and retract as `vcmm.task.measuring.plan.touches` makes them."""
    points = np.concatenate([s.points for s in plan.steps])
    normal = np.concatenate([s.normals for s in plan.steps])
    approach = np.concatenate([-s.normals if s.approach is None else s.approach for s in plan.steps])
    styli = tuple(dict.fromkeys(s.stylus for s in plan.steps))
    stylus = np.concatenate([np.full(len(s.points), styli.index(s.stylus)) for s in plan.steps])
    radius = np.array([plan.styli[styli[i]].tip_radius for i in stylus])
    offset = np.array([plan.styli[styli[i]].offset for i in stylus], dtype=float)
    tip, away = points + radius[:, None] * normal, plan.touch.approach
    count: dict[str, int] = {}
    names = []
    for step in plan.steps:
        for _ in range(len(step.points)):
            count[step.feature] = count.get(step.feature, 0) + 1
            names.append(f"point {count[step.feature]} on {step.feature}")
    return TouchSequence(
        plan=plan, styli=styli, tip=tip, normal=normal, start=tip - away * approach, end=tip + away * normal,
        radius=radius, offset=offset, stylus=stylus, names=tuple(names),
    )  # fmt: skip


class Tooling:
    """The tool of every stylus of a plan, and the gaps it must keep."""

    def __init__(self, rows: TouchSequence, around: Surroundings) -> None:
        self.rows, self.around = rows, around
        styli = [rows.plan.styli[name] for name in rows.styli]
        self.tools = [_round_quill(tool_bodies(around.head, s)) for s in styli]
        shaft = np.array([shaft_radius(around.head, s) for s in styli])[rows.stylus]
        self.shaft_need = np.minimum(around.shaft, 0.5 * (rows.radius - shaft))

    def key(self, rotation: Array) -> tuple[float, ...]:
        """Return a key: poses with one key (machine_from_part rotations) see the part from the same side, since all bodies are round."""
        return self.keys(rotation[None])[0]

    def keys(self, rotations: Array) -> list[tuple[float, ...]]:
        """Return `key` of each of (m, 3, 3); m may be 0."""
        looks = np.round(self.looks @ rotations, 9) + 0.0
        return list(map(tuple, looks.reshape(len(looks), self.looks.size).tolist()))

    @cached_property
    def looks(self) -> Array:
        """Directions (1 + s, 3), machine: the way up and one place of each tool, which determine the sides of the part that it sees."""
        up = np.array(self.around.head.up, dtype=float)
        return np.vstack([up / np.linalg.norm(up), *(t.centre[0] for t in self.tools)])

    def need(self, body: int) -> Array:
        return self.shaft_need if body == 0 else np.full(self.rows.n, self.around.safe)

    def place_body(self, body: int, which: Ints, tips: Array, rotation: Array) -> Bodies:
        """Return one body at the touches `which` (k,), whose tips are at (k, 3); rotation: frame_from_machine."""
        stylus = self.rows.stylus[which]
        groups = [np.flatnonzero(stylus == s) for s in range(len(self.tools))]
        parts = [at_touches(self.tools[s], body, tips[g], rotation) for s, g in enumerate(groups) if len(g)]
        order = np.argsort(np.concatenate([g for g in groups if len(g)]), kind="stable")
        return join_bodies(parts).take(order)

    def body(
        self, body: int, which: Ints, begin: Array, end: Array, rotation: Array
    ) -> tuple[Bodies, Array, Array]:
        """Return one body while the tip goes straight from begin (k, 3) to end (k, 3); the clearance that it must keep; and the accuracy
        of the body."""
        bodies = self.place_body(body, which, begin, rotation).swept_volume(np.zeros_like(begin), end - begin)
        return bodies, self.need(body)[which], np.full(len(which), FINE if body == 0 else COARSE)

    def ball(self, which: Ints, begin: Array, end: Array, need: Array) -> tuple[Bodies, Array, Array]:
        """Return the tip itself."""
        return rods(begin, end, self.rows.radius[which]), need, np.full(len(which), FINE)

    def moving(self, solid: Solid, which: Ints, begin: Array, end: Array, rotation: Array) -> Array:
        """Return the missing clearance (k,) mm of the whole tool on a straight positioning move; the tip keeps `safe`, or its present clearance."""
        if not len(which):
            return np.zeros(0)
        keep = np.full(len(which), min(self.around.safe, 0.5 * self.rows.plan.touch.approach))
        bodies = [self.body(b, which, begin, end, rotation) for b in range(len(NAMES))]
        return np.asarray(missing_clearance(solid, [self.ball(which, begin, end, keep), *bodies]).max(axis=0))


def _round_quill(tool: Bodies) -> Bodies:
    """Return the square quill as its round hull, so that a turn about the axis changes nothing."""
    edges, quill = tool.edges.copy(), NAMES.index("quill")
    sides = np.linalg.norm(edges[quill, :2], axis=1)
    radius = float(np.hypot(*sides))
    edges[quill, :2] *= (radius / sides)[:, None]
    round_ = tool.round.copy()
    round_[quill] = radius
    return Bodies(tool.centre, edges, tool.radius, round_)
