"""Compute the true characteristics of a part, by touching its surface everywhere without errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.part.gps.criteria import POINTS, criteria_needed
from vcmm.part.gps.filters import PER_WAVE
from vcmm.part.part import Feature, normal, surface_point
from vcmm.task.measuring.plan import Touches
from vcmm.task.measuring.task import Task
from vcmm.task.response.influence import Influence, Product
from vcmm.task.response.trials import Draws

ALONG, SIDE = 5, 15  # points along a feature, along each side of a plane
# points around a surface, a circle, and where elements by contact are searched in every drawn part: next to no factors in common
# with 2 to 15 lobes, which so show at many phases; even by contact, so that two-point sizes find their opposite
AROUND, CIRCLE, BY_CONTACT = 127, 361, 74


@dataclass(frozen=True, eq=False)
class Errorless:
    """The world in which nothing has errors."""

    task: Task
    predicts: bool = True

    def errors(self) -> Array:
        return np.zeros((self.task.touches.run.n, 3))

    def influences(self) -> tuple[Influence, ...]:
        return ()

    def products(self, influences: Sequence[Influence]) -> tuple[Product, ...]:
        return ()

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        return self.errors()[None]

    def machine_of(self, quantity: Input) -> tuple[Machine, Run]:
        return self.task.machine, self.task.touches.run


def all_over(feature: Feature, measured: Array, count: int = AROUND, *, middles: bool = False) -> Array:
    """Return points (m, 3) all over a feature; the measured ones where it has no surface of its own (a point, a mesh), the nominal
    ones where it is known by them.

    count: around the feature, or along a line. middles: of equal pieces of the surface, for means over it; else up to its ends, for
    extreme values. Of 15 points up to the ends the mean square is 16 / 42 = 0.381, of middles 0.332, of the side itself 1 / 3.
    """
    around = np.arange(count) * (2 * np.pi / count)

    def places(n: int) -> Array:
        """Return places (n,) from -1 to 1."""
        return np.linspace(-1.0, 1.0, n) * ((n - 1) / n if middles else 1.0)

    if feature.kind == "plane":
        u, v = (places(SIDE) * e / 2 for e in feature.extent)
        return surface_point(feature, np.repeat(u, SIDE), np.tile(v, SIDE))
    if feature.kind == "line":
        return surface_point(feature, (places(count) + 1.0) * feature.extent[0] / 2)
    if feature.kind == "circle":
        return surface_point(feature, around)
    if feature.nominal is not None:
        return feature.nominal.points
    if feature.kind in ("cylinder", "cone"):
        heights = (places(ALONG) + 1.0) * feature.extent[0] / 2
        return surface_point(feature, np.tile(around, ALONG), np.repeat(heights, count))
    if feature.kind == "sphere":  # evenly over the whole sphere, turned by the golden angle (spiral of Vogel)
        k = np.arange(240) + 0.5
        return surface_point(feature, k * np.pi * (3.0 - np.sqrt(5.0)), np.arcsin(1.0 - 2.0 * k / 240))
    if feature.kind == "torus":
        return surface_point(
            feature, np.tile(around[::2], 8), np.repeat(np.arange(8) * (np.pi / 4), len(around[::2]))
        )
    return measured


def _around(task: Task, name: str) -> int:
    """Return the number of points around a feature: enough for its filters, and no more than needed where elements by contact are searched."""
    feature = task.part.features[name]
    filters = [c.filter for c in task.part.characteristics if c.filter is not None and name in c.of]
    waves = [f.upr or feature.extent[0] / float(f.cutoff or feature.extent[0]) for f in filters]
    touched = set(criteria_needed(task.part.characteristics, task.part.features).get(name, ())) - {POINTS}
    count = BY_CONTACT if touched else CIRCLE if feature.kind == "circle" else AROUND
    return max([count, *(math.ceil(PER_WAVE * w) for w in waves)])


def surface_model(task: Task) -> LinearModel:
    """Return the linear model of the true characteristics of the part of a task, from departures of its surface at dense points."""
    t, features = task.touches, task.part.features
    points = {n: all_over(features[n], t.points[rows], _around(task, n)) for n, rows in t.rows.items()}
    normals = {
        name: t.normals[t.rows[name]]
        if features[name].kind in ("point", "mesh")
        else normal(features[name], p)
        for name, p in points.items()
    }
    ends = np.cumsum([0, *(len(p) for p in points.values())])
    rows = {name: np.arange(a, b) for name, a, b in zip(points, ends, ends[1:])}
    at, outward = np.concatenate(list(points.values())), np.concatenate(list(normals.values()))
    run = Run({}, np.zeros((len(at), 3)), {f"n{c}": outward[:, i] for i, c in enumerate("xyz")})
    everywhere = Touches(
        run=run,
        points=at,
        normals=outward,
        approach=-outward,
        tip_radius=np.zeros(len(at)),
        rows=rows,
        pose=Pose.identity(),
    )
    dense = replace(task, touches=everywhere, inputs=(), form=np.zeros(len(at)))
    return build(dense, Errorless(dense))
