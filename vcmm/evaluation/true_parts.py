"""Parts of a given true value as displacements of the touches, and what a machine indicates of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.core.run import Array
from vcmm.evaluation import streams
from vcmm.evaluation.linear import LinearModel
from vcmm.gps import characteristics as gps
from vcmm.gps.criteria import chosen
from vcmm.measuring.task import Task, fit_features, measured_points
from vcmm.part.part import Characteristic, centre
from vcmm.part.random_form import GENTLE, PAIR, ROUGH, SINGLE, SMOOTH, random_forms

ORIENTATION = ("parallelism", "perpendicularity", "angularity")
LOCATION = ("position", "coaxiality", "symmetry")
TURNED, FIXED = "any direction", "one direction"
WEAK = 0.2  # a direction that shows less than this share of the strongest is no way in which a part of this kind is off


@dataclass(frozen=True, eq=False)
class TrueParts:
    """The parts that one characteristic is asked about. model: of this characteristic alone."""

    model: LinearModel
    characteristic: Characteristic

    @property
    def families(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The families of which the inverse is made, and those that it does not know."""
        if self.characteristic.type in gps.FORM:
            return (SMOOTH, SINGLE), (ROUGH, GENTLE, PAIR)
        return (TURNED,), (FIXED,)

    def shapes(self, family: str, count: int, seed: int) -> Array:
        """(count, K): change of q per mm of true value, one row per part."""
        rng = np.random.default_rng(streams.key(seed, f"true parts: {self.characteristic.name}: {family}"))
        if self.characteristic.type in gps.FORM:
            rows = self.model.task.touches.rows[self.characteristic.of[0]]
            feature = self.model.task.part.features[self.characteristic.of[0]]
            points = self.model.task.touches.points[rows]
            return np.asarray(
                random_forms(feature, points, count, family, rng) @ self.model.operator[:, rows].T
            )
        return self._moved(family, count, rng)

    def _moved(self, family: str, count: int, rng: np.random.Generator) -> Array:
        """The feature as a whole off its direction or place, mm of zone."""
        moves = self._rigid(family, 4 * count, rng)
        step = 1e-3
        shown = (
            self.model.values(self.nominal + step * moves)[:, 0] - self.model.values(self.nominal)[0]
        ) / step
        strong = np.flatnonzero(shown > WEAK * shown.max())
        chosen_rows = np.resize(strong, count)
        return np.asarray(moves[chosen_rows] / shown[chosen_rows, None])

    def _rigid(self, family: str, count: int, rng: np.random.Generator) -> Array:
        """(count, K): turns about the middle of the feature, for a location shifts too, a few directions or all."""
        task, name = self.model.task, (*self.characteristic.of, *self.characteristic.between)[0]
        rows, feature = task.touches.rows[name], task.part.features[name]
        n, arm = task.touches.normals[rows], task.touches.points[rows] - centre(feature)
        reach = max(float(np.abs(arm).max()), 1e-9)
        if family == FIXED:
            axes = np.eye(3)[np.arange(count) % 3]
            turn = shift = axes * rng.choice([-1.0, 1.0], (count, 1))
        else:
            turn, shift = rng.standard_normal((count, 3)), rng.standard_normal((count, 3))
        share = np.ones((count, 1))
        if self.characteristic.type in LOCATION:
            share = rng.uniform(0, 1, (count, 1)) if family == TURNED else np.zeros((count, 1))
        height = (share * turn / reach) @ np.cross(arm, n).T
        if self.characteristic.type in LOCATION:
            height = height + ((1 - share) * shift) @ n.T
        return np.asarray(height @ self.model.operator[:, rows].T)

    @cached_property
    def nominal(self) -> Array:
        """(K,): q of the nominal part on a machine without errors."""
        task = self.model.task
        return self._perfect(replace(task, form=np.zeros(task.touches.run.n)))

    @cached_property
    def indicated(self) -> Array:
        """(K,): q of the nominal part as the machine indicates it, with all errors at their estimates."""
        return self.nominal + (self.model.q0 - self._perfect(self.model.task))

    def _perfect(self, task: Task) -> Array:
        points = measured_points(task, np.zeros((task.touches.run.n, 3)))
        return self.model.at_points(points, fit_features(task, points))


def invertible(model: LinearModel, c: Characteristic) -> bool:
    """Whether there is a family of true parts for a characteristic, and what it needs was measured."""
    if c.type in gps.FORM:
        kind = model.task.part.features[c.of[0]].kind
        return chosen(c).gauss and kind in ("line", "plane", "circle", "cylinder", "sphere")
    return c.type in (*ORIENTATION, *LOCATION)
