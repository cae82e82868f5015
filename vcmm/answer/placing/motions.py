"""Small motions of a feature, and the changes of its surface and of the characteristics by them.

A feature moves by shifts and turns about its centre and by changes of its sizes, as far as its fit determines them. J (n, p)
is the displacement of the surface along the normal at n points per unit of each; the least-squares fit answers to
displacements d of its points by (J^T J)^-1 J^T d (Forbes, Appl. Sci. 12 (2022) 2808).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.pose import Array, Pose
from vcmm.part.alignment import Alignment, align
from vcmm.part.fit import FittedElement
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import Characteristic, Feature, centre, frame, signed_distance

# shifts and turns (numbers of u, v, w) that a fit determines from displacements along the normal
FREE: Mapping[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "point": ((2,), ()), "line": ((0,), (1,)), "plane": ((2,), (0, 1)), "circle": ((0, 1), ()),
    "sphere": ((0, 1, 2), ()), "cylinder": ((0, 1), (0, 1)), "cone": ((0, 1, 2), (0, 1)), "torus": ((0, 1, 2), (0, 1)),
}  # fmt: skip
SIZES: Mapping[str, tuple[int, ...]] = {
    "circle": (0,), "sphere": (0,), "cylinder": (0,), "cone": (1,), "torus": (0, 1),
}  # fmt: skip
STEP_MM, STEP_RAD = 1e-4, 1e-6


@dataclass(frozen=True, eq=False)
class Motions:
    """p motions of one feature: shifts (a, 3) and turns (b, 3) as directions, then the sizes by number.

    step (p,): 1e-4 mm or 1e-6 rad. reach: half the size of the feature, mm: what makes a turn a length.
    """

    feature: Feature
    shifts: Array
    turns: Array
    sizes: tuple[int, ...]
    step: Array
    reach: float

    @property
    def count(self) -> int:
        return len(self.step)

    def rows(self, points: Array, normals: Array) -> Array:
        """Return J (n, p)."""
        arm = points - centre(self.feature)
        columns = [normals @ e for e in self.shifts]
        columns += [np.einsum("ni,ni->n", normals, np.cross(e, arm)) for e in self.turns]
        for i, step in zip(self.sizes, self.step[len(self.shifts) + len(self.turns) :]):
            columns.append(
                (self._with_size(i, -step, points) - self._with_size(i, step, points)) / (2.0 * step)
            )
        return np.stack(columns, axis=1) if columns else np.zeros((len(points), 0))

    def _with_size(self, i: int, step: float, points: Array) -> Array:
        sizes = np.array(self.feature.sizes)
        sizes[i] += step
        return signed_distance(replace(self.feature, sizes=sizes), points)

    def move(self, amounts: Array) -> FittedElement:
        """Return the nominal element moved by amounts (b, p): a batch."""
        f, a, t = self.feature, len(self.shifts), len(self.turns)
        turn = amounts[:, a : a + t] @ self.turns
        point = f.point + amounts[:, :a] @ self.shifts + np.cross(turn, f.point - centre(f))
        axis = f.axis + np.cross(turn, f.axis)
        if np.any(f.axis):
            axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
        sizes = np.tile(np.asarray(f.sizes, dtype=float), (len(amounts), 1))
        for k, i in enumerate(self.sizes):
            sizes[:, i] += amounts[:, a + t + k]
        empty = np.zeros((len(amounts), 0))
        return FittedElement(f.kind, point, axis, sizes, empty, empty[..., None] * np.zeros(3))

    def scale(self) -> Array:
        """Return mm per unit of each motion at the rim of the feature, (p,)."""
        a, t = len(self.shifts), len(self.turns)
        angles = [i == 1 and self.feature.kind == "cone" for i in self.sizes]
        return np.array(
            [1.0] * a + [self.reach] * t + [self.reach if is_angle else 1.0 for is_angle in angles]
        )


def motions_of(feature: Feature) -> Motions:
    """Return the motions of a feature that its fit determines."""
    axes = frame(feature)
    shifts, turns = FREE.get(feature.kind, ((), ()))
    sizes = SIZES.get(feature.kind, ())
    step = [STEP_MM] * len(shifts) + [STEP_RAD] * len(turns)
    step += [STEP_RAD if feature.kind == "cone" else STEP_MM for _ in sizes]
    reach = 0.5 * max([*feature.extent, *(2.0 * float(s) for s in feature.sizes[:1])], default=1.0)
    return Motions(
        feature,
        axes[list(shifts)].reshape(-1, 3),
        axes[list(turns)].reshape(-1, 3),
        sizes,
        np.array(step),
        reach,
    )


def outputs(
    characteristics: Sequence[Characteristic],
    features: Mapping[str, Feature],
    moving: Mapping[str, Motions],
    alignment: Alignment | None,
) -> dict[str, Array]:
    """Return every characteristic but form, by name, as linear outputs B (r, P) of the motions of all features: u^2 = sum of the
    variances of the rows.

    One row for a size, distance or angle. A characteristic that is 0 on the drawing (orientation, location) is the
    length of a small vector: several rows, and u is the rms of what a perfect part would show.
    """
    out = {}
    for c in characteristics:
        if c.type in gps.FORM:
            continue
        smooth = gps.is_linear(c, features)
        rows = _gradient if smooth else _factor
        out[c.name] = rows(c, features, moving, alignment)
    return out


def _values(
    c: Characteristic,
    features: Mapping[str, Feature],
    moving: Mapping[str, Motions],
    scheme: Alignment | None,
    amounts: Array,
) -> Array:
    """Return the values (b,) of a characteristic for motions (b, P) of all features."""
    fitted, at = {}, 0
    for name, m in moving.items():
        fitted[name] = m.move(amounts[:, at : at + m.count])
        at += m.count
    pose = None if scheme is None else align(scheme, features, fitted, Pose.identity())
    return np.broadcast_to(gps.evaluate(c, features, fitted, pose), (len(amounts),))


def _steps(moving: Mapping[str, Motions]) -> Array:
    return np.concatenate([m.step for m in moving.values()])


def _gradient(
    c: Characteristic,
    features: Mapping[str, Feature],
    moving: Mapping[str, Motions],
    scheme: Alignment | None,
) -> Array:
    step = _steps(moving)
    both = _values(c, features, moving, scheme, np.vstack([np.diag(step), -np.diag(step)]))
    return np.asarray((both[: len(step)] - both[len(step) :]) / (2.0 * step))[None]


def _factor(
    c: Characteristic,
    features: Mapping[str, Feature],
    moving: Mapping[str, Motions],
    scheme: Alignment | None,
) -> Array:
    """Return the rows B with value^2 = |B theta|^2: value^2 is a quadratic form, read off at pairs of motions."""
    step = _steps(moving)
    p = len(step)
    i, j = np.triu_indices(p, 1)
    single, unit = np.diag(step), np.eye(p) * step
    grid = np.vstack([single, unit[i] + unit[j], unit[i] - unit[j]])
    square = _values(c, features, moving, scheme, grid) ** 2
    q = np.diag(square[:p])
    q[i, j] = q[j, i] = (square[p : p + len(i)] - square[p + len(i) :]) / 4.0
    values, vectors = np.linalg.eigh(q / np.outer(step, step) * np.outer(step, step).max())
    keep = values > 1e-9 * max(float(values.max(initial=0.0)), 1e-300)
    return np.asarray((vectors[:, keep] * np.sqrt(values[keep] / np.outer(step, step).max())).T)
