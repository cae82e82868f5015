"""The bodies of the tool in the frame of the tip: shaft, extension, head, quill.

The tip is the origin; a touch puts it somewhere. All along machine directions: rotary axes stay at zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.pose import Array, triad, unit
from vcmm.measuring.obstacles import SHAFT_SHARE, Head
from vcmm.measuring.plan import Stylus
from vcmm.placing.collision import EDGES, Bodies, joined, rods

NAMES = ("shaft", "extension", "head", "quill")


def shaft_radius(head: Head, stylus: Stylus) -> float:
    """mm; a shaft is never thicker than its tip."""
    diameter = head.shafts.get(stylus.name, 2.0 * SHAFT_SHARE * stylus.tip_radius)
    return min(0.5 * diameter, stylus.tip_radius)


def tool_bodies(head: Head, stylus: Stylus) -> Bodies:
    """The four bodies of NAMES about the tip's centre."""
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
    return joined([shaft, extension, cylinder, bar])


def _bar(centre: Array, axes: Sequence[Array], sizes: Sequence[float]) -> Bodies:
    edges = np.zeros((1, EDGES, 3))
    for k in range(3):
        edges[0, k] = 0.5 * sizes[k] * axes[k]
    return Bodies(centre[None], edges, np.zeros(1), np.zeros(1))


def at_touches(tool: Bodies, body: int, tips: Array, rotation: Array) -> Bodies:
    """One body of the tool at n tips (n, 3), turned from machine to another frame by `rotation`."""
    one = tool.take(np.array([body]))
    n = len(tips)
    return Bodies(
        tips + one.centre @ rotation.T,
        np.broadcast_to(one.edges @ rotation.T, (n, EDGES, 3)),
        np.broadcast_to(one.radius, (n,)),
        np.broadcast_to(one.round, (n,)),
    )
